"""Friction that differs from run to run: nobody can foretell it, so that its spread is fitted, and each run's own is what it shows.

Theta of a run is that of its configuration times 1 + d with d normal about 0 (a mixed model, Harville 1977). Linear in d, its
likelihood, theta and d integrated or fitted, has a closed form for each spread. A pulley, or a gain of one system, shows in
the same contrasts between runs of a bend, by fewer numbers: without this rival it would be sure of whatever friction does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import gammaincinv, ndtr

from sstl_cli.diagnosis.constants import FEWEST_CONTRASTS, HALF, LEADERS
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.simulator import RUNS, Free, Simulator

Array = NDArray[np.float64]
EFFECT = "friction_drift"
# what is held out of such a model
OWN = "nothing: the friction of each run is fitted to it"
SCATTERS = Hypothesis((EFFECT,), (Free(RUNS, RUNS.parameters[0]),))


def contrasts(sim: Simulator) -> int:
    """Return how many differences between runs of one configuration there are."""
    return len(sim.problem.records) - len(sim.problem.configs)


def add(found: Search, most: int) -> None:
    """Add friction that differs from run to run to what was found: on the base, and beside the leading effects.

    Parameters
    ----------
    most : int
        How many effects may stand together.
    """
    if EFFECT not in found.singles:
        return
    leaders = [w for w in found.ranked() if len(w.ids) == 1 and w.ids != (EFFECT,) and w.evidence > 0.0][:LEADERS]
    alone = weighed(found, Weighed(found.base, 0.0, 0.0))
    if alone is None:
        return
    found.singles[EFFECT] = tuple(sorted((*found.singles[EFFECT], alone), key=lambda w: -w.evidence))
    for leader in leaders if most > 1 else ():
        both = weighed(found, leader)
        key = tuple(sorted((*leader.ids, EFFECT)))
        if both is not None and (key not in found.combined or both.evidence > found.combined[key].evidence):
            found.combined[key] = both


def weighed(found: Search, on: Weighed) -> Weighed | None:
    """Return a model with friction that differs from run to run; None where few runs say so, or where a rig is known to vary."""
    sim, base = found.sim, on.fit
    if contrasts(sim) < FEWEST_CONTRASTS or any(r.misfit_n is not None or r.wander is not None for r in sim.problem.records):
        return None
    column = base.jacobian[:, 0] * base.theta[sim.config]
    seen, left = base.whiten(column), base.whiten(base.residual)
    runs = len(sim.problem.records)
    told, score = (np.bincount(sim.run, x, runs).astype(np.float64) for x in (seen**2, seen * left))
    place = np.array([r.config for r in sim.problem.records])
    if not told.any():
        return None
    # from what the noise of one run hides to all of friction
    lowest = float(np.log(HALF / np.sqrt(told.max())))
    best = minimize_scalar(lambda x: -gain_of(float(np.exp(x)), told, score, place)[0], bounds=(lowest, 0.0), method="bounded")
    spread = float(np.exp(best.x))
    gain, own, shared = gain_of(spread, told, score, place)
    moved = column * (own + shared)[sim.run]
    f = replace(
        base,
        hypothesis=base.hypothesis.joined(SCATTERS),
        values=np.append(base.values, spread),
        cost=base.cost - gain,
        prediction=base.prediction + moved,
        residual=base.residual - moved,
        jacobian=np.column_stack((base.jacobian, column * (own / spread)[sim.run])),
    )
    return Weighed(f, on.gain + gain, on.evidence + gain - strengths_charge(1, 2.0 * max(gain, 0.0)))


def gain_of(spread: float, told: Array, score: Array, place: NDArray[np.int64]) -> tuple[float, Array, Array]:
    """Return what a spread gains (nats), the part of each run that is its own, and the part that its configuration shares.

    Parameters
    ----------
    told, score : ndarray, shape (runs,)
        Information on a run's relative friction, and the derivative of the log likelihood over it, where the base stands.
    place : ndarray, shape (runs,)
        Configuration of each run.
    """
    kept = 1.0 / (1.0 + told * spread**2)
    shared = (np.bincount(place, score * kept) / np.maximum(np.bincount(place, told * kept), 1e-300))[place]
    apart = score - told * shared
    own = apart * kept * spread**2
    gain = float(np.sum(score * shared - 0.5 * told * shared**2 + 0.5 * apart * own + 0.5 * np.log(kept)))
    return gain, own, shared


def interval(sim: Simulator, spread: float) -> tuple[float, float]:
    """Return the 95 % interval of a spread of as many contrasts, each known well (chi square)."""
    half = 0.5 * contrasts(sim)
    low, high = (2.0 * float(gammaincinv(half, p)) for p in (ndtr(1.96), ndtr(-1.96)))
    return spread * float(np.sqrt(2.0 * half / low)), spread * float(np.sqrt(2.0 * half / high))


def lasting(found: Search, f: Fit) -> Fit:
    """Return a fit without what runs have of their own."""
    if f.hypothesis.foretold:
        return f
    rest = tuple(sorted(i for i in f.ids if i != EFFECT))
    return found.best(rest).fit if rest else found.base


def shown(base: Fit, f: Fit, sim: Simulator) -> dict[str, float]:
    """Return by which part the friction of each run is above that of its configuration, by run."""
    column = base.jacobian[:, 0] * base.theta[sim.config]
    power = np.maximum(np.bincount(sim.run, column**2), 1e-300)
    level = np.bincount(sim.run, column * (f.prediction - base.prediction)) / power
    return {r.raw.run_id: float(x) for r, x in zip(sim.problem.records, level, strict=True)}
