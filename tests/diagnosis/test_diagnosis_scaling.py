"""A log far from a tendon's forces is fitted in units of its own; the document is in those of the recording."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.documents.diagnosis import (
    Analysis,
    Band,
    Estimated,
    EstimatedInput,
    EstimatedOutput,
    Gap,
    LeastShown,
    LoopCurves,
    NextExperiment,
    Parameter,
    Place,
    ResidualCurves,
    TensionBand,
)
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.scale import Scale
from sstl_cli.diagnosis.scaling import Units, in_proportion, mechanics, parameter, restored, scaled, unit_of
from sstl_cli.physics.effect import FORCE_UNITS
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Scenario

NOTHING_KNOWN = {"shrink_pct": None, "shrink_ci95_pct": None, "explained_of_reducible_pct": None, "held_out": True}


def a_gap(base_n, with_n, floor_n, **more):
    return Gap(rmse_base_n=base_n, rmse_retuned_n=None, rmse_with_effect_n=with_n, noise_floor_n=floor_n, **{**NOTHING_KNOWN, **more})


def of_noise(kind, n):
    return kind(estimate=n, ci95=(0.5 * n, 2.0 * n))


def an_analysis(system):
    sensors = {"input": {"white_n": of_noise(EstimatedInput, 0.2)}, "output": {"white_n": of_noise(EstimatedOutput, 0.2)}}
    sensors["output"]["correlation_s"] = Estimated(estimate=0.4, ci95=None)
    return Analysis(rate_hz=50.0, samples=9, runs=1, set_aside={}, theta={"C": 0.5}, noise={system: sensors})


def a_parameter(unit, estimate, ci95=None):
    return Parameter(name="p", unit=unit, estimate=estimate, ci95=ci95, at_bound=False)


def test_every_tension_and_every_interval_is_in_the_recordings_units_again():
    units = Units(100.0)
    found = restored(a_gap(2.0, None, 0.5, shrink_pct=40.0), units)
    assert (found.rmse_base_n, found.rmse_with_effect_n, found.noise_floor_n, found.shrink_pct) == (200.0, None, 50.0, 40.0)
    assert found.model_fields_set == a_gap(2.0, None, 0.5).model_fields_set
    parameters = [restored(p, units) for p in (a_parameter("N", 3.0, (2.0, None)), a_parameter("1", 0.1), a_parameter("1/N", 0.5))]
    assert [(p.estimate, p.ci95) for p in parameters] == [(300.0, (200.0, None)), (0.1, None), (pytest.approx(0.005), None)]
    noise = restored(an_analysis("act"), units).noise["act"]
    assert (noise["input"]["white_n"].estimate, noise["output"]["white_n"].ci95, noise["output"]["correlation_s"].estimate) == (
        20.0, (10.0, 40.0), 0.4,
    )  # fmt: skip
    friction = restored(
        LeastShown(effect="const_friction", parameter="w_l_n", unit="N", size=0.2, gap_n=0.1, rival="zero_offset", told_size=0.4), units
    )
    gain = restored(LeastShown(effect="gain_error", parameter="g_act", unit="1", size=0.01, gap_n=0.1), units)
    assert (friction.size, friction.gap_n, friction.told_size) == (20.0, 10.0, 40.0) and (gain.size, gain.gap_n) == (0.01, 10.0)


def test_what_a_report_draws_and_the_tensions_of_its_ranges_are_in_the_recordings_units():
    loop = LoopCurves(run_id="r", system="act", tension_in_n=[1.0, 2.0], measured_n=[0.5, 1.0], base_n=[0.4, 0.8], with_effect_n=[0.5, 0.9])
    left = ResidualCurves(run_id="r", system="act", time_s=[0.0, 0.1], tension_in_n=[1.0, 2.0], base_n=[0.1, 0.2], effect_n=[0.0, 0.1])
    drawn, rest = restored(loop, Units(10.0)), restored(left, Units(10.0))
    assert (drawn.tension_in_n, drawn.measured_n, drawn.base_n, drawn.with_effect_n) == ([10.0, 20.0], [5.0, 10.0], [4.0, 8.0], [5.0, 9.0])
    assert (rest.time_s, rest.tension_in_n, rest.base_n, rest.effect_n) == ([0.0, 0.1], [10.0, 20.0], [1.0, 2.0], [0.0, 1.0])
    ranges = [restored(kind(low=1.0, high=2.0, share_pct=30.0), Units(10.0)) for kind in (TensionBand, Band)]
    assert [(b.low, b.high, b.share_pct) for b in ranges] == [(10.0, 20.0, 30.0), (1.0, 2.0, 30.0)]


def test_an_output_that_is_no_force_is_told_in_its_own_unit_from_its_own_origin():
    # 8 counts a newton and 500 counts at rest in actuation, 3 from 100 in the loop; errors of both go by the middle of the two (2.5)
    # and the loop's sensor sits the other way round: its readings fall, its errors are as large
    units = Units(10.0, Scale("counts", {"act": 8.0, "sstl": -3.0}, {"act": 500.0, "sstl": 100.0}))
    loop = LoopCurves(run_id="r", system="act", tension_in_n=[1.0], measured_n=[4.0], base_n=[3.0], with_effect_n=[4.0])
    drawn = restored(loop, units)
    assert (drawn.tension_in_n, drawn.measured_n, drawn.base_n) == ([10.0], [820.0], [740.0])
    left = ResidualCurves(run_id="r", system="sstl", time_s=[0.0], tension_in_n=[1.0], base_n=[0.1], effect_n=[0.2])
    assert restored(left, units).base_n == [pytest.approx(-3.0)]
    place = Place(system="sstl", phase="pull", config_id=None, share_pct=50.0, rmse_n=0.5)
    assert restored(place, units).rmse_n == 15.0 and restored(a_gap(2.0, 1.0, 0.5), units).rmse_base_n == 50.0
    noise = restored(an_analysis("sstl"), units).noise["sstl"]
    assert (noise["input"]["white_n"].estimate, noise["output"]["white_n"].estimate) == (2.0, pytest.approx(6.0))


def test_a_log_of_usual_forces_stays_as_it_is():
    document = a_gap(2.0, 1.0, 0.5)
    assert restored(document, Units()) is document


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
    extra = {"neighbour_n": np.full(200, 8.0), "known_tension_out_n": np.ones(200)}
    one = run(1000.0, tension_ref_n=np.full(200, 30.0), extra=extra)
    (found,) = scaled([one], 50.0)
    assert found.tension_in_n.max() == 20.0 and found.tension_out_n[0] == 10.0 and found.tension_ref_n[0] == pytest.approx(0.6)
    assert found.extra["neighbour_n"][0] == pytest.approx(0.16) and found.extra["known_tension_out_n"][0] == 1.0
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


def test_every_parameter_goes_to_the_unit_of_the_fit_and_back_by_one_factor():
    there = {e.id: {p.name: p.high for p in e.parameters} for e in catalogue().values()}
    # a power of two: nothing is lost by dividing
    found = scaling.effects(Scenario.model_construct(effects=there), 64.0)
    assert {e: scaling.in_recording(e, values, 64.0) for e, values in found.items()} == there
    moved = {e.parameter(k).unit for e in catalogue().values() for k, v in found[e.id].items() if v != there[e.id][k]}
    assert moved == {p.unit for e in catalogue().values() for p in e.parameters if p.unit in scaling.POWERS and p.high}


def test_a_proposed_movement_keeps_its_tensions_beside_the_factor_that_says_their_unit():
    # both were multiplied, so that a movement was driven to the square of the factor
    scenario = {"low_n": 1.0, "rig": {"ea_n": 8000.0}}
    proposed = NextExperiment(separates=["a", "b"], trajectory="fast", why="", scenario=scenario, tension_factor=10.0)
    assert restored(proposed, Units(10.0)) == proposed
