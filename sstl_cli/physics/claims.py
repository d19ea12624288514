"""What is claimed of the output of a loop, and how far off it is: propagation lines, or a simulator at a theta."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission import activate, play_operator, predict
from sstl_cli.physics.transmission.model import drive_of, observed_output

Array = NDArray[np.float64]
# from input tension (N), sampling period (s) and first output (N) to the output (N)
Reference = Callable[[Array, float, float], Array]


def gap_n(reference: Reference, run: Run) -> float:
    """Return the RMSE (N) between the measured output of a loop and the reference's."""
    first = float(np.median(run.tension_out_n[:5]))
    return float(np.sqrt(np.mean((run.tension_out_n - reference(run.tension_in_n, run.dt_s, first)) ** 2)))


def lines_of(gamma_p: float, beta_p: float, gamma_r: float, beta_r: float) -> Reference:
    """Return the play between two propagation lines, Eq. (3) and (5)."""

    def reference(tension: Array, _dt_s: float, first: float) -> Array:
        return play_operator(tension, gamma_p, beta_p, gamma_r, beta_r, first)

    return reference


def of_simulator(sim: Scenario, run: Run, gamma_p: float | None, gamma_r: float | None) -> Reference:
    """Return the simulator at the configuration's theta, or where it names none, at that of the slopes that were found."""
    known = {c.id: c.theta for c in sim.configurations if c.theta is not None}
    theta = known.get(run.config_id or "")
    active, mechanics = activate(sim.effects), sim.rig.mechanics()
    if theta is None and gamma_p is not None and gamma_r is not None:
        theta = max(math.log(gamma_r / gamma_p) / (2.0 * run.passes * mechanics.friction(run.system)), 0.0)
    angle = sim.theta_of(run.config_id) if theta is None else theta

    def reference(tension: Array, dt_s: float, first: float) -> Array:
        drive = drive_of(run.system, run.location, dt_s, tension, mechanics)
        out = predict(drive, angle, active, first)
        return observed_output(run.system, dt_s, tension, out, active, angle)

    return reference
