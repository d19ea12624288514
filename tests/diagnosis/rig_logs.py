"""Rig recordings for the diagnosis tests: never made by the model that is fitted."""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory
from sstl_cli.steps import simulate

FULL = (
    Trajectory(kind="trapezoid", drive="tension", duration_s=12.0),
    Trajectory(kind="trapezoid", label="slow trapezoid", drive="tension", duration_s=40.0),
    Trajectory(kind="random", duration_s=60.0, low_n=2.0),
    Trajectory(kind="ramp_hold", duration_s=40.0),
    Trajectory(kind="minor_loops", duration_s=40.0),
)
# one speed from another, holds, and reversals: a quarter of the samples
SHORT = (
    Trajectory(kind="trapezoid", drive="tension", duration_s=8.0),
    Trajectory(kind="random", duration_s=24.0, low_n=2.0),
    Trajectory(kind="ramp_hold", duration_s=20.0),
)
RAMPS = FULL[:2]
# strengths that leave about twice the noise RMS (0.02 N) after the base is re-tuned
STRENGTH = {
    "const_friction": {"w_l_n": 0.05},
    "pulley_friction": {"m_p": 0.009},
    "load_dependent_friction": {"alpha": 0.007},
    "asymmetric_friction": {"a": 0.0085},
    "sheath_compliance": {"c_t_per_n": 0.0008},
    "friction_drift": {"d_mu": 0.022},
    "stribeck": {"ratio": 1.0145},
    "viscous": {"c_l_n_s_per_mm": 0.0138},
    "presliding": {"breakaway_mm": 0.028},
    "stick_slip": {"ratio": 1.03},
    "dwell_aging": {"b": 0.03},
    "viscoelastic_creep": {"fraction": 0.06},
    "zero_offset": {"z_out_act_n": 0.07},
    "gain_error": {"g_sstl": 1.01},
    "zero_drift": {"r_out_act_n": 0.2},
    "channel_delay": {"tau_act_s": 0.021},
    "channel_lowpass": {"tau_act_s": 0.022},
    "crosstalk": {"c_in_to_out": 0.0037},
    "sensor_nonlinearity": {"a_out": 0.008},
}


def scenario(
    hz: float = 50.0, white: float = 0.02, coloured: float = 0.0, configs: int = 2, moves: tuple[Trajectory, ...] = SHORT
) -> Scenario:
    places = (("a", "NP", 0.46), ("b", "ND", 0.60), ("c", "CP", 0.53))[:configs]
    return Scenario(
        simulator="rig",
        sampling_hz=hz,
        noise=NoiseSection(white_n=white, coloured_n=coloured),
        configurations=tuple(Configuration(id=i, location=p, theta=t) for i, p, t in places),
        trajectories=moves,
    )


def record(effects: dict, seed: int = 0, **rig) -> list:
    return list(simulate.run(scenario(**rig), effects, seed))


def sound(n: int, noise_n: float) -> Faults:
    """Return the faults of a channel of ``n`` readings, every one of them sound."""
    none = np.zeros(n, bool)
    return Faults(none, none, none, float("inf"), 0.0, noise_n)


def theta_jump(runs: list, at: float = 0.5) -> list:
    """An effect of no catalogue: the tube moves half-way through every run."""
    from dataclasses import replace

    moved = []
    for run in runs:
        n = run.passes
        k = int(len(run) * at)
        low, high = np.exp(-n * 0.62), np.exp(n * 0.62)
        out, y = run.tension_out_n.copy(), run.tension_out_n[k - 1]
        for i in range(k, len(out)):
            y = max(low * run.tension_in_n[i], min(y, high * run.tension_in_n[i]))
            out[i] = y + 0.02 * np.sin(1e4 * i)
        moved.append(replace(run, tension_out_n=out))
    return moved
