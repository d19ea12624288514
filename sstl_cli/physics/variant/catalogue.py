"""Parameters of every effect by the catalogue's names: neutral value and range, twice the catalogue's."""

from __future__ import annotations

from collections.abc import Mapping

from sstl_cli.physics.given import Bounds, Values, resolved

WIDER = 2.0


def _wide(neutral: float, low: float, high: float, unit: str) -> Bounds:
    """Return a strength's bounds, both ends `WIDER` times as far from neutral."""
    return Bounds(neutral, neutral + WIDER * (low - neutral), neutral + WIDER * (high - neutral), unit)


def _shape(neutral: float, low: float, high: float, unit: str) -> Bounds:
    """Return bounds of a time, length or speed, which must stay positive."""
    return Bounds(neutral, low / WIDER, high * WIDER, unit)


def _per_sensor(prefix: str, high: float) -> dict[str, Bounds]:
    return {f"{prefix}_{side}_{system}_n": _wide(0.0, -high, high, "N") for system in ("act", "sstl") for side in ("in", "out")}


EFFECTS: dict[str, dict[str, Bounds]] = {
    "const_friction": {"w_l_n": _wide(0.0, 0.0, 0.5, "N")},
    "pulley_friction": {"m_p": _wide(0.0, 0.0, 0.25, "1"), "m_r": _wide(0.0, 0.0, 0.25, "1"), "f0_n": _wide(0.0, 0.0, 2.0, "N")},
    "load_dependent_friction": {"alpha": _wide(0.0, -0.1, 0.33, "1")},
    "asymmetric_friction": {"a": _wide(0.0, -0.2, 0.2, "1")},
    "sheath_compliance": {"c_t_per_n": _wide(0.0, 0.0, 0.01, "1/N"), "k_sh_mm_per_n": _wide(0.0, 0.0, 0.2, "mm/N")},
    "friction_drift": {"d_mu": _wide(0.0, -0.3, 0.3, "1"), "path_n": _shape(200.0, 10.0, 5000.0, "N")},
    "tendon_crosstalk": {"c_bend_per_n": _wide(0.0, -0.01, 0.02, "1/N")},
    "stribeck": {"ratio": _wide(1.0, 1.0, 1.5, "1"), "v_s_mm_s": _shape(1.0, 0.1, 10.0, "mm/s")},
    "viscous": {"c_l_n_s_per_mm": _wide(0.0, 0.0, 0.05, "N s/mm")},
    "presliding": {"breakaway_mm": _wide(0.0, 0.0, 1.5, "mm"), "spread": Bounds(0.5, 0.0, 1.0, "1")},
    "stick_slip": {"ratio": _wide(1.0, 1.0, 1.5, "1"), "v_c_mm_s": _shape(1.0, 0.1, 10.0, "mm/s")},
    "dwell_aging": {"b": _wide(0.0, 0.0, 0.05, "1"), "t0_s": _shape(1.0, 0.1, 10.0, "s")},
    "viscoelastic_creep": {"fraction": _wide(0.0, 0.0, 0.3, "1"), "tau_s": _shape(10.0, 1.0, 100.0, "s")},
    "slack": {"gap_mm": _wide(0.0, 0.0, 5.0, "mm")},
    "tendon_elasticity": {"compliance_per_kn": _wide(0.0, 0.0, 0.33, "1/kN")},
    "load_spring": {"k3_per_mm2": _wide(0.0, 0.0, 0.1, "1/mm^2"), "play_mm": _wide(0.0, 0.0, 2.0, "mm")},
    "tension_loop_lag": {"tau_s": _wide(0.0, 0.0, 0.5, "s"), "inverse_slew_s_per_n": _wide(0.0, 0.0, 0.2, "s/N")},
    "zero_offset": _per_sensor("z", 2.0),
    "gain_error": {"g_act": _wide(1.0, 0.85, 1.15, "1"), "g_sstl": _wide(1.0, 0.85, 1.15, "1")},
    "zero_drift": _per_sensor("r", 1.0),
    "channel_delay": {"tau_act_s": _wide(0.0, 0.0, 0.2, "s"), "tau_sstl_s": _wide(0.0, 0.0, 0.2, "s")},
    "channel_lowpass": {"tau_act_s": _wide(0.0, 0.0, 0.32, "s"), "tau_sstl_s": _wide(0.0, 0.0, 0.32, "s")},
    "crosstalk": {"c_in_to_out": _wide(0.0, 0.0, 0.05, "1"), "c_out_to_in": _wide(0.0, 0.0, 0.05, "1")},
    "sensor_nonlinearity": {"a_in": _wide(0.0, -0.02, 0.02, "1"), "a_out": _wide(0.0, -0.02, 0.02, "1"), "h_n": _wide(0.0, 0.0, 0.1, "N")},
    "quantisation": {"q_in_n": _wide(0.0, 0.0, 0.5, "N"), "q_out_n": _wide(0.0, 0.0, 0.5, "N")},
    "saturation": {"t_max_in_n": Bounds(1000.0, 0.5, 1000.0, "N"), "t_max_out_n": Bounds(1000.0, 0.5, 1000.0, "N")},
    "acquisition_faults": {
        "spike_pct": _wide(0.0, 0.0, 2.0, "%"),
        "spike_n": _shape(5.0, 0.5, 50.0, "N"),
        "dropout_pct": _wide(0.0, 0.0, 2.0, "%"),
        "frozen_pct": _wide(0.0, 0.0, 2.0, "%"),
        "jitter_pct": _wide(0.0, 0.0, 2.0, "%"),
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
