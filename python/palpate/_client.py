"""A running session looked at and steered: what plays there, the states of its world, a person's wishes."""
from __future__ import annotations

import threading
import weakref
from os import PathLike
from types import TracebackType
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Optional, Union

import numpy as np

from . import _arguments as arguments
from ._arguments import Floats
from ._refused import Refused
from ._states import State, StateBlock

if TYPE_CHECKING:
    from . import _live

ROLES = ("observer", "graphics", "operator")
CONTROLS = ("begin", "reset", "pause", "resume")


class Body(NamedTuple):
    """A body of the world."""

    name: str  # empty where it has none
    mass: float  # kg; 0 where nobody says it, or it is held fast


class SceneSurface(NamedTuple):
    """A real rectangle, as the server's rig has it."""

    name: str
    corners: Floats  # (4, 3), World, m, in the order in which they were touched


class ServerClock(NamedTuple):
    """How the server's clock read beside this machine's at one moment."""

    local: float  # s, as time.monotonic() gives it
    server: float  # s, of the server's clock at the same moment
    uncertainty: float  # s, how far `server` may be wrong: half of the round trip and three standard deviations
    drift: float  # s/s, what the server's clock gains
    round_trip: float  # s, the shortest so far
    settled: bool  # False in the first seconds, and where the newest exchanges contradict those before

    @property
    def offset(self) -> float:
        """The server's clock minus this machine's, s."""
        return self.server - self.local

    def server_time(self, local: float) -> float:
        """The server's time, s, when time.monotonic() is `local`."""
        return self.server + (local - self.local) * (1.0 + self.drift)

    def local_time(self, server: float) -> float:
        """time.monotonic(), s, when the server's time is `server`."""
        return self.local + (server - self.server) / (1.0 + self.drift)


class Client:
    """A client of a physics server.

        with palpate.Client() as client:
            print(client.application, client.state().positions)

    Many threads may use one. A call that waits lets other threads run, and Ctrl-C ends it. When it is closed, loops over
    its states end, and other calls raise ValueError.
    """

    def __init__(self, address: str = "", *, role: Optional[str] = None, keys: Union[str, PathLike[str], None] = None,
                 server_key: str = "", insecure: bool = False, name: str = "python", patience: float = 10.0) -> None:
        """Connects, and returns when the server has said what it plays.

        address: "ipc://PATH" or "tcp://HOST:PORT"; empty: this user's own server.
        role: "observer", "graphics" or "operator": as what it comes. It may do no more than that, and is refused where the
            server lets it do less. None: whatever the server lets it do.
        keys: the folder of this machine's keys, for tcp://; None: this user's. server_key: the server's public key;
            empty: the one known for the address. insecure: tcp:// without encryption.
        name: what `palpate status` calls this client, at most 64 bytes.
        patience: how long to wait for a server that does not answer, here and in all other calls, s.

        Raises ValueError for what is no address; palpate.Refused where nobody answers (code "timed_out"), keys are
        missing, or the role is not granted.
        """
        from . import _live
        if role is not None:
            arguments.one_of(role, "role", ROLES)
        self._patience = arguments.number(patience, "patience", "seconds", above=0.0)
        self._wanted = role
        self._core = _live.Client(address, insecure, "" if keys is None else arguments.path_text(keys, "keys"), server_key, name)
        self._may = _live.may
        self._end = weakref.finalize(self, self._core.close)
        self._control = threading.Lock()
        try:
            if not self._core.wait_for_scene(self._patience):
                raise self._silent()
            granted = self.role
            if role is not None and ROLES.index(granted) < ROLES.index(role):
                raise Refused(f"the server at {self.address} lets this machine in as {granted}, not as {role}; there, "
                              f"`palpate keys authorize KEY --role {role} --name NAME` gives it that role")
        except BaseException:
            self.close()
            raise

    def _silent(self) -> Refused:
        facts = self._core.facts()
        if facts["trouble"]:
            return Refused(f"the physics server at {self.address}: {facts['trouble']}", "timed_out")
        return Refused(f"no physics server answers at {self.address} after {self._patience:g} s; start `palpate physics` first, "
                       f"or name the address that it listens at", "timed_out")

    def _facts(self) -> dict[str, Any]:
        self._open()
        return self._core.facts()

    def _open(self) -> None:
        if self._core.closed():
            raise ValueError("this client is closed; palpate.Client(...) makes a new one")

    @property
    def address(self) -> str:
        """Of the server."""
        return self._core.address()

    @property
    def application(self) -> str:
        """What plays there: "pingpong". After a server has come back it may be another."""
        name: str = self._facts()["application"]
        return name

    @property
    def bodies(self) -> tuple[Body, ...]:
        """What body 0, 1, ... of a state is; body 1 is the one that the stylus carries."""
        return tuple(Body(*told) for told in self._facts()["bodies"])

    @property
    def surfaces(self) -> tuple[SceneSurface, ...]:
        """The real surfaces of the server's rig."""
        return tuple(SceneSurface(*told) for told in self._facts()["surfaces"])

    @property
    def gravity(self) -> Floats:
        """(3,), World, m/s^2."""
        gravity: Floats = self._facts()["gravity"]
        return gravity

    @property
    def carried_offset(self) -> Floats:
        """From the stylus tip to the body that it carries, (3,), in the tip's frame, m."""
        offset: Floats = self._facts()["carried_offset"]
        return offset

    @property
    def settings(self) -> bytes:
        """The application's own settings as they travel; JSON of the applications that come with Palpate."""
        content: bytes = self._facts()["settings"]
        return content

    @property
    def session(self) -> int:
        """The number of the server's life: another one after it was started again."""
        number: int = self._facts()["session"]
        return number

    @property
    def alive(self) -> bool:
        """Whether the server answers. A client finds it again by itself."""
        there: bool = self._facts()["alive"]
        return there

    @property
    def role(self) -> str:
        """What this client may do: "observer" (see), "graphics" (and begin) or "operator" (and reset, pause, resume)."""
        granted: str = self._facts()["role"]
        if self._wanted is None:
            return granted
        return min(granted, self._wanted, key=ROLES.index)

    def state(self, at: Optional[float] = None) -> State:
        """The world's newest step, or the state at a time.

        at: on the server's clock, s (ServerClock.server_time). Of the last 8 s it is what was, between two steps
            interpolated; up to 0.1 s ahead it is extrapolated. State.kind says which: "exact", "interpolated",
            "extrapolated" (by State.extrapolated_by, s), "too_old" or "too_new" (then it is the oldest or newest there is).

        Raises palpate.Refused where the server does not answer, or its world has not moved yet, for want of an arm.
        """
        self._open()
        wanted = None if at is None else round(1e9 * arguments.number(at, "at", "seconds of the server's clock"))
        if wanted is not None and abs(wanted) >= 2**60:
            raise ValueError(f"at is {at:g}; seconds of the server's clock are expected: are these nanoseconds?")
        fields = self._core.state(wanted, self._patience)
        if fields is None:
            raise self._closed_meanwhile() or self._silent()
        state = State(fields)
        if state.tick == 0:
            raise Refused("the world has not moved yet: the server has no arm to follow; `palpate status` says why", "not_found")
        return state

    def _closed_meanwhile(self) -> Optional[Refused]:
        return Refused("this client was closed while it waited", "stopped") if self._core.closed() else None

    def states(self, every: float = 0.1) -> States:
        """Every step of the world from now on: an iterator over blocks of them, without a gap.

        every: how much time a block covers, s.

        They are read from the server's history, which holds 8 s; this client holds 16 s for a loop that is slow. Steps that
        are lost all the same are counted: StateBlock.missed.
        """
        self._open()
        return States(self, self._core, arguments.number(every, "every", "seconds", above=0.0))

    def watch(self, rate: int) -> Watch:
        """The newest state, again and again: an iterator over states as they come.

        rate: how many a second, 1 to 1000, a whole number. A loop that is slower gets the newest and skips the others.
        """
        self._open()
        if isinstance(rate, bool) or not isinstance(rate, (int, np.integer)) or not 1 <= rate <= 1000:
            raise ValueError(f"rate is {rate!r}; a whole number from 1 to 1000, states a second, is expected")
        return Watch(self, self._core, int(rate))

    def control(self, wish: str) -> None:
        """Hands a person's wish to the application, and returns when the server has taken it.

        wish: "begin" (whatever a person begins there: a serve, the next trial), "reset", "pause" or "resume".

        Raises palpate.Refused where the role may not, and where the server does not take it within 2 s: it will not be
        carried out later.
        """
        self._open()
        arguments.one_of(wish, "wish", CONTROLS)
        allowed = [role for role in ROLES if self._may(role, wish)]
        if self.role not in allowed:
            raise Refused(f"{wish!r}: this client has the role {self.role}, and {' or '.join(allowed)} is needed; "
                          f"{self._how_it_may(allowed)}")
        with self._control:
            became = self._core.control(wish)
        if became == "closed":
            raise Refused("this client was closed while it waited", "stopped")
        if became == "dropped":
            trouble = self._facts()["trouble"]
            raise Refused(f"{wish!r}: the server at {self.address} has not taken it within 2 s{': ' + trouble if trouble else ''}",
                          "timed_out")

    def _how_it_may(self, allowed: list[str]) -> str:
        if self._facts()["role"] in allowed:
            return f"make it with role={allowed[0]!r}"
        return f"at the server, `palpate keys authorize KEY --role {allowed[0]} --name NAME` gives it"

    def clock(self) -> ServerClock:
        """The server's clock beside this machine's, as exchanges of time stamps tell it.

        Raises palpate.Refused where the server does not answer.
        """
        self._open()
        told = self._core.clock(self._patience)
        if told is None:
            raise self._closed_meanwhile() or self._silent()
        return ServerClock(told["local_ns"] / 1e9, told["server_ns"] / 1e9, told["uncertainty"], told["drift"], told["round_trip"],
                           told["settled"])

    @property
    def closed(self) -> bool:
        """Whether it is closed."""
        return self._core.closed()

    def close(self) -> None:
        """Ends it, also from another thread; again and again, if you like."""
        self._end()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: Optional[type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        if self.closed:
            return f"<client of {self.address}, closed>"
        return f"<client of {self.application} at {self.address}, {self.role}>"


class States(Iterator[StateBlock]):
    """Blocks of steps, as Client.states gives them. A loop over it ends when the client is closed."""

    def __init__(self, client: Client, core: _live.Client, every: float) -> None:
        self._client, self._core, self._every = client, core, every
        self._steps = core.begin_steps()
        self._last: Optional[int] = None
        self.missed: int = 0  # steps, so far
        weakref.finalize(self, core.end_steps, self._steps)

    def __next__(self) -> StateBlock:
        """The next block. Raises palpate.Refused where the server has not moved its world for as long as the client's patience."""
        told = self._core.next_block(self._steps, self._every, self._every + self._client._patience)
        if told is None:
            if self._core.closed():
                raise StopIteration
            if not self._core.facts()["alive"]:
                raise self._client._silent()
            raise Refused(f"the server at {self._client.address} answers, but its world has not moved for {self._client._patience:g} s; "
                          f"`palpate status` says whether it has an arm", "timed_out")
        columns, restarted = told
        ticks = columns["tick"]
        first, last = int(ticks[0]), int(ticks[-1])
        before = first - 1 if restarted or self._last is None else self._last
        missed = last - before - len(ticks)
        self._last = last
        self.missed += missed
        return StateBlock(columns, missed, restarted)


class Watch(Iterator[State]):
    """States at a rate, as Client.watch gives them. A loop over it ends when the client is closed."""

    def __init__(self, client: Client, core: _live.Client, rate: int) -> None:
        self._client, self._core, self._rate = client, core, rate
        self._watch = core.begin_watch(rate)
        weakref.finalize(self, core.end_watch, self._watch)

    @property
    def skipped(self) -> int:
        """States that had come and were not looked at, because a newer one had, too."""
        return self._watch.counts()[0]

    @property
    def missed(self) -> int:
        """States that were lost on their way."""
        return self._watch.counts()[1]

    def __next__(self) -> State:
        """The newest that has come since the last one. Raises palpate.Refused where none comes for as long as the client's patience."""
        fields = self._core.next_watched(self._watch, min(5e-3, 0.25 / self._rate), 1.0 / self._rate + self._client._patience)
        if fields is not None:
            return State(fields)
        if self._core.closed():
            raise StopIteration
        if refusal := self._watch.refusal():
            raise Refused(f"the server at {self._client.address} sends no states: {refusal}", "exhausted")
        raise self._client._silent()
