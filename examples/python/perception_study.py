"""Does a delay of the force change how stiff a surface feels? A small study end to end, with a scripted observer.

Two surfaces are compared in each trial: a standard, and one of another stiffness whose force comes at once or 40 ms late.
What each feels like is measured in the simulated laboratory: a scripted hand touches it, through the arm, its motors and all
loops. The observer goes by how the force rises with the depth in the first moments of each touch, and compares with noise.

    python3 examples/python/perception_study.py [--seed 1] [--trials trials.csv] [--out plot.png]
"""
import argparse
import pathlib
import tempfile

import numpy as np
import numpy.typing as npt

import palpate

STANDARD = 120.0  # N/m: soft tissue
DEPTH_UM = 5  # of the counters of touch: how far the tip is below the surface
JUDGED = 0.2  # s, from the beginning of each touch
OBSERVER = 0.14  # Weber fraction
CONDITIONS = """
name = "delayed-stiffness"
question = "Which of the two is stiffer?"
task = "comparison"
stimulus = "stiffness_ratio"
method = "constant-stimuli"
practice = 4

[constant]
levels = [0.5, 0.7, 0.9, 1.1, 1.4, 1.8, 2.3, 2.9]
repeats = 20

[[factor]]
name = "force_delay_ms"
levels = [0, 40]
"""


def felt_stiffness(seed: int, ratio: float, force_delay_ms: float) -> dict[str, float]:
    """N/m, of a surface as the hand meets it: the motors' force over the depth of the tip, where a touch has just begun."""
    result = palpate.lockstep("touch", seed=seed, seconds=5.0, settings={"touch.stiffness_n_m": STANDARD * ratio},
                              force_delay=1e-3 * force_delay_ms)
    assert result.states is not None and result.forces is not None
    time, depth = result.states.time, 1e-6 * np.asarray(result.states["counters"])[:, DEPTH_UM]
    force = np.interp(time, result.forces.time, np.linalg.norm(np.asarray(result.forces["commanded_n"]), axis=1))
    judged = np.zeros(len(time), dtype=bool)
    for event in result.events:
        if event["event"] == "touch-begins" and event["time_s"] > 0.5:  # the first one is where the hand happened to be
            judged |= (time >= event["time_s"]) & (time < event["time_s"] + JUDGED)
    judged &= np.asarray(result.states["touching"], dtype=bool)
    return {"felt_n_m": float(np.sum(force[judged] * depth[judged]) / np.sum(depth[judged] ** 2))}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="draws the order of trials, the laboratory and the observer")
    parser.add_argument("--trials", help="write every trial to this new file")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    conditions = palpate.Conditions.parse(CONDITIONS)
    surfaces = palpate.grid(ratio=[1.0, *conditions.levels], force_delay_ms=[float(ms) for ms in conditions.factors["force_delay_ms"]])
    table = palpate.sweep(felt_stiffness, surfaces, [options.seed], workers=0)
    felt = {key: value for key, value in zip(zip(table["ratio"], table["force_delay_ms"]), table["felt_n_m"])}

    observer = palpate.Observer(OBSERVER, lapse_rate=0.02, seed=options.seed)
    with tempfile.TemporaryDirectory() as folder:
        run = palpate.ExperimentRun(conditions, options.seed, out=options.trials or pathlib.Path(folder) / "trials.csv")
        for trial in run:
            pair = [felt[1.0, 0.0]] * 2
            pair[trial.target - 1] = felt[trial.stimulus, float(trial.levels["force_delay_ms"])]
            run.answer(1 + observer.largest(pair), response_s=1.0, time_s=2.0 * trial.number)

    fits = {}
    for ms in conditions.factors["force_delay_ms"]:
        counted = (run.table["force_delay_ms"] == ms) & ~run.table["practice"]
        fits[ms] = palpate.fit_psychometric(run.table["stimulus"][counted], run.table["response"][counted], comparison=True, seed=options.seed)
        print(f"{ms:>3} ms: as stiff as the standard at {fits[ms].threshold:.3f} of it, +- {100 * fits[ms].log_threshold_sd:.1f} %; "
              f"Weber fraction {fits[ms].weber_fraction:.3f}, the observer's is {OBSERVER}")
    if options.out:
        draw(fits, options.out)


def draw(fits: dict[str, palpate.PsychometricFit], out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("no picture: matplotlib is not installed (python3-matplotlib)")
        return
    figure, axis = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
    for ms, fit in fits.items():
        ratios: npt.NDArray[np.float64] = np.geomspace(fit.stimuli[0], fit.stimuli[-1], 200)
        line, = axis.plot(ratios, fit.chance(ratios), label=f"force {ms} ms late")
        axis.plot(fit.stimuli, fit.positives / fit.trials, "o", color=line.get_color())
        axis.axvline(fit.threshold, color=line.get_color(), linewidth=0.8)
    axis.set(xscale="log", xlabel="stiffness over the standard's", ylabel="taken for the stiffer one")
    axis.set_xticks(list(fit.stimuli), labels=[f"{ratio:g}" for ratio in fit.stimuli])
    axis.minorticks_off()
    axis.legend()
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
