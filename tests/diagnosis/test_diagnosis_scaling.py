"""A log far from a tendon's forces is fitted in units of its own; the document is in those of the recording."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.scaling import in_proportion, mechanics, parameter, restore, scaled, unit_of
from sstl_cli.physics.effect import FORCE_UNITS
from sstl_cli.physics.scenario import Scenario

DOCUMENT = {
    "unit": "N",
    "gap": {"rmse_base_n": 2.0, "shrink_pct": 40.0, "held_out": True},
    "candidates": [
        {"parameters": [
            {"name": "w_l_n", "unit": "N", "estimate": 3.0, "ci95": [2.0, 4.0]},
            {"name": "alpha", "unit": "1", "estimate": 0.1, "ci95": None},
            {"name": "c_t_per_n", "unit": "1/N", "estimate": 0.5, "ci95": None},
        ]},
    ],
    "analysis": {"noise": {"act": {"output": {
        "white_n": {"estimate": 0.2, "ci95": [0.1, 0.3]}, "correlation_s": {"estimate": 0.4, "ci95": None},
    }}}},
    "verdict": {"would_have_shown": [
        {"effect": "const_friction", "parameter": "w_l_n", "unit": "N", "size": 0.2, "gap_n": 0.1},
        {"effect": "gain_error", "parameter": "g_act", "unit": "1", "size": 0.01, "gap_n": 0.1},
    ]},
}  # fmt: skip


def test_every_tension_and_every_interval_is_in_the_recordings_units_again():
    found = restore(DOCUMENT, 100.0)
    assert found["gap"] == {"rmse_base_n": 200.0, "shrink_pct": 40.0, "held_out": True}
    width, alpha, compliance = found["candidates"][0]["parameters"]
    assert (width["estimate"], width["ci95"]) == (300.0, [200.0, 400.0])
    assert (alpha["estimate"], alpha["ci95"]) == (0.1, None)
    assert compliance["estimate"] == pytest.approx(0.005) and compliance["ci95"] is None
    output = found["analysis"]["noise"]["act"]["output"]
    assert output["white_n"] == {"estimate": 20.0, "ci95": [10.0, 30.0]}
    assert output["correlation_s"] == {"estimate": 0.4, "ci95": None}
    friction, gain = found["verdict"]["would_have_shown"]
    assert (friction["size"], friction["gap_n"]) == (20.0, 10.0) and (gain["size"], gain["gap_n"]) == (0.01, 10.0)


def test_a_log_of_usual_forces_stays_as_it_is():
    assert restore(DOCUMENT, 1.0) is DOCUMENT


@pytest.mark.parametrize(
    ("unit", "power"), [("N", 1), ("N s/mm", 1), ("1/N", -1), ("mm/N", -1), ("1/kN", -1), ("s/N", -1), ("1", 0), ("s", 0), ("mm", 0)]
)
def test_a_parameter_goes_with_the_size_of_the_forces_as_its_unit_says(unit, power):
    assert parameter(3.0, unit, 10.0) == pytest.approx(3.0 * 10.0**power) and (unit in FORCE_UNITS) is (power != 0)


def run(top, **more):
    return Run("r", "act", np.arange(200.0), np.where(np.arange(200) < 100, 0.0, top), np.full(200, 0.5 * top), **more)


@pytest.mark.parametrize(
    ("top", "unit"),
    [(3.0, 1.0), (2.9, 0.14), (60.0, 1.0), (61.0, 3.0), (1000.0, 50.0), (-1000.0, 50.0), (12_345.0, 620.0), (0.02, 0.001), (0.0, 1.0)],
)
def test_tensions_far_from_a_tendon_s_are_brought_to_twenty_newtons_by_a_round_number(top, unit):
    assert unit_of([run(top)]) == unit


def test_the_unit_is_that_of_the_largest_run_but_for_its_spikes():
    spiky = run(20.0)
    spiky.tension_in_n[50] = 9000.0
    holes = run(20.0)
    holes.tension_in_n[:] = np.nan
    assert unit_of([spiky, holes]) == 1.0 and unit_of([holes]) == 1.0 and unit_of([run(20.0), run(400.0)]) == 20.0


def test_runs_and_a_rig_are_brought_to_the_unit_together():
    extra = {"neighbour_n": np.full(200, 8.0), "known_tension_out_n_": np.ones(200)}
    one = run(1000.0, tension_ref_n=np.full(200, 30.0), extra=extra)
    (found,) = scaled([one], 50.0)
    assert found.tension_in_n.max() == 20.0 and found.tension_out_n[0] == 10.0 and found.tension_ref_n[0] == pytest.approx(0.6)
    assert found.extra["neighbour_n"][0] == pytest.approx(0.16) and found.extra["known_tension_out_n_"][0] == 1.0
    assert scaled([one], 1.0)[0] is one and scaled([run(9.0)], 3.0)[0].tension_ref_n is None
    # a rig of which nothing is known is as much stiffer as its tensions are larger: in their unit it is the usual one
    usual = Scenario().rig.mechanics()
    assert mechanics(in_proportion(50.0), 50.0) == usual and mechanics(Scenario(), 50.0).ea_n == usual.ea_n / 50.0
    assert (
        mechanics(Scenario(), 50.0).load_n_per_mm == usual.load_n_per_mm / 50.0 and mechanics(Scenario(), 50.0).length_mm == usual.length_mm
    )


def test_effects_of_a_simulator_are_brought_to_the_unit_and_back():
    there = {"const_friction": {"w_l_n": 5.0}, "tendon_elasticity": {"compliance_per_kn": 0.01}, "gain_error": {"g_act": 1.1}}
    found = scaling.effects(Scenario(effects=there), 50.0)
    assert found["const_friction"] == {"w_l_n": pytest.approx(0.1)} and found["tendon_elasticity"] == {
        "compliance_per_kn": pytest.approx(0.5)
    }
    assert found["gain_error"] == {"g_act": 1.1} and parameter(
        found["tendon_elasticity"]["compliance_per_kn"], "1/kN", 50.0
    ) == pytest.approx(0.01)


def test_a_proposed_movement_keeps_its_tensions_beside_the_factor_that_says_their_unit():
    # both were multiplied, so that a movement was driven to the square of the factor
    proposed = {"rmse_n": 2.0, "scenario": {"low_n": 1.0, "rig": {"ea_n": 8000.0}}, "tension_factor": 10.0}
    assert restore({"next_experiment": proposed}, 10.0) == {"next_experiment": {**proposed, "rmse_n": 20.0}}
