"""Poses: where a body stood, reading by reading.

A pose is a 4 x 4 matrix that carries points of the body into the frame it is reported in; N of them are an array
(N, 4, 4), in metres. Every function that takes poses takes such an array, or `Poses`, which keeps quaternions as they were
read, to the last bit, and the times beside them.
"""
from __future__ import annotations

from os import PathLike
from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import Floats

PosesLike = Union["Poses", npt.ArrayLike]

_QUATERNIONS = "(N, 4)"
_LENGTH_TOLERANCE = 0.02  # of a unit quaternion, as the readers of files have it


class Poses:
    """N poses. `np.asarray(poses)` gives the matrices, (N, 4, 4)."""

    __slots__ = ("_positions", "_quaternions", "_time", "_segments")

    def __init__(self, matrices: npt.ArrayLike, time: Optional[npt.ArrayLike] = None) -> None:
        array = arguments.shaped(matrices, "poses", ("N", 4, 4), "metres")
        if not np.allclose(array[:, 3], (0.0, 0.0, 0.0, 1.0), atol=1e-9):
            raise ValueError("poses: the last row of a pose is not 0 0 0 1; matrices that carry points of the body into the "
                             "frame it is seen from are expected: are they transposed?")
        arguments.near(array[:, :3, 3], "poses")
        self._positions, self._quaternions = _core.split_matrices(array, "poses")
        self._time = None if time is None else arguments.read_only(arguments.times(time, "time", len(array), "poses"))
        self._segments: Optional[tuple[Optional[str], ...]] = None

    @classmethod
    def _of(cls, positions: Floats, quaternions: Floats, time: Optional[Floats],
            segments: Optional[Sequence[Optional[str]]] = None) -> Poses:
        poses = cls.__new__(cls)
        poses._positions, poses._quaternions, poses._time = positions, quaternions, time
        poses._segments = None if segments is None else tuple(segments)
        return poses

    @property
    def positions(self) -> Floats:
        """(N, 3), m."""
        return self._positions

    def quaternions(self, order: str) -> Floats:
        """(N, 4); order: "wxyz" or "xyzw"."""
        arguments.one_of(order, "order", ("wxyz", "xyzw"))
        if order == "wxyz":
            return self._quaternions
        turned: Floats = arguments.read_only(np.roll(self._quaternions, -1, axis=1))
        return turned

    @property
    def time(self) -> Optional[Floats]:
        """(N,), s; None where nobody knows."""
        return self._time

    @property
    def segments(self) -> Optional[tuple[Optional[str], ...]]:
        """The label that a file gave to each pose; None where it gave none."""
        return self._segments

    @property
    def matrices(self) -> Floats:
        """(N, 4, 4), a new array."""
        return _core.join_matrices(self._positions, self._quaternions)

    def __array__(self, dtype: Any = None) -> npt.NDArray[Any]:
        return self.matrices if dtype is None else self.matrices.astype(dtype)

    def __len__(self) -> int:
        return len(self._positions)

    def __getitem__(self, rows: Union[slice, npt.NDArray[Any], Sequence[int]]) -> Poses:
        """Some of them: a slice, a list of rows or a mask."""
        if not isinstance(rows, slice):
            rows = np.asarray(rows)
            if rows.ndim != 1:
                raise TypeError("poses[...]: a slice, a list of rows or a mask is expected; np.asarray(poses)[i] is one pose")
        read_only = arguments.read_only
        some = np.arange(len(self))[rows]
        return Poses._of(read_only(self._positions[some]), read_only(self._quaternions[some]),
                         None if self._time is None else read_only(self._time[some]),
                         None if self._segments is None else [self._segments[i] for i in some])

    def __repr__(self) -> str:
        during = "" if self._time is None else f", {self._time.max() - self._time.min():.1f} s"
        return f"<{len(self)} poses{during}>"


def poses_from_quaternions(positions: npt.ArrayLike, quaternions: npt.ArrayLike, order: str,
                           time: Optional[npt.ArrayLike] = None) -> Poses:
    """Poses of positions (N, 3), m, and unit quaternions (N, 4).

    order: how the numbers of a quaternion follow each other, "wxyz" (Eigen's text, PLUS, this package's files) or "xyzw"
    (ROS, scipy). There is no default, for no file tells.
    """
    places = arguments.points(positions, "positions")
    rotations = arguments.shaped(quaternions, "quaternions", ("N", 4), "without unit")
    arguments.same_length(rotations, "quaternions", len(places), "positions")
    arguments.one_of(order, "order", ("wxyz", "xyzw"))
    lengths = np.linalg.norm(rotations, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > _LENGTH_TOLERANCE)
    if len(wrong) > 0:
        raise ValueError(f"quaternions[{wrong[0]}] has the length {lengths[wrong[0]]:.4g}; unit quaternions are expected")
    rotations = rotations / lengths[:, None]
    if order == "xyzw":
        rotations = np.ascontiguousarray(np.roll(rotations, 1, axis=1))
    return Poses._of(arguments.read_only(places), arguments.read_only(rotations),
                     None if time is None else arguments.read_only(arguments.times(time, "time", len(places), "positions")))


def read_poses(path: Union[str, PathLike[str]], *, transform: str = "", segments: str = "") -> Poses:
    """Poses of a file as the command line reads them: CSV in several forms, .igs.mha, a folder of matrices, files of others
    (TUM, EuRoC, ROS, NDI and more). Rows in which the body was hidden are left out.

    transform: which of an .igs.mha sequence, "StylusToReference", or of several tools side by side. segments: the column that
    numbers the pivots.
    """
    fields = _core.read_poses(arguments.path_text(path), transform, segments)
    return Poses._of(fields["positions"], fields["quaternions"], fields["time"], fields["segments"])


def as_poses(value: Any, name: str) -> Poses:
    """An argument that is Poses or an array (N, 4, 4)."""
    if isinstance(value, Poses):
        return value
    array = arguments.shaped(value, name, ("N", 4, 4), "metres; or Poses (palpate.read_poses, palpate.poses_from_quaternions)")
    try:
        return Poses(array)
    except ValueError as error:
        raise ValueError(str(error).replace("poses", name, 1)) from None
