"""Worker processes end with the program that started them, however it ends."""

from __future__ import annotations

import _thread
import contextlib
import ctypes
import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from sstl_cli.core.errors import EXIT_FAILED

LOOK_S = 0.25
_PR_SET_PDEATHSIG = 1
_watching = False
# folders in which this process is at work, removed if its program is gone
_begun: set[Path] = set()
# the exception of a signal can fall where Python or a library throws it away, or leaves a lock held: the time (s) after which a
# program that was asked to end is ended, and what it says then
PATIENCE_S = 10.0
# how often a folder is removed that is still written into, and how far apart (s)
REMOVALS, REMOVAL_S = 20, 0.02
_last_words: str | None = None
_asked = False


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


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or another request to end.

    A class of its own, because Python notes a plain ``KeyboardInterrupt`` that leaves code run from a string (what
    ``inspect`` and ``dataclasses`` do for every annotation and field), and forgets it not even when it is caught: at its end
    it then kills itself with the signal, whatever the exit code (``unhandled_keyboard_interrupt`` in pythonrun.c).
    """


def stop_on_signals(last_words: str) -> None:
    """Let Ctrl-C and the requests to end that a terminal or a service sends raise :class:`Interrupted`.

    A program that is still there ``PATIENCE_S`` later, and has not called :func:`goes_on`, says its last words and ends.
    """
    global _last_words
    _last_words = last_words
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        kind = getattr(signal, name, None)
        # what was told to be ignored (nohup) stays ignored
        if kind is not None and signal.getsignal(kind) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(kind, _interrupt)


def last_words_said() -> None:
    """The program has told how it ends: nothing more is said if it has to be ended."""
    global _last_words
    _last_words = ""


def is_interrupt(error: BaseException) -> bool:
    """Whether this came of a request to end: inside compiled code that returned all the same, Python makes a SystemError of it."""
    return isinstance(error, KeyboardInterrupt) or isinstance(error.__cause__, KeyboardInterrupt)


def end_if_asked() -> None:
    """Raise :class:`Interrupted` if the program was asked to end and the exception of that was lost."""
    if _asked:
        raise Interrupted


def goes_on() -> None:
    """The program was asked to end, and has more to do than tidy up: it is not ended."""
    global _last_words
    _last_words = None


def _interrupt(number: int, frame: object) -> None:
    global _asked
    _asked = True
    # no threading.Thread: its start takes locks, which this may have been called under
    _thread.start_new_thread(_end_at_last, (PATIENCE_S,))
    raise Interrupted


def _end_at_last(patience_s: float) -> None:
    time.sleep(patience_s)
    if _last_words is None:
        return
    _remove_begun()
    with contextlib.suppress(OSError):
        os.write(2, _last_words.encode())
    os._exit(EXIT_FAILED)


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Keep Ctrl-C waiting, for this thread and, as long as they live, the processes it starts."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    # starts with the first process otherwise, and then lets Ctrl-C through to that one (Python 3.11)
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_thread(parent: int) -> None:
    """Let this forked process be killed when the thread that forked it ends, even while a C library holds it (Linux)."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    _remove_begun()
    os._exit(1)


def _remove_begun() -> None:
    """Remove the folders that were begun, whose owner may still be writing into them."""
    for _ in range(REMOVALS):
        for folder in list(_begun):
            shutil.rmtree(folder, ignore_errors=True)
        if not any(folder.exists() for folder in list(_begun)):
            return
        time.sleep(REMOVAL_S)
