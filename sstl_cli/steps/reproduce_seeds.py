"""One experiment over many data seeds: its draws one after the other, those at hand not again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from sstl_cli.paper.spread import Draw

EXPERIMENTS = ("R", "III")


def draw(experiment: str, seed: int) -> Draw:
    """Return the entries of one data seed by block."""
    if experiment == "R":
        from sstl_cli.paper import block_r

        return block_r.draw(block_r.run(seed))
    from sstl_cli.steps import reproduce_mapping

    return reproduce_mapping.draw(seed)


def run(
    experiment: str, seeds: Sequence[int], at_hand: Callable[[int], Draw | None], keep: Callable[[int, Draw], None]
) -> Iterator[Draw]:
    """Yield the draw of every seed; ``keep`` is told each new one at once, so that a stopped run can be taken up."""
    for seed in seeds:
        made = at_hand(seed)
        if made is None:
            made = draw(experiment, seed)
            keep(seed, made)
        yield made


def together(experiment: str, seeds: Sequence[int], workers: int) -> list[Draw]:
    """Return the draws of several seeds, computed by as many processes (a process of its own keeps no result)."""
    if workers < 2 or len(seeds) < 2:
        return [draw(experiment, s) for s in seeds]
    with ProcessPoolExecutor(min(workers, len(seeds)), get_context("spawn")) as pool:
        return list(pool.map(draw, [experiment] * len(seeds), seeds))
