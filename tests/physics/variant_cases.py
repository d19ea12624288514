"""A clearly visible strength of every effect of the catalogue, and the runs on which the law variants are tested."""

from __future__ import annotations

import numpy as np

from sstl_cli.physics.variant import QUIET, VariantResult, VariantRun, VariantSpec, known_laws, parameters, simulate_variant

STRENGTHS: dict[str, dict[str, float]] = {
    "acquisition_faults": {"spike_pct": 1.0, "frozen_pct": 1.0, "dropout_pct": 0.5, "jitter_pct": 1.0},
    "asymmetric_friction": {"a": 0.08},
    "channel_delay": {"tau_act_s": 0.06, "tau_sstl_s": 0.09},
    "channel_lowpass": {"tau_act_s": 0.06, "tau_sstl_s": 0.09},
    "const_friction": {"w_l_n": 0.3},
    "crosstalk": {"c_in_to_out": 0.02, "c_out_to_in": 0.015},
    "dwell_aging": {"b": 0.04},
    "friction_drift": {"d_mu": 0.2, "path_n": 50.0},
    "gain_error": {"g_act": 1.04, "g_sstl": 0.95},
    "load_dependent_friction": {"alpha": 0.15},
    "load_spring": {"k3_per_mm2": 0.05, "play_mm": 0.8},
    "presliding": {"breakaway_mm": 0.2},
    "pulley_friction": {"m_p": 0.1, "m_r": 0.06, "f0_n": 0.3},
    "quantisation": {"q_in_n": 0.1, "q_out_n": 0.2},
    "saturation": {"t_max_in_n": 15.0, "t_max_out_n": 6.0},
    "sensor_nonlinearity": {"a_in": 0.01, "a_out": -0.012, "h_n": 0.05},
    "sheath_compliance": {"c_t_per_n": 0.005, "k_sh_mm_per_n": 0.05},
    "slack": {"gap_mm": 2.0},
    "stick_slip": {"ratio": 1.2, "v_c_mm_s": 1.0},
    "stribeck": {"ratio": 1.2, "v_s_mm_s": 3.0},
    "tendon_crosstalk": {"c_bend_per_n": 0.006},
    "tendon_elasticity": {"compliance_per_kn": 0.2},
    "tension_loop_lag": {"tau_s": 0.1, "inverse_slew_s_per_n": 0.05},
    "viscoelastic_creep": {"fraction": 0.2, "tau_s": 10.0},
    "viscous": {"c_l_n_s_per_mm": 0.03},
    "zero_drift": {"r_in_act_n": 0.3, "r_out_act_n": -0.4, "r_in_sstl_n": 0.2, "r_out_sstl_n": 0.3},
    "zero_offset": {"z_in_act_n": 0.3, "z_out_act_n": -0.4, "z_in_sstl_n": -0.3, "z_out_sstl_n": 0.2},
}
EVERY_LAW = [(effect, law.id) for effect, laws in known_laws().items() for law in laws]
HZ = 100.0


def movement(system: str, theta: float = 0.5) -> VariantRun:
    """Return 15 s of loops, minor loops and holds, beside a tendon that moves alike 2.5 s later."""
    time = np.arange(round(15.0 * HZ)) / HZ
    places = [0.0, 2, 3.5, 5.5, 7.5, 8.5, 10.5, 11.5, 13, 15]
    command = np.interp(time, places, [0.5, 22, 22, 2, 2, 18, 6, 15, 4, 20])
    return VariantRun(system, theta, "CP", time, "tension", command, np.roll(command, 250))


def recorded(system: str, effect: str | None, law: str | None = None, scale: float = 1.0) -> VariantResult:
    """Return the movement recorded without noise, with one effect by one law; ``scale`` stretches it from neutral."""
    effects = {}
    if effect is not None:
        neutral = {k: b.neutral for k, b in parameters()[effect].items()}
        effects = {effect: {k: neutral[k] + scale * (v - neutral[k]) for k, v in STRENGTHS[effect].items()}}
    spec = VariantSpec(laws={} if law is None or effect is None else {effect: law}, law_seed=1)
    return simulate_variant(spec, movement(system), effects, QUIET, 3)
