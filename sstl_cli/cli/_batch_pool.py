"""Where the jobs of a batch run: local processes, or the workers of a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from sstl_cli import __version__
from sstl_cli.cli._batch_worker import Job, run_one
from sstl_cli.core.errors import EXIT_FAILED, SstlError
from sstl_cli.steps.batch import Outcome

CONNECT_S = 15


def run_all(jobs: list[Job], workers: int, scheduler: str | None, told: Callable[[Outcome], None]) -> list[Outcome]:
    """Return the outcome of every job in the order given, calling ``told`` as each one ends.

    A file whose worker dies (out of memory, a crash in a C library) is tried again alone, and listed if it dies again.
    """
    found: dict[str, Outcome] = {}

    def note(outcome: Outcome) -> None:
        # a job that died with others may have been counted before
        if outcome.source not in found:
            told(outcome)
        found[outcome.source] = outcome

    if scheduler:
        with _cluster(scheduler):
            _try(jobs, -1, note, found)
    elif workers == 1:
        for job in jobs:
            note(run_one(job))
    else:
        _try(jobs, workers, note, found)
    return [found[job.item.source] for job in jobs]


def _try(jobs: list[Job], workers: int, note: Callable[[Outcome], None], found: dict[str, Outcome]) -> None:
    try:
        for outcome in _parallel(jobs, workers):
            note(outcome)
    except _deaths():
        for job in jobs:
            if job.item.source in found:
                continue
            try:
                for outcome in _parallel([job], min(workers, 1)):
                    note(outcome)
            except _deaths() as error:
                line = f"[E040] {job.item.source}: the worker died twice ({type(error).__name__}); it may need more memory"
                note(Outcome(job.item.source, job.item.output, "failed", EXIT_FAILED, line))


def _parallel(jobs: list[Job], workers: int) -> Iterator[Outcome]:
    from joblib import Parallel, delayed

    # one at a time even for one worker: a process of its own keeps a crash away from this one
    pool = Parallel(n_jobs=workers if workers != 1 else 2, batch_size=1, return_as="generator_unordered")
    yield from pool(delayed(run_one)(job) for job in jobs)


def _deaths() -> tuple[type[BaseException], ...]:
    from joblib.externals.loky.process_executor import BrokenProcessPool

    kinds: list[type[BaseException]] = [BrokenProcessPool]
    try:
        from distributed.scheduler import KilledWorker

        kinds.append(KilledWorker)
    except ImportError:
        pass
    return tuple(kinds)


@contextmanager
def _cluster(scheduler: str) -> Iterator[None]:
    try:
        from distributed import Client
    except ImportError:
        raise SstlError(
            "needs the package distributed", where="--scheduler", fix="pip install 'sstl-cli[cluster]'", code="E041"
        ) from None
    from joblib import parallel_config

    try:
        client = Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        text = " ".join(str(error).split())[:120]
        raise SstlError(
            f"no scheduler answers ({text})", where=scheduler, fix="start one with 'dask scheduler'", code="E042"
        ) from None
    try:
        _check_workers(client, scheduler)
        with parallel_config(backend="dask", client=client, wait_for_workers_timeout=CONNECT_S):
            yield
    finally:
        client.close(timeout=5)


def _check_workers(client: Any, scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError:
        raise SstlError(
            "the scheduler has no workers", where=scheduler, fix=f"start one with 'dask worker {scheduler}'", code="E043"
        ) from None
    for address, version in client.run(worker_version, on_error="return").items():
        if version != __version__:
            shown = version if isinstance(version, str) else type(version).__name__
            raise SstlError(
                f"worker {address} has sstl {shown}, this is {__version__}",
                where=scheduler,
                fix="install the same version everywhere",
                code="E044",
            )


def worker_version() -> str:
    """Return the version of this program where it is called."""
    return __version__


def default_workers() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
