"""The difference between the first two blocks of Table IV: which part of the explanation carries how much of it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sstl_cli.control.plant import PlayTendon, pulled
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.paper.published import of_table
from sstl_cli.paper.scores import distance
from sstl_cli.paper.settings import FITTED, PARTS, STATED, partly
from sstl_cli.paper.table_iv import Array, Block, Prepared, block, plant_lines
from sstl_cli.steps.compensate import Result

EVERY, NOISE_N = 10, 0.02
LOGGED = ("none", "proposed")


@dataclass(frozen=True)
class Share:
    """One part of the explanation: distance to the paper with this part alone, with all but it, and its Shapley share.

    Distances (N) are those of :func:`paper.scores.distance`; ``share_pct`` adds up to 100 over the parts.
    """

    part: str
    alone: float
    without: float
    share_pct: float


@dataclass(frozen=True)
class Gap:
    """Distance to the paper as stated and as fitted, and what each part of the explanation is worth."""

    stated: float
    fitted: float
    shares: tuple[Share, ...]

    @property
    def shrink_pct(self) -> float:
        return 100.0 * (1.0 - self.fitted / self.stated)


def run(prepared: Prepared, seed: int, advance: Callable[[float], None] = lambda _: None) -> Gap:
    """Return the distances for every combination of the parts of the explanation, and their Shapley shares.

    ``advance`` is told which share more of the combinations is done.
    """
    published = {(e.table, e.row, e.column): e.value for e in of_table("IV")}
    names = tuple(PARTS)
    value = {}
    for chosen in (c for k in range(len(names) + 1) for c in itertools.combinations(names, k)):
        value[frozenset(chosen)] = distance(block(partly(chosen), prepared, seed).entries, published)
        advance(0.5 ** len(names))
    whole, none = frozenset(names), frozenset[str]()
    drop = value[none] - value[whole]
    shares = []
    for name in names:
        gain = 0.0
        for some in (s for s in value if name not in s):
            weight = math.factorial(len(some)) * math.factorial(len(names) - len(some) - 1) / math.factorial(len(names))
            gain += weight * (value[some] - value[some | {name}])
        shares.append(Share(name, value[frozenset({name})], value[whole - {name}], 100.0 * gain / drop if drop else 0.0))
    return Gap(value[none], value[whole], tuple(shares))


def logs(prepared: Prepared, fitted: Block, seed: int) -> tuple[Iterator[Run], Iterator[Run]]:
    """Return two logs paired by run_id for ``sstl diagnose MEASURED --against SIMULATED``.

    The first stands in for the paper's recordings: the tracked runs under the explaining settings as sensors of
    0.02 N noise show them. The second is what the stated settings predict for the same input tension. Every tenth
    sample, tensions in N; the recorded ``tension_ref_n`` is the commanded input, which shows the loop lag.
    """
    return _measured(fitted, seed), _predicted(prepared, fitted)


def _kept(fitted: Block) -> list[Result]:
    return [r for r in fitted.results if r.method in LOGGED]


def _measured(fitted: Block, seed: int) -> Iterator[Run]:
    for r in _kept(fitted):
        rng = stream(seed, "gap", r.run_id)
        seen_in, seen_out = (v[::EVERY] + NOISE_N * rng.standard_normal(len(v[::EVERY])) for v in (r.track.tension_in, r.track.tension_out))
        yield _run(r, seen_in, seen_out)


def _predicted(prepared: Prepared, fitted: Block) -> Iterator[Run]:
    for r in _kept(fitted):
        tendon = PlayTendon(plant_lines(STATED, prepared, str(r.case.location)))
        out = pulled(tendon, r.track.tension_in, float(r.track.tension_in[0]), r.reference.dt_s)
        yield _run(r, r.track.tension_in[::EVERY], out[::EVERY])


def _run(r: Result, tension_in: Array, tension_out: Array) -> Run:
    return Run(
        r.run_id,
        "act",
        r.reference.time_s[::EVERY],
        tension_in,
        tension_out,
        r.case.config_id,
        r.case.location,
        trajectory=f"{r.trajectory} {r.method}",
        tension_ref_n=r.track.command[::EVERY],
    )


__all__ = ["FITTED", "STATED", "Gap", "Share", "logs", "run"]
