"""A rig file read: what was calibrated, as the file says it, and the transforms that follow from it."""
from __future__ import annotations

import tomllib
from os import PathLike
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import Floats


class RigSurface:
    """A real rectangle of a rig."""

    __slots__ = ("name", "pose", "width", "height", "_known")

    def __init__(self, fields: dict[str, Any]) -> None:
        self.name: str = fields["name"]
        self.pose: Floats = fields["pose"]  # (4, 4), in the world
        self.width: float = fields["width"]  # m
        self.height: float = fields["height"]
        self._known: tuple[Any, ...] = fields["known"]

    def __repr__(self) -> str:
        return f"<surface {self.name}, {1e3 * self.width:.0f} x {1e3 * self.height:.0f} mm>"


class Rig:
    """A rig. `palpate.Rig.load(path)` reads one."""

    def __init__(self, core: Any) -> None:
        self._core = core
        self._transforms: dict[tuple[str, str], Floats] = core.transforms()

    @classmethod
    def load(cls, path: Union[str, PathLike[str]]) -> Rig:
        """Reads a rig file; ValueError names what is wrong in it, with file and line."""
        return cls(_core.Rig(arguments.path_text(path)))

    @property
    def parts(self) -> dict[str, Any]:
        """What the file says, with its keys and units (mm, degrees), absent until calibrated."""
        return tomllib.loads(self._core.text())

    @property
    def surfaces(self) -> list[RigSurface]:
        return [RigSurface(fields) for fields in self._core.surfaces()]

    @property
    def frames(self) -> list[str]:
        """The frames that transform() knows without joints."""
        return sorted({frame for pair in self._transforms for frame in pair})

    def transform(self, parent: str, child: str) -> Floats:
        """The pose of one frame in another, (4, 4), m, where no joint lies between: p_parent = T @ p_child."""
        for frame in (parent, child):
            if frame not in self.frames:
                raise KeyError(f"{frame!r}: this rig knows {', '.join(self.frames) or 'no frame'}; what was not calibrated is missing")
        found = {parent: np.eye(4)}
        open_frames = [parent]
        while open_frames:
            here = open_frames.pop()
            for (a, b), pose in self._transforms.items():
                for start, end, step in ((a, b, pose), (b, a, np.linalg.inv(pose))):
                    if start == here and end not in found:
                        found[end] = found[here] @ step
                        open_frames.append(end)
        if child not in found:
            raise KeyError(f"{child!r} in {parent!r}: nothing fixed joins them; Rig.stylus(joints) is the tip in the world")
        return found[child]

    def stylus(self, joints: npt.ArrayLike, gimbal: Optional[npt.ArrayLike] = None) -> Floats:
        """The stylus in the world at these encoder readings: (N, joints), rad, and (N, 3) of the gimbal, give (N, 4, 4)."""
        count = self._core.joint_count()
        if count == 0:
            raise KeyError("this rig has no calibrated arm; palpate calibrate arm --rig FILE writes one")
        readings = arguments.angles(joints, "joints", count)
        turns = np.zeros((len(readings), 3)) if gimbal is None else arguments.angles(gimbal, "gimbal", 3)
        arguments.same_length(turns, "gimbal", len(readings), "joints")
        stood: Floats = self._core.stylus(readings, turns)
        return stood

    def __repr__(self) -> str:
        return f"<rig with {', '.join(self.parts)}>"
