"""What the data could tell: distances between what one model shows and what another can show.

D^2(i -> j) is the squared whitened distance from what i shows to the nearest that j can show, theta and all parameters of
j refitted. The log-likelihood ratio of i over j is then normal with mean D^2 / 2 and variance D^2 (Eriksson, Frisk and
Krysander 2013): 49 to 1 with a power of 95 % needs D^2 = 24.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from sstl_cli.diagnosis.constants import ENOUGH_NATS, MAX_ITERATIONS, REFIT_ITERATIONS
from sstl_cli.diagnosis.fit import Fit, fit, normal_equations
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.simulator import Simulator


@dataclass(frozen=True)
class Shown:
    """The smallest size of an effect that a log would have shown, and the gap (N, RMS) that it leaves."""

    effect: str
    parameter: str
    unit: str
    size: float
    gap_n: float


def distance2(sim: Simulator, truth: Fit, rival: Fit) -> float:
    """Return D^2 from a fitted model to a rival: the rival refitted to what the model predicts, without noise."""
    return _squared(truth, _nearest(sim, truth, rival))


def _nearest(sim: Simulator, truth: Fit, rival: Fit) -> Fit:
    made = copy(sim)
    made.y = truth.prediction
    # what readings say of moments is not in what a model makes
    return fit(made, replace(truth.whiten, shift_n=None), rival.hypothesis, rival.theta, rival.values, REFIT_ITERATIONS, rival)


def _squared(truth: Fit, near: Fit) -> float:
    return max(2.0 * near.cost - truth.whiten.log_det, 0.0)


def least_shown(found: Search, d2: float) -> list[Shown]:
    """Return for each effect the smallest size that this log would have shown: the base refitted to it stays as far behind.

    An effect that would not have shown within its bounds has no row.

    Parameters
    ----------
    d2 : float
        Squared distance that shows (see ``Weights.shows_d2``).
    """
    rows = [
        _least(found, d2, effect_id, next(w.fit for w in models if w.fit.hypothesis.foretold))
        for effect_id, models in sorted(found.singles.items())
    ]
    return [row for row in rows if row is not None]


def _least(found: Search, shows: float, effect_id: str, f: Fit) -> Shown | None:
    sim = found.sim
    started = _linear(sim, f, shows)
    if started is None:
        return None
    i, size = started
    p = f.free[i].parameter
    up = p.high > p.neutral
    reach = p.most - p.neutral if up else p.neutral - p.least
    for _ in range(MAX_ITERATIONS):
        if size > reach:
            return None
        values = np.array([v if x.parameter.shape else x.parameter.neutral for x, v in zip(f.free, f.values, strict=True)])
        values[i] += size if up else -size
        truth = fit(sim, found.base.whiten, f.hypothesis, found.base.theta, values, 0)
        near = _nearest(sim, truth, found.base)
        d2 = _squared(truth, near)
        if d2 >= shows - 2.0 * ENOUGH_NATS:
            left = truth.prediction - near.prediction
            gap = float(np.sqrt(np.sum(sim.weight * left**2) / max(sim.weight.sum(), 1.0)))
            return Shown(effect_id, p.name, p.unit, size, gap)
        # a response that saturates, or that theta takes up, needs more than the linear one says
        size *= min(float(np.sqrt(shows / d2)), 2.0) if d2 > 0.0 else 2.0
    return None


def _linear(sim: Simulator, f: Fit, shows: float) -> tuple[int, float] | None:
    """Return the strength whose linear response shows with the smallest gap, theta refitted, and its size."""
    a, _ = normal_equations(sim, f.whiten(f.jacobian), np.zeros(len(sim.y)))
    configs = len(f.theta)
    rows = []
    for i, x in enumerate(f.free):
        if x.parameter.shape:
            continue
        own = np.arange(configs)
        cross = a[configs + i, own] / np.maximum(a[own, own], 1e-12)
        information = float(a[configs + i, configs + i] - cross @ a[own, configs + i])
        if information <= 0.0:
            continue
        size = float(np.sqrt(shows / information))
        column = f.jacobian[:, 1 + i] - f.jacobian[:, 0] * cross[sim.config]
        rows.append((size * float(np.sqrt(np.sum(sim.weight * column**2))), i, size))
    return min(rows)[1:] if rows else None
