"""States of a running session's world: one, and many that follow each other."""
from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from ._arguments import Floats


class _World:
    """The columns that one state and many have in common; one row has no first dimension."""

    __slots__ = ("_columns", "_one")

    def __init__(self, columns: dict[str, npt.NDArray[Any]], one: bool) -> None:
        self._columns, self._one = columns, one

    def _column(self, name: str) -> npt.NDArray[Any]:
        column = self._columns[name]
        if not self._one:
            return column
        row: npt.NDArray[Any] = column[0]
        return row

    @property
    def positions(self) -> Floats:
        """Of the bodies' origins, World, m: (bodies, 3), of a block (N, bodies, 3)."""
        return self._column("positions")

    def orientations(self, order: str) -> Floats:
        """Unit quaternions that turn vectors of a body into World: (bodies, 4), of a block (N, bodies, 4).

        order: "wxyz" or "xyzw"; there is no default.
        """
        arguments.one_of(order, "order", ("wxyz", "xyzw"))
        rotations = self._column("orientations")
        if order == "wxyz":
            return rotations
        turned: Floats = arguments.read_only(np.roll(rotations, -1, axis=-1))
        return turned

    @property
    def velocities(self) -> Floats:
        """Of the bodies' origins, World, m/s: (bodies, 3), of a block (N, bodies, 3)."""
        return self._column("velocities")

    @property
    def angular_velocities(self) -> Floats:
        """Of the bodies, World, rad/s: (bodies, 3), of a block (N, bodies, 3)."""
        return self._column("angular_velocities")

    @property
    def jumps(self) -> npt.NDArray[np.uint32]:
        """How often each body has jumped (impacts, serves): (bodies,), of a block (N, bodies)."""
        return self._column("jumps")

    @property
    def visible(self) -> npt.NDArray[np.bool_]:
        """Whether each body is shown: (bodies,), of a block (N, bodies)."""
        return self._column("visible")

    @property
    def counters(self) -> npt.NDArray[np.int32]:
        """The application's own counters: (16,), of a block (N, 16)."""
        return self._column("counters")

    @property
    def force(self) -> Floats:
        """What the hand feels, World, N: (3,), of a block (N, 3). The sum of continuous and impact force."""
        force: Floats = arguments.read_only(self._column("continuous_force") + self._column("impact_force"))
        return force

    @property
    def continuous_force(self) -> Floats:
        """The part of the force that lasts as long as its reason, World, N: (3,), of a block (N, 3)."""
        return self._column("continuous_force")

    @property
    def impact_force(self) -> Floats:
        """The part of the force that a blow gives, World, N: (3,), of a block (N, 3)."""
        return self._column("impact_force")

    @property
    def impact_point(self) -> Floats:
        """Where the blow acts, World, m: (3,), of a block (N, 3). Of no meaning where impact_share is 0."""
        return self._column("impact_point")

    @property
    def touching_point(self) -> Floats:
        """Where something is touched, World, m: (3,), of a block (N, 3). Of no meaning where nothing is."""
        return self._column("touching_point")


class State(_World):
    """How the world was at one moment. Arrays are read-only."""

    __slots__ = ("kind", "extrapolated_by")

    kind: str  # how the server knew: "exact", "interpolated", "extrapolated", "too_old", "too_new" (Client.state)
    extrapolated_by: float  # s, the time asked for after the newest step, or (below 0) before the oldest; else 0

    def __init__(self, fields: dict[str, Any]) -> None:
        super().__init__(fields["columns"], one=True)
        self.kind = fields["kind"]
        self.extrapolated_by = fields["extrapolated_by"]

    @property
    def time(self) -> float:
        """On the server's clock, s."""
        return self.time_ns / 1e9

    @property
    def time_ns(self) -> int:
        """On the server's clock, ns."""
        return int(self._column("time_ns"))

    @property
    def tick(self) -> int:
        """The number of the world's last step until then; the first has 1."""
        return int(self._column("tick"))

    @property
    def touching(self) -> bool:
        """Whether something is touched."""
        return bool(self._column("touching"))

    @property
    def impact_share(self) -> float:
        """How much of a blow's duration has passed, above 0 to 1; 0 where there is none."""
        return float(self._column("impact_share"))

    def __repr__(self) -> str:
        return f"<state at {self.time:.3f} s: tick {self.tick}, {len(self.positions)} bodies, {self.kind}>"


class StateBlock(_World):
    """Steps of the world that follow each other, a row each, with their own times. Arrays are read-only."""

    __slots__ = ("missed", "restarted")

    missed: int  # steps that are not there, before the first row or between rows
    restarted: bool  # a server that has come back made these: ticks began anew, and what it did not tell before its end is lost

    def __init__(self, columns: dict[str, npt.NDArray[Any]], missed: int, restarted: bool) -> None:
        super().__init__(columns, one=False)
        self.missed, self.restarted = missed, restarted

    @property
    def time(self) -> Floats:
        """On the server's clock, s: (N,)."""
        seconds: Floats = arguments.read_only(self.time_ns / 1e9)
        return seconds

    @property
    def time_ns(self) -> npt.NDArray[np.int64]:
        """On the server's clock, ns: (N,)."""
        return self._column("time_ns")

    @property
    def tick(self) -> npt.NDArray[np.uint64]:
        """The number of each step: (N,). Numbers that are not there are steps that were missed."""
        return self._column("tick")

    @property
    def touching(self) -> npt.NDArray[np.bool_]:
        """Whether something is touched: (N,)."""
        return self._column("touching")

    @property
    def impact_share(self) -> Floats:
        """How much of a blow's duration has passed, above 0 to 1; 0 where there is none: (N,)."""
        return self._column("impact_share")

    def __len__(self) -> int:
        return len(self.time_ns)

    def __repr__(self) -> str:
        words = f", {self.missed} missed" if self.missed else ""
        return f"<{len(self)} states from tick {self.tick[0]}{words}{', restarted' if self.restarted else ''}>"
