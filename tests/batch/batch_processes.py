"""Processes of a test that end with it, whatever happens: a group each, killed as one."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator

import psutil


@contextlib.contextmanager
def started(words: list[str], **more: object) -> Iterator[subprocess.Popen[str]]:
    """Start a program in a session of its own and kill what is left of it at the end."""
    process = subprocess.Popen(  # type: ignore[call-overload]
        words, text=True, start_new_session=True, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more}
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(timeout=10)


def wait_for(reached: Callable[[], object], seconds: float = 30.0) -> None:
    """Wait until something is so; AssertionError if that takes longer."""
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def group(leader: int) -> list[int]:
    """Return the live processes of a session."""
    found = []
    for process in psutil.process_iter(["status"]):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if os.getsid(process.pid) == leader and process.info["status"] != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
    return found
