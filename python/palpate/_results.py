"""What a calibration gives back: named values in SI and radians, with how good they are."""
from __future__ import annotations

import copy
import re
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from ._arguments import Floats, read_only
from ._refused import in_python

Flags = npt.NDArray[np.bool_]


def _short(values: npt.ArrayLike, scale: float, digits: int = 3) -> str:
    return " ".join(f"{scale * value:.{digits}f}" for value in np.ravel(np.asarray(values)))


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """What all calibrations tell. Arrays are read-only."""

    covariance: Floats  # of the values in `order`, m, rad, s
    order: tuple[str, ...]
    residuals: Floats  # (N, 3), m
    inliers: Flags  # (N,): which measurements agree with the others
    rms: float  # m, of the residuals, per component
    condition: float  # of the scaled normal equations; large: the data barely carry the result
    unobservable: tuple[str, ...]  # directions that the data do not see
    converged: bool
    warnings: tuple[str, ...]
    _json: dict[str, Any]

    @property
    def std(self) -> Floats:
        """Standard deviations of the values in `order`; 0 for what was held fixed."""
        deviations: Floats = np.sqrt(np.maximum(np.diagonal(self.covariance), 0.0))
        return deviations

    def std_of(self, name: str) -> float:
        """The standard deviation of one of the values in `order`, "tip_x"."""
        if name not in self.order:
            raise KeyError(f"{name!r}; one of {', '.join(self.order)} is expected")
        return float(self.std[self.order.index(name)])

    def to_dict(self) -> dict[str, Any]:
        """What `palpate calibrate ... --json` writes, all but `data`, the name of the file: the same keys, units and numbers."""
        return copy.deepcopy(self._json)

    def _lines(self) -> list[str]:
        return []

    def __repr__(self) -> str:
        title = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(self).__name__.removesuffix("Result")).lower()
        lines = [title.capitalize(), *("  " + line for line in self._lines())]
        return "\n".join(lines + [f"  warning: {warning}" for warning in self.warnings])


@dataclass(frozen=True, repr=False, eq=False)
class PivotResult(Result):
    """Where a tip sits in its marker's frame, and the places where it rested."""

    tip: Floats  # (3,), m, in the marker's frame
    tip_std: Floats  # (3,)
    pivots: Floats  # (S, 3), m, in the frame the poses are reported in
    pivot_stds: Floats  # (S, 3)
    segments: tuple[str, ...]  # the pivots' labels
    rotation_range: float  # rad, largest angle between two poses of a pivot

    def _lines(self) -> list[str]:
        return [f"tip in marker  {_short(self.tip, 1e3)} mm  +- {_short(self.tip_std, 1e3)}",
                f"pivots         {len(self.pivots)}",
                f"residual       {1e3 * self.rms:.3f} mm rms per component, {int(self.inliers.sum())} of {len(self.inliers)} poses, "
                f"turning by {np.degrees(self.rotation_range):.1f} deg"]


@dataclass(frozen=True, repr=False, eq=False)
class RigidMotionResult(Result):
    """The motion that carries one list of points onto another: to = rotation @ from + translation."""

    matrix: Floats  # (4, 4)
    mirrored: bool  # a mirror image would fit much better

    @property
    def rotation(self) -> Floats:
        return self.matrix[:3, :3]

    @property
    def translation(self) -> Floats:
        return self.matrix[:3, 3]

    def __call__(self, points: npt.ArrayLike) -> Floats:
        """The points (..., 3) carried along."""
        moved: Floats = np.asarray(points, dtype=np.float64) @ self.rotation.T + self.translation
        return moved

    def _lines(self) -> list[str]:
        angle = np.degrees(np.arccos(np.clip((np.trace(self.rotation) - 1.0) / 2.0, -1.0, 1.0)))
        return [f"translation  {_short(self.translation, 1e3)} mm  +- {_short(self.std[3:], 1e3)}",
                f"rotation     {angle:.3f} deg  +- {_short(np.degrees(self.std[:3]), 1.0)}",
                f"residual     {1e3 * self.rms:.3f} mm rms per component, {len(self.residuals)} points"]


@dataclass(frozen=True, repr=False, eq=False)
class HandEyeResult(Result):
    """Where a camera sits in the marker it carries, and by how much the two clocks differ."""

    camera_in_marker: Floats  # (4, 4)
    board_in_world: Floats  # (4, 4)
    delay: float  # s: hand time = eye time + delay
    delay_std: float

    def _lines(self) -> list[str]:
        return [f"camera in marker  {_short(self.camera_in_marker[:3, 3], 1e3)} mm  +- {_short(self.std[3:6], 1e3)}",
                f"turn              +- {_short(np.degrees(self.std[:3]), 1.0)} deg",
                f"delay             {self.delay:.5f} +- {self.delay_std:.5f} s (hand time = eye time + delay)",
                f"residual          {1e3 * self.rms:.3f} mm rms per component, {len(self.residuals)} eye poses"]


@dataclass(frozen=True, repr=False, eq=False)
class ArmResult(Result):
    """An arm's joints corrected, and its place in the world."""

    gains: Floats  # of each joint: angle = gain * reading + offset
    offsets: Floats  # rad
    base: Floats  # (4, 4), the arm's base in the world
    tip: Optional[Floats]  # (3,), m, in its marker; None where no marker was measured
    delay: float  # s, the tracker's stamps minus the encoders'
    unseen_errors: Floats  # (M, 3), m, on samples that the calibration has not seen
    _predictor: Any

    def tips(self, joints: npt.ArrayLike) -> Floats:
        """Where the tip is at these readings: (N, joints), rad, gives (N, 3), m, in the world."""
        from ._arguments import angles
        predicted: Floats = self._predictor.tips(angles(joints, "joints", len(self.gains)))
        return predicted

    def tip_stds(self, joints: npt.ArrayLike) -> Floats:
        """How far that may be off: the rms distance (N,), m."""
        from ._arguments import angles
        predicted: Floats = self._predictor.stds(angles(joints, "joints", len(self.gains)))
        return predicted

    def tip_covariances(self, joints: npt.ArrayLike) -> Floats:
        """The same as covariances, (N, 3, 3), m^2, in the world's axes."""
        from ._arguments import angles
        predicted: Floats = self._predictor.covariances(angles(joints, "joints", len(self.gains)))
        return predicted

    def _lines(self) -> list[str]:
        errors = np.linalg.norm(self.unseen_errors, axis=1)
        return [f"gains     {_short(self.gains, 1.0, 5)}",
                f"offsets   {_short(np.degrees(self.offsets), 1.0, 4)} deg",
                f"residual  {1e3 * self.rms:.3f} mm rms per component, {int(self.inliers.sum())} of {len(self.inliers)} samples",
                f"unseen    {1e3 * errors.mean():.3f} mm mean, {1e3 * errors.max():.3f} mm at most, over {len(errors)} samples"]


@dataclass(frozen=True, repr=False, eq=False)
class CameraResult(Result):
    """A camera's lens. `rms` is in px, sqrt(sum of |r|^2 / N) over the corners, as OpenCV has it."""

    matrix: Floats  # (3, 3): fx, fy, cx, cy
    distortion: Floats  # (5,): k1 k2 p1 p2 k3; of a rational lens (8,): and k4 k5 k6; of a fisheye lens (4,): k1 k2 k3 k4
    boards: Floats  # (V, 4, 4), the board in the camera in each view
    lens: str = "brown"  # or "fisheye", "rational"

    def _lines(self) -> list[str]:
        sd = self.std
        names = {"fisheye": "k1 k2 k3 k4", "rational": "k1 k2 p1 p2 k3 k4 k5 k6"}.get(self.lens, "k1 k2 p1 p2 k3")
        return [f"focal length  {self.matrix[0, 0]:.3f} +- {sd[0]:.3f}, {self.matrix[1, 1]:.3f} +- {sd[1]:.3f} px",
                f"centre        {self.matrix[0, 2]:.3f} +- {sd[2]:.3f}, {self.matrix[1, 2]:.3f} +- {sd[3]:.3f} px",
                f"distortion    {_short(self.distortion, 1.0, 5)} ({names})",
                f"residual      {self.rms:.4f} px rms over {len(self.boards)} views"]


@dataclass(frozen=True, repr=False, eq=False)
class SurfaceResult(Result):
    """A real rectangle."""

    name: str
    pose: Floats  # (4, 4): origin at corner 1, x to corner 2, y to corner 4, z out of the surface
    corners: Floats  # (4, 3), m
    width: float  # m, corner 1 to 2
    height: float  # m, corner 1 to 4
    _known: tuple[Any, ...]  # as calibrate_landmarks wants it

    def _lines(self) -> list[str]:
        return [f"{self.name}: {1e3 * self.width:.1f} x {1e3 * self.height:.1f} mm",
                f"residual  {1e3 * self.rms:.3f} mm rms per component over {len(self.residuals)} points"]


@dataclass(frozen=True, repr=False, eq=False)
class LandmarksResult(Result):
    """Dots on real surfaces."""

    labels: tuple[str, ...]
    places: Floats  # (L, 3), m
    normals: Floats  # (L, 3)
    surfaces: tuple[str, ...]  # the one that each lies on

    def _lines(self) -> list[str]:
        deviations = self.std.reshape(-1, 3)
        return [f"{label:<12} {_short(place, 1e3)} mm  +- {_short(sd, 1e3)}, on the {surface}"
                for label, place, sd, surface in zip(self.labels, self.places, deviations, self.surfaces)]


@dataclass(frozen=True, repr=False, eq=False)
class DelayResult:
    """By how much the clocks of two recordings of one motion differ: to time = from time + delay."""

    delay: float  # s
    std: float  # s
    correlation: float  # 0 to 1, at this delay
    overlap: float  # s, common time
    warnings: tuple[str, ...]
    _json: dict[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """What `palpate calibrate delay --json` writes, all but `data`."""
        return copy.deepcopy(self._json)

    def __repr__(self) -> str:
        lines = ["Delay", f"  delay        {self.delay:.5f} +- {self.std:.5f} s (to time = from time + delay)",
                 f"  correlation  {self.correlation:.5f} over {self.overlap:.1f} s"]
        return "\n".join(lines + [f"  warning: {warning}" for warning in self.warnings])


def common(fields: dict[str, Any], rms: float) -> dict[str, Any]:
    """What every Result holds, of the fields that the library gave."""
    json = fields["json"]
    return {
        "covariance": fields["covariance"],
        "order": tuple(re.sub(r"_(mm|deg|px|s)$", "", name) for name in json["covariance"]["order"]),
        "residuals": fields["residuals"],
        "inliers": fields["inliers"],
        "rms": rms,
        "condition": fields["condition"],
        "unobservable": tuple(fields["unobservable"]),
        "converged": fields["converged"],
        "warnings": tuple(in_python(warning) for warning in json["warnings"]),
        "_json": json,
    }


def diagonal_std(covariance: Floats, first: int, count: int) -> Floats:
    deviations: Floats = np.sqrt(np.maximum(np.diagonal(covariance)[first:first + count], 0.0))
    read_only(deviations)
    return deviations
