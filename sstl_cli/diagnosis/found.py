"""What a search has found: the base, every effect by its hypotheses, and combinations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, fit, settle
from sstl_cli.diagnosis.heldout import HeldOut
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise

T = TypeVar("T")
R = TypeVar("R")
NOTHING = Hypothesis((), ())


@dataclass(frozen=True)
class Search:
    """The fitted models of a diagnosis: the base, each effect by its hypotheses (best first), combinations, and what has no name.

    ``noise`` is the likeliest with what the models leave, ``measured`` what it starts from, ``read`` that by holds and readings alone.
    """

    sim: Simulator
    noise: Noise
    measured: Noise
    base: Fit
    singles: dict[str, tuple[Weighed, ...]]
    combined: dict[tuple[str, ...], Weighed]
    nameless: tuple[Weighed, ...] = ()
    read: Noise | None = None

    @cached_property
    def held_out(self) -> HeldOut:
        """What its models leave of data that they were not fitted to."""
        return HeldOut(self.sim)

    def best(self, ids: tuple[str, ...]) -> Weighed:
        """Return the best fit of one effect or of a combination, or of what has no name."""
        own = tuple(sorted(ids))
        nameless = next((w for w in self.nameless if tuple(sorted(w.ids)) == own), None)
        if nameless is not None:
            return nameless
        return self.singles[ids[0]][0] if len(ids) == 1 else self.combined[own]

    def parts(self, ids: Collection[str]) -> list[Weighed]:
        """Return the models that lack just one of several effects."""
        return [w for w in self.every() if len(w.ids) == len(ids) - 1 and set(w.ids) < set(ids)]

    def ranked(self) -> list[Weighed]:
        """Return the best model of every effect and combination, the most evident first."""
        return _by_evidence([v[0] for v in self.singles.values()] + list(self.combined.values()))

    def every(self) -> list[Weighed]:
        """Return the same and what has no name among them."""
        return _by_evidence([*self.ranked(), *self.nameless])


def _by_evidence(models: Iterable[Weighed]) -> list[Weighed]:
    return sorted(models, key=lambda w: (-w.evidence, w.ids))


def deepest(sim: Simulator, noise: Noise, base: Fit, fits: Iterable[Fit]) -> Fit:
    """Return the most likely base: from where it stands, or from the bends of fits, each of which contains it.

    Where a model misses more than noise the likelihood has several valleys, and what found a deeper one by chance would gain by it.
    """
    starts = [fit(sim, base.whiten, NOTHING, f.theta, np.zeros(0), 0) for f in fits]
    return min((base, *(settle(sim, noise, s) for s in starts)), key=lambda f: f.cost)


def each(work: Callable[[T], R], items: Sequence[T], workers: int) -> list[R]:
    """Return ``work`` of each item in order; threads share the data, the kernels release the lock."""
    if workers < 2:
        return [work(item) for item in items]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(work, items))
