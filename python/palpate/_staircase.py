"""Adaptive staircases, and the scripted observer that tries them out."""
from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, NamedTuple, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _experiment as core
from ._arguments import Floats


@dataclass(frozen=True)
class StaircaseRule:
    """How the stimulus follows the answers. Stimuli are above 0, in any unit; a larger one is the easier one."""

    kind: str = "transformed"  # n positive answers make it weaker (Levitt); or "weighted": each answer moves it (Kaernbach)
    down_after: int = 2  # n of the transformed rule
    target: float = 0.75  # of the weighted rule: share of positive answers
    start: float = 2.0
    lowest: float = 1.001
    highest: float = 8.0
    step_factors: Sequence[float] = (1.5, 1.3, 1.15)  # downwards, up to the first reversal, the second, ...; the last one stays
    reversals: int = 10  # it ends with so many, or with most_trials
    most_trials: int = 100
    discard: int = 4  # reversals that do not count

    def __post_init__(self) -> None:
        arguments.one_of(self.kind, "kind", ("transformed", "weighted"))
        for name in ("down_after", "reversals", "most_trials", "discard"):
            arguments.whole_number(getattr(self, name), name, 0, 10**6)
        for name in ("target", "start", "lowest", "highest"):
            arguments.number(getattr(self, name), name, "above 0", above=0.0)
        arguments.above_zero(self.step_factors, "step_factors")
        self.share_sought()  # complains of what does not go together

    def _fields(self) -> dict[str, Any]:
        return {**{field.name: getattr(self, field.name) for field in dataclasses.fields(self)},
                "step_factors": [float(factor) for factor in self.step_factors]}

    def share_sought(self) -> float:
        """The share of positive answers that it closes in on."""
        return core.share_sought(self._fields())


class StaircaseThreshold(NamedTuple):
    """Where a staircase has come to rest: the mean of its reversals."""

    stimulus: float
    log_sd: float  # scatter of the reversals' logarithms; they depend on each other, so it is no error of the mean
    reversals: int


class Staircase:
    """One staircase: show `stimulus`, tell `answer`, until it is `finished`."""

    def __init__(self, rule: Optional[StaircaseRule] = None) -> None:
        self.rule = rule or StaircaseRule()
        self._core: Optional[core.Staircase] = core.Staircase(self.rule._fields())
        self._state = self._core.state()

    @classmethod
    def _of(cls, rule: StaircaseRule, state: dict[str, Any]) -> Staircase:
        staircase = cls(rule)
        staircase._core, staircase._state = None, state
        return staircase

    def _own(self) -> core.Staircase:
        if self._core is None:
            raise RuntimeError("this staircase is one of several; tell the answer to all of them")
        return self._core

    @property
    def finished(self) -> bool:
        return bool(self._state["finished"])

    @property
    def stimulus(self) -> float:
        """Of the next trial."""
        return float(self._state["stimulus"])

    @property
    def trials(self) -> int:
        return int(self._state["trials"])

    @property
    def trials_at_limit(self) -> int:
        """Trials with the weakest or the strongest stimulus there is."""
        return int(self._state["trials_at_limit"])

    @property
    def reversals(self) -> Floats:
        """Stimuli at which the direction turned."""
        turned: Floats = self._state["reversals"]
        return turned

    def answer(self, positive: bool) -> None:
        self._own().answer(bool(positive))
        self._state = self._own().state()

    def skip(self) -> None:
        """A trial without an answer: it is counted, and the stimulus stays."""
        self._own().skip()
        self._state = self._own().state()

    def threshold(self) -> Optional[StaircaseThreshold]:
        """None with fewer than two reversals that count."""
        told = self._state["threshold"]
        return None if told is None else StaircaseThreshold(*told)

    def __repr__(self) -> str:
        return f"<staircase: {self.trials} trials, {len(self.reversals)} reversals{', finished' if self.finished else ''}>"


class InterleavedStaircases:
    """Several at a time, in rounds, each in an order that nobody can foresee: ask `next`, show `stimulus`, tell `answer`."""

    def __init__(self, rules: Sequence[StaircaseRule], seed: int) -> None:
        self.rules = list(rules)
        if not self.rules:
            raise ValueError("rules is empty; one rule or more is expected")
        self._core = core.InterleavedStaircases([rule._fields() for rule in self.rules], arguments.seed_number(seed))

    @property
    def finished(self) -> bool:
        return self._core.finished()

    @property
    def next(self) -> int:
        """Whose turn it is."""
        return self._core.next()

    @property
    def stimulus(self) -> float:
        return float(self._core.states()[self.next]["stimulus"])

    def answer(self, positive: Optional[bool]) -> None:
        """Of the one whose turn it is; None: without an answer it passes."""
        self._core.answer(None if positive is None else bool(positive))

    @property
    def all(self) -> list[Staircase]:
        """Each as it stands now; answers go to the whole."""
        return [Staircase._of(rule, state) for rule, state in zip(self.rules, self._core.states())]


class Observer:
    """A scripted observer: compares what it is given with noise of a known size. The same seed, the same answers."""

    def __init__(self, weber_fraction: float = 0.14, lapse_rate: float = 0.02, seed: int = 1) -> None:
        self._core = core.Observer(arguments.number(weber_fraction, "weber_fraction", "such as 0.14", above=0.0),
                                   arguments.number(lapse_rate, "lapse_rate", "0 to 1"), arguments.seed_number(seed))

    def perceived(self, quantities: npt.ArrayLike) -> Floats:
        """What it takes each quantity for: its natural logarithm with noise."""
        return self._core.perceived(arguments.above_zero(quantities, "quantities"))

    def largest(self, quantities: npt.ArrayLike) -> int:
        """The place, from 0, of the one it takes for the largest."""
        return self._core.largest(arguments.above_zero(quantities, "quantities").reshape(1, -1))[0]

    def is_above(self, quantities: npt.ArrayLike, criterion: float) -> npt.NDArray[np.bool_]:
        """Of each quantity, whether it is above a criterion that is remembered without noise."""
        limit = arguments.number(criterion, "criterion", "above 0", above=0.0)
        return np.array(self._core.is_above(arguments.above_zero(quantities, "quantities"), limit), dtype=np.bool_)


def practised_weber_fraction(sessions: int) -> float:
    """The Weber fraction of compliance after so many sessions of practice (Howell et al. 2008)."""
    return core.practised_weber_fraction(arguments.whole_number(sessions, "sessions", 0, 10**6))
