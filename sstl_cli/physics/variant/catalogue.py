"""Parameters of every effect by the catalogue's names: neutral value and range, twice the catalogue's."""

from __future__ import annotations

from collections.abc import Mapping

from sstl_cli.physics.given import Bounds, Values, resolved

WIDER = 2.0


def _wide(neutral: float, low: float, high: float) -> Bounds:
    """Return a strength's bounds, both ends `WIDER` times as far from neutral."""
    return Bounds(neutral, neutral + WIDER * (low - neutral), neutral + WIDER * (high - neutral))


def _shape(neutral: float, low: float, high: float) -> Bounds:
    """Return bounds of a time, length or speed, which must stay positive."""
    return Bounds(neutral, low / WIDER, high * WIDER)


def _per_sensor(prefix: str, high: float) -> dict[str, Bounds]:
    return {f"{prefix}_{side}_{system}_n": _wide(0.0, -high, high) for system in ("act", "sstl") for side in ("in", "out")}


EFFECTS: dict[str, dict[str, Bounds]] = {
    "const_friction": {"w_l_n": _wide(0.0, 0.0, 0.5)},
    "pulley_friction": {"m_p": _wide(0.0, 0.0, 0.25), "m_r": _wide(0.0, 0.0, 0.25), "f0_n": _wide(0.0, 0.0, 2.0)},
    "load_dependent_friction": {"alpha": _wide(0.0, -0.1, 0.33)},
    "asymmetric_friction": {"a": _wide(0.0, -0.2, 0.2)},
    "sheath_compliance": {"c_t_per_n": _wide(0.0, 0.0, 0.01), "k_sh_mm_per_n": _wide(0.0, 0.0, 0.2)},
    "friction_drift": {"d_mu": _wide(0.0, -0.3, 0.3), "path_n": _shape(200.0, 10.0, 5000.0)},
    "tendon_crosstalk": {"c_bend_per_n": _wide(0.0, -0.01, 0.02)},
    "stribeck": {"ratio": _wide(1.0, 1.0, 1.5), "v_s_mm_s": _shape(1.0, 0.1, 10.0)},
    "viscous": {"c_l_n_s_per_mm": _wide(0.0, 0.0, 0.05)},
    "presliding": {"breakaway_mm": _wide(0.0, 0.0, 1.5), "spread": Bounds(0.5, 0.0, 1.0)},
    "stick_slip": {"ratio": _wide(1.0, 1.0, 1.5), "v_c_mm_s": _shape(1.0, 0.1, 10.0)},
    "dwell_aging": {"b": _wide(0.0, 0.0, 0.05), "t0_s": _shape(1.0, 0.1, 10.0)},
    "viscoelastic_creep": {"fraction": _wide(0.0, 0.0, 0.3), "tau_s": _shape(10.0, 1.0, 100.0)},
    "slack": {"gap_mm": _wide(0.0, 0.0, 5.0)},
    "tendon_elasticity": {"compliance_per_kn": _wide(0.0, 0.0, 0.33)},
    "load_spring": {"k3_per_mm2": _wide(0.0, 0.0, 0.1), "play_mm": _wide(0.0, 0.0, 2.0)},
    "tension_loop_lag": {"tau_s": _wide(0.0, 0.0, 0.5), "inverse_slew_s_per_n": _wide(0.0, 0.0, 0.2)},
    "zero_offset": _per_sensor("z", 2.0),
    "gain_error": {"g_act": _wide(1.0, 0.85, 1.15), "g_sstl": _wide(1.0, 0.85, 1.15)},
    "zero_drift": _per_sensor("r", 1.0),
    "channel_delay": {"tau_act_s": _wide(0.0, 0.0, 0.2), "tau_sstl_s": _wide(0.0, 0.0, 0.2)},
    "channel_lowpass": {"tau_act_s": _wide(0.0, 0.0, 0.32), "tau_sstl_s": _wide(0.0, 0.0, 0.32)},
    "crosstalk": {"c_in_to_out": _wide(0.0, 0.0, 0.05), "c_out_to_in": _wide(0.0, 0.0, 0.05)},
    "sensor_nonlinearity": {"a_in": _wide(0.0, -0.02, 0.02), "a_out": _wide(0.0, -0.02, 0.02), "h_n": _wide(0.0, 0.0, 0.1)},
    "quantisation": {"q_in_n": _wide(0.0, 0.0, 0.5), "q_out_n": _wide(0.0, 0.0, 0.5)},
    "saturation": {"t_max_in_n": Bounds(1000.0, 0.5, 1000.0), "t_max_out_n": Bounds(1000.0, 0.5, 1000.0)},
    "acquisition_faults": {
        "spike_pct": _wide(0.0, 0.0, 2.0),
        "spike_n": _shape(5.0, 0.5, 50.0),
        "dropout_pct": _wide(0.0, 0.0, 2.0),
        "frozen_pct": _wide(0.0, 0.0, 2.0),
        "jitter_pct": _wide(0.0, 0.0, 2.0),
    },
}


def resolve_effects(effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect, neutral where `effects` is silent; ValueError where one is unknown or out of range.

    Examples
    --------
    >>> resolve_effects({"stribeck": {"ratio": 1.2}})["stribeck"]
    {'ratio': 1.2, 'v_s_mm_s': 1.0}
    """
    return resolved("variant", EFFECTS, effects)
