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
from sstl_cli.diagnosis.laid import scatter_n
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]


def loosened(found: Search, workers: int) -> Search:
    """Return the search by the noise that its likeliest model has beside what is known: of each system a share of its scatter, and its law's."""
    if not found.sim.problem.scatters:
        return found
    best = [v[0].fit for v in found.singles.values()]
    sim, fits = _scattering(found, [found.base, *sorted(best, key=lambda f: f.cost)[:LEADERS]])
    lead = min(fits, key=lambda f: f.cost)
    # another law's jumps are no noise: nothing else jumps
    if lead.discrepancy > 0.0 and not jumping(lead):
        sim = replace(sim, more_n=_with(sim.more_n, lead.discrepancy * own_response(sim, lead)))
    if sim is found.sim:
        return found
    if not best:
        return replace(found, sim=sim, base=settle(sim, found.noise, found.base))
    return judged(replace(found, sim=sim), found.noise, workers)


def _scattering(found: Search, known: Sequence[Fit]) -> tuple[Simulator, Sequence[Fit]]:
    """Return the simulator with as much of its scatter new at every step, or in every slide, as makes the likeliest of models likeliest, and these."""
    sim, fits, records = found.sim, known, found.sim.problem.records
    of = np.repeat([r.system for r in records], [len(r) for r in records])
    scatter = scatter_n(records)
    for system, slips in itertools.product(found.sim.problem.systems, (False, True)):
        own, before = scatter * (of == system), sim
        for share in SHARES[1:] if np.any(own > 0.0) else ():
            new = share * own
            tried = replace(before, slips_n=_with(before.slips_n, new)) if slips else replace(before, more_n=_with(before.more_n, new))
            again = [settle(tried, found.noise, f, 0) for f in known]
            if min(f.cost for f in again) >= min(f.cost for f in fits):
                break
            sim, fits = tried, again
    return sim, fits


def _with(known_n: Array | None, more_n: Array) -> Array:
    return more_n if known_n is None else np.hypot(known_n, more_n)
