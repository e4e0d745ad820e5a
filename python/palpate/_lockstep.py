"""Sessions in the simulated laboratory on the virtual clock: an application, a scripted player, figures and states."""
from __future__ import annotations

import copy
import dataclasses
import os
import pathlib
import tempfile
from dataclasses import dataclass, field
from typing import Any, Mapping, Optional, Union

from . import _arguments as arguments
from . import _program
from ._recording import Recording, Topic

Path = Union[str, "os.PathLike[str]"]


class LockstepResult:
    """What came of a session.

    figures: what `palpate lockstep --json` writes. events: its list of moments, `{"time_s", "event", ...}`. states, forces and
    samples: columns of the play at 1 kHz, numpy arrays by name; None where they were not asked for.
    """

    def __init__(self, figures: dict[str, Any], topics: Mapping[str, Topic]) -> None:
        self.figures = figures
        self.events: list[dict[str, Any]] = figures["events"]
        self.states: Optional[Topic] = topics.get("/physics/state")
        self.forces: Optional[Topic] = topics.get("/arm/force")
        self.samples: Optional[Topic] = topics.get("/arm/sample")

    def to_dict(self) -> dict[str, Any]:
        return copy.deepcopy(self.figures)

    def __repr__(self) -> str:
        told = self.figures
        return f"<session of {told['application']}, seed {told['seed']}: {told['seconds']:g} s, {len(self.events)} events>"


@dataclass(frozen=True)
class Session:
    """A session as a value: what is played, by whom, through which delays. `run(seed)` plays it.

    The same session and seed give the same figures and states to the last bit. It can be sent to another process or machine.
    """

    application: str
    seconds: float = 10.0
    settings: Mapping[str, Any] = field(default_factory=dict)  # of the application by name, in the unit that the name ends in
    world: Optional[Path] = None  # world file; None: the reference laboratory
    rig: Optional[Path] = None  # calibrated rig file of this world and seed; None: without errors of calibration
    force_delay: Optional[float] = None  # s, added to the forces; None: as the world file says
    picture_delay: Optional[float] = None  # s, added to the pictures
    player_delay: float = 0.0  # s: the player sees everything so much later
    network_delay: float = 150e-6  # s, one way
    network_jitter: float = 50e-6  # s, mean, on top of it
    network_loss: float = 0.0  # share of the messages

    def __post_init__(self) -> None:
        if not isinstance(self.application, str):
            raise TypeError(f"application is {self.application!r}; the name of one is expected, such as those that `palpate apps` lists")
        for name in ("seconds", "player_delay", "network_delay", "network_jitter", "network_loss", "force_delay", "picture_delay"):
            value = getattr(self, name)
            if value is not None:
                arguments.number(value, name, "a share" if name == "network_loss" else "seconds")
        if not isinstance(self.settings, Mapping):
            raise TypeError(f"settings is {self.settings!r}; a dict of names and values is expected")

    def run(self, seed: int = 1, *, states: bool = True, record: Optional[Path] = None) -> LockstepResult:
        """Plays it. seed: draws the laboratory, all noise, the delays and the player.

        states: read states, forces and samples, too. record: keep the recording (MCAP) in this new file.
        Other threads go on meanwhile.
        """
        command = self._command(arguments.seed_number(seed))
        if record is not None:
            return self._played(command, arguments.path_text(record, "record"), states)
        if not states:
            return self._played(command, "", states)
        with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
            return self._played(command, str(pathlib.Path(folder) / "play.mcap"), states)

    def but(self, **changes: Any) -> Session:
        """The same with other fields: session.but(force_delay=0.040)."""
        return dataclasses.replace(self, **changes)

    def _command(self, seed: int) -> list[str]:
        def ms(seconds: Optional[float]) -> Optional[float]:
            return None if seconds is None else 1e3 * float(seconds)

        option = _program.option
        words = ["lockstep", "--quiet", *option("app", self.application), *option("seed", seed), *option("seconds", float(self.seconds))]
        words += option("world", None if self.world is None else arguments.path_text(self.world, "world"))
        words += option("rig", None if self.rig is None else arguments.path_text(self.rig, "rig"))
        for name, value in self.settings.items():
            words.append(f"--set={name}={_program.text_of(value)}")
        words += option("extra_force_delay_ms", ms(self.force_delay)) + option("extra_picture_delay_ms", ms(self.picture_delay))
        words += option("player_delay_ms", ms(self.player_delay)) + option("network_delay_ms", ms(self.network_delay))
        return words + option("network_jitter_ms", ms(self.network_jitter)) + option("network_loss", float(self.network_loss))

    @staticmethod
    def _played(command: list[str], record: str, states: bool) -> LockstepResult:
        figures = _program.run(command + _program.option("record", record or None))
        if not states:
            return LockstepResult(figures, {})
        recording = Recording(record)
        return LockstepResult(figures, {name: recording[name] for name in ("/physics/state", "/arm/force", "/arm/sample")})


def lockstep(application: str, *, seed: int = 1, states: bool = True, record: Optional[Path] = None, **session: Any) -> LockstepResult:
    """Plays an application in the simulated laboratory on the virtual clock: `Session(application, ...).run(seed)`.

        palpate.lockstep("touch", seed=3, seconds=8, settings={"touch.stiffness_n_m": 400}, force_delay=0.040)
    """
    return Session(application, **session).run(seed, states=states, record=record)


def study(name: str, *, out: Optional[Path] = None, **options: Any) -> dict[str, Any]:
    """`palpate study NAME`: its figures, as --json has them. options: those of the command, `runs=100` for `--runs 100`.

    out: a folder for the page and the tables.
    """
    if not isinstance(name, str) or not name or name.startswith("-"):
        raise ValueError(f"name is {name!r}; the name of a study is expected, such as those that `palpate study --help` lists")
    words = ["study", name]
    for key, value in options.items():
        words += _program.option(key, value)
    figures: dict[str, Any] = _program.run(words + _program.option("out", None if out is None else arguments.path_text(out, "out")))
    return figures
