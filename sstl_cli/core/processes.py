"""Processes of our own that share out long work, and leave Ctrl-C to the program that started them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from typing import Any, TypeVar

from sstl_cli.core.workers import end_with, interrupts_held

T = TypeVar("T")


class _Processes(ProcessPoolExecutor):
    """Starts its processes, which it does when work is handed in, with Ctrl-C held back: they leave it to this one."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        with interrupts_held():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of new processes; what they still do when the block is left by an error is thrown away at once."""
    others = set(active_children())
    pool = _Processes(count, get_context("spawn"), end_with, (os.getpid(),))
    try:
        yield pool
    except BaseException:
        with interrupts_held():
            for process in set(active_children()) - others:
                process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
