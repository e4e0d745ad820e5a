"""Experiments with people, or with scripted observers: conditions, the order of trials, answers, what follows from them."""
from __future__ import annotations

from os import PathLike
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _experiment as core

Path = Union[str, "PathLike[str]"]
EXCLUSIONS = ("", "force-limited", "tripped", "interrupted")


class Conditions:
    """What is asked, how often, in which order: `Conditions.read(file)`, `Conditions.parse(text)`, `example_conditions(method)`."""

    def __init__(self, conditions: core.Conditions) -> None:
        self._core = conditions
        fields = conditions.fields()
        self.name: str = fields["name"]
        self.question: str = fields["question"]
        self.task: str = fields["task"]  # choice, comparison or yes-no
        self.places: int = fields["places"]  # what there is to choose from
        self.stimulus: str = fields["stimulus"]  # what is varied, with its unit
        self.method: str = fields["method"]  # constant-stimuli or staircase
        self.levels: tuple[float, ...] = tuple(fields["levels"])  # of constant stimuli
        self.repeats: int = fields["repeats"]
        self.factors: dict[str, list[str]] = fields["factors"]  # levels of each, as they are written
        self.cells: list[list[str]] = fields["cells"]  # combinations of the factors' levels, the last factor changing fastest
        self.most_trials: int = fields["most_trials"]  # without practice and repeats
        self.hash: str = fields["hash"]

    @classmethod
    def read(cls, path: Path) -> Conditions:
        """A TOML file; ValueError names file, line and key of what is wrong."""
        return cls(core.read_conditions(arguments.path_text(path)))

    @classmethod
    def parse(cls, text: str, source: str = "conditions") -> Conditions:
        """The same from a text; `source` is what complaints call it."""
        return cls(core.parse_conditions(text, source))

    def text(self) -> str:
        """The file that read() gives the same back from."""
        return self._core.text()

    def __repr__(self) -> str:
        return f"<conditions {self.name}: {self.method}, {len(self.cells)} cells, {self.most_trials} trials at most>"


def example_conditions(method: str = "constant-stimuli") -> Conditions:
    """To begin with: which of two is stiffer, with and without sight."""
    return Conditions(core.example_conditions(arguments.one_of(method, "method", ("constant-stimuli", "staircase"))))


class Trial(NamedTuple):
    """What to show next."""

    number: int  # from 1, in the order of presentation
    practice: bool
    block: int  # of constant stimuli, from 1; else 0
    track: int  # of staircases, from 1; else 0
    repeated: int  # how often it was left out before
    stimulus: float
    target: int  # the place, from 1, that has the stimulus; the others have the standard
    levels: dict[str, str]  # of the factors


class ExperimentRun:
    """An experiment that is going on.

        run = ExperimentRun(conditions, seed, out="run_1.csv")
        for trial in run:
            place = ask(trial)
            run.answer(place, response_s=took)
        run.to_dict()

    All follows from conditions, seed and answers. `for trial in run` ends rests by itself; who gives people rests looks at
    `state`. out: the file of trials, in which each answer stands before the next trial begins; where it is there already and
    take_up is set, the run goes on after its answers.
    """

    def __init__(self, conditions: Conditions, seed: int, *, out: Optional[Path] = None, take_up: bool = False) -> None:
        self.conditions = conditions
        self.seed = arguments.seed_number(seed)
        self._core = core.Run(conditions._core, self.seed)
        if out is not None:
            path = arguments.path_text(out, "out")
            if take_up:
                self._core.take_up(path)
            else:
                self._core.write_to(path)

    @property
    def state(self) -> str:
        """trial, rest or finished."""
        return self._core.state()

    @property
    def answered(self) -> int:
        """Trials so far, practice included."""
        return self._core.answered()

    @property
    def most_trials(self) -> int:
        """Of all, practice included; what staircases do not need is left over."""
        return self._core.most_trials()

    def next_trial(self) -> Trial:
        return Trial(**self._core.next_trial())

    def end_rest(self) -> None:
        self._core.end_rest()

    def answer(self, place: int, response_s: float = 0.0, time_s: float = 0.0, exclusion: str = "") -> bool:
        """Whether it was a positive answer.

        place: from 1; of a yes-no task 1 is yes and 2 no; 0: none, of a trial that is left out. response_s: how long it took;
        time_s: when it came, since the run's beginning. exclusion: why it does not count: force-limited, tripped, interrupted.
        """
        why = arguments.one_of(exclusion, "exclusion", EXCLUSIONS)
        return self._core.answer(arguments.whole_number(place, "place", 0, self.conditions.places + (self.conditions.task == "yes-no")),
                                 arguments.number(response_s, "response_s", "seconds"), arguments.number(time_s, "time_s", "seconds"), why)

    def __iter__(self) -> ExperimentRun:
        return self

    def __next__(self) -> Trial:
        while self.state == "rest":
            self.end_rest()
        if self.state == "finished":
            raise StopIteration
        return self.next_trial()

    @property
    def table(self) -> dict[str, npt.NDArray[Any]]:
        """The answers so far, an array for each column of the file of trials."""
        return {name: np.array(values) for name, values in self._core.table().items()}

    def to_dict(self, repeats: int = 2000, seed: int = 1, level: float = 0.95) -> dict[str, Any]:
        """What follows from the answers so far: a curve for each cell, a threshold for each staircase.

        repeats, seed: of the bootstrap; level: of the intervals.
        """
        again = arguments.whole_number(repeats, "repeats", 40, 10**6)
        return self._core.report(again, arguments.seed_number(seed), arguments.number(level, "level", "0 to 1", above=0.0))

    def __repr__(self) -> str:
        return f"<run of {self.conditions.name}, seed {self.seed}: {self.answered} trials, {self.state}>"
