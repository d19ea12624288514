"""A sensing loop that ends at a load of its own: simulated, told from the tendon's, kept in a model and used again."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.free import LINE
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Law
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.physics.transmission.model import drive_of
from sstl_cli.steps import diagnose
from sstl_cli.steps import simulate as step

TENDON, LOOP, DRAG = 2.6, 18.0, {"viscous": {"c_l_n_s_per_mm": 0.02}}


def rig(**changes: object) -> Scenario:
    """Return a small scenario of a soft load."""
    plan = load("default")
    two = plan.model_copy(update={"sampling_hz": 25.0, "configurations": plan.configurations[:2], "trajectories": plan.trajectories[:1]})
    return two.with_rig(load_n_per_mm=TENDON).with_rig(**changes)


def recorded(scenario: Scenario, seed: int = 1) -> list:
    return list(step.run(scenario, DRAG, seed))


@pytest.mark.parametrize("simulator", ["transmission", "rig"])
def test_each_system_ends_at_its_own_load(simulator):
    plan = rig(loop_load_n_per_mm=LOOP).model_copy(update={"simulator": simulator, "configurations": rig().configurations[:1]})
    ours, soft, stiff = (recorded(p) for p in (plan, plan.with_rig(loop_load_n_per_mm=None), plan.with_rig(load_n_per_mm=LOOP)))
    assert {r.system for r in ours} == {"act", "sstl"}
    for own, a, b in zip(ours, soft, stiff, strict=True):
        like, unlike = (a, b) if own.system == "act" else (b, a)
        assert np.array_equal(own.tension_out_n, like.tension_out_n)
        assert np.abs(own.tension_out_n - unlike.tension_out_n).max() > 0.05


def test_a_common_load_keeps_how_much_stiffer_the_loop_is_known_to_end():
    asked = diagnose.DiagnoseOptions(effects=("zero_offset",), max_effects=1, sim=rig(loop_load_n_per_mm=LOOP))
    sim = diagnose.run(recorded(rig())[:2], asked).evidence.search.sim
    assert isinstance(sim, Simulator)
    soft = {"load_mm_per_n": 0.2}
    assert sim.end_mm_per_n("act", soft) == 0.2 and sim.end_mm_per_n("sstl", soft) == pytest.approx(0.2 * TENDON / LOOP)
    assert sim.end_mm_per_n("sstl", {**soft, "loop_load_mm_per_n": 0.7}) == 0.7


@pytest.fixture(scope="module")
def told():
    asked = diagnose.DiagnoseOptions(effects=("viscous", "channel_lowpass"))
    return diagnose.run(recorded(rig(loop_load_n_per_mm=LOOP)), asked)


def test_drag_is_named_where_the_loop_ends_stiffer_than_the_tendon(told):
    assert told.verdict.status == "identified" and told.verdict.effects == ("viscous",)
    ends = told.evidence.search.best(("viscous",)).fit.effects[LINE.id]
    assert ends["load_mm_per_n"] > 2.0 * ends["loop_load_mm_per_n"]


def test_the_model_keeps_both_loads_and_another_day_has_nothing_new(told):
    model = told.model()
    assert model.rig.loop_load_n_per_mm > 2.0 * model.rig.load_n_per_mm
    again = diagnose.run(
        recorded(rig(loop_load_n_per_mm=LOOP), 2), diagnose.DiagnoseOptions(sim=model, effects=("viscous", "channel_lowpass"))
    )
    assert again.verdict.status == "none"


def test_one_load_is_enough_where_both_end_alike():
    found = diagnose.run(recorded(rig()), diagnose.DiagnoseOptions(effects=("viscous",), max_effects=1)).evidence.search
    assert "loop_load_mm_per_n" not in found.best(("viscous",)).fit.effects[LINE.id]


def test_a_loop_that_ends_stiffer_slips_and_wears_less():
    mechanics = rig(loop_load_n_per_mm=LOOP).rig.mechanics()
    law, v = Law(), get("friction_drift").complete({"d_mu": 0.3, "path_n": 50.0})
    get("friction_drift").law(law, v)
    tension = 10.0 + 5.0 * np.sin(np.linspace(0.0, 60.0, 400))
    worn = {s: law.friction_scale[0](drive_of(s, None, 0.05, tension, mechanics)) - 1.0 for s in ("act", "sstl")}
    slips = (0.5 * mechanics.tendon_mm_per_n + 1.0 / LOOP) / (0.5 * mechanics.tendon_mm_per_n + 1.0 / TENDON)
    assert np.log(worn["sstl"] / 0.3) == pytest.approx(slips * np.log(worn["act"] / 0.3), abs=1e-12)


@pytest.mark.slow
def test_friction_that_warms_is_found_by_how_far_each_line_slips():
    plan = rig(loop_load_n_per_mm=LOOP)
    runs = list(step.run(plan, {"friction_drift": {"d_mu_heat_s_per_n2": -2e-3, "cooling_s": 8.0}}, 1))
    found = diagnose.run(runs, diagnose.DiagnoseOptions(effects=("friction_drift", "zero_drift"), max_effects=1))
    assert found.verdict.effects == ("friction_drift",)
    best = found.evidence.search.best(("friction_drift",)).fit
    # it slips by the loads that the fit has, not by those of the simulator it began from
    assert best.effects["friction_drift"]["d_mu_heat_s_per_n2"] == pytest.approx(-2e-3, rel=0.2)
