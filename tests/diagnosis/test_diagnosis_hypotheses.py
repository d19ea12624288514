"""The ways in which an effect can be there: which sensor, which system, which law."""

from __future__ import annotations

import pytest

from sstl_cli.diagnosis.hypotheses import apart, at_known_load, by_usual_law, full, laws, variants
from sstl_cli.physics.effects import catalogue

BOTH = ("act", "sstl")


def names(h):
    return [f.parameter.name for f in h.free]


@pytest.mark.parametrize("effect", sorted(e.id for e in catalogue().values() if e.fitted))
def test_every_variant_is_part_of_the_full_effect_and_stands_once(effect):
    whole, found = full(effect, BOTH), variants(effect, BOTH)
    beside = laws(effect, BOTH)
    assert found and all(h.ids == (effect,) and h.strengths for h in found)
    assert all(set(h.free) <= set(whole.free) or h in beside for h in found)
    assert len({h.free for h in found}) == len(found)
    assert [len(h.strengths) for h in found] == sorted(len(h.strengths) for h in found)
    # no strength is lost
    assert {f for h in found for f in h.strengths} == {f for h in (whole, *beside) for f in h.strengths}
    # another law has numbers of its own
    assert not {f for h in beside for f in h.strengths} & set(whole.strengths)


def test_one_sensor_two_sensors_or_all():
    found = by_usual_law("zero_offset", BOTH)
    assert [len(h.free) for h in found] == [1] * 4 + [2] * 6 + [4]
    # or a preload, of one sensor, from nothing or not, or of both alike
    assert [len(h.free) for h in laws("zero_offset", BOTH)] == [1] * 4 + [2] * 6
    assert [len(h.strengths) for h in variants("zero_offset", BOTH)] == [1] * 8 + [2] * 12 + [4]


def test_only_sensors_of_recorded_systems_can_be_off():
    assert {n for h in by_usual_law("zero_offset", ("act",)) for n in names(h)} == {"z_in_act_n", "z_out_act_n"}
    assert [names(h) for h in laws("zero_offset", ("act",))] == [
        ["preload_in_act_n"],
        ["preload_out_act_n"],
        ["preload_in_act_n", "straight_in_act_n"],
        ["preload_out_act_n", "straight_out_act_n"],
    ]
    assert variants("gain_error", ("sstl",))[0].free[0].parameter.name == "g_sstl"


def test_declared_laws_replace_the_subsets_and_take_their_own_shapes_along():
    assert sorted(map(names, variants("friction_drift", BOTH))) == [
        ["d_mu", "path_n", "load_mm_per_n"],
        ["d_mu_heat_s_per_n2", "cooling_s", "load_mm_per_n"],
        ["d_mu_time", "time_s", "load_mm_per_n"],
    ]


def test_a_shape_that_no_variant_claims_belongs_to_all():
    # the stiffness of the load is not known from tensions
    assert all(names(h)[-1] == "load_mm_per_n" for h in variants("viscous", BOTH))


def test_joined_effects_share_what_both_need_once():
    viscous, stribeck = full("viscous", BOTH), full("stribeck", BOTH)
    both = viscous.joined(stribeck)
    assert both.ids == ("viscous", "stribeck")
    assert names(both).count("load_mm_per_n") == 1
    assert len(both.free) == len(viscous.free) + len(stribeck.free) - 1
    assert both.joined(stribeck) == both


def test_a_line_that_jumps_has_a_law_of_its_own_on_average():
    for effect, shape in (("stribeck", "v_s_mm_s"), ("stick_slip", "v_c_mm_s")):
        assert sorted(map(names, variants(effect, BOTH))) == [["mean_ratio", "mean_mm_s"], ["ratio", shape, "load_mm_per_n"]]


def test_two_of_a_family_are_no_combination():
    assert apart(("crosstalk", "stribeck")) and not apart(("crosstalk", "stick_slip", "stribeck"))
    assert not apart(("channel_delay", "channel_lowpass"))


def test_sensors_on_a_common_mount_and_one_sensor_alone_are_laws_of_crosstalk():
    assert [sorted(names(h)) for h in variants("crosstalk", BOTH)] == [
        ["c_in_to_out"], ["c_out_to_in"], ["m_out"], ["m_in"], ["c_in_act"], ["c_out_act"], ["c_in_sstl"], ["c_out_sstl"],
        ["c_in_to_out", "c_out_to_in"], ["m_in", "m_out"],
    ]  # fmt: skip


def test_a_load_that_is_known_is_free_in_no_hypothesis():
    for h in variants("viscous", BOTH):
        assert names(h)[-1] == "load_mm_per_n" and names(at_known_load(h)) == names(h)[:-1]
    assert at_known_load(full("gain_error", BOTH)) == full("gain_error", BOTH)
