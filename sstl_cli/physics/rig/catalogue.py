"""Parameters of every effect the rig can carry: unit, neutral value and range, checked on entry."""

from __future__ import annotations

from collections.abc import Mapping

from sstl_cli.physics.given import Bounds, Values, resolved


def _per_sensor(prefix: str, high: float, unit: str) -> dict[str, Bounds]:
    sensors = [f"{side}_{system}" for system in ("act", "sstl") for side in ("in", "out")]
    return {f"{prefix}_{sensor}_n": Bounds(0.0, -high, high, unit) for sensor in sensors}


EFFECTS: dict[str, dict[str, Bounds]] = {
    # friction law
    "const_friction": {"w_l_n": Bounds(0.0, 0.0, 0.5, "N")},
    "pulley_friction": {"m_p": Bounds(0.0, 0.0, 0.25, "-"), "m_r": Bounds(0.0, 0.0, 0.25, "-"), "f0_n": Bounds(0.0, 0.0, 2.0, "N")},
    "load_dependent_friction": {"alpha": Bounds(0.0, -0.1, 0.33, "-")},
    "asymmetric_friction": {"a": Bounds(0.0, -0.2, 0.2, "-")},
    "sheath_compliance": {"c_t_per_n": Bounds(0.0, 0.0, 0.01, "1/N"), "k_sh_mm_per_n": Bounds(0.0, 0.0, 0.2, "mm/N")},
    "friction_drift": {"d_mu": Bounds(0.0, -0.3, 0.3, "-"), "path_n": Bounds(200.0, 10.0, 5000.0, "N")},
    "tendon_crosstalk": {"c_bend_per_n": Bounds(0.0, -0.01, 0.02, "1/N")},
    "stribeck": {"ratio": Bounds(1.0, 1.0, 1.5, "-"), "v_s_mm_s": Bounds(1.0, 0.1, 10.0, "mm/s")},
    "viscous": {"c_l_n_s_per_mm": Bounds(0.0, 0.0, 0.05, "N s/mm")},
    # transition
    "presliding": {"breakaway_mm": Bounds(0.0, 0.0, 1.5, "mm"), "spread": Bounds(0.5, 0.0, 1.0, "-")},
    "stick_slip": {"ratio": Bounds(1.0, 1.0, 1.5, "-"), "v_c_mm_s": Bounds(1.0, 0.1, 10.0, "mm/s")},
    "dwell_aging": {"b": Bounds(0.0, 0.0, 0.05, "-"), "t0_s": Bounds(1.0, 0.1, 10.0, "s")},
    "viscoelastic_creep": {"fraction": Bounds(0.0, 0.0, 0.3, "-"), "tau_s": Bounds(10.0, 1.0, 100.0, "s")},
    "slack": {"gap_mm": Bounds(0.0, 0.0, 5.0, "mm")},
    "tendon_elasticity": {"compliance_per_kn": Bounds(0.0, 0.0, 0.33, "1/kN")},
    "load_spring": {"k3_per_mm2": Bounds(0.0, 0.0, 0.1, "1/mm2"), "play_mm": Bounds(0.0, 0.0, 2.0, "mm")},
    "tension_loop_lag": {"tau_s": Bounds(0.0, 0.0, 0.5, "s"), "inverse_slew_s_per_n": Bounds(0.0, 0.0, 0.2, "s/N")},
    # instrument
    "zero_offset": _per_sensor("z", 2.0, "N"),
    "gain_error": {"g_act": Bounds(1.0, 0.85, 1.15, "-"), "g_sstl": Bounds(1.0, 0.85, 1.15, "-")},
    "zero_drift": _per_sensor("r", 1.0, "N"),
    "channel_delay": {"tau_act_s": Bounds(0.0, 0.0, 0.2, "s"), "tau_sstl_s": Bounds(0.0, 0.0, 0.2, "s")},
    "channel_lowpass": {"tau_act_s": Bounds(0.0, 0.0, 0.32, "s"), "tau_sstl_s": Bounds(0.0, 0.0, 0.32, "s")},
    "crosstalk": {"c_in_to_out": Bounds(0.0, 0.0, 0.05, "-"), "c_out_to_in": Bounds(0.0, 0.0, 0.05, "-")},
    "sensor_nonlinearity": {
        "a_in": Bounds(0.0, -0.02, 0.02, "-"),
        "a_out": Bounds(0.0, -0.02, 0.02, "-"),
        "h_n": Bounds(0.0, 0.0, 0.1, "N"),
    },
    "quantisation": {"q_in_n": Bounds(0.0, 0.0, 0.5, "N"), "q_out_n": Bounds(0.0, 0.0, 0.5, "N")},
    "saturation": {"t_max_in_n": Bounds(1000.0, 1.0, 1000.0, "N"), "t_max_out_n": Bounds(1000.0, 1.0, 1000.0, "N")},
    "acquisition_faults": {
        "spike_pct": Bounds(0.0, 0.0, 2.0, "%"),
        "dropout_pct": Bounds(0.0, 0.0, 2.0, "%"),
        "frozen_pct": Bounds(0.0, 0.0, 2.0, "%"),
        "jitter_pct": Bounds(0.0, 0.0, 2.0, "%"),
        "spike_n": Bounds(5.0, 0.5, 50.0, "N"),
    },
}


def resolve_effects(effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect, neutral where `effects` is silent; ValueError where one is unknown or out of range.

    Examples
    --------
    >>> resolve_effects({"stribeck": {"ratio": 1.2}})["stribeck"]
    {'ratio': 1.2, 'v_s_mm_s': 1.0}
    """
    return resolved("rig", EFFECTS, effects)
