"""Where the jobs of a batch run: this process, local processes, or the workers of a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

from sstl_cli.cli._batch_worker import Job, run_here, run_one
from sstl_cli.core.errors import EXIT_FAILED
from sstl_cli.core.workers import interrupts_held
from sstl_cli.steps.batch import Outcome

Spread = Callable[[list[Job]], Iterator[Outcome]]
# jobs handed out at once, in the order given: those in flight when a worker dies are among the first unfinished
AHEAD = 2


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
        from sstl_cli.cli._batch_cluster import connected, spread

        with connected(scheduler) as client:
            slots = max(1, sum(client.nthreads().values()))
            _all(jobs, lambda some: spread(some, client, scheduler, AHEAD * slots), AHEAD * slots, note, found)
    elif workers == 1:
        for job in jobs:
            note(run_one(job))
    else:
        _all(jobs, lambda some: _local(some, workers), AHEAD * workers, note, found)
    return [found[job.item.source] for job in jobs]


def _all(jobs: list[Job], spread: Spread, ahead: int, note: Callable[[Outcome], None], found: dict[str, Outcome]) -> None:
    """Run all jobs; each time a worker dies, those that were in flight run one by one, the rest together again."""
    while jobs:
        try:
            for outcome in spread(jobs):
                note(outcome)
            return
        except _deaths():
            jobs = [job for job in jobs if job.item.source not in found]
        suspects, jobs = jobs[:ahead], jobs[ahead:]
        for job in suspects:
            try:
                for outcome in spread([job]):
                    note(outcome)
            except _deaths() as error:
                line = f"[E040] {job.item.source}: the worker died twice ({type(error).__name__}); it may need more memory"
                note(Outcome(job.item.source, job.item.output, "failed", EXIT_FAILED, line))


def _local(jobs: list[Job], workers: int) -> Iterator[Outcome]:
    from joblib import Parallel, delayed

    # n_jobs=1 would run here: a process of its own keeps a crash away from this one
    pool = Parallel(n_jobs=max(workers, 2), batch_size=1, pre_dispatch=AHEAD * max(workers, 2), return_as="generator_unordered")
    with interrupts_held():
        # the processes start here and keep the mask: Ctrl-C ends this one, which ends them
        results = pool(delayed(run_here)(job, os.getpid()) for job in jobs)
    yield from results


def _deaths() -> tuple[type[BaseException], ...]:
    from joblib.externals.loky.process_executor import BrokenProcessPool

    kinds: list[type[BaseException]] = [BrokenProcessPool]
    try:
        from distributed.scheduler import KilledWorker

        kinds.append(KilledWorker)
    except ImportError:
        pass
    return tuple(kinds)


def default_workers() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
