"""Where is the tip of a stylus, and how sure is that? A recording of a real tracker, in numbers and as a picture.

    python3 examples/python/pivot.py [--poses FILE --segments COLUMN] [--out plot.png]
"""
import argparse
import pathlib

import numpy as np
import numpy.typing as npt

import palpate

DATA = pathlib.Path(__file__).parents[2] / "data" / "plus_eight_landmark_pivots"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", default=DATA / "stylus_to_reference.csv", help="poses of the stylus' marker")
    parser.add_argument("--segments", default="landmark", help="the column that numbers the places where the tip rested")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    poses = palpate.read_poses(options.poses, segments=options.segments)
    result = palpate.calibrate_pivot(poses)
    print(result)

    # What each rest says alone: the scatter of these tips is what the stated deviation has to explain.
    tips = []
    for label in result.segments:
        alone = poses[np.array([segment == label for segment in poses.segments or ()])]
        try:
            tips.append(palpate.calibrate_pivot(alone).tip)
        except palpate.Refused as refused:
            print(f"  {label}: {refused.reason}")
    scatter = np.std(tips, axis=0, ddof=1) / np.sqrt(len(tips))
    print("  stated    +-", " ".join(f"{1e3 * value:.3f}" for value in result.tip_std), "mm")
    print("  by rests  +-", " ".join(f"{1e3 * value:.3f}" for value in scatter), "mm")

    if options.out:
        draw(result, np.array(tips), options.out)


def draw(result: palpate.PivotResult, tips: npt.NDArray[np.float64], out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("  no picture: matplotlib is not installed (python3-matplotlib)")
        return
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), constrained_layout=True)
    lengths = 1e3 * np.linalg.norm(result.residuals, axis=1)
    left.hist(lengths[result.inliers], bins=40)
    left.set(xlabel="distance from its pivot, mm", ylabel="poses", title=f"{len(lengths)} poses")
    for row, axis in enumerate("xyz"):
        right.plot(1e3 * (tips[:, row] - result.tip[row]), np.full(len(tips), row), "o", alpha=0.5)
        right.errorbar(0.0, row, xerr=2e3 * result.tip_std[row], fmt="k|", capsize=6)
    right.set(yticks=range(3), yticklabels="xyz", xlabel="tip, mm from the common one", title="rests alone; bar: 2 sd of all together")
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
