"""The calibrations: the engines, defaults and refusals of `palpate calibrate`, on arrays in SI and radians.

Each takes copies of what it is given, lets other threads run while it solves, prints nothing and gives back a result whose
`to_dict()` is what the command line's --json writes. ValueError and TypeError name an argument that makes no sense;
`palpate.Refused` says that sound data cannot carry an answer, and why.
"""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core, _results
from ._arguments import Floats
from ._files import ArmSamples, BoardViews, Path, board_shape
from ._poses import Poses, PosesLike, as_poses
from ._refused import Refused

_PIVOT_METHODS = ("algebraic", "sphere", "robust")
_ARM_METHODS = ("joint", "eq7", "alternating", "one-pass")


def _times_of(poses: Poses, time: Optional[npt.ArrayLike], name: str, of: str) -> Optional[Floats]:
    """Times given beside the poses, else the poses' own."""
    return poses.time if time is None else arguments.times(time, name, len(poses), of)


def _segment_numbers(segments: Any, poses: Poses, count: int) -> tuple[npt.NDArray[np.int64], list[str]]:
    """Of each pose the number of its segment, -1 for none, and the segments' labels in the order in which they come."""
    if segments is None:
        segments = poses.segments
    if segments is None:
        return np.zeros(count, dtype=np.int64), []
    if isinstance(segments, (str, bytes)):
        raise ValueError(f'segments is {segments!r}; a label for each pose (0, "" or None: in none), or "auto", is expected')
    given = [None if label is None or str(label) in ("", "0") else str(label) for label in segments]
    if len(given) != count:
        raise ValueError(f"segments has {len(given)} entries, poses has {count}; as many are expected")
    names: list[str] = []
    numbers = np.full(count, -1, dtype=np.int64)
    for i, label in enumerate(given):
        if label is None:
            continue
        if label not in names:
            names.append(label)
        numbers[i] = names.index(label)
    return numbers, names


def calibrate_pivot(poses: PosesLike, *, time: Optional[npt.ArrayLike] = None,
                    segments: Union[str, Iterable[Any], None] = None, method: str = "algebraic",
                    tip: Optional[npt.ArrayLike] = None, motion: Optional[npt.ArrayLike] = None,
                    subtract_motion: bool = False, motion_calibrated: bool = False,
                    shared_errors: bool = True) -> _results.PivotResult:
    """Where a tip sits in its marker's frame, from poses of the marker while the tip rested.

    poses: (N, 4, 4), m, or Poses. time: (N,), s. segments: a label for each pose where the tip rested in several places
    (0, "" or None: in none); "auto": they are found, by the times. method: "algebraic", "sphere" or "robust". tip: (3,), m,
    a known one: only the pivots are found. motion: (N, 3), m, where an arm saw the tip, which tells whether it rested;
    subtract_motion takes it away; motion_calibrated: the arm's gains are known. shared_errors: poses near each other may err
    alike, as a real tracker's do, and the covariance allows for it; False: their errors are independent (a simulation's), the
    covariance is narrower and the answer comes sooner.
    """
    stood = as_poses(poses, "poses")
    times = _times_of(stood, time, "time", "poses")
    arguments.one_of(method, "method", _PIVOT_METHODS)
    find = isinstance(segments, str) and segments == "auto"
    if find and times is None:
        raise ValueError('segments is "auto", by the times of the poses; time is expected too')
    numbers, labels = (np.zeros(len(stood), dtype=np.int64), []) if find else _segment_numbers(segments, stood, len(stood))
    moved = None if motion is None else arguments.points(motion, "motion")
    if moved is not None:
        arguments.same_length(moved, "motion", len(stood), "poses")
    if subtract_motion and moved is None:
        raise ValueError("subtract_motion=True needs motion, the tip's places as the arm saw them")
    if subtract_motion and method == "sphere":
        raise ValueError('subtract_motion=True goes with the methods "algebraic" and "robust", not with "sphere"')
    fields = _core.pivot(stood.positions, stood.quaternions("wxyz"), times, numbers, labels, find, method,
                         arguments.point(tip, "tip"), moved, bool(subtract_motion), bool(motion_calibrated), bool(shared_errors))
    covariance = fields["covariance"]
    pivots = fields["pivots"]
    return _results.PivotResult(
        **_results.common(fields, fields["json"]["rms_mm"] / 1e3), tip=fields["tip"],
        tip_std=_results.diagonal_std(covariance, 0, 3), pivots=pivots,
        pivot_stds=_results.diagonal_std(covariance, 3, 3 * len(pivots)).reshape(-1, 3),
        segments=tuple(entry["label"] for entry in fields["json"]["segments"]), rotation_range=fields["rotation_range"])


def absolute_orientation(from_points: npt.ArrayLike, to_points: npt.ArrayLike, *, weights: Optional[npt.ArrayLike] = None,
                         labels: Optional[Iterable[Any]] = None) -> _results.RigidMotionResult:
    """The rotation and translation that carry one list of points, (N, 3), m, onto another, row by row.

    weights: (N,), of the rows. labels: for words about single points; without, their numbers from 1.
    """
    first, second = arguments.points(from_points, "from_points"), arguments.points(to_points, "to_points")
    arguments.same_length(second, "to_points", len(first), "from_points")
    heavy = None
    if weights is not None:
        heavy = arguments.shaped(weights, "weights", ("N",), "without unit")
        arguments.same_length(heavy, "weights", len(first), "from_points")
        if np.any(heavy < 0.0):
            raise ValueError("weights: one of them is negative; at least 0 is expected")
    names = [str(i + 1) for i in range(len(first))] if labels is None else arguments.labels(labels, "labels", len(first), "from_points")
    fields = _core.rigid_motion(first, second, heavy, names, labels is not None)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = fields["rotation"], fields["translation"]
    arguments.read_only(matrix)
    return _results.RigidMotionResult(**_results.common(fields, fields["json"]["rms_mm"] / 1e3), matrix=matrix,
                                      mirrored=fields["mirrored"])


def calibrate_hand_eye(hand: PosesLike, eye: PosesLike, *, hand_time: Optional[npt.ArrayLike] = None,
                       eye_time: Optional[npt.ArrayLike] = None, estimate_delay: bool = False,
                       delay: float = 0.0) -> _results.HandEyeResult:
    """Where a camera sits in the marker it carries.

    hand: poses of the marker in the tracker. eye: poses of the camera in the board's frame (not the board's in the
    camera's). With times, s, for both the hand is interpolated to the eye's times; without, row k of one belongs to row k of
    the other. estimate_delay: find by how much the clocks differ too; else hand time = eye time + delay.
    """
    marker, camera = as_poses(hand, "hand"), as_poses(eye, "eye")
    marker_time = _times_of(marker, hand_time, "hand_time", "hand")
    camera_time = _times_of(camera, eye_time, "eye_time", "eye")
    if (marker_time is None) != (camera_time is None):
        lacking = "hand_time" if marker_time is None else "eye_time"
        raise ValueError(f"{lacking} is missing, the other has times; both or neither is expected")
    if marker_time is None:
        if estimate_delay:
            raise ValueError("estimate_delay=True needs hand_time and eye_time")
        if len(marker) != len(camera):
            raise ValueError(f"hand has {len(marker)} poses, eye has {len(camera)}; without times they belong together one by one")
    fields = _core.hand_eye(marker.positions, marker.quaternions("wxyz"), marker_time, camera.positions,
                            camera.quaternions("wxyz"), camera_time, bool(estimate_delay),
                            arguments.number(delay, "delay", "seconds"))
    return _results.HandEyeResult(
        **_results.common(fields, fields["rms"]), camera_in_marker=fields["camera_in_marker"],
        board_in_world=fields["board_in_world"], delay=fields["delay"], delay_std=fields["delay_std"])


def calibrate_arm(samples: ArmSamples, arm: Path, *, free: Union[str, Sequence[str], None] = None, method: str = "joint",
                  tip: Optional[npt.ArrayLike] = None, test: Optional[ArmSamples] = None, seed: int = 1) -> _results.ArmResult:
    """Joint correction and place of an arm, from encoder readings and what a tracker saw.

    arm: "phantom-premium-1.5", or a file that describes one. free: what is estimated, of "gains", "offsets", "lengths",
    "tip", "gimbal", "quadratic", "hysteresis", "delay", "dh"; "auto": what lowers the error in regions not seen; None: what
    suits the samples. tip: (3,), m, in its marker, from a pivot calibration. test: samples to judge by; without, five folds
    of the samples, drawn by seed.
    """
    for name, value in (("samples", samples), ("test", test)):
        if not isinstance(value, ArmSamples) and not (name == "test" and value is None):
            raise TypeError(f"{name} is a {type(value).__name__}; palpate.ArmSamples(joints, tips=...) or palpate.read_arm_samples(path) is expected")
    arguments.one_of(method, "method", _ARM_METHODS)
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"seed is {seed!r}; a whole number, at least 0, is expected")
    wanted = free if isinstance(free, str) else ",".join(free or ())
    fields = _core.arm(samples._columns, arguments.path_text(arm, "arm"), method, wanted, arguments.point(tip, "tip"),
                       None if test is None else test._columns, int(seed))
    return _results.ArmResult(
        **_results.common(fields, fields["json"]["rms_mm"] / 1e3), gains=fields["gains"], offsets=fields["offsets"],
        base=fields["base"], tip=fields["tip"], delay=fields["delay"], unseen_errors=fields["unseen_errors"],
        _predictor=fields["predictor"])


def calibrate_camera(corners: Union[BoardViews, npt.ArrayLike, Sequence[npt.ArrayLike]], size: Optional[tuple[int, int]] = None, *,
                     board: tuple[int, int] = (9, 6), square: float = 0.025,
                     reject_outlier_views: bool = False, lens: str = "brown") -> _results.CameraResult:
    """A camera's lens from views of a chessboard.

    corners: BoardViews, or all inner corners in each view, (V, rows * columns, 2), px, along the rows of the board; (0, 0)
    is the centre of the first pixel. size: (width, height) of the images, px. board: (columns, rows); square: m.
    reject_outlier_views: fit again without the views that are flagged. lens: "brown", up to some 110 degrees,
    "rational", up to some 130, or "fisheye".
    """
    if lens not in ("brown", "fisheye", "rational"):
        raise ValueError(f"lens is {lens!r}; 'brown', 'fisheye' or 'rational' is expected")
    views, told = _views_of(corners, board, square)
    if size is None and told is None:
        raise ValueError("size is None; width and height of the images, px, are expected, such as (640, 480)")
    width, height = told if size is None else size  # type: ignore[misc]
    if told is not None and (width, height) != told:
        raise ValueError(f"size is {width} x {height}; the images of the views are {told[0]} x {told[1]} px")
    for name, _, image in views:
        if np.any(image < -0.5) or np.any(image[:, 0] > width - 0.5) or np.any(image[:, 1] > height - 0.5):
            raise ValueError(f"corners of view {name!r} lie outside an image of {width} x {height} px; (x, y) in px are expected")
    from . import _vision
    found = corners if isinstance(corners, BoardViews) else None
    fields = _vision.camera(views, int(width), int(height), bool(reject_outlier_views), found.not_found if found else (),
                            found.warnings if found else (), lens)
    boards = np.array(fields["boards"])
    arguments.read_only(boards)
    return _results.CameraResult(**_results.common(fields, fields["rms"]), matrix=fields["matrix"],
                                 distortion=fields["distortion"], boards=boards, lens=fields["lens"])


def _views_of(corners: Any, board: Any, square: Any) -> tuple[list[tuple[str, Floats, Floats]], Optional[tuple[int, int]]]:
    if isinstance(corners, BoardViews):
        return corners._views, corners.size
    columns, rows, side = board_shape(board, square)
    if isinstance(corners, (str, bytes)) or not hasattr(corners, "__len__"):
        raise TypeError(f"corners is {corners!r}; an array (V, {rows * columns}, 2), px, or BoardViews is expected")
    places = np.array([(side * (i % columns), side * (i // columns), 0.0) for i in range(columns * rows)])
    views = [(str(i), places, arguments.shaped(view, f"corners[{i}]", (columns * rows, 2), "px"))
             for i, view in enumerate(corners)]
    return views, None


def calibrate_surface(points: npt.ArrayLike, *, corners: Optional[npt.ArrayLike] = None, name: str = "surface") -> _results.SurfaceResult:
    """A real rectangle from touched points, (N, 3), m.

    corners: (N,), which corner each is, 1 to 4 in order around the surface, or 0: somewhere on it. Without, the first four
    are the corners in order.
    """
    return calibrate_surfaces({name: (points, corners)})[0]


def calibrate_surfaces(touched: Mapping[str, tuple[npt.ArrayLike, Optional[npt.ArrayLike]]]) -> list[_results.SurfaceResult]:
    """Several rectangles that one hand has touched, by name: what the hand misses by is learned from all of them."""
    touches = []
    for name, (points, corners) in touched.items():
        places = arguments.points(points, "points")
        numbers = (np.zeros(len(places), dtype=np.int64) if corners is None
                   else arguments.whole(corners, "corners", len(places), "points", 0, 4))
        touches.append((str(name), places, numbers))
    if not touches:
        raise ValueError("no surface is given; points of one or more are expected")
    results = []
    for (name, _, _), fields in zip(touches, _core.surfaces(touches, *_core.PRESUMED_TOUCH)):
        results.append(_results.SurfaceResult(
            **_results.common(fields, fields["json"]["rms_mm"] / 1e3), name=name, pose=fields["pose"], corners=fields["corners"],
            width=fields["width"], height=fields["height"], _known=fields["known"]))
    return results


def calibrate_landmarks(points: npt.ArrayLike, surfaces: Sequence[Any], *, labels: Optional[Iterable[Any]] = None,
                        touch_std: Optional[float] = None, tracker_std: float = 1e-4,
                        diameter: float = 0.008) -> _results.LandmarksResult:
    """Dots on calibrated surfaces, from touches of their middles, (N, 3), m.

    surfaces: results of calibrate_surface, or Rig.surfaces. labels: which dot each touch is of; touches of one label belong
    together. touch_std: m, by how much the hand misses per axis (None: as the surfaces tell); tracker_std: m, the tracker's
    error that touches of one place share. diameter: m, of the dots.
    """
    places = arguments.points(points, "points")
    names = ([str(i + 1) for i in range(len(places))] if labels is None
             else arguments.labels(labels, "labels", len(places), "points"))
    known = [surface._known for surface in surfaces]
    fields = _core.landmarks(places, names, known,
                             None if touch_std is None else arguments.number(touch_std, "touch_std", "metres", above=0.0),
                             arguments.number(tracker_std, "tracker_std", "metres"),
                             arguments.number(diameter, "diameter", "metres", above=0.0))
    return _results.LandmarksResult(**_results.common(fields, fields["json"]["rms_mm"] / 1e3), labels=tuple(fields["labels"]),
                                    places=fields["places"], normals=fields["normals"], surfaces=tuple(fields["surfaces"]))


def _motion_of(recording: Any, time: Any, name: str) -> tuple[Floats, Floats]:
    """Times and columns: a place and a quaternion of poses, a point, or one number."""
    expected = "poses (N, 4, 4), points (N, 3), m, or one number a row (N,)"
    if not isinstance(recording, Poses):
        array = arguments.numbers(recording, f"{name}_motion", expected)
        if array.ndim == 3:
            recording = as_poses(recording, f"{name}_motion")
        elif array.ndim == 2 and array.shape[1] == 3:
            recording = arguments.points(recording, f"{name}_motion")
        elif array.ndim == 1 and len(array) > 0:
            largest = float(array[int(np.argmax(np.abs(array)))])
            # To size 1, as the command line does: a squared number of another unit may be too large for a double.
            recording = (array / abs(largest) if largest != 0.0 else array).reshape(-1, 1)
        else:
            raise ValueError(f"{name}_motion has the shape {array.shape}; {expected} is expected")
    if isinstance(recording, Poses):
        times = _times_of(recording, time, f"{name}_time", f"{name}_motion")
        columns = np.hstack([recording.positions, recording.quaternions("wxyz")])
    else:
        times = None if time is None else arguments.times(time, f"{name}_time", len(recording), f"{name}_motion")
        columns = recording
    if times is None:
        raise ValueError(f"{name}_time is missing; a delay is told by times, s")
    return times, np.ascontiguousarray(columns)


def calibrate_delay(from_motion: PosesLike, to_motion: PosesLike, *, from_time: Optional[npt.ArrayLike] = None,
                    to_time: Optional[npt.ArrayLike] = None, longest: Optional[float] = None) -> _results.DelayResult:
    """By how much the clocks of two recordings of one motion differ: to time = from time + delay.

    Each is poses (N, 4, 4), points (N, 3), m, or one number a row that follows the motion, (N,); with times, s. Frames,
    units and signs of the two need not agree. longest: s, longer delays are not looked for.
    """
    first_time, first = _motion_of(from_motion, from_time, "from")
    second_time, second = _motion_of(to_motion, to_time, "to")
    fields = _core.delay("from_motion", first_time, first, "to_motion", second_time, second,
                         None if longest is None else arguments.number(longest, "longest", "seconds", above=0.0))
    json = fields["json"]
    return _results.DelayResult(delay=fields["delay"], std=fields["std"], correlation=fields["correlation"],
                                overlap=fields["overlap"], warnings=tuple(json["warnings"]), _json=json)


__all__ = ["Refused", "absolute_orientation", "calibrate_arm", "calibrate_camera", "calibrate_delay", "calibrate_hand_eye",
           "calibrate_landmarks", "calibrate_pivot", "calibrate_surface", "calibrate_surfaces"]
