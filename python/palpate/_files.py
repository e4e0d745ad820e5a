"""Readers of what people record: samples of an arm, lists of points, views of a board."""
from __future__ import annotations

from os import PathLike
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import Floats
from ._poses import Poses, PosesLike, as_poses

Path = Union[str, "PathLike[str]"]


class Points(NamedTuple):
    """A list of points, which goes wherever points go."""

    points: Floats  # (N, 3), m
    labels: Optional[list[str]]
    weights: Optional[Floats]

    def __array__(self, dtype: npt.DTypeLike = None) -> Floats:
        return np.array(self.points, dtype=dtype)


def read_points(path: Path) -> Points:
    """Points of a CSV file: x_mm,y_mm,z_mm (or _m), with a label and a weight where there are some."""
    fields = _core.read_points(arguments.path_text(path))
    return Points(fields["points"], fields["labels"], fields["weights"])


class ArmSamples:
    """Readings of an arm's encoders with the tip's measured place or its marker's pose. Arrays are read-only."""

    __slots__ = ("_columns",)

    def __init__(self, joints: npt.ArrayLike, *, tips: Optional[npt.ArrayLike] = None, markers: Optional[PosesLike] = None,
                 gimbal: Optional[npt.ArrayLike] = None, time: Optional[npt.ArrayLike] = None,
                 covariances: Optional[npt.ArrayLike] = None, systematic: Optional[npt.ArrayLike] = None) -> None:
        """joints: (N, J), rad, as read. tips: (N, 3), m, as the tracker measured them; markers: N poses of the tip's marker.

        gimbal: (N, 3), rad. time: (N,), s. covariances: (N, 3, 3), m^2, of the tips; systematic: (N,), m, the part of their
        error that is the same for places near each other, 3-D rms.
        """
        columns: dict[str, Floats] = {"joints": arguments.angles(joints, "joints", "J")}
        count = len(columns["joints"])
        if tips is None and markers is None:
            raise ValueError("neither tips nor markers: where the tracker saw the tip, or its marker, is expected")

        def put(name: str, array: Floats) -> None:
            arguments.same_length(array, name, count, "joints")
            columns[name] = array

        if gimbal is not None:
            put("gimbal", arguments.angles(gimbal, "gimbal", 3))
        if time is not None:
            put("time", arguments.times(time, "time", count, "joints"))
        if tips is not None:
            put("tips", arguments.points(tips, "tips"))
        if markers is not None:
            poses = as_poses(markers, "markers")
            if len(poses) != count:
                raise ValueError(f"markers has {len(poses)} entries, joints has {count}; as many are expected")
            columns["marker_positions"], columns["marker_quaternions"] = poses.positions, poses.quaternions("wxyz")
        if covariances is not None:
            put("covariances", arguments.shaped(covariances, "covariances", ("N", 3, 3), "square metres"))
        if systematic is not None:
            put("systematic", arguments.shaped(systematic, "systematic", ("N",), "metres"))
        for array in columns.values():
            array.flags.writeable = False
        self._columns = columns

    @classmethod
    def _of(cls, columns: dict[str, Floats]) -> ArmSamples:
        samples = cls.__new__(cls)
        samples._columns = columns
        return samples

    @property
    def joints(self) -> Floats:
        return self._columns["joints"]

    @property
    def tips(self) -> Optional[Floats]:
        return self._columns.get("tips")

    @property
    def gimbal(self) -> Optional[Floats]:
        return self._columns.get("gimbal")

    @property
    def time(self) -> Optional[Floats]:
        time = self._columns.get("time")
        return None if time is None else time.reshape(-1)

    @property
    def markers(self) -> Optional[Poses]:
        if "marker_positions" not in self._columns:
            return None
        return Poses._of(self._columns["marker_positions"], self._columns["marker_quaternions"], self.time)

    def __len__(self) -> int:
        return len(self.joints)

    def __repr__(self) -> str:
        return f"<{len(self)} samples of an arm with {self.joints.shape[1]} joints: {', '.join(self._columns)}>"


def read_arm_samples(path: Path) -> ArmSamples:
    """Samples of a CSV file as `palpate calibrate arm --samples` reads it."""
    return ArmSamples._of(_core.read_arm_samples(arguments.path_text(path)))


class BoardViews:
    """Corners of a board in views of one camera."""

    __slots__ = ("_views", "size", "not_found", "warnings")

    def __init__(self, views: list[tuple[str, Floats, Floats]], size: Optional[tuple[int, int]],
                 not_found: tuple[str, ...] = (), warnings: tuple[str, ...] = ()) -> None:
        self._views = views
        self.size = size  # width and height of the images, px; None where nobody told
        self.not_found = not_found  # names of images without a complete board
        self.warnings = warnings

    @property
    def names(self) -> list[str]:
        return [name for name, _, _ in self._views]

    @property
    def corners(self) -> list[Floats]:
        """(K, 2), px, of each view; (0, 0) is the centre of the first pixel."""
        return [image for _, _, image in self._views]

    @property
    def board(self) -> list[Floats]:
        """(K, 3), m, the same corners on the board, of each view."""
        return [board for _, board, _ in self._views]

    def __len__(self) -> int:
        return len(self._views)

    def __repr__(self) -> str:
        return f"<{len(self)} views of a board>"


def board_shape(board: Any, square: Any) -> tuple[int, int, float]:
    if not (isinstance(board, tuple) and len(board) == 2 and all(isinstance(n, (int, np.integer)) and 2 <= n <= 200 for n in board)):
        raise ValueError(f"board is {board!r}; the inner corners as (columns, rows), 2 to 200 each, are expected, such as (9, 6)")
    side = arguments.number(square, "square", "metres", above=0.0)
    if not 1e-5 < side < 10.0:
        raise ValueError(f"square is {side:g}; the side of a square in metres is expected: are these millimetres?")
    return int(board[0]), int(board[1]), side


def _found(told: tuple[Any, int, int, list[str], str], columns: int, rows: int) -> BoardViews:
    views, width, height, not_found, doubt = told
    return BoardViews(views, (width, height) if width > 0 else None, tuple(not_found),
                      tuple(f"no complete {columns}x{rows} board in '{name}'" for name in not_found) + ((doubt,) if doubt else ()))


def read_corners(path: Path, board: tuple[int, int] = (9, 6), square: float = 0.025) -> BoardViews:
    """Corners that somebody has found, a CSV table. board: inner corners (columns, rows); square: its side, m."""
    from . import _vision
    columns, rows, side = board_shape(board, square)
    return _found(_vision.read_corners(arguments.path_text(path), columns, rows, side), columns, rows)


def find_corners(images: str, board: tuple[int, int] = (9, 6), square: float = 0.025,
                 window: int | None = None) -> BoardViews:
    """The corners of a chessboard in photographs. images: a pattern such as "left*.jpg"; window: half the window in px in
    which a corner is refined, 0: fitted to each view, None: 11, and 0 where that is too large for most views."""
    from . import _vision
    columns, rows, side = board_shape(board, square)
    return _found(_vision.find_corners(arguments.path_text(images, "images"), columns, rows, side, window), columns, rows)
