"""Where in its workspace may an arm be trusted? A robot calibrated against a laser tracker, judged where it was not trained.

    python3 examples/python/arm_map.py [--out plot.png]
"""
import argparse
import pathlib

import numpy as np
import numpy.typing as npt

import palpate

DATA = pathlib.Path(__file__).parents[2] / "data" / "ur5_laser_tracker"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--free", default="gains,offsets", help="what is estimated")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    train = palpate.read_arm_samples(DATA / "3D_UR5_uncalibrated_grid_cleaned.csv")
    test = palpate.read_arm_samples(DATA / "3D_UR5_uncalibrated_random_cleaned.csv")
    result = palpate.calibrate_arm(train, DATA / "ur5.toml", free=options.free, test=test)
    print(result)

    errors = np.linalg.norm(result.unseen_errors, axis=1)
    stated = result.tip_stds(test.joints)
    # How often the truth lies within twice what is stated says whether the statement is honest.
    print(f"  predicted +- {1e3 * np.sqrt(np.mean(stated**2)):.3f} mm rms at the test's places, "
          f"{100 * np.mean(errors < 2 * stated):.0f} % of the errors within twice of that")
    if options.out:
        draw(test.tips if test.tips is not None else result.tips(test.joints), errors, options.out)


def draw(places: npt.NDArray[np.float64], errors: npt.NDArray[np.float64], out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("  no picture: matplotlib is not installed (python3-matplotlib)")
        return
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), constrained_layout=True)
    for axis, (i, j) in zip(axes, ((0, 1), (0, 2))):
        dots = axis.scatter(places[:, i], places[:, j], c=1e3 * errors, s=14, cmap="viridis")
        axis.set(xlabel=f"{'xyz'[i]}, m", ylabel=f"{'xyz'[j]}, m", aspect="equal")
    figure.colorbar(dots, ax=axes, label="error on samples not seen, mm")
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
