"""Do calibrations know how wrong they are? Simulated ones by the thousand: how often the stated 95 % region holds the truth.

With few poses the size of the noise is itself an estimate, and the region, which is a chi-square's, holds a little less.

    python3 examples/python/coverage_sweep.py [--runs 200] [--workers N] [--table coverage.csv] [--out plot.png]
"""
import argparse
from typing import Any

import numpy as np
import numpy.typing as npt

import palpate

CHI_SQUARE_95 = 12.5916  # 6 degrees of freedom
TIP, PIVOT = np.array([0.004, -0.012, -0.153]), np.array([0.1, 0.2, -0.9])  # m: of the marker, of the tracker


def turns(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Rotation matrices by |vector| about each vector (Rodrigues)."""
    angles = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = (vectors / angles[:, :, 0]).T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    matrices: npt.NDArray[np.float64] = np.eye(3) + np.sin(angles) * cross + (1.0 - np.cos(angles)) * cross @ cross
    return matrices


def pivot(seed: int, poses: int, noise_mm: float) -> dict[str, Any]:
    """One simulated calibration: so many poses of a marker whose tip rests, each measured with white noise."""
    random = np.random.default_rng(seed)
    markers = np.tile(np.eye(4), (poses, 1, 1))
    markers[:, :3, :3] = turns(random.uniform(-0.6, 0.6, (poses, 3)))
    markers[:, :3, 3] = PIVOT - markers[:, :3, :3] @ TIP + 1e-3 * noise_mm * random.standard_normal((poses, 3))
    result = palpate.calibrate_pivot(markers, shared_errors=False)
    error = np.concatenate([result.tip - TIP, result.pivots[0] - PIVOT])
    return {"error_mm": 1e3 * float(np.linalg.norm(result.tip - TIP)),
            "stated_mm": 1e3 * float(np.linalg.norm(result.tip_std)),
            "held": bool(error @ np.linalg.solve(result.covariance, error) < CHI_SQUARE_95)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=200, help="calibrations of each kind")
    parser.add_argument("--workers", type=int, help="default: one for each core; 0: without Dask")
    parser.add_argument("--table", help="write all calibrations to this file; what was interrupted goes on")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    kinds = palpate.grid(poses=[20, 60, 180], noise_mm=[0.1, 0.4])
    table = palpate.sweep(pivot, kinds, seeds=range(1, options.runs + 1), workers=options.workers, out=options.table)
    shares = []
    for poses, noise_mm in zip(kinds["poses"], kinds["noise_mm"]):
        these = (table["poses"] == poses) & (table["noise_mm"] == noise_mm)
        share = float(np.mean(table["held"][these]))
        shares.append((f"{poses} poses\n{noise_mm} mm", share, float(np.sqrt(share * (1.0 - share) / options.runs))))
        rms, stated = np.sqrt(np.mean(table["error_mm"][these] ** 2)), np.sqrt(np.mean(table["stated_mm"][these] ** 2))
        print(f"{poses:4d} poses, {noise_mm:g} mm noise: tip off by {rms:.3f} mm rms, stated +- {stated:.3f} mm; "
              f"the 95 % region held the truth in {100 * share:.1f} +- {100 * shares[-1][2]:.1f} %")
    if options.out:
        draw(shares, options.out)


def draw(shares: list[tuple[str, float, float]], out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("no picture: matplotlib is not installed (python3-matplotlib)")
        return
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    names, held, deviations = zip(*shares)
    axis.errorbar(range(len(held)), [100 * share for share in held], yerr=[200 * deviation for deviation in deviations], fmt="o", capsize=5)
    axis.axhspan(93, 97, alpha=0.15)
    axis.axhline(95, color="k", linewidth=0.8)
    axis.set(xticks=range(len(names)), xticklabels=names, ylabel="regions that held the truth, %", title="bar: 2 sd of the share")
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
