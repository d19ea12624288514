"""Stiffness in the units of the fit: tensions outside of the catalogue's range, with effects of an elastic line."""

from __future__ import annotations

import pytest

from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory
from sstl_cli.steps import simulate
from sstl_cli.steps.diagnose import DiagnoseOptions, run

PLACE = (Configuration(id="a", location="NP", theta=0.5),)
ELASTIC = {"presliding": {"breakaway_mm": 0.2}, "viscous": {"c_l_n_s_per_mm": 0.05}}


def rig(top_n: float, *effects: str) -> Scenario:
    moves = [Trajectory(kind="trapezoid", drive="tension", duration_s=12.0), Trajectory(kind="ramp_hold", duration_s=20.0)]
    moves = [m.model_copy(update={"low_n": 0.02 * top_n, "high_n": top_n}) for m in moves]
    noise = NoiseSection(white_n=0.001 * top_n)
    return Scenario(
        sampling_hz=50.0, effects={e: ELASTIC[e] for e in effects}, noise=noise, configurations=PLACE, trajectories=tuple(moves)
    )


@pytest.mark.parametrize("top_n", [pytest.param(20.0, marks=pytest.mark.slow), 90.0])
def test_a_given_simulator_predicts_its_own_recordings_at_any_tension(top_n):
    scenario = rig(top_n, *ELASTIC)
    found = run(list(simulate.run(scenario, {}, 1)), DiagnoseOptions(sim=scenario, max_effects=1, effects=("const_friction",)))
    gap = found.document()["gap"]
    # with the stiffness of the fit's own unit, 90 N left 15 times the noise
    assert gap["rmse_base_n"] == pytest.approx(gap["noise_floor_n"], rel=0.1)
    assert found.model().rig == scenario.rig


@pytest.mark.slow
def test_an_assumed_simulator_is_stiffer_with_its_tensions_and_says_so():
    runs = list(simulate.run(rig(90.0, "viscous"), {}, 1))
    first = run(runs, DiagnoseOptions(max_effects=1, effects=("viscous",)))
    assert first.verdict.effects == ("viscous",)
    unit_n, assumed = first.evidence.problem.unit_n, first.model()
    assert unit_n > 1.0 and assumed.rig.ea_n == pytest.approx(unit_n * Scenario().rig.ea_n)
    again = run(runs, DiagnoseOptions(sim=assumed, max_effects=1, effects=("const_friction",))).document()
    assert again["verdict"]["status"] == "none"
    assert again["gap"]["rmse_base_n"] == pytest.approx(first.document()["gap"]["rmse_with_effect_n"], rel=0.05)
