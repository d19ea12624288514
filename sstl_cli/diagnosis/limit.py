"""What the data could tell: distances between what one model shows and what another can show.

D^2(i -> j) is the squared whitened distance from what i shows to the nearest that j can show, theta and all parameters of
j refitted. The log-likelihood ratio of i over j is then normal with mean D^2 / 2 and variance D^2 (Eriksson, Frisk and
Krysander 2013): 49 to 1 with a power of 95 % needs D^2 = 24.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np

from sstl_cli.diagnosis.constants import DECIDABLE, REFIT_ITERATIONS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit, fit, normal_equations
from sstl_cli.diagnosis.search import Search
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
    made = copy(sim)
    made.y = truth.prediction
    near = fit(made, truth.whiten, rival.hypothesis, rival.theta, rival.values, REFIT_ITERATIONS, rival)
    return max(2.0 * near.cost - truth.whiten.log_det, 0.0)


def least_shown(found: Search) -> list[Shown]:
    """Return for each effect the smallest size that this log would have shown, its best direction, theta refitted."""
    rows = []
    for effect_id, models in sorted(found.singles.items()):
        rows += _least(found.sim, effect_id, models[0])
    return rows


def _least(sim: Simulator, effect_id: str, w: Weighed) -> list[Shown]:
    f = w.fit
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
        size = float(np.sqrt(DECIDABLE / information))
        column = f.jacobian[:, 1 + i] - f.jacobian[:, 0] * cross[sim.config]
        gap = size * float(np.sqrt(np.sum(sim.weight * column**2) / max(sim.weight.sum(), 1.0)))
        rows.append(Shown(effect_id, x.parameter.name, x.parameter.unit, size, gap))
    return sorted(rows, key=lambda s: s.gap_n)[:1]
