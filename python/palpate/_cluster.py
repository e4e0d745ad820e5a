"""The workers of a sweep, by Dask (python3-distributed): a local cluster, or one that somebody else has started.

Whoever may speak to a Dask scheduler runs code as its owner. So a local cluster listens on 127.0.0.1 alone and only to who has
its key, and one beyond this machine is joined through TLS or not at all.
"""
from __future__ import annotations

import ast
import contextlib
import importlib
import ipaddress
import logging
import os
import pathlib
import sys
import types
import urllib.parse
from typing import Any, Callable, Iterator, Optional, Sequence

Work = Callable[[Any], Any]


def check_scheduler(address: str, security: Any) -> None:
    """Refuses, in words, an address at which anybody on the way could give the workers code of their own."""
    parts = urllib.parse.urlsplit(address if "://" in address else "tcp://" + address)
    if parts.scheme not in ("tcp", "tls") or not parts.hostname or parts.port is None:
        raise ValueError(f"scheduler is {address!r}; an address such as tls://host:8786 is expected, as the scheduler prints it")
    if parts.scheme == "tls":
        if security is None:
            raise ValueError(f"scheduler {address}: TLS needs keys; give security=distributed.Security(tls_ca_file=..., "
                             "tls_client_cert=..., tls_client_key=..., require_encryption=True)")
        return
    if not _is_this_machine(parts.hostname):
        raise ValueError(f"scheduler {address}: is beyond this machine and not encrypted; whoever is on the way could run code on "
                         "every worker. Start it with TLS and give its address as tls://")


def _is_this_machine(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False  # a name may lead anywhere


def check_main_program() -> None:
    """Refuses, in words, a script that would begin its sweep anew in every worker: a worker imports the script once more."""
    main = sys.modules.get("__main__")
    path = getattr(main, "__file__", None)
    frame: Optional[types.FrameType] = sys._getframe()
    while frame is not None and not (frame.f_code.co_name == "<module>" and frame.f_globals is getattr(main, "__dict__", None)):
        frame = frame.f_back
    if path is None or frame is None:
        return  # a prompt, a notebook
    try:
        tree = ast.parse(pathlib.Path(path).read_bytes())
    except (OSError, SyntaxError):
        return
    line = frame.f_lineno
    for part in tree.body:
        if isinstance(part, ast.If) and part.lineno <= line <= (part.end_lineno or line) and "__name__" in ast.dump(part.test):
            return
    raise RuntimeError(f"{path}, line {line}: each worker of a sweep imports this file, and would begin the sweep again; put the "
                       'call below if __name__ == "__main__":, or give workers=0 (this process alone)')


def _distributed() -> Any:
    try:
        importlib.import_module("cryptography")
        return importlib.import_module("distributed")
    except ImportError as error:
        raise ImportError(f"a sweep over workers needs Dask ({error}): apt install python3-distributed python3-cryptography; "
                          "workers=0 does without, in this process") from None


def _patience() -> Any:
    """On a busy machine a process takes long to start, and is none the worse for it."""
    return importlib.import_module("dask").config.set({"distributed.comm.timeouts.connect": "300s", "distributed.comm.timeouts.tcp": "300s",
                                                       "distributed.scheduler.worker-ttl": None})


def _patience_once_started() -> Any:
    """What a worker has found may be asked for when it has just died: its address is tried for so long before others do it again."""
    return importlib.import_module("dask").config.set({"distributed.comm.timeouts.connect": "20s"})


@contextlib.contextmanager
def client_of(scheduler: Optional[str], security: Any, workers: Optional[int]) -> Iterator[Any]:
    """A client of the scheduler, or of a local cluster with so many workers; None: one for each core."""
    if scheduler is not None:
        check_scheduler(scheduler, security)
        with _distributed().Client(scheduler, security=security) as client:
            yield client
        return
    distributed = _distributed()
    with _patience(), distributed.LocalCluster(n_workers=workers or os.cpu_count(), threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
                                  worker_dashboard_address=None, security=distributed.Security.temporary(),
                                  silence_logs=logging.CRITICAL) as cluster:
        with distributed.Client(cluster, timeout=300) as client, _patience_once_started():
            yield client


def outcomes(client: Any, work: Work, shares: Sequence[Any]) -> Iterator[Any]:
    """What work() makes of each share, as it comes. A worker that dies has its share done by another one."""
    distributed = _distributed()
    futures = [client.submit(work, share, pure=False) for share in shares]
    try:
        for future in distributed.as_completed(futures):
            yield future.result()
            future.release()
    finally:
        client.cancel(futures, force=True)
