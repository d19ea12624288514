"""What the sensing loop ends at: a load of its own, where effects along the line tell it from that of the tendon.

The loop comes back to where it began and is held there, often by a load cell far stiffer than what the tendon pulls. Friction that
goes with the speed of a line, its creep and its presliding show in both, in each by how far its end gives way.
"""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.constants import ADDS, FACTORS, SHORT_ITERATIONS
from sstl_cli.diagnosis.fit import Fit, fit, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.free import LINE, Free
from sstl_cli.diagnosis.hypotheses import Hypothesis

LOAD, OWN = (Free(LINE, p) for p in LINE.parameters)


def apart(found: Search, f: Fit) -> Fit | None:
    """Return a fit in which the sensing loop ends at a load of its own, None where that adds nothing or there is none to be told apart."""
    sim = found.sim
    if LOAD not in f.free or OWN in f.free or not {"act", "sstl"} <= set(sim.problem.systems):
        return None
    at = f.free.index(LOAD)
    h = Hypothesis(f.ids, (*f.free, OWN))
    low, high = OWN.parameter.least, OWN.parameter.most
    # as stiff as the tendon's, stiffer and softer: the answer of a line is not linear in it
    starts = [np.append(f.values, np.clip(k * f.values[at], low, high)) for k in FACTORS]
    tried = min((fit(sim, f.whiten, h, f.theta, v, SHORT_ITERATIONS) for v in starts), key=lambda x: x.cost)
    return settle(sim, found.noise, tried) if f.cost - tried.cost > ADDS else None
