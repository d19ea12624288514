"""The verdict on evidence made by hand: each status, each way in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN, causes, gap_closed
from sstl_cli.diagnosis.constants import DECIDES_NATS, HALF, LEAST_SHARE
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import (
    CANDIDATE_TERMS,
    LOG_TERMS,
    _squash,
    _told,
    candidate_terms,
    decided,
    log_terms,
    probabilities,
    tempered,
    verdict,
)
from sstl_cli.diagnosis.weights import learned

CALM = Leftover(5000, 1.0, 0.0, 0.0, 0.0, (Misfit("mean by run", 0.5, 0.3, "0"),))
LOUD = Leftover(5000, 2.0, 0.5, 3.0, 0.0, (Misfit("mean by run and time in the run", 400.0, 900.0, "3"),))
LOG = LogRow(5000, 2, 3, 1.0, 1.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0)


def row(*ids, evidence=-1.0, kind=OUTPUT, chi2=1.0, worst=1.0, mean=0.5, share=1.0, drop=None, gain=None):
    gain = evidence + 4.0 if gain is None else gain
    drop = evidence if drop is None else drop
    return CandidateRow(tuple(sorted(ids)), kind, len(ids), gain, evidence, drop, chi2, worst, mean, 0, 1.0, share)


def rows(*candidates, log=LOG, best=CALM):
    return Rows(log, tuple(candidates), CALM, best)


FAILING = replace(LOG, base_chi2=2.0, base_worst_z=400.0, base_mean_z=300.0)
OTHERS = [row(i, evidence=e) for i, e in (("viscous", -1.0), ("gain_error", -0.5), ("zero_offset", -1.2), ("crosstalk", -1.0))]


def said(*args, **kwargs):
    return verdict(rows(*args, **kwargs), learned())


def test_nothing_gains_and_nothing_is_left():
    assert said(*OTHERS).status == "none"


def test_one_effect_explains_all_and_the_others_little():
    found = said(
        row("pulley_friction", evidence=2000.0),
        *[replace(r, evidence=300.0, gain=304.0, chi2=1.7, worst_z=300.0, mean_z=200.0) for r in OTHERS],
        log=FAILING,
    )
    assert found.status == "identified" and found.effects == ("pulley_friction",)
    assert found.confidence is not None and found.confidence > 0.6


def test_an_output_that_wanders_for_longer_than_noise_does_is_something():
    slow, short = (replace(LOG, wanders=DECIDES_NATS + d) for d in (1.0, -1.0))
    found = said(*OTHERS, log=slow)
    assert found.status == "unknown" and found.effects == () and found.probabilities[NONE] == 0.0
    assert found.why == "the outputs wander for longer than noise of a sensor does (5 nats), and no candidate explains it"
    assert said(*OTHERS, log=short) == said(*OTHERS)
    # what has a name keeps it, and what has none its own reason
    clear = row("pulley_friction", evidence=2000.0)
    named = said(clear, *OTHERS, log=replace(FAILING, wanders=5.0))
    assert named.status == "identified" and named.effects == ("pulley_friction",)
    p = {("viscous",): 0.1, NONE: 0.1, UNKNOWN: 0.8}
    assert "wander" not in decided(rows(*OTHERS, log=slow), p, learned()).why


@pytest.mark.parametrize("outside", [0, 1, 2])
def test_two_effects_of_sizes_that_neither_usually_has_describe_a_gap_and_are_no_cause(outside):
    both = replace(row("pulley_friction", "zero_drift", evidence=3000.0, drop=2000.0), outside=outside)
    parts = [row(i, evidence=1000.0, chi2=1.5, worst=200.0, mean=100.0, share=0.0) for i in both.ids]
    found = said(both, *parts, *OTHERS, log=FAILING)
    assert (found.status == "unknown") == ("sizes that none of its effects usually has" in found.why) == (outside == 2)
    # one effect alone may be larger than rigs usually are
    alone = replace(row("pulley_friction", evidence=2000.0), outside=1)
    assert said(alone, *OTHERS, log=FAILING).effects == ("pulley_friction",)


def test_two_that_explain_alike_are_not_told_apart():
    a, b = row("channel_delay", evidence=300.0), row("channel_lowpass", evidence=299.8)
    found = said(a, b, *OTHERS, log=FAILING)
    assert found.status == "ambiguous" and {("channel_delay",), ("channel_lowpass",)} <= set(found.group)


def test_a_gap_that_nobody_explains_is_unknown():
    found = said(*[replace(r, evidence=8.0, gain=12.0, chi2=1.95, worst_z=390.0, mean_z=290.0) for r in OTHERS], log=FAILING, best=LOUD)
    assert found.status == "unknown" and "sigma" in found.why


def test_spikes_that_carry_the_error_are_named():
    found = said(row("acquisition_faults", evidence=9e4, gain=9e4, kind=RECORDER, share=0.99), *OTHERS)
    assert found.effects == ("acquisition_faults",)


@pytest.mark.parametrize("share", [0.99, 0.3])
def test_a_fault_of_the_recorder_and_an_effect_of_the_rig_are_both_named(share):
    rig = (row("pulley_friction", evidence=9000.0), row("zero_offset", evidence=900.0, chi2=3.0, share=0.2))
    clipped = row("saturation", kind=RECORDER, gain=40_000.0, evidence=40_000.0, share=share)
    found = said(*rig, clipped, log=replace(LOG, base_chi2=6.0, base_worst_z=900.0))
    assert found.status == "identified" and found.effects == ("pulley_friction", "saturation")
    assert found.group == (found.effects,) and 0.5 < found.confidence <= 1.0 and "beside it saturation carries" in found.why


def test_a_fault_stands_beside_each_of_a_set():
    alike = row("const_friction", evidence=900.0), row("sensor_nonlinearity", evidence=899.8)
    rounded = row("quantisation", kind=RECORDER, gain=9000.0, evidence=9000.0, share=0.06)
    without, found = said(*alike, *OTHERS, log=FAILING), said(*alike, rounded, *OTHERS, log=FAILING)
    assert without.status == found.status == "ambiguous" and found.effects == tuple(sorted((*without.effects, "quantisation")))
    assert {("const_friction", "quantisation"), ("quantisation", "sensor_nonlinearity")} <= set(found.group)
    assert all("quantisation" in ids for ids in found.group) and "beside it quantisation carries 6 %" in found.why
    # the set is no surer with it, nor less sure: the fault is beyond doubt
    assert found.confidence is not None and found.confidence == pytest.approx(without.confidence, abs=0.05)
    # a set that holds the fault itself says so already
    either = said(alike[0], replace(rounded, share=0.9), *OTHERS, log=FAILING)
    assert either.status != "ambiguous" or ("quantisation",) in either.group


def test_a_fault_that_carries_next_to_nothing_or_may_be_chance_is_no_second_cause():
    rig, log = row("pulley_friction", evidence=9000.0), replace(LOG, base_chi2=6.0, base_worst_z=900.0)
    for gain, share in ((40_000.0, 0.01), (20.0, 0.3)):
        assert said(rig, row("saturation", kind=RECORDER, gain=gain, evidence=gain, share=share), log=log).effects == ("pulley_friction",)
    # nor is what is not among the candidates, nor what only may be there beside a fault
    barred = rows(rig, row("saturation", kind=RECORDER, gain=40_000.0, evidence=40_000.0, share=0.3), log=log)
    assert verdict(replace(barred, barred={"saturation": "saturation"}), learned()).effects == ("pulley_friction",)
    fault = row("saturation", kind=RECORDER, gain=40_000.0, evidence=40_000.0, share=0.99)
    assert said(row("zero_offset", evidence=5.0), row("gain_error", evidence=4.0), fault, log=log).effects == ("saturation",)


def test_a_lag_of_the_loop_comes_in_as_evidence():
    found = said(row("tension_loop_lag", evidence=5e3, kind=BESIDE, share=0.95), *OTHERS)
    assert found.effects == ("tension_loop_lag",)


def test_without_propagation_nothing_is_said():
    found = said(row("pulley_friction", evidence=2000.0), *OTHERS, log=replace(LOG, propagates=0.0))
    assert found.status == "unknown" and found.confidence is None and "hold" in found.why


def test_probabilities_sum_to_one_and_do_not_depend_on_the_order():
    a = probabilities(rows(row("viscous", evidence=20.0), *OTHERS[1:]), learned())
    b = probabilities(rows(*OTHERS[:0:-1], row("viscous", evidence=20.0)), learned())
    assert sum(a.values()) == pytest.approx(1.0) and a == pytest.approx(b) and {NONE, UNKNOWN} < set(a)


def test_a_prior_of_ones_own_moves_the_odds_by_its_factor_and_takes_the_confidence():
    made = rows(row("viscous", evidence=20.0), *OTHERS[1:])
    plain, own = probabilities(made, learned()), probabilities(made, learned(), {"viscous": 10.0})
    odds = (own[("viscous",)] / own[NONE]) / (plain[("viscous",)] / plain[NONE])
    assert odds == pytest.approx(10.0)
    assert verdict(made, learned(), {"viscous": 10.0}).confidence is None


def test_who_explains_little_of_the_gap_is_not_its_cause():
    found = said(row("const_friction", evidence=2000.0, chi2=1.9), *OTHERS, log=FAILING)
    assert found.status == "ambiguous" and "explains only" in found.why


@pytest.mark.parametrize(
    ("effect", "chi2", "held", "status"),
    [
        ("friction_drift", 1.0, None, "identified"),
        # nothing, or less than half of the gap at most, is removed of what was held out, however well it fits
        ("friction_drift", 1.0, -0.4, "unknown"),
        ("friction_drift", 1.0, 0.4, "ambiguous"),
        ("friction_drift", 3.0, 0.4, "ambiguous"),
        ("friction_drift", 3.0, 0.7, "identified"),
        ("friction_drift", 1.0, float("inf"), "identified"),
        # what is left is noise by the candidate's own law: jumps that nobody can foretell
        ("stick_slip", 1.5, 0.2, "identified"),
        # but their mean is the best that can be foretold: surely worse than nothing added it cannot be
        ("stick_slip", 1.0, -0.2, "unknown"),
        ("stick_slip", 3.0, 0.2, "ambiguous"),
    ],
)
def test_who_does_not_describe_what_was_held_out_is_not_its_cause(effect, chi2, held, status):
    wide = replace(LOG, base_chi2=1e5, base_worst_z=1e5, base_mean_z=1e5)
    winner = replace(row(effect, evidence=2e6, chi2=chi2), held=held)
    others = [replace(r, evidence=300.0, gain=304.0, chi2=9e4) for r in OTHERS if r.ids != (effect,)]
    found = said(winner, *others, log=wide)
    assert found.status == status and found.confidence is not None
    if held is not None and held < 0.5 and chi2 != 1.5:
        assert "held out" in found.why


def test_a_mean_over_jumps_that_is_no_nearer_than_the_base_is_no_cause_whatever_its_scatter_gains():
    wide = replace(LOG, base_chi2=1e5, base_worst_z=1e5, base_mean_z=1e5)
    others = [replace(r, evidence=300.0, gain=304.0, chi2=9e4) for r in OTHERS]
    named = said(row("stribeck", evidence=2e6, share=0.4), *others, log=wide)
    assert named.effects == ("stribeck",)
    found = said(row("stribeck", evidence=2e6, share=0.0), *others, log=wide)
    assert found.status == "unknown" and "no nearer" in found.why


def test_a_set_holds_who_is_probable_beside_a_class_that_leads():
    lag = [row("channel_delay", evidence=735.0), row("channel_lowpass", evidence=731.0)]
    pair = row("channel_lowpass", "pulley_friction", evidence=737.0, drop=6.0)
    p = {("channel_delay",): 0.36, ("channel_lowpass",): 0.28, ("viscous",): 0.26, pair.ids: 0.002, NONE: 0.05, UNKNOWN: 0.04}
    found = decided(rows(*lag, row("viscous", evidence=609.0), pair, log=FAILING), p, learned())
    assert found.status == "ambiguous" and set(found.group) == {("channel_delay",), ("channel_lowpass",), ("viscous",)}


@pytest.mark.parametrize(("share", "left", "named"), [(0.76, 5.7, True), (0.07, 49.5, False)])
def test_an_effect_beside_is_named_for_what_it_takes_off_the_squared_error(share, left, named):
    # 76 % off the error is 95 % of the squared error beyond the noise, 7 % with seven times the noise left is 14 %
    found = said(row("load_spring", evidence=226.0, kind=BESIDE, share=share, chi2=left), *OTHERS)
    assert found.status == ("identified" if named else "ambiguous")
    if not named:
        assert "only 14 %" in found.why


def test_stated_probabilities_are_as_sure_as_their_odds_were_right():
    p = {("viscous",): 0.6, ("slack",): 0.3, NONE: 0.09, UNKNOWN: 0.01}
    stated = tempered(p, 0.5)
    # the roots of 0.9, 0.09 and 0.01 over their sum; which cause it is stays 2 to 1
    whole = 0.9**0.5 + 0.3 + 0.1
    assert stated[NONE] == pytest.approx(0.3 / whole) and stated[UNKNOWN] == pytest.approx(0.1 / whole)
    assert stated[("viscous",)] == pytest.approx(2.0 * stated[("slack",)]) and sum(stated.values()) == pytest.approx(1.0)
    assert tempered(p, 1.0) == pytest.approx(p)
    assert tempered({NONE: 1.0, UNKNOWN: 0.0}, 0.5) == {NONE: 1.0, UNKNOWN: 0.0}


def test_what_is_decided_does_not_depend_on_how_sure_the_odds_were():
    made = rows(row("viscous", evidence=300.0), *OTHERS)
    plain, careful = (verdict(made, replace(learned(), temper=t)) for t in (1.0, 0.5))
    assert (plain.status, plain.effects, plain.confidence) == (careful.status, careful.effects, careful.confidence)
    assert careful.probabilities[("viscous",)] < plain.probabilities[("viscous",)]


@pytest.mark.parametrize(("share", "status"), [(LEAST_SHARE, "unknown"), (1.01 * LEAST_SHARE, "ambiguous")])
def test_what_explains_a_twentieth_is_no_cause_and_what_explains_more_is_a_part(share, status):
    little = row("pulley_friction", evidence=2000.0, share=share)
    p = {("pulley_friction",): 0.9, NONE: 0.05, UNKNOWN: 0.05}
    found = decided(rows(little, *OTHERS, log=FAILING), p, learned())
    assert found.status == status and found.effects == (("pulley_friction",) if status == "ambiguous" else ())


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_odds_between_a_name_none_and_no_name_are_raised_and_names_keep_theirs(power):
    p = {("a",): 0.4, ("b",): 0.2, NONE: 0.3, UNKNOWN: 0.1}
    found = tempered(p, power)
    assert sum(found.values()) == pytest.approx(1.0) and found[("a",)] / found[("b",)] == pytest.approx(2.0)
    assert found[NONE] / found[UNKNOWN] == pytest.approx(3.0**power)
    assert (found[("a",)] + found[("b",)]) / found[NONE] == pytest.approx(2.0**power)
    # without a name there is nothing to share
    assert tempered({NONE: 0.8, UNKNOWN: 0.2}, power)[NONE] == pytest.approx(4.0**power / (1.0 + 4.0**power))


@pytest.mark.parametrize(("outside", "term"), [(0, 0.0), (1, 1.0), (3, 1.0)])
def test_sizes_outside_of_what_is_usual_are_one_number_however_many(outside, term):
    lead = replace(row("pulley_friction", evidence=2000.0), outside=outside)
    seen = rows(lead, *OTHERS, log=FAILING)
    assert dict(zip(CANDIDATE_TERMS, candidate_terms(lead, seen), strict=True))["outside"] == term
    assert dict(zip(LOG_TERMS, log_terms(seen), strict=True))["outside"] == term
    # of the leading model, not of another
    other = rows(replace(lead, evidence=-1.0), row("viscous", evidence=5.0), log=FAILING)
    assert dict(zip(LOG_TERMS, log_terms(other), strict=True))["outside"] == 0.0


def test_squashed_numbers_are_decades_with_their_sign():
    assert [_squash(x) for x in (0.0, 9.0, 99.0, -9.0)] == pytest.approx([0.0, 1.0, 2.0, -1.0])


def test_an_effect_beside_closes_a_gap_over_the_noise_of_its_channel():
    # it leaves the noise, and half of the error: sqrt(4 - 1)
    assert gap_closed(row("tension_loop_lag", kind=BESIDE, chi2=1.0, share=0.5)) == pytest.approx(np.sqrt(3.0))
    # it leaves twice the noise: twice the gap; and all of it where nothing is left
    assert gap_closed(row("tension_loop_lag", kind=BESIDE, chi2=4.0, share=0.5)) == pytest.approx(2.0 * np.sqrt(3.0))
    assert gap_closed(row("tension_loop_lag", kind=BESIDE, chi2=0.5, share=0.0)) == 0.0
    assert gap_closed(row("tension_loop_lag", kind=BESIDE, share=1.0)) == float("inf")
    # what makes it worse closes none
    assert gap_closed(row("tension_loop_lag", kind=BESIDE, share=-0.5)) == 0.0


def test_a_fault_that_is_no_cause_leaves_its_probability_to_what_has_a_name_if_anything_has():
    fault, cause = row("quantisation", kind=RECORDER, share=0.1), row("viscous", evidence=900.0, share=0.7)
    p = {("quantisation",): 0.6, ("viscous",): 0.2, ("crosstalk",): 0.1, NONE: 0.05, UNKNOWN: 0.05}
    found = causes(rows(fault, cause, log=FAILING), p)
    assert found == pytest.approx({("viscous",): 0.6, ("crosstalk",): 0.3, NONE: 0.05, UNKNOWN: 0.05})
    # where nothing else has any it keeps it
    alone = {("quantisation",): 0.9, ("viscous",): 0.0, NONE: 0.05, UNKNOWN: 0.05}
    assert causes(rows(fault, cause, log=FAILING), alone) == alone
    # half of the error, or as much as the output's model explains, is a cause; and so is all where nothing of the output decides
    for other, model in ((replace(fault, share=HALF), cause), (replace(fault, share=0.3), replace(cause, share=0.3))):
        assert causes(rows(other, model, log=FAILING), p) == p
    assert causes(rows(fault, replace(cause, evidence=DECIDES_NATS), log=FAILING), p) == p
    # the sound samples leave as much beyond the noise as noise (half of 0.7), in the nine or seven tenths that are not the fault's
    assert causes(rows(replace(fault, share=0.26), cause, log=FAILING), p) == p
    assert ("quantisation",) not in causes(rows(replace(fault, share=0.25), cause, log=FAILING), p)
    # where they leave the noise alone there is nothing that a model could explain more of
    assert causes(rows(fault, cause), p) == p


@pytest.mark.parametrize(("apart", "told"), [(201.0 * DECIDES_NATS + 1.0, True), (201.0 * DECIDES_NATS - 1.0, False)])
def test_a_law_that_leaves_the_noise_alone_is_off_by_no_more_than_chance_can_hide(apart, told):
    # 5000 samples hide two standard deviations of chi^2, 100 nats of a million: twice that and one
    lead, other = row("channel_delay", evidence=1e6), row("channel_lowpass", evidence=1e6 - apart)
    assert _told(rows(lead, other), lead.ids, [lead.ids, other.ids], {"lag": 0.5}) is told
    # where no share will do members are never told
    assert not _told(rows(lead, other), lead.ids, [lead.ids, other.ids], {"lag": 1.0})
    # a small share says how far the other may be off by itself
    close = replace(other, evidence=1e6 - 2.0 * DECIDES_NATS)
    assert _told(rows(lead, close), lead.ids, [lead.ids, close.ids], {}) and _told(rows(lead), lead.ids, [lead.ids], {"lag": 0.5})
