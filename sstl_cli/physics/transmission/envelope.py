"""Lower and upper output tension as functions of the input tension: the propagation lines.

A law that is linear in tension is tabulated exactly by two nodes; otherwise the tension balance
dT/dphi = -zeta (f(T) T + h), Eq. (1), is integrated through the bend on a grid of input tensions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.effect import Law, Mechanics

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
NODES = 161
STEPS = 8
SCALE_NODES = 33
CEILING_N = 1e5


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


def envelopes(law: Law, wanted: Sequence[Line], mechanics: Mechanics) -> Envelopes:
    """Return the propagation lines of several runs, integrated together."""
    linear = not law.factors
    nodes = 2 if linear else NODES
    # below this spread the rows would coincide to rounding
    rows = np.array([SCALE_NODES if w.high - w.low > 1e-6 else 1 for w in wanted])
    factors = np.concatenate([np.linspace(w.low, w.high, n) if n > 1 else [w.low] for w, n in zip(wanted, rows, strict=True)])
    grids = np.linspace(0.0, np.maximum([w.top_n for w in wanted], 1.0), nodes, axis=1)
    straight = np.repeat([mechanics.straight(w.location) for w in wanted], rows, axis=0)
    before, behind = straight[:, :1], straight[:, 1:]
    theta = np.repeat([w.theta for w in wanted], rows)
    twice = np.repeat([w.system == "sstl" for w in wanted], rows)
    tables = []
    for zeta, side in ((1.0, law.scale_pull), (-1.0, law.scale_release)):
        phi = theta * side * factors
        tension = _one_pass(law, np.repeat(grids, rows, axis=0) - zeta * law.begin_n, phi, zeta, before, behind, linear)
        if twice.any():
            m = law.pulley_pull if zeta > 0 else law.pulley_release
            back = tension[twice] * np.exp(-zeta * m) - zeta * law.pulley_n
            tension[twice] = _one_pass(law, back, phi[twice], zeta, behind[twice], before[twice], linear)
        tables.append(np.ascontiguousarray(tension - zeta * law.end_n))
    edges = np.concatenate(([0], np.cumsum(rows)))
    first = edges[:-1]
    step = np.where(rows > 1, factors[np.minimum(first + 1, len(factors) - 1)] - factors[first], 1.0)
    return Envelopes(tables[0], tables[1], edges.astype(np.int64), grids[:, 1] - grids[:, 0], factors[first], step)


def _one_pass(law: Law, tension: Array, phi: Array, zeta: float, before: Array, behind: Array, linear: bool) -> Array:
    """Carry tension through the straight part before the bend, the bend, and the part behind it."""
    w = zeta * law.constant_n
    tension = tension - w * before
    arc = w * (1.0 - before - behind)
    angle = zeta * phi[:, None]
    if linear:
        # what is pressed on without tension behaves as if all tensions were so much larger
        tension = np.exp(-angle) * tension - arc * _mean_decay(angle) + law.adhesion_n * np.expm1(-angle)
    else:
        tension = _integrate(law, tension, angle, arc)
    return tension - w * behind


def _mean_decay(angle: Array) -> Array:
    """Return (1 - exp(-x)) / x, the mean of exp(-x s) over s in 0..1."""
    small = np.abs(angle) < 1e-9
    safe = np.where(small, 1.0, angle)
    return np.where(small, 1.0, -np.expm1(-safe) / safe)


def _integrate(law: Law, tension: Array, angle: Array, arc: Array) -> Array:
    """Integrate the tension balance through the bend with the classical Runge-Kutta rule."""
    h = 1.0 / STEPS

    def slope(t: Array) -> Array:
        # far outside the range of any tendon a fit may ask for the absurd; it must only not overflow
        t = np.clip(t, 0.0, CEILING_N)
        friction = t + law.adhesion_n
        for factor in law.factors:
            friction = friction * factor(t)
        return -angle * friction - arc

    for _ in range(STEPS):
        k1 = slope(tension)
        k2 = slope(tension + 0.5 * h * k1)
        k3 = slope(tension + 0.5 * h * k2)
        k4 = slope(tension + h * k3)
        tension = np.clip(tension + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), -CEILING_N, CEILING_N)
    return tension
