"""Noise beside what a known rig scatters by, the same for all models.

How an accepted model scatters was learned on another day, as slow as it mostly is. What is new on this day, or faster, every
model may take for noise, or one that may be off by a share of its own response buys with that what the others have to explain.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.again import judged
from sstl_cli.diagnosis.constants import LEADERS, SHARES
from sstl_cli.diagnosis.fit import Fit, jumping, own_response, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]


def loosened(found: Search, workers: int) -> Search:
    """Return the search by the noise that its likeliest model has beside what is known: of each system a share of its scatter, and its law's."""
    if not found.sim.problem.scatters:
        return found
    best = [v[0].fit for v in found.singles.values()]
    fits = [found.base, *sorted(best, key=lambda f: f.cost)[:LEADERS]]
    sim = _scattering(found, fits)
    lead = min((settle(sim, found.noise, f, 0) for f in fits), key=lambda f: f.cost)
    # another law's jumps are no noise: nothing else jumps
    law = 0.0 * sim.y if jumping(lead) else lead.discrepancy * own_response(sim, lead)
    if np.any(law > 0.0):
        sim = replace(sim, more_n=_with(sim.more_n, law))
    if sim is found.sim:
        return found
    if not best:
        return replace(found, sim=sim, base=settle(sim, found.noise, found.base))
    return judged(replace(found, sim=sim), found.noise, workers)


def _scattering(found: Search, fits: Sequence[Fit]) -> Simulator:
    """Return the simulator with as much of its scatter new at every step, or in every slide, as makes the likeliest of these models likeliest."""
    records, best, sim = found.sim.problem.records, min(f.cost for f in fits), found.sim
    for system, slips in itertools.product(found.sim.problem.systems, (False, True)):
        parts = [np.zeros(len(r)) if r.misfit_n is None or r.system != system else r.misfit_n for r in records]
        scatter, before = np.concatenate(parts), sim
        for share in SHARES[1:] if np.any(scatter > 0.0) else ():
            new = share * scatter
            tried = replace(before, slips_n=_with(before.slips_n, new)) if slips else replace(before, more_n=_with(before.more_n, new))
            cost = min(settle(tried, found.noise, f, 0).cost for f in fits)
            if cost >= best:
                break
            best, sim = cost, tried
    return sim


def _with(known_n: Array | None, more_n: Array) -> Array:
    return more_n if known_n is None else np.hypot(known_n, more_n)
