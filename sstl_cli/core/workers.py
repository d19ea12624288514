"""Worker processes end with the program that started them, however it ends."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

LOOK_S = 0.25
_PR_SET_PDEATHSIG = 1
_watching = False
# folders in which this process is at work, removed if its program is gone
_begun: set[Path] = set()


def end_with(parent: int) -> None:
    """Let this process end soon after ``parent``, the process that started it, is gone (killed ones tell nobody).

    The system's own signal for this goes by the thread that started the process, which may end long before the program.
    """
    global _watching
    if _watching or parent == os.getpid() or not hasattr(os, "getppid"):
        return
    _watching = True
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


@contextlib.contextmanager
def at_work_in(folder: Path) -> Iterator[None]:
    """Name a folder that must not outlive this process."""
    _begun.add(folder)
    try:
        yield
    finally:
        _begun.discard(folder)


def stop_on_signals() -> None:
    """Let the requests to end that a terminal or a service sends end the program as Ctrl-C does, in good order."""
    for name in ("SIGTERM", "SIGHUP"):
        kind = getattr(signal, name, None)
        # what was told to be ignored (nohup) stays ignored
        if kind is not None and signal.getsignal(kind) == signal.SIG_DFL:
            signal.signal(kind, signal.default_int_handler)


def end_with_thread(parent: int) -> None:
    """Let this forked process be killed when the thread that forked it ends, even while a C library holds it (Linux)."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    for folder in list(_begun):
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)
