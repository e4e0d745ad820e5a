"""What a sweep keeps on the disk: each row as it comes, so that it can go on after an interruption; at the end the table.

The rows that are done stand in FILE.partial, a line of JSON each, given to the system one by one and on the disk within a second.
A line that was cut off is dropped when the sweep goes on. FILE itself is there whole or not at all.
"""
from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import pathlib
import time
from typing import Any, BinaryIO, Optional

import numpy as np
import numpy.typing as npt

Row = dict[str, Any]
Cell = npt.NDArray[Any]


def plain(value: Any, name: str) -> Any:
    """A number, a truth or a text, as JSON and CSV have them; floats to the last bit."""
    if hasattr(value, "tolist") and getattr(value, "ndim", 0) == 0:
        value = value.tolist()  # numpy's
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{name} is {type(value).__name__}; a number, a text, True or False is expected in a cell of the table")


def identity(name: str, rows: list[Row]) -> str:
    """Of a sweep: what is called, and with what."""
    return hashlib.sha256(json.dumps([name, rows]).encode()).hexdigest()[:16]


class PartialFile:
    """The rows of one sweep that are done."""

    def __init__(self, out: Optional[str], sweep: str) -> None:
        self.done: dict[int, Row] = {}
        self._out = out
        self._file: Optional[BinaryIO] = None
        self._synced = 0.0
        if out is None:
            return
        if os.path.exists(out):
            raise FileExistsError(f"{out}: is there already; name a new file, or remove it first")
        self._partial = out + ".partial"
        self._take_up(sweep)

    def _take_up(self, sweep: str) -> None:
        kept = b""
        if os.path.exists(self._partial):
            content = pathlib.Path(self._partial).read_bytes()
            kept = content[:content.rfind(b"\n") + 1]  # without a line that was cut off
            lines = kept.splitlines()
            if lines and json.loads(lines[0]).get("sweep") != sweep:
                raise ValueError(f"{self._partial}: belongs to another sweep, with other parameters, seeds or function; "
                                 "remove it, or name another file")
            for line in lines[1:]:
                told = json.loads(line)
                self.done[told["row"]] = told["values"]
        file = open(self._partial, "r+b" if kept else "wb")
        file.truncate(len(kept))
        file.seek(len(kept))
        self._file = file
        if not kept:
            self._write({"sweep": sweep})

    def _write(self, told: dict[str, Any]) -> None:
        assert self._file is not None
        self._file.write(json.dumps(told).encode() + b"\n")
        self._file.flush()
        if time.monotonic() - self._synced > 1.0:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()

    def add(self, number: int, values: Row) -> None:
        self.done[number] = values
        if self._file is not None:
            self._write({"row": number, "values": values})

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def finish(self, columns: list[str], rows: list[Row]) -> None:
        """The table takes the partial file's place."""
        self.close()
        if self._out is None:
            return
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            writer.writerow([cell_text(row.get(column)) for column in columns])
        half = self._out + ".half"
        with open(half, "w", encoding="utf-8", newline="") as file:
            file.write(text.getvalue())
            file.flush()
            os.fsync(file.fileno())
        os.replace(half, self._out)
        os.remove(self._partial)


def cell_text(value: Any) -> str:
    """Numbers with all the digits that give the same again."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return repr(value) if isinstance(value, float) else str(value)


def column_of(values: list[Any]) -> Cell:
    """As an array: truths, whole numbers, numbers (what is missing is nan), or texts."""
    if all(isinstance(value, bool) for value in values):
        array: Cell = np.array(values, dtype=np.bool_)
    elif all(isinstance(value, int) for value in values):
        array = np.array(values)
    elif all(value is None or isinstance(value, (bool, int, float)) for value in values):
        array = np.array([np.nan if value is None else float(value) for value in values])
    else:
        array = np.array(["" if value is None else str(value) for value in values])
    array.flags.writeable = False
    return array
