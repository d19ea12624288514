"""Friction that runs in or wears: both slopes open or close over the cycles, biases stay."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Drive, Effect, Law, Parameter, Values
from sstl_cli.physics.filters import low_pass


def _law(law: Law, v: Values) -> None:
    by_path, path, by_time, time, by_heat = v["d_mu"], v["path_n"], v["d_mu_time"], v["time_s"], v["d_mu_heat_s_per_n2"]
    if by_path != 0.0 or by_time != 0.0 or by_heat != 0.0:

        def scale(drive: Drive) -> Array:
            factor = 1.0 + by_path * np.exp(-drive.path_n * _slips(drive) / path) + by_time * np.exp(-drive.time_s / time)
            if by_heat != 0.0:
                factor = factor + by_heat * _warmth(drive, v["cooling_s"])
            return np.asarray(np.maximum(factor, 0.0))

        law.friction_scale.append(scale)


def _slips(drive: Drive) -> float:
    """Return by how much a line slips for its input, over the actuation tendon: that wears and warms, and a loop that ends stiffer slips less."""
    return drive.mechanics.slip_mm_per_n(drive.system) / drive.mechanics.slip_mm_per_n("act")


def _warmth(drive: Drive, cooling_s: float) -> Array:
    """Return the temperature over that around it, as the power (N^2/s) that would keep it: friction goes with tension, its speed with the rate."""
    power = np.maximum(drive.tension_n, 0.0) * np.abs(drive.rate_n_s) * _slips(drive)
    # a run begins cold
    power[0] = 0.0
    return low_pass(power, drive.dt_s, cooling_s)


EFFECT = Effect(
    id="friction_drift",
    title="Friction that drifts with use, or differs from run to run",
    stage=FRICTION_LAW,
    equation="mu = mu_inf (1 + d_mu exp(-W / path) + d_mu_time exp(-t / time)), W = path of the input tension; "
    "or mu = mu0 (1 + d_heat h), cooling dh/dt + h = T |dT/dt|",
    source="Run-in and wear go with the path, warming with time, heat with Newton's cooling; catalogue entry [L]",
    parameters=(
        Parameter("d_mu", "1", 0.0, -0.3, 0.3, "relative friction above its final value at the start, lost by path", limits=(-0.9, 3.0)),
        Parameter("path_n", "N", 200.0, 10.0, 5000.0, "input-tension path of the run-in", shape=True),
        Parameter("d_mu_time", "1", 0.0, -0.3, 0.3, "the same, lost by time", limits=(-0.9, 3.0)),
        Parameter("time_s", "s", 60.0, 2.0, 1000.0, "time constant of the loss by time", shape=True),
        Parameter("d_mu_heat_s_per_n2", "s/N^2", 0.0, -3e-3, 3e-3, "relative friction that comes with the heat of friction, and cools off"),
        Parameter("cooling_s", "s", 10.0, 1.0, 300.0, "time constant of that cooling", shape=True),
    ),
    excitation="Several equal cycles in one run.",
    look_alikes=("zero_drift",),
    variants=(("d_mu", "path_n"), ("d_mu_time", "time_s"), ("d_mu_heat_s_per_n2", "cooling_s")),
    law=_law,
    along=True,
)
