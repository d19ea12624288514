"""The contract of every effect with every simulator, as ``simulate`` runs them; a new file beside either is covered by itself."""

from __future__ import annotations

from functools import cache
from typing import get_args

import numpy as np
import pytest

from sstl_cli.core.config import parse
from sstl_cli.core.errors import SstlError
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import simulate

SIMULATORS = get_args(Scenario.model_fields["simulator"].annotation)
# laws that the fast model has beside those of the simulators that stand in for hardware
OWN = {
    "const_friction": {"w_bend_n", "w_end_n", "w_in_n"},
    "crosstalk": {"m_out", "m_in"} | {f"c_{side}_{system}" for side in ("in", "out") for system in ("act", "sstl")},
    "friction_drift": {"d_mu_time", "time_s", "d_mu_heat_s_per_n2", "cooling_s"},
    "load_dependent_friction": {"step", "step_n", "fall", "fall_n", "rise", "rise_n"},
    "presliding": {"bristle_mm", "dahl_mm", "tail"},
    "sensor_nonlinearity": {f"a_{side}_{system}" for side in ("in", "out") for system in ("act", "sstl")}
    | {"chord", "h_act_n", "h_sstl_n", "k_act", "k_sstl", "width_n", "b_out", "b_in", "knee_n"},
    "saturation": {"soft_out", "knee_n", "width_n"},
    "stick_slip": {"mean_ratio"},
    "stribeck": {"mean_ratio"},
    "viscoelastic_creep": {"spread"},
    "viscous": {"c_bend_n_s_per_mm", "c_end_n_s_per_mm", "c_seal_n_s_per_mm", "power"},
    "zero_drift": {"warming", "session_s"} | {f"s_{side}_{system}_n" for side in ("in", "out") for system in ("act", "sstl")},
    "zero_offset": {f"{law}_{side}_{system}_n" for law in ("preload", "straight") for side in ("in", "out") for system in ("act", "sstl")},
}
CHANNELS = ("tension_in_n", "tension_out_n", "position_in_mm")
# pulled and released with a hold, a corner and a minor loop; two tendons that do not move alike
SCENARIO = {
    "schema": "sstl.scenario/1",
    "sampling_hz": 50.0,
    "rig": {"nodes": 15},
    "noise": {"white_n": 0.0},
    "configurations": [{"id": "A", "location": "CP", "theta": 0.5}],
    "trajectories": [
        {
            "kind": kind,
            "drive": "tension",
            "duration_s": 12.0,
            "low_n": 0.0,
            "high_n": 30.0,
            "record_position": True,
            "record_reference": True,
        }
        for kind in ("ramp_hold", "minor_loops")
    ],
    "tendons": [{"id": "left"}, {"id": "right", "delay_s": 2.0, "level": 0.6}],
}


def recorded(simulator: str, effects: dict[str, dict[str, float]]) -> list[np.ndarray]:
    scenario = parse(Scenario, {**SCENARIO, "simulator": simulator}, "contract")
    return [np.asarray(getattr(run, c)) for run in simulate.run(scenario, effects, 1) for c in CHANNELS]


@cache
def plain(simulator: str) -> list[np.ndarray]:
    return recorded(simulator, {})


def test_every_simulator_is_here() -> None:
    assert set(SIMULATORS) == {"transmission", "rig", "bristle", "variant"}


@pytest.mark.parametrize("effect_id", sorted(catalogue()))
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_neutral_changes_nothing_and_strong_is_finite_and_seen(simulator: str, effect_id: str) -> None:
    effect = get(effect_id)
    before = plain(simulator)
    for a, b in zip(before, recorded(simulator, {effect_id: effect.neutral()}), strict=True):
        assert np.array_equal(a, b)
    strong = {p.name: p.neutral + 0.6 * ((p.high if p.high > p.neutral else p.low) - p.neutral) for p in effect.parameters if not p.shape}
    if effect_id == "saturation":
        strong = {"t_max_in_n": 20.0, "t_max_out_n": 8.0}
    own = OWN.get(effect_id, set()) if simulator != "transmission" else set()
    for name in own & set(strong):
        with pytest.raises(SstlError, match=rf"E720.*unknown parameter of {effect_id} '{name}'"):
            recorded(simulator, {effect_id: {name: strong[name]}})
    # as a command line gives it: complete, what is not named being neutral
    after = recorded(simulator, {effect_id: effect.complete({k: v for k, v in strong.items() if k not in own})})
    assert all(np.isfinite(x).all() for x in after)
    # what a recorder loses is lost from all channels
    assert any(a.shape != b.shape or np.abs(a - b).max() > 1e-3 for a, b in zip(before, after, strict=True))
