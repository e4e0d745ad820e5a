"""Sweeps: one function, or one session, over a table of parameters and many seeds, by as many workers as there are."""
from __future__ import annotations

import itertools
import sys
import time
from dataclasses import fields
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Sequence, Union

import numpy.typing as npt

from . import _arguments as arguments
from . import _cluster as cluster
from ._lockstep import LockstepResult, Path, Session
from ._refused import Refused
from ._sweep_file import PartialFile, Row, column_of, identity, plain

Table = Union[Mapping[str, Sequence[Any]], Sequence[Mapping[str, Any]]]
Study = Union[Callable[..., Mapping[str, Any]], Session]
REFUSED = "refused"  # the column that says why a row has no values


def grid(**values: Iterable[Any]) -> dict[str, list[Any]]:
    """Every combination of these, the last one changing fastest, as a table for sweep(): grid(delay=[0, 0.04], noise=[1, 2])."""
    combinations = list(itertools.product(*(list(each) for each in values.values())))
    return {name: [one[i] for one in combinations] for i, name in enumerate(values)}


def sweep(study: Study, table: Table, seeds: Iterable[int] = (1,), *, out: Optional[Path] = None, workers: Optional[int] = None,
          scheduler: Optional[str] = None, security: Any = None, progress: bool = True) -> dict[str, npt.NDArray[Any]]:
    """Calls study(seed=..., **parameters) for each row of the table with each seed; gives a table, an array for each column.

    study: a function that gives a dict of numbers and texts, the same keys each time; or a Session, whose fields and settings the
    table's columns change, and whose figures are the result ("force.peak_n").
    table: lists of equal length by name (grid() makes one), or a list of dicts.
    out: a CSV file for the same table. A sweep that was interrupted goes on where it stopped when it is called again.
    workers: of a local cluster, None: one for each core; 0: in this process, without Dask. scheduler: the address of one that is
    there already, "tls://host:8786", with security as distributed.Security has it.

    Rows come in the order of the table, seeds within a row, and are equal to the last bit whatever the number of workers. What a
    study refuses stands in the column "refused"; any other exception ends the sweep.
    """
    rows = _rows(table, seeds)
    name = repr(study) if isinstance(study, Session) else f"{getattr(study, '__module__', '')}.{getattr(study, '__qualname__', study)}"
    if workers is not None:
        arguments.whole_number(workers, "workers", 0, 4096)
    if scheduler is not None:
        cluster.check_scheduler(scheduler, security)
    elif workers != 0:
        cluster.check_main_program()
    partial = PartialFile(None if out is None else arguments.path_text(out, "out"), identity(name, rows))
    try:
        left = [number for number in range(len(rows)) if number not in partial.done]
        shown = _Progress(len(rows), len(left)) if progress and left else None
        for number, values in _work(_Task(study), [(number, rows[number]) for number in left], workers, scheduler, security):
            partial.add(number, values)
            if shown is not None:
                shown.update(len(partial.done))
        columns, complete = _joined(rows, partial.done)
        partial.finish(columns, complete)
    finally:
        partial.close()
    return {column: column_of([row.get(column) for row in complete]) for column in columns}


def _rows(table: Table, seeds: Iterable[int]) -> list[Row]:
    if isinstance(table, Mapping):
        lengths = {name: len(values) for name, values in table.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"table: columns of equal length are expected; {', '.join(f'{name} has {n}' for name, n in lengths.items())}")
        given: list[Mapping[str, Any]] = [dict(zip(table, row)) for row in zip(*table.values())]
    else:
        given = list(table)
        if any(not isinstance(row, Mapping) or list(row) != list(given[0]) for row in given):
            raise ValueError("table: a dict of lists, or a list of dicts with the same keys is expected")
    numbers = [arguments.seed_number(seed) for seed in seeds]
    rows = [{**{name: plain(value, name) for name, value in row.items()}, "seed": seed} for row in given for seed in numbers]
    if not rows:
        raise ValueError("table and seeds give no row; one or more of each are expected")
    if "seed" in given[0] or REFUSED in given[0]:
        raise ValueError("table: the columns seed and refused are the sweep's own; call them otherwise")
    return rows


class _Task:
    """What a worker does with its share of the rows."""

    def __init__(self, study: Study) -> None:
        self.study = study

    def __call__(self, share: Sequence[tuple[int, Row]]) -> list[tuple[int, Row]]:
        return [(number, self.one(row)) for number, row in share]

    def one(self, row: Row) -> Row:
        try:
            if isinstance(self.study, Session):
                return figures_of(_changed(self.study, row).run(row["seed"], states=False))
            found = self.study(**row)
        except Refused as refused:
            return {REFUSED: refused.reason}
        except Exception as error:
            error.add_note(f"in the sweep's row {row}")
            raise
        return {str(name): plain(value, str(name)) for name, value in found.items()}


def _changed(session: Session, row: Row) -> Session:
    """Columns with a point in their name are settings, the others fields of the session."""
    known = {field.name for field in fields(Session)} - {"settings"}
    changes = {name: value for name, value in row.items() if name != "seed"}
    settings = {name: changes.pop(name) for name in list(changes) if "." in name}
    for name in changes:
        if name not in known:
            raise ValueError(f"{name}: a session has no such field; there are {', '.join(sorted(known))}, and settings, such as touch.friction")
    return session.but(settings={**session.settings, **settings}, **changes)


def figures_of(result: LockstepResult) -> Row:
    """The figures of a session that are numbers or texts, by names such as "force.peak_n"; what the row says already is left out."""
    flat: Row = {}

    def put(name: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, part in value.items():
                put(f"{name}.{key}" if name else key, part)
        elif not isinstance(value, list):
            flat[name] = value

    put("", {key: part for key, part in result.figures.items() if key not in ("seed", "settings", "application", "seconds", "events")})
    return flat


def _work(task: _Task, left: list[tuple[int, Row]], workers: Optional[int], scheduler: Optional[str],
          security: Any) -> Iterator[tuple[int, Row]]:
    if not left:
        return
    if workers == 0 and scheduler is None:
        for one in left:
            yield from task([one])
        return
    with cluster.client_of(scheduler, security, workers) as client:
        # Small enough that a worker that dies loses little, and large enough that messages cost little.
        size = max(1, min(50, len(left) // (16 * max(1, len(client.scheduler_info()["workers"])))))
        shares = [left[i:i + size] for i in range(0, len(left), size)]
        for done in cluster.outcomes(client, task, shares):
            yield from done


def _joined(rows: list[Row], done: Mapping[int, Row]) -> tuple[list[str], list[Row]]:
    """All columns, and each row with its parameters and what came of it."""
    names: Optional[list[str]] = None
    refusals = False
    for number in range(len(rows)):
        if REFUSED in done[number]:
            refusals = True
        elif names is None:
            names = list(done[number])
        elif list(done[number]) != names:
            raise ValueError(f"the study gives {', '.join(done[number])} for {rows[number]}, and {', '.join(names)} before; the same keys each "
                             "time are expected")
    taken = [name for name in names or [] if name in rows[0]]
    if taken:
        raise ValueError(f"the study gives {', '.join(taken)}, as a parameter is called; call it otherwise")
    columns = [*rows[0], *(names or []), *([REFUSED] if refusals else [])]
    return columns, [{**row, **done[number]} for number, row in enumerate(rows)]


class _Progress:
    """On a terminal a line that is written again and again, else a line for each tenth; on standard error."""

    def __init__(self, total: int, left: int) -> None:
        self._total, self._before = total, total - left
        self._begun = self._drawn = time.monotonic()
        self._tenth = 10 * self._before // total
        self._terminal = sys.stderr.isatty()

    def update(self, done: int) -> None:
        now = time.monotonic()
        pace = (now - self._begun) / max(1, done - self._before)
        left = pace * (self._total - done)
        text = f"sweep: {100 * done // self._total} % ({done} of {self._total}), {time_left(left)} left"
        if self._terminal:
            if now - self._drawn > 0.1 or done == self._total:
                self._drawn = now
                sys.stderr.write(f"\r\x1b[K{text}" if done < self._total else "\r\x1b[K")
        elif 10 * done // self._total > self._tenth:
            self._tenth = 10 * done // self._total
            sys.stderr.write(text + "\n")
        sys.stderr.flush()


def time_left(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole} s" if whole < 60 else f"{whole // 60}:{whole % 60:02d}" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"
