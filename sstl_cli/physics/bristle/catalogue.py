"""What the bristle simulator has code for: every parameter of every effect, with its neutral value and range."""

from __future__ import annotations

from collections.abc import Mapping

from sstl_cli.physics.given import Bounds, Values, resolved


def _share(high: float, low: float = 0.0, neutral: float = 0.0) -> Bounds:
    return Bounds(neutral, low, high)


def _sensors(letter: str, high: float) -> dict[str, Bounds]:
    names = ("in_act", "out_act", "in_sstl", "out_sstl")
    return {f"{letter}_{name}_n": Bounds(0.0, -high, high) for name in names}


def _lags(high: float) -> dict[str, Bounds]:
    return {f"tau_{system}_s": Bounds(0.0, 0.0, high) for system in ("act", "sstl")}


EFFECTS: dict[str, dict[str, Bounds]] = {
    "acquisition_faults": {
        **{f"{name}_pct": Bounds(0.0, 0.0, 2.0) for name in ("spike", "dropout", "frozen", "jitter")},
        "spike_n": Bounds(5.0, 0.5, 50.0),
    },
    "asymmetric_friction": {"a": _share(0.2, -0.2)},
    "channel_delay": _lags(0.2),
    "channel_lowpass": _lags(0.32),
    "const_friction": {"w_l_n": Bounds(0.0, 0.0, 0.5)},
    "crosstalk": {"c_in_to_out": _share(0.05), "c_out_to_in": _share(0.05)},
    "dwell_aging": {"b": _share(0.05), "t0_s": Bounds(1.0, 0.1, 10.0)},
    "friction_drift": {"d_mu": _share(0.3, -0.3), "path_n": Bounds(200.0, 10.0, 5000.0)},
    "gain_error": {"g_act": _share(1.15, 0.85, 1.0), "g_sstl": _share(1.15, 0.85, 1.0)},
    "load_dependent_friction": {"alpha": _share(0.33, -0.1)},
    "load_spring": {"k3_per_mm2": Bounds(0.0, 0.0, 0.1), "play_mm": Bounds(0.0, 0.0, 2.0)},
    "presliding": {"breakaway_mm": Bounds(0.0, 0.0, 1.5), "spread": _share(1.0, 0.0, 0.5)},
    "pulley_friction": {"m_p": _share(0.25), "m_r": _share(0.25), "f0_n": Bounds(0.0, 0.0, 2.0)},
    "quantisation": {"q_in_n": Bounds(0.0, 0.0, 0.5), "q_out_n": Bounds(0.0, 0.0, 0.5)},
    "saturation": {f"t_max_{side}_n": Bounds(1000.0, 1.0, 1000.0) for side in ("in", "out")},
    "sensor_nonlinearity": {"a_in": _share(0.02, -0.02), "a_out": _share(0.02, -0.02), "h_n": Bounds(0.0, 0.0, 0.1)},
    "sheath_compliance": {"c_t_per_n": Bounds(0.0, 0.0, 0.01), "k_sh_mm_per_n": Bounds(0.0, 0.0, 0.2)},
    "slack": {"gap_mm": Bounds(0.0, 0.0, 5.0)},
    "stick_slip": {"ratio": _share(1.5, 1.0, 1.0), "v_c_mm_s": Bounds(1.0, 0.1, 10.0)},
    "stribeck": {"ratio": _share(1.5, 1.0, 1.0), "v_s_mm_s": Bounds(1.0, 0.1, 10.0)},
    "tendon_crosstalk": {"c_bend_per_n": Bounds(0.0, -0.01, 0.02)},
    "tendon_elasticity": {"compliance_per_kn": Bounds(0.0, 0.0, 0.33)},
    "tension_loop_lag": {"tau_s": Bounds(0.0, 0.0, 0.5), "inverse_slew_s_per_n": Bounds(0.0, 0.0, 0.2)},
    "viscoelastic_creep": {"fraction": _share(0.3), "tau_s": Bounds(10.0, 1.0, 100.0)},
    "viscous": {"c_l_n_s_per_mm": Bounds(0.0, 0.0, 0.05)},
    "zero_drift": _sensors("r", 1.0),
    "zero_offset": _sensors("z", 2.0),
}


def resolve_effects(effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect, neutral where `effects` is silent; ValueError where one is unknown or out of range.

    Examples
    --------
    >>> resolve_effects({"stribeck": {"ratio": 1.2}})["stribeck"]
    {'ratio': 1.2, 'v_s_mm_s': 1.0}
    """
    return resolved("bristle", EFFECTS, effects)
