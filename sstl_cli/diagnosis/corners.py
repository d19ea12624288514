"""Whether an input passes its samples at corners: what holds keep says so.

A line holds the extreme that was reached, not the one that was sampled. A recorder of a steady rig misses it by a little each
time, a simulator that steps from sample to sample never does; each hold is one reading of which of the two it was.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import DECIDES_NATS, HELD
from sstl_cli.diagnosis.fit import Fit, first_theta, fit
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.recorder import stretches
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white

Array = NDArray[np.float64]


def likelier(sims: Sequence[Simulator], nominal: Array) -> tuple[Simulator, Array]:
    """Return the simulator whose input is the likelier one, and the theta of its base (unwhitened).

    Parameters
    ----------
    sims : sequence of Simulator
        One, or one whose input keeps to its samples and one whose input passes them at corners.
    nominal : ndarray, shape (configurations,)
    """
    first = _base(sims[0], nominal)
    if len(sims) == 1 or not passes(*holds(sims[0], first, sims[1].predict(first.theta, {}) - first.prediction)):
        return sims[0], first.theta
    return sims[1], _base(sims[1], nominal).theta


def _base(sim: Simulator, nominal: Array) -> Fit:
    whiten = white(1.0, sim.weight, [s.start for s in sim.slices()])
    return fit(sim, whiten, Hypothesis((), ()), first_theta(sim, nominal), np.zeros(0))


def holds(sim: Simulator, base: Fit, passed: Array) -> tuple[Array, Array]:
    """Return the mean of each hold (N, shape (holds,)): of what the base leaves, and of what corners would add there.

    Parameters
    ----------
    passed : ndarray, shape (samples,)
        What corners add to the prediction (N).
    """
    held = (sim.phases(base.theta, {}).slide < HELD) & (sim.weight > 0.0) & (passed != 0.0)
    found = [(a + s.start, b + s.start) for s in sim.slices() for a, b in stretches(held[s])]
    left = sim.y - base.prediction
    return np.array([left[a:b].mean() for a, b in found]), np.array([passed[a:b].mean() for a, b in found])


def passes(left: Array, passed: Array) -> bool:
    """Whether holds are off by what corners add: at 49 to 1 over none of it, and neither by half of it nor by far more.

    An effect that is missing leaves holds off as well, but not in that measure.
    """
    if not np.any(passed):
        return False
    share = float(left @ passed / (passed @ passed))
    none, all_of_it = float(left @ left), float(np.sum((left - passed) ** 2))
    return round(share) in (1, 2) and all_of_it < none * float(np.exp(-2.0 * DECIDES_NATS / len(left)))
