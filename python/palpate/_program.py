"""The program `palpate` run for what is no part of the extension modules: sessions in the simulated laboratory, studies.

A process of its own, since a session holds OpenGL, ZeroMQ and protobuf's library, of which a Python process may have others.
"""
from __future__ import annotations

import contextlib
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import Any, Sequence

from ._refused import Refused, refusal, wrong_use


def program() -> str:
    """The program's file: of the environment's PALPATE, of the build or prefix that this package lies in, or of the PATH."""
    named = os.environ.get("PALPATE", "")
    if named:
        return named
    package = pathlib.Path(__file__).absolute().parent
    for place in (package.parents[1] / "palpate", package.parents[3] / "bin" / "palpate"):
        if place.is_file() and os.access(place, os.X_OK):
            return str(place)
    found = shutil.which("palpate")
    if found is None:
        raise FileNotFoundError("the program palpate is not installed, or not on the PATH; install it, or name its file in the "
                                "environment variable PALPATE")
    return found


def run(arguments: Sequence[str]) -> Any:
    """What the program writes with --json. Raises what it refuses: Refused, ValueError or FileNotFoundError, in its words."""
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        figures = pathlib.Path(folder) / "figures.json"
        code, words = _ran([program(), *arguments, f"--json={figures}"])
        if code == 0:
            return json.loads(figures.read_text(encoding="utf-8"))
    if code == 1:
        raise refusal(words, "unspecified")
    if code == 2:
        raise wrong_use(words, "not_found" if "no such file" in words.lower() else "unspecified")
    raise Refused(f"the program palpate ended with {code}: {words}")


def _ran(command: Sequence[str]) -> tuple[int, str]:
    """The exit code, and what was wrong."""
    reads, writes = os.pipe()
    with open(reads, encoding="utf-8", errors="replace") as reports:
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                       pass_fds=(writes,), env={**os.environ, "PALPATE_REPORT_FD": str(writes)})
        except OSError as error:
            raise FileNotFoundError(f"{command[0]}: cannot be started ({error.strerror})") from None
        finally:
            os.close(writes)
        with _ended(process):
            err = process.communicate()[1]
            told = _error(reports.read())
    return process.returncode, told or err.decode("utf-8", "replace").strip() or "it said nothing"


@contextlib.contextmanager
def _ended(process: subprocess.Popen[bytes]) -> Any:
    """Whatever happens here, Ctrl-C too: the process does not go on."""
    try:
        yield
    except BaseException:
        process.kill()
        process.wait()
        raise


def _error(reports: str) -> str:
    """The last error among lines of JSON."""
    words = ""
    for line in reports.splitlines():
        with contextlib.suppress(ValueError):
            report = json.loads(line)
            if isinstance(report, dict) and report.get("event") == "error":
                words = str(report.get("message", ""))
    return words


def option(name: str, value: Any) -> list[str]:
    """--name-of-it value, as the command line has it: numbers to the last bit, lists with commas, True for a flag."""
    dashed = "--" + name.replace("_", "-")
    if value is None or value is False:
        return []
    return [dashed] if value is True else [f"{dashed}={text_of(value)}"]


def text_of(value: Any) -> str:
    if hasattr(value, "tolist"):
        value = value.tolist()  # numpy's
    if isinstance(value, (list, tuple)):
        return ",".join(text_of(part) for part in value)
    return repr(value) if isinstance(value, float) else str(value)
