"""The difference between the first two blocks of Table IV: which part of the explanation carries how much of it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from sstl_cli.core.runs import Run
from sstl_cli.paper.published import of_table
from sstl_cli.paper.settings import EXPLAINED, PARTS, STATED, partly
from sstl_cli.steps.reproduce_tracking import Block, Prepared, block, distance


@dataclass(frozen=True)
class Share:
    """One part of the explanation: distance to the paper with this part alone, with all but it, and its Shapley share.

    Distances (N) are those of :func:`reproduce_tracking.distance`; ``share_pct`` adds up to 100 over the parts.
    """

    part: str
    alone: float
    without: float
    share_pct: float


@dataclass(frozen=True)
class Gap:
    """Distance to the paper as stated and as explained, and what each part of the explanation is worth."""

    stated: float
    explained: float
    shares: tuple[Share, ...]

    @property
    def shrink_pct(self) -> float:
        return 100.0 * (1.0 - self.explained / self.stated)


def run(prepared: Prepared, seed: int) -> Gap:
    """Return the distances for every combination of the parts of the explanation, and their Shapley shares."""
    published = {(e.table, e.row, e.column): e.value for e in of_table("IV")}
    names = tuple(PARTS)
    value = {
        frozenset(some): distance(block(partly(some), prepared, seed).entries, published)
        for k in range(len(names) + 1)
        for some in itertools.combinations(names, k)
    }
    whole, none = frozenset(names), frozenset[str]()
    drop = value[none] - value[whole]
    shares = []
    for name in names:
        gain = 0.0
        for some in (s for s in value if name not in s):
            weight = math.factorial(len(some)) * math.factorial(len(names) - len(some) - 1) / math.factorial(len(names))
            gain += weight * (value[some] - value[some | {name}])
        shares.append(
            Share(name, value[frozenset({name})], value[whole - {name}], 100.0 * gain / drop if drop else 0.0)
        )
    return Gap(value[none], value[whole], tuple(shares))


def logs(stated: Block, explained: Block) -> tuple[Iterator[Run], Iterator[Run]]:
    """Return the tracked runs of both blocks as logs, paired by run_id, for ``sstl diagnose --against``.

    Tensions in N; the reference is the recorded ``tension_ref_n``.
    """
    return _runs(stated), _runs(explained)


def _runs(made: Block) -> Iterator[Run]:
    for r in made.results:
        yield Run(
            r.run_id,
            "act",
            r.reference.time_s,
            r.track.tension_in,
            r.track.tension_out,
            r.case.config_id,
            r.case.location,
            trajectory=r.trajectory,
            tension_ref_n=r.reference.tension_n,
        )


__all__ = ["EXPLAINED", "STATED", "Gap", "Share", "logs", "run"]
