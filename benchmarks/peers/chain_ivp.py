"""The elastic chain with Coulomb friction at every node as an ODE for ``scipy.integrate.solve_ivp``.

Friction needs a velocity to have a direction, so each node gets a small drag c and a friction that saturates at
the speed v_s: c v + L clip(v / v_s, -1, 1) = T_left - T_right, solved for v. Both go to zero towards Coulomb's law.
LSODA with the tridiagonal Jacobian is the quickest of scipy's stiff solvers here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """Springs (mm/N), the load spring (N/mm) at the end, friction limit over mean tension of each node."""

    compliance: Array
    load_n_per_mm: float
    slope_pull: Array
    slope_release: Array
    pretension_n: float
    drag: float = 2e-4
    speed: float = 5e-4

    def output(self, last: Array) -> Array:
        """Return the tension of the load spring (N) for the displacement (mm) of the last node."""
        both = self.compliance[-1] + 1.0 / self.load_n_per_mm
        return self.pretension_n + last / both

    def rate(self, t: float, u: Array, time: Array, tension: Array) -> Array:
        """Return the velocities (mm/s) of the nodes."""
        k = 1.0 / self.compliance[1:-1]
        right = np.empty_like(u)
        right[:-1] = self.pretension_n + k * (u[:-1] - u[1:])
        right[-1] = self.output(u[-1])
        left = np.concatenate(([np.interp(t, time, tension)], right[:-1]))
        net, mean = left - right, 0.5 * (left + right)
        limit = np.where(net > 0.0, self.slope_pull, self.slope_release) * np.maximum(mean, 0.0)
        creeping = net / (self.drag + limit / self.speed)
        sliding = (net - np.sign(net) * limit) / self.drag
        return np.where(np.abs(net) <= limit + self.drag * self.speed, creeping, sliding)


def march(chain: Chain, time: Array, tension: Array, rtol: float = 1e-4, atol: float = 1e-8) -> Array:
    """Return the output tension (N) at the sampling times."""
    lead = 1.0
    start = chain.pretension_n
    times = np.concatenate(([-lead], time))
    tensions = np.concatenate(([start], tension))
    done = solve_ivp(
        chain.rate,
        (-lead, time[-1]),
        np.zeros(len(chain.slope_pull)),
        "LSODA",
        time,
        args=(times, tensions),
        rtol=rtol,
        atol=atol,
        lband=1,
        uband=1,
        max_step=0.05,
    )
    if not done.success:
        raise RuntimeError(done.message)
    return chain.output(done.y[-1])
