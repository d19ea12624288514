"""Draw the cases of a withheld-effect check from the simulators that stand in for hardware."""

from __future__ import annotations

from collections.abc import Callable, Generator

import numpy as np

from sstl_cli.blind.cases import Case, draw
from sstl_cli.blind.schedule import MIXED, Job, jobs
from sstl_cli.core.processes import processes

Named = tuple[str, Case]


def names(cases: int) -> list[str]:
    """Return the neutral names of the cases of a set."""
    return [f"case-{i + 1:04d}" for i in range(cases)]


def run(
    cases: int,
    seed: int,
    quick: bool = False,
    workers: int = 1,
    advance: Callable[[float], None] = lambda _: None,
    simulator: str = MIXED,
    recordings: str = MIXED,
    nulls: int = 0,
) -> Generator[Named]:
    """Yield name and case in order, further ``nulls`` among them; case k belongs to seed + k, whatever the number of workers.

    Raises
    ------
    SstlError
        If a case cannot be simulated.
    """
    waiting = jobs(cases, seed, simulator, quick, recordings, nulls=nulls)
    named = names(len(waiting))
    if workers <= 1:
        for name, job in zip(named, waiting, strict=True):
            yield name, draw_job(job)
            advance(1)
        return
    with processes(workers) as pool:
        # a few at a time: finished cases wait in memory until they are written
        for start in range(0, len(waiting), 4 * workers):
            part = slice(start, start + 4 * workers)
            for name, case in zip(named[part], pool.map(draw_job, waiting[part]), strict=True):
                yield name, case
                advance(1)


def draw_job(job: Job) -> Case:
    """Return the case that a job describes."""
    np.seterr(all="ignore")
    return draw(job.entry, job.seed, job.quick, job.simulator, job.as_labs)
