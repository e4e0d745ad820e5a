"""What the library says no with: data that cannot carry an answer, and arguments that make no sense."""
from __future__ import annotations

# The library speaks of the command line's options; here the same things are called:
_CALLED_HERE = (
    ("--segments COLUMN, or auto", 'segments=..., or "auto"'),
    ("--test FILE judges", "test=... judges"),
    ("(--free ...,delay)", "(free=[..., \"delay\"])"),
    ("--free ", "free="),
    ("--estimate-delay", "estimate_delay=True"),
    ("--with-arm", "subtract_motion=True"),
    ("--test", "test="),
    ("--tip-mm", "tip="),
    ("--app ", "application="),
    ("--extra-force-delay-ms", "force_delay, in ms,"),
    ("--extra-picture-delay-ms", "picture_delay, in ms,"),
    ("--player-delay-ms", "player_delay, in ms,"),
    ("--network-delay-ms", "network_delay, in ms,"),
    ("--network-jitter-ms", "network_jitter, in ms,"),
    ("--network-loss", "network_loss"),
    ("--seconds", "seconds"),
)


def in_python(words: str) -> str:
    """The same words with this package's arguments in place of the command line's options."""
    for option, argument in _CALLED_HERE:
        words = words.replace(option, argument)
    return words


class Refused(Exception):
    """Sound arguments, and still no answer: the data or the machine cannot carry one.

    reason: what is wrong, and mostly what to do about it, in words.
    remedy: the part that says what to do; empty where there is none.
    code: what a program can act on: "unspecified", "not_found", "exhausted", "timed_out" ...
    """

    def __init__(self, reason: str, code: str = "unspecified") -> None:
        super().__init__(reason)
        self.reason = reason
        self.code = code
        self.remedy = reason.partition("; ")[2]


def refusal(message: str, code: str) -> Exception:
    return Refused(in_python(message), code)


def wrong_use(message: str, code: str) -> Exception:
    if code == "not_found":
        return FileNotFoundError(in_python(message))
    return ValueError(in_python(message))
