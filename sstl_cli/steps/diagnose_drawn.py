"""What a report draws of a diagnosis, thinned: loops, and what is left over time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.diagnosis import LoopCurves, ResidualCurves
from sstl_cli.diagnosis.records import Record
from sstl_cli.steps.diagnose_given import Given

# points of a curve that are more than a figure shows
DRAWN = 600


def loops(g: Given) -> list[LoopCurves]:
    """Return a measured loop of each system with the simulated ones before and after."""
    base, after = g.search.base.prediction, g.accepted.prediction
    return [
        LoopCurves(
            run_id=r.run_id,
            system=r.system,
            tension_in_n=u.tolist(),
            measured_n=r.y[::step].tolist(),
            base_n=base[s][::step].tolist(),
            with_effect_n=after[s][::step].tolist(),
        )
        for r, s, step, u in _first_of_each(g)
    ]


def residuals(g: Given) -> list[ResidualCurves]:
    """Return measured minus simulated of one run a system, before and after."""
    base, after = g.search.base.residual, g.accepted.residual
    return [
        ResidualCurves(
            run_id=r.run_id,
            system=r.system,
            time_s=r.time_s[::step].tolist(),
            tension_in_n=u.tolist(),
            base_n=base[s][::step].tolist(),
            effect_n=after[s][::step].tolist(),
        )
        for r, s, step, u in _first_of_each(g)
    ]


def _first_of_each(g: Given) -> Iterator[tuple[Record, slice, int, NDArray[np.float64]]]:
    """Yield the first run of each system: record, place among the samples, thinning, thinned input (N)."""
    sim = g.search.sim
    seen: set[str] = set()
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        if r.system not in seen:
            seen.add(r.system)
            step = max(1, len(r) // DRAWN)
            yield r, s, step, r.u.reshape(-1, r.factor).mean(axis=1)[::step]
