"""One experiment over many data seeds: its draws one after the other, those at hand not again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache

from sstl_cli.core.processes import processes
from sstl_cli.paper.block_r import Tracked
from sstl_cli.paper.spread import Draw


@dataclass(frozen=True)
class Drawn:
    """One data seed: its entries by block, and for block R what was tracked."""

    seed: int
    entries: Draw
    tracked: Tracked | None = None


def draw(experiment: str, seed: int) -> Drawn:
    """Return one data seed of an experiment: ``generator`` (Tables I, II and IV), ``III`` or ``R``."""
    if experiment == "R":
        from sstl_cli.paper import block_r

        made = block_r.run(seed)
        return Drawn(seed, block_r.draw(made), made.tracked)
    from sstl_cli.paper import table_iii, table_iv

    return Drawn(seed, table_iii.draw(seed) if experiment == "III" else table_iv.draw(seed))


def run(experiment: str, seeds: Sequence[int], at_hand: Callable[[int], Draw | None], keep: Callable[[int, Draw], None]) -> Iterator[Draw]:
    """Yield the entries of every seed; ``keep`` is told new ones at once, so that a stopped run can be taken up."""
    for seed in seeds:
        made = at_hand(seed)
        if made is None:
            made = draw(experiment, seed).entries
            keep(seed, made)
        yield made


@contextmanager
def beside(experiment: str, seeds: Sequence[int], workers: int) -> Iterator[Callable[[], list[Drawn]]]:
    """Yield a function that waits for several seeds, computed by other processes meanwhile (0: when it is first called)."""
    if workers < 1 or not seeds:
        yield cache(lambda: [draw(experiment, s) for s in seeds])
        return
    with processes(min(workers, len(seeds))) as pool:
        jobs = [pool.submit(draw, experiment, s) for s in seeds]
        yield lambda: [job.result() for job in jobs]
