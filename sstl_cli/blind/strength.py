"""How large an effect is drawn: its parameters on one scale from 0 (neutral) to 1 (the catalogue's bound)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from sstl_cli.core.rng import log_uniform
from sstl_cli.physics import rig

Rng = np.random.Generator
STRENGTHS = (0.4, 1.2, 4.0)
BANDS = ((0.1, 0.6), (0.6, 2.0), (2.0, np.inf))
TOLERANCE = 0.08
TRIES = 8


@dataclass(frozen=True)
class Direction:
    """One effect with the share of its range that each parameter takes at scale 1; shapes stay as they are."""

    id: str
    full: Mapping[str, float]
    shapes: Mapping[str, float] = field(default_factory=dict)

    def at(self, scale: float) -> dict[str, float]:
        """Return the parameter values at a scale from 0 to 1."""
        values = dict(self.shapes)
        for name, end in self.full.items():
            start = self.shapes.get(f"{name}:from", rig.parameters()[self.id][name].neutral)
            values[name] = float(start + scale * (end - start))
        return {k: v for k, v in values.items() if ":" not in k}


def band(strength: float) -> float | None:
    """Return the nominal strength (0.4, 1.2, 4) whose band holds a realised one; None below 0.1."""
    for nominal, (low, high) in zip(STRENGTHS, BANDS, strict=True):
        if low <= strength < high:
            return nominal
    return None


def direction(effect_id: str, rng: Rng, top_in_n: float, top_out_n: float) -> Direction:
    """Return a random direction of an effect; the tops are the largest tensions of the two channels (N)."""
    if effect_id == "saturation":
        name, top = [("t_max_in_n", top_in_n), ("t_max_out_n", top_out_n)][int(rng.integers(2))]
        return Direction(effect_id, {name: 0.3 * top}, {f"{name}:from": 1.001 * top})
    if effect_id == "acquisition_faults":
        shapes = {"spike_pct": float(rng.uniform(0.02, 0.3)), "spike_n:from": 0.5}
        if rng.random() < 0.5:
            shapes["frozen_pct"] = float(rng.uniform(0.0, 0.5))
        return Direction(effect_id, {"spike_n": 50.0}, shapes)
    draw = _DRAWS.get(effect_id)
    if draw is not None:
        return Direction(effect_id, *draw(rng))
    name, bounds = next(iter(rig.parameters()[effect_id].items()))
    return Direction(effect_id, {name: bounds.high})


def find_scale(gap: Callable[[float], float], target: float, start: float = 0.2) -> tuple[float, float]:
    """Return the scale in (0, 1] whose gap (N) comes nearest to a target, and that gap.

    Gaps grow about as a power of the scale: a secant in logarithms, kept inside its bracket.
    """
    tries: list[tuple[float, float]] = []
    scale = start
    for _ in range(TRIES):
        tries.append((scale, max(gap(scale), 1e-9)))
        if abs(np.log(tries[-1][1] / target)) < TOLERANCE:
            break
        below = max((t for t in tries if t[1] < target), default=None)
        above = min((t for t in tries if t[1] >= target), default=None)
        if below is not None and above is not None and below[0] < above[0]:
            share = np.log(target / below[1]) / np.log(above[1] / below[1])
            scale = float(below[0] * (above[0] / below[0]) ** np.clip(share, 0.1, 0.9))
        else:
            step = np.clip(target / tries[-1][1], 0.05, 20.0)
            scale = float(np.clip(tries[-1][0] * step, 1e-4, 1.0))
        if scale == tries[-1][0]:
            break
    best = min(tries, key=lambda t: abs(np.log(t[1] / target)))
    return best


Drawn = tuple[dict[str, float], dict[str, float]]


def _sign(rng: Rng) -> float:
    return float(rng.choice((-1.0, 1.0)))


def _pulley(rng: Rng) -> Drawn:
    if rng.random() < 0.3:
        return {"f0_n": 2.0}, {}
    return {"m_p": 0.25, "m_r": float(rng.uniform(0.12, 0.25))}, {}


def _sensors(prefix: str, high: float) -> Callable[[Rng], Drawn]:
    def draw(rng: Rng) -> Drawn:
        names = [f"{prefix}_{side}_{system}_n" for system in ("act", "sstl") for side in ("in", "out")]
        count = int(rng.integers(1, 3))
        return {str(n): _sign(rng) * high * float(rng.uniform(0.5, 1.0)) for n in rng.choice(names, count, False)}, {}

    return draw


def _gains(rng: Rng) -> Drawn:
    both = {"g_act": 1.0 + 0.15 * _sign(rng), "g_sstl": 1.0 + 0.15 * _sign(rng)}
    if rng.random() < 0.6:
        name = str(rng.choice(list(both)))
        return {name: both[name]}, {}
    return both, {}


def _times(high: float) -> Callable[[Rng], Drawn]:
    def draw(rng: Rng) -> Drawn:
        return {"tau_act_s": high * float(rng.uniform(0.3, 1.0)), "tau_sstl_s": high * float(rng.uniform(0.3, 1.0))}, {}

    return draw


def _bent_sensor(rng: Rng) -> Drawn:
    name = str(rng.choice(["a_in", "a_out", "h_n"], p=[0.4, 0.4, 0.2]))
    return {name: 0.1 if name == "h_n" else 0.02 * _sign(rng)}, {}


def _spring(rng: Rng) -> Drawn:
    return ({"k3_per_mm2": 0.1}, {}) if rng.random() < 0.5 else ({"play_mm": 2.0}, {})


def _loop(rng: Rng) -> Drawn:
    return ({"tau_s": 0.5}, {}) if rng.random() < 0.6 else ({"inverse_slew_s_per_n": 0.2}, {})


_DRAWS: dict[str, Callable[[Rng], Drawn]] = {
    "pulley_friction": _pulley,
    "load_dependent_friction": lambda rng: ({"alpha": 0.33 if rng.random() < 0.6 else -0.1}, {}),
    "asymmetric_friction": lambda rng: ({"a": 0.2 * _sign(rng)}, {}),
    "friction_drift": lambda rng: ({"d_mu": 0.3 * _sign(rng)}, {"path_n": log_uniform(rng, 50.0, 1000.0)}),
    "stribeck": lambda rng: ({"ratio": 1.5}, {"v_s_mm_s": log_uniform(rng, 0.5, 5.0)}),
    "stick_slip": lambda rng: ({"ratio": 1.5}, {"v_c_mm_s": log_uniform(rng, 0.3, 5.0)}),
    "dwell_aging": lambda rng: ({"b": 0.05}, {"t0_s": log_uniform(rng, 0.2, 3.0)}),
    "viscoelastic_creep": lambda rng: ({"fraction": 0.3}, {"tau_s": log_uniform(rng, 2.0, 30.0)}),
    "presliding": lambda rng: ({"breakaway_mm": 1.5}, {"spread": float(rng.uniform(0.3, 0.9))}),
    "load_spring": _spring,
    "tension_loop_lag": _loop,
    "zero_offset": _sensors("z", 2.0),
    "zero_drift": _sensors("r", 1.0),
    "gain_error": _gains,
    "channel_delay": _times(0.2),
    "channel_lowpass": _times(0.32),
    "crosstalk": lambda rng: ({str(rng.choice(["c_in_to_out", "c_out_to_in"])): 0.05}, {}),
    "sensor_nonlinearity": _bent_sensor,
    "quantisation": lambda rng: ({"q_in_n": 0.5, "q_out_n": 0.5}, {}),
}
