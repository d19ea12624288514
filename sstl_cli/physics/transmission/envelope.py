"""Lower and upper output tension as functions of the input tension: the propagation lines.

A law that is linear in tension is tabulated exactly by two nodes; otherwise the tension balance
dT/dphi = -zeta (f(T) T + h), Eq. (1), is integrated through the bend on a grid of input tensions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.effect import Law, Mechanics

Array = NDArray[np.float64]
NODES = 161
STEPS = 8
SCALE_NODES = 33
CEILING_N = 1e5


@dataclass(frozen=True)
class Envelope:
    """Tables of the propagation lines, shape (scale nodes, tension nodes), over equal grids.

    ``scale`` is a factor on mu that may change with time; the grids start at ``scale0`` and 0 N.
    """

    pull: Array
    release: Array
    tension_step_n: float
    scale0: float
    scale_step: float


def envelope(
    law: Law,
    theta: float,
    system: str,
    location: str | None,
    mechanics: Mechanics,
    top_n: float,
    scales: tuple[float, float] = (1.0, 1.0),
) -> Envelope:
    """Return the propagation lines of one run.

    Parameters
    ----------
    theta : float
        Friction coefficient times bending angle of one pass (rad).
    top_n : float
        Largest input tension that will be looked up (N).
    scales : tuple of float
        Range of the time-varying factor on mu.
    """
    linear = not law.factors
    nodes = 2 if linear else NODES
    grid = np.linspace(0.0, max(top_n, 1.0), nodes)
    low, high = scales
    # below this spread the rows would coincide to rounding
    factors = np.linspace(low, high, SCALE_NODES) if high - low > 1e-6 else np.array([low])
    before, behind = mechanics.straight(location)
    tables = []
    for zeta, side in ((1.0, law.scale_pull), (-1.0, law.scale_release)):
        phi = theta * side * factors
        tension = np.broadcast_to(grid, (len(factors), nodes))
        tension = _one_pass(law, tension, phi, zeta, before, behind, linear)
        if system == "sstl":
            m = law.pulley_pull if zeta > 0 else law.pulley_release
            tension = tension * np.exp(-zeta * m) - zeta * law.pulley_n
            tension = _one_pass(law, tension, phi, zeta, behind, before, linear)
        tables.append(np.ascontiguousarray(tension))
    step = float(grid[1] - grid[0])
    return Envelope(tables[0], tables[1], step, float(low), float(factors[1] - factors[0]) if len(factors) > 1 else 1.0)


def _one_pass(law: Law, tension: Array, phi: Array, zeta: float, before: float, behind: float, linear: bool) -> Array:
    """Carry tension through the straight part before the bend, the bend, and the part behind it."""
    w = zeta * law.constant_n
    tension = tension - w * before
    arc = w * (1.0 - before - behind)
    angle = zeta * phi[:, None]
    if linear:
        tension = np.exp(-angle) * tension - arc * _mean_decay(angle)
    else:
        tension = _integrate(law, tension, angle, arc)
    return tension - w * behind


def _mean_decay(angle: Array) -> Array:
    """Return (1 - exp(-x)) / x, the mean of exp(-x s) over s in 0..1."""
    small = np.abs(angle) < 1e-9
    safe = np.where(small, 1.0, angle)
    return np.where(small, 1.0, -np.expm1(-safe) / safe)


def _integrate(law: Law, tension: Array, angle: Array, arc: float) -> Array:
    """Integrate the tension balance through the bend with the classical Runge-Kutta rule."""
    h = 1.0 / STEPS

    def slope(t: Array) -> Array:
        # far outside the range of any tendon a fit may ask for the absurd; it must only not overflow
        t = np.clip(t, 0.0, CEILING_N)
        friction = t
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
