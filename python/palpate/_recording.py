"""A recording of a session (MCAP) read: each topic as columns of numpy, or as a table of pandas."""
from __future__ import annotations

from os import PathLike
from typing import Any, Iterator, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

Column = Union[npt.NDArray[Any], list[str]]
_LAST_NS = 2**63 - 1


class Topic:
    """The messages of one topic, a row each. Arrays are read-only.

    A field has its name in the message's description (docs/recording.md), one of a message within it a point in between:
    "tip_m.x". A number that repeats is an array (N, most), what a shorter message lacks NaN or 0. What no message within a
    message said is NaN or 0, too. Of pictures the bytes are counted.
    """

    def __init__(self, name: str, start_ns: int, fields: dict[str, Any]) -> None:
        self.name = name
        self.schema: str = fields["schema"]  # the message's full name
        self.unread: int = fields["unread"]  # messages that are not what they should be; their rows are not complete
        self.log_time_ns: npt.NDArray[np.int64] = fields["log_time_ns"]  # on the recording's one timeline
        self._start_ns = start_ns
        self._columns: dict[str, Column] = fields["columns"]

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """(N,), s since the recording's beginning."""
        seconds: npt.NDArray[np.float64] = (self.log_time_ns - self._start_ns) / 1e9
        return seconds

    @property
    def columns(self) -> list[str]:
        return list(self._columns)

    def __getitem__(self, column: str) -> Column:
        """A column; of a vector "tip_m" its x, y and z, (N, 3)."""
        if column in self._columns:
            return self._columns[column]
        parts = [self._columns.get(f"{column}.{axis}") for axis in "xyz"]
        if all(isinstance(part, np.ndarray) for part in parts):
            return arguments.read_only(np.stack(parts, axis=1))  # type: ignore[arg-type]
        raise KeyError(f"{column!r}; {self.name} has {', '.join(self._columns) or 'no messages'}")

    def to_numpy(self) -> dict[str, Column]:
        """All columns by name."""
        return dict(self._columns)

    def to_dataframe(self) -> Any:
        """A table of pandas (python3-pandas), the time its index; a number that repeats as columns "joints_rad.0" ..."""
        import pandas  # type: ignore[import]
        table: dict[str, Any] = {}
        for name, column in self._columns.items():
            if isinstance(column, np.ndarray) and column.ndim == 2:
                table.update({f"{name}.{k}": column[:, k] for k in range(column.shape[1])})
            else:
                table[name] = column
        return pandas.DataFrame(table, index=pandas.Index(self.time, name="time_s"))

    def __len__(self) -> int:
        return len(self.log_time_ns)

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self)} messages of {self.schema}>"


class Recording:
    """A recording. `recording["/arm/sample"]` is a Topic, read when it is asked for.

    What is damaged is left out and told in `faults`; a recording whose writer was killed is read as far as it is sound.
    """

    def __init__(self, path: Union[str, PathLike[str]]) -> None:
        self._path = arguments.path_text(path)
        info = _core.recording_info(self._path)
        self.topics: dict[str, int] = {name: told[0] for name, told in info["topics"].items()}  # messages of each
        self.dropped: dict[str, int] = {name: told[1] for name, told in info["topics"].items()}  # while it was recorded
        self.seconds: float = info["seconds"]  # between the first and the last message
        self.version: str = info["version"]  # of Palpate that wrote it
        self.faults: tuple[str, ...] = tuple(info["faults"])
        self._start_ns: int = info["start_ns"]

    def topic(self, name: str, from_s: float = 0.0, to_s: Optional[float] = None) -> Topic:
        """One topic, or the part of it between these times, s since the recording's beginning."""
        if name not in self.topics:
            raise KeyError(f"{name!r}; this recording has {', '.join(self.topics) or 'no topics'}")
        begin = arguments.number(from_s, "from_s", "seconds")
        until = _LAST_NS if to_s is None else self._start_ns + round(1e9 * arguments.number(to_s, "to_s", "seconds"))
        fields = _core.recording_topic(self._path, name, max(0, self._start_ns + round(1e9 * begin)), max(0, until))
        return Topic(name, self._start_ns, fields)

    def __getitem__(self, name: str) -> Topic:
        return self.topic(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.topics)

    def __len__(self) -> int:
        return len(self.topics)

    def __contains__(self, name: object) -> bool:
        return name in self.topics

    def __repr__(self) -> str:
        return f"<recording of {self.seconds:.1f} s, {len(self.topics)} topics>"
