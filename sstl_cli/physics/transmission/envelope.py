"""Lower and upper output tension as functions of the input tension: the propagation lines.

A law that is linear in tension is tabulated exactly by two nodes; otherwise the tension balance
dT/dphi = -zeta (f(T) T + h), Eq. (1), is integrated through the bend on a grid of input tensions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.effect import Law, Mechanics

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
NODES = 161
STEPS = 8
SCALE_NODES = 33
CEILING_N = 1e5
# a factor on friction is tabulated so finely, up to so many times the largest tension that goes in
FACTOR_NODES, REACH = 4096, 8.0


class Line(NamedTuple):
    """What one table is for: friction coefficient times bending angle (rad), run, largest input tension (N), range of the
    factor on mu that changes with time.
    """

    theta: float
    system: str
    location: str | None
    top_n: float
    low: float
    high: float


@dataclass(frozen=True)
class Envelopes:
    """Tables of propagation lines; table i has the rows ``edges[i]`` to ``edges[i + 1]``.

    ``pull`` and ``release`` (N) have one row a factor on mu, from ``scale0[i]`` in steps of ``scale_step[i]``, over input
    tensions from 0 in steps of ``tension_step_n[i]``.
    """

    pull: Array
    release: Array
    edges: Counts
    tension_step_n: Array
    scale0: Array
    scale_step: Array


class _Pass(NamedTuple):
    """One pass through the tube, row by row: angle times friction with its sign (1: pulling), that sign, shares of the length
    before and behind the bend, and the largest tension that goes in (N); each of shape (rows, 1).
    """

    angle: Array
    sign: Array
    before: Array
    behind: Array
    top_n: Array


def envelopes(law: Law, wanted: Sequence[Line], mechanics: Mechanics) -> Envelopes:
    """Return the propagation lines of several runs, integrated together."""
    nodes = NODES if law.factors else 2
    # below this spread the rows would coincide to rounding
    rows = np.array([SCALE_NODES if w.high - w.low > 1e-6 else 1 for w in wanted])
    factors = np.concatenate([np.linspace(w.low, w.high, n) if n > 1 else [w.low] for w, n in zip(wanted, rows, strict=True)])
    tops = np.maximum([w.top_n for w in wanted], 1.0)
    grids = np.linspace(0.0, tops, nodes, axis=1)
    theta = np.repeat([w.theta for w in wanted], rows) * factors
    # pulling and releasing are integrated together: small arrays cost what calls cost
    sign = np.repeat([1.0, -1.0], len(theta))[:, None]
    angle = sign * np.concatenate((theta * law.scale_pull, theta * law.scale_release))[:, None]
    straight = np.tile(np.repeat([mechanics.straight(w.location) for w in wanted], rows, axis=0), (2, 1))
    there = _Pass(angle, sign, straight[:, :1], straight[:, 1:], np.tile(np.repeat(tops, rows), 2)[:, None])
    tension = _passed(law, np.tile(np.repeat(grids, rows, axis=0), (2, 1)) - sign * law.begin_n, there)
    twice = np.tile(np.repeat([w.system == "sstl" for w in wanted], rows), 2)
    if twice.any():
        angle, sign, before, behind, top = (x[twice] for x in there)
        m = np.where(sign > 0.0, law.pulley_pull, law.pulley_release)
        back = tension[twice] * np.exp(-sign * m) - sign * law.pulley_n
        tension[twice] = _passed(law, back, _Pass(angle, sign, behind, before, top))
    pull, release = np.split(tension - there.sign * law.end_n, 2)
    edges = np.concatenate(([0], np.cumsum(rows)))
    first = edges[:-1]
    step = np.where(rows > 1, factors[np.minimum(first + 1, len(factors) - 1)] - factors[first], 1.0)
    return Envelopes(pull, release, edges.astype(np.int64), grids[:, 1] - grids[:, 0], factors[first], step)


def _passed(law: Law, tension: Array, way: _Pass) -> Array:
    """Carry tension through the straight part before the bend, the bend, and the part behind it."""
    w, angle = way.sign * law.constant_n, way.angle
    tension = tension - w * way.before
    arc = w * (1.0 - way.before - way.behind)
    if law.factors:
        tension = _integrate(law, tension, angle, arc, way.top_n)
    else:
        # what is pressed on without tension behaves as if all tensions were so much larger
        tension = np.exp(-angle) * tension - arc * _mean_decay(angle) + law.adhesion_n * np.expm1(-angle)
    return tension - w * way.behind


def _mean_decay(angle: Array) -> Array:
    """Return (1 - exp(-x)) / x, the mean of exp(-x s) over s in 0..1."""
    small = np.abs(angle) < 1e-9
    safe = np.where(small, 1.0, angle)
    return np.where(small, 1.0, -np.expm1(-safe) / safe)


def _integrate(law: Law, tension: Array, angle: Array, arc: Array, top_n: Array) -> Array:
    """Integrate the tension balance through the bend with the classical Runge-Kutta rule."""
    tops, table = np.unique(top_n[:, 0], return_inverse=True)
    # what is let out at the end may be under more tension than what goes in; more than that no recording reaches
    roots = np.linspace(0.0, np.sqrt(np.minimum(REACH * tops, CEILING_N)), FACTOR_NODES, axis=1)
    factors = np.ones_like(roots)
    for f in law.factors:
        factors = factors * f(roots * roots)
    return _through(tension, angle[:, 0], arc[:, 0], law.adhesion_n, factors, roots[:, 1], table)


@njit(cache=True, nogil=True, error_model="numpy")
def _through(tension: Array, angle: Array, arc: Array, adhesion_n: float, factors: Array, root_steps: Array, table: Counts) -> Array:
    """Return tensions behind the bend, shape (rows, nodes); factors on friction are tabulated over the root of tension."""
    out, h = tension.copy(), 1.0 / STEPS
    ask, k, total = np.empty(tension.shape[1]), np.empty(tension.shape[1]), np.empty(tension.shape[1])
    for i in range(len(tension)):
        t, factor, root_step = out[i], factors[table[i]], root_steps[table[i]]
        for _ in range(STEPS):
            # node by node within a stage: their chains of additions do not wait for one another
            _slopes(t, angle[i], arc[i], adhesion_n, factor, root_step, k)
            for j in range(t.size):
                total[j], ask[j] = k[j], t[j] + 0.5 * h * k[j]
            _slopes(ask, angle[i], arc[i], adhesion_n, factor, root_step, k)
            for j in range(t.size):
                total[j], ask[j] = total[j] + 2.0 * k[j], t[j] + 0.5 * h * k[j]
            _slopes(ask, angle[i], arc[i], adhesion_n, factor, root_step, k)
            for j in range(t.size):
                total[j], ask[j] = total[j] + 2.0 * k[j], t[j] + h * k[j]
            _slopes(ask, angle[i], arc[i], adhesion_n, factor, root_step, k)
            for j in range(t.size):
                t[j] = min(max(t[j] + h / 6.0 * (total[j] + k[j]), -CEILING_N), CEILING_N)
    return out


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _slopes(tension: Array, angle: float, arc: float, adhesion_n: float, factor: Array, root_step: float, out: Array) -> None:
    most = factor.size - 1.001
    for j in range(tension.size):
        # far outside the range of any tendon a fit may ask for the absurd; it must only not overflow, and stay a number
        t = min(tension[j], CEILING_N) if tension[j] > 0.0 else 0.0
        at = min(math.sqrt(t) / root_step, most)
        k = int(at)
        out[j] = -angle * (t + adhesion_n) * (factor[k] + (at - k) * (factor[k + 1] - factor[k])) - arc
