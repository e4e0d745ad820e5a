"""Psychometric curves: how often an answer is positive as the stimulus grows, and how sure that is."""
from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _experiment as core
from ._arguments import Floats, Integers

Ends = tuple[Optional[float], Optional[float]]  # None: the data do not bound it on this side


@dataclass(frozen=True, repr=False, eq=False)
class PsychometricFit:
    """A curve fitted to answers: p(x) = guess + (1 - guess - lapse) Phi((ln x - ln threshold) / spread)."""

    threshold: float  # in the stimulus' unit
    threshold_interval: Ends  # by profile likelihood
    threshold_bootstrap: Ends
    spread: float  # standard deviation along ln x
    spread_interval: Ends
    spread_bootstrap: Ends
    log_threshold_sd: float
    log_spread_sd: float
    lapse: float
    lapse_at_bound: bool
    deviance: float
    deviance_share: float  # of data drawn from the curve with a deviance as large; below 0.05 the curve does not fit
    weber_fraction: Optional[float]  # of a comparison of two
    weber_fraction_interval: Optional[Ends]
    stimuli: Floats  # (K,), rising
    positives: Integers  # (K,)
    trials: Integers  # (K,)
    _task: tuple[bool, float, float]
    _json: dict[str, Any]

    def chance(self, stimuli: npt.ArrayLike) -> Floats:
        """The curve's chance of a positive answer at each stimulus."""
        return core.chances(arguments.above_zero(stimuli, "stimuli"), self.threshold, self.spread, self.lapse, *self._task)

    def stimulus_at(self, share: float) -> float:
        """The stimulus of which this share of answers is positive; nan where the curve does not come there."""
        wanted = arguments.number(share, "share", "0 to 1", above=0.0)
        return core.stimulus_at(wanted, self.threshold, self.spread, self.lapse, *self._task)

    def to_dict(self) -> dict[str, Any]:
        """What `palpate study psychometric --json` writes of a group: the same keys and numbers."""
        return copy.deepcopy(self._json)

    def __repr__(self) -> str:
        def ends(interval: Ends) -> str:
            return " to ".join("?" if end is None else f"{end:.4g}" for end in interval)

        lines = ["Psychometric curve", f"  threshold  {self.threshold:.4g} ({ends(self.threshold_interval)})",
                 f"  spread     {self.spread:.3g} ({ends(self.spread_interval)})"]
        if self.weber_fraction is not None and self.weber_fraction_interval is not None:
            lines.append(f"  Weber fraction {self.weber_fraction:.3g} ({ends(self.weber_fraction_interval)})")
        lines.append(f"  lapses {self.lapse:.2g}, {int(np.sum(self.trials))} trials, deviance {self.deviance:.3g} "
                     f"(share {self.deviance_share:.2f})")
        return "\n".join(lines)


def _counts(count: int, responses: Optional[npt.ArrayLike], positives: Optional[npt.ArrayLike],
            trials: Optional[npt.ArrayLike]) -> tuple[Integers, Integers]:
    if (responses is None) == (positives is None) or (positives is None) != (trials is None):
        raise ValueError("either responses, or positives and trials are expected")
    if responses is not None:
        given = np.asarray(responses)
        given = given.astype(np.int64) if given.dtype == np.bool_ else given
        return arguments.whole(given, "responses", count, "stimuli", 0, 1), np.ones(count, dtype=np.int64)
    tried = arguments.whole(trials, "trials", count, "stimuli", 0, 10**6)
    answered = arguments.whole(positives, "positives", count, "stimuli", 0, 10**6)
    if np.any(answered > tried):
        i = int(np.argmax(answered > tried))
        raise ValueError(f"positives[{i}] is {answered[i]}, of {tried[i]} trials; at most as many are expected")
    return answered, tried


def fit_psychometric(stimuli: npt.ArrayLike, responses: Optional[npt.ArrayLike] = None, *, positives: Optional[npt.ArrayLike] = None,
                     trials: Optional[npt.ArrayLike] = None, comparison: bool = False, guess: float = 0.5, most_lapse: float = 0.06,
                     level: float = 0.95, repeats: int = 2000, seed: int = 1) -> PsychometricFit:
    """The curve most likely to have given these answers.

    stimuli: (N,), above 0. responses: (N,), 1 or True for a positive answer, a row for each trial; or positives and trials, counts.
    comparison: which of two is larger; else guess is the share of positive answers by guessing: 0.5 of two places, 0 of yes and no.
    level: of the intervals. repeats, seed: of the bootstrap.
    Refused, with one of no_trials, one_level, all_positive, all_negative, no_rise, separated, out_of_range as its code, where the
    answers tell no curve.
    """
    given = arguments.above_zero(stimuli, "stimuli")
    answered, tried = _counts(len(given), responses, positives, trials)
    task = (bool(comparison), arguments.number(guess, "guess", "0 to 0.9"), arguments.number(most_lapse, "most_lapse", "0 to 0.2"))
    if not 0.0 <= task[1] <= 0.9 or not 0.0 <= task[2] <= 0.2:
        raise ValueError(f"guess is {guess:g}, most_lapse {most_lapse:g}; 0 to 0.9 and 0 to 0.2 are expected")
    share = arguments.number(level, "level", "0 to 1", above=0.0)
    if share >= 1.0:
        raise ValueError(f"level is {share:g}; less than 1 is expected, such as 0.95")
    again = arguments.whole_number(repeats, "repeats", 40, 10**6)
    found = core.fit(given, answered, tried, *task, share, again, arguments.seed_number(seed))
    told = found["json"]
    levels = told["levels"]

    def ends(key: str) -> Ends:
        low, high = told[key]
        return low, high

    return PsychometricFit(
        threshold=told["threshold"], threshold_interval=ends("threshold_interval"), threshold_bootstrap=ends("threshold_bootstrap"),
        spread=told["spread"], spread_interval=ends("spread_interval"), spread_bootstrap=ends("spread_bootstrap"),
        log_threshold_sd=found["log_threshold_sd"], log_spread_sd=found["log_spread_sd"], lapse=told["lapse"],
        lapse_at_bound=told["lapse_at_bound"], deviance=told["deviance"], deviance_share=told["deviance_share"],
        weber_fraction=told.get("weber_fraction"),
        weber_fraction_interval=ends("weber_fraction_interval") if "weber_fraction_interval" in told else None,
        stimuli=arguments.read_only(np.array([one["stimulus"] for one in levels])),
        positives=arguments.read_only(np.array([one["positives"] for one in levels], dtype=np.int64)),
        trials=arguments.read_only(np.array([one["trials"] for one in levels], dtype=np.int64)), _task=task, _json=told)


def weber_fraction(spread: float) -> float:
    """The Weber fraction of whoever compares two with this spread."""
    return core.weber_fraction(arguments.number(spread, "spread", "of ln stimulus", above=0.0))


def spread_of_weber_fraction(fraction: float) -> float:
    """The spread of a comparison that has this Weber fraction."""
    return core.spread_of_weber_fraction(arguments.number(fraction, "fraction", "such as 0.14", above=0.0))
