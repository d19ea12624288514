"""Distances from the truth: which cases have one, which rivals are looked at, and a case that nothing could decide."""

from types import SimpleNamespace

import pytest

from sstl_cli.blind.schedule import Entry, Job
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import blind_limit
from sstl_cli.steps.blind_make import draw_job

ORDER = ("crosstalk", "gain_error", "zero_offset", "viscous", "zero_drift", "friction_drift", "load_spring", "asymmetric_friction", "channel_delay")


def search(order=ORDER):
    return SimpleNamespace(ranked=lambda: [SimpleNamespace(ids=(e,)) for e in order] + [SimpleNamespace(ids=order[:2])])


@pytest.mark.parametrize("effects", [(), ("acquisition_faults",), ("tension_loop_lag",), ("disturbance",)])
def test_what_the_fast_model_does_not_hold_has_no_distance(effects):
    found = blind_limit.run("c", [], Scenario(), effects)
    assert found["d2_base"] is None and found["decidable"] is False and found["why"]


def test_the_simulator_as_stated_may_hold_the_effect_already():
    sim = Scenario(effects={"viscous": {"c_l_n_s_per_mm": 0.01}})
    assert blind_limit.run("c", [], sim, ("viscous",))["why"]


def test_rivals_are_the_best_fitting_and_every_look_alike():
    last = ORDER[-1]
    assert last in get("channel_lowpass").look_alikes
    found = blind_limit.rivals(search(), ("channel_lowpass",))
    assert found[: blind_limit.RIVALS] == list(ORDER[: blind_limit.RIVALS]) and last in found
    assert "gain_error" not in blind_limit.rivals(search(), ("gain_error",))
    # one part of a pair alone is a rival of the pair
    assert {"gain_error", "channel_delay"} <= set(blind_limit.rivals(search(), ("channel_delay", "gain_error")))


def test_a_set_counts_what_could_be_told():
    rows = [
        {"case": "a", "effects": ["x"], "d2_base": 90.0, "d2_rival": 30.0, "rival": "y", "decidable": True, "why": None},
        {"case": "b", "effects": ["x"], "d2_base": 90.0, "d2_rival": 1.0, "rival": "y", "decidable": False, "why": None},
        {"case": "c", "effects": [], "d2_base": None, "d2_rival": None, "rival": None, "decidable": False, "why": "-"},
    ]
    found = blind_limit.document(rows)
    assert (found["cases"], found["judged"], found["decidable"]) == (3, 2, 1)


@pytest.mark.slow
def test_a_plain_effect_is_far_from_the_base_and_a_hidden_one_is_not():
    far, near = (
        blind_limit.run("c", case.runs, case.sim, ("friction_drift",))
        for case in (draw_job(Job(Entry("single", ("friction_drift",), s), 12, "rig", True)) for s in (4.0, 0.02))
    )
    assert far["d2_base"] > 500.0 and far["rival"] is not None
    assert near["d2_base"] < 100.0
