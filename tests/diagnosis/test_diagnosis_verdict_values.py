"""The numbers that a verdict is made from, each worked out by hand, and its thresholds from either side."""

from __future__ import annotations

from dataclasses import replace
from math import log, log10, sqrt

import pytest

from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN, barred, causes, gap_closed, grown, sizeable, wandering
from sstl_cli.diagnosis.evidence import discounted
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import (
    CANDIDATE_TERMS,
    LOG_TERMS,
    REACH_NATS,
    _family,
    _runner_up,
    _set,
    _tied,
    _told,
    _with_faults,
    candidate_terms,
    decided,
    inclusive,
    log_terms,
    probabilities,
    standing,
    tempered,
)
from sstl_cli.diagnosis.weights import Weights

LEFT = Leftover(400, 1.5, 0.0, 0.0, 0.0, (Misfit("mean by run", 7.0, 3.0, "run a"),))
LOG = LogRow(400, 2, 3, 1.5, 99.0, 9.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0)
DECIDES, JOINS = log(49.0), 5.0


def row(*ids, evidence=100.0, kind=OUTPUT, **more):
    plain = CandidateRow(tuple(sorted(ids)), kind, len(ids), 104.0, evidence, evidence, 1.0, 1.0, 0.5, 0, 1.0, 1.0)
    return replace(plain, **more)


def rows(*candidates, log=LOG, **more):
    return Rows(log, candidates, LEFT, LEFT, **more)


def numbers(c, *others, log=LOG):
    return dict(zip(CANDIDATE_TERMS, candidate_terms(c, rows(c, *others, log=log)).tolist(), strict=True))


def of_log(*candidates, value=0.0, **log):
    return dict(zip(LOG_TERMS, log_terms(rows(*candidates, log=replace(LOG, **log)), value).tolist(), strict=True))


def weights(commit=0.8, quiet=0.3, cover=0.2, reliability=None, **effect):
    own, one = dict.fromkeys(CANDIDATE_TERMS, 0.0), dict.fromkeys(LOG_TERMS, 0.0)
    return Weights(own, one, one, effect, commit, {"lag": 0.03}, quiet, cover, 24.0, reliability or {})


def test_every_number_of_a_model_of_the_output():
    lead = row("viscous", evidence=120.0)
    c = row("crosstalk", evidence=100.0, gain=49.0, chi2=1.5, worst_z=8.0, mean_z=9.0, outside=2, unstable=10.0, share=0.75, strengths=3)
    found = numbers(c, lead, row("zero_offset", evidence=110.0), row("gain_error", "slack", evidence=500.0, kind=RECORDER))
    # 120 nats apart by a share m count less by 1 + 2 m^2 120
    by_share = {f"log_behind_{m:g}": -log10(1.0 + 20.0 / (1.0 + 2.0 * m * m * 120.0)) for m in (0.0, 0.03, 0.1)}
    assert {k: found[k] for k in by_share} == pytest.approx(by_share)
    expected = {
        "behind": -2.0, "rank": log10(3.0) / log10(2.0), "ahead": 0.0, "left_share": 100.0 / 149.0, "little": 0.25, "means": 1.0, "more": 0.0,
        "weak_part": 0.0, "outside": 1.0, "unstable": 1.0, "strengths": 3.0,
    }  # fmt: skip
    assert {k: found[k] for k in expected} == pytest.approx(expected)
    rest = set(found) - set(expected) - set(by_share)
    assert rest == {t for t in CANDIDATE_TERMS if t.startswith(("recorder", "beside"))} and not any(found[t] for t in rest)


def test_how_far_a_model_is_behind_or_ahead_counts_to_an_end():
    far = row("viscous", evidence=1e4)
    assert numbers(row("slack", evidence=0.0), far)["behind"] == -REACH_NATS / 10.0 == -6.0
    assert numbers(row("slack", evidence=9991.0), far)["behind"] == pytest.approx(-0.9)
    # ahead of the next by 9 nats; of nobody, by all
    assert numbers(row("slack", evidence=20.0), row("viscous", evidence=11.0))["ahead"] == pytest.approx(1.0)
    assert numbers(row("slack", evidence=99.0))["ahead"] == pytest.approx(2.0)
    # a base that nobody beats is ahead: the difference is to that
    assert numbers(row("slack", evidence=-10.0))["behind"] == pytest.approx(-1.0)
    # others of as many effects count, and of the same kind
    pair, fault = row("a", "b", evidence=200.0), row("c", evidence=300.0, kind=RECORDER)
    assert numbers(row("slack", evidence=100.0), pair, fault)["rank"] == 0.0
    # as evident is not above
    assert numbers(row("slack", evidence=100.0), row("viscous", evidence=100.0))["rank"] == 0.0


@pytest.mark.parametrize(("drop", "term"), [(0.9, log10(10.0)), (200.0, log10(1001.0)), (-5.0, 0.0)])
def test_a_part_of_a_combination_is_weak_by_what_it_adds(drop, term):
    pair = row("slack", "viscous", evidence=100.0, drop_one=drop)
    assert numbers(pair)["weak_part"] == pytest.approx(term) and numbers(pair)["more"] == 1.0


def test_every_number_of_a_fault_and_of_what_lies_beside():
    lead = row("viscous", evidence=99.0)
    fault = numbers(row("saturation", kind=RECORDER, gain=9.0, share=0.9, chi2=50.0, mean_z=7.0, unstable=9.0), lead)
    expected = {
        "recorder": 1.0, "recorder_share": 1.0, "recorder_gain": 1.0, "recorder_out": 2.0, "means": 1.0, "left_share": 100.0 / 109.0,
        "little": 0.0, "unstable": 0.0, "rank": 0.0, "ahead": 0.0, "behind": 0.0, "strengths": 1.0, "beside": 0.0, "beside_out": 0.0,
    }  # fmt: skip
    assert {k: fault[k] for k in expected} == pytest.approx(expected)
    loop = numbers(row("tension_loop_lag", kind=BESIDE, evidence=9.0, share=0.4, gain=0.5, outside=0), lead)
    expected = {
        "beside": 1.0,
        "beside_gain": 1.0,
        "beside_share": 0.4,
        "beside_out": 2.0,
        "recorder": 0.0,
        "left_share": 100.0 / 101.0,
        "log_behind_0": 0.0,
    }
    assert {k: loop[k] for k in expected} == pytest.approx(expected)
    assert numbers(row("saturation", kind=RECORDER, gain=-9.0))["recorder_gain"] == 0.0
    assert numbers(row("tension_loop_lag", kind=BESIDE, evidence=-9.0))["beside_gain"] == 0.0
    # where no model of the output is evident there is nothing that it asks for
    assert numbers(row("saturation", kind=RECORDER), row("viscous", evidence=-9.0))["recorder_out"] == 0.0


def test_every_number_of_a_log():
    lead = row("viscous", evidence=9.0, gain=50.0, chi2=1.25, worst_z=9.0, mean_z=99.0, share=0.7)
    small, large = (row("saturation", kind=RECORDER, share=s, gain=g) for s, g in ((0.2, 999.0), (0.5, 99.0)))
    loop = row("tension_loop_lag", kind=BESIDE, evidence=5.0, share=0.5, chi2=10.0)
    found = of_log(lead, small, large, loop, row("load_spring", kind=BESIDE, evidence=4.0), value=1.25, noise_ratio=1.0 / 3.0)
    expected = {
        "one": 1.0, "nats": 3.6, "best": 1.0, "base_rms": log10(1.0 + 10.0 * sqrt(0.5)), "base_worst": 2.0, "base_means": 1.0,
        "left_share": 50.0 / 100.0, "left_rms": log10(6.0), "worst": 1.0, "means": 2.0, "little": 0.3, "outside": 0.0, "recorder": 0.5 * 2.0,
        "beside": 2.0, "beside_left": 0.5, "beside_base": log10(40.0), "coloured": 0.3, "noise_ratio": log10(1.0 + 10.0 * log(3.0)), "inclusive": 1.25,
    }  # fmt: skip
    assert found == pytest.approx(expected)


def test_numbers_of_a_log_have_ends():
    assert of_log(row("viscous", evidence=1e3))["nats"] == 10.0 and of_log(row("viscous", evidence=-1.0))["nats"] == 0.0
    assert of_log(row("tension_loop_lag", kind=BESIDE, evidence=1e3))["beside"] == 10.0
    assert of_log(row("tension_loop_lag", kind=BESIDE, share=-0.5, chi2=10.0))["beside_left"] == 0.0
    assert of_log(coloured=2.9)["coloured"] == 2.9 and of_log(coloured=9.0)["coloured"] == 3.0
    nothing = of_log(base_chi2=0.5, base_worst_z=-1.0, base_mean_z=-1.0, noise_ratio=0.0)
    assert nothing["base_rms"] == nothing["base_worst"] == nothing["base_means"] == nothing["left_rms"] == nothing["left_share"] == 0.0
    assert nothing["noise_ratio"] == pytest.approx(log10(1.0 + 10.0 * log(1e9))) and nothing["recorder"] == nothing["beside"] == 0.0
    # a base that leaves 100 nats and no model that gains: all of it is left; what gains less than one counts as one
    assert of_log()["left_share"] == pytest.approx(100.0 / 101.0) and of_log()["little"] == 0.0
    lead = row("viscous", gain=0.5, chi2=1.5, evidence=0.2)
    assert of_log(lead)["left_share"] == pytest.approx(100.0 / 101.0)


def test_values_in_closed_form():
    assert discounted(20.0, 0.5, 18.0) == pytest.approx(2.0) and inclusive([]) == 0.0
    assert inclusive([log(3.0), log(1.0)]) == pytest.approx(log(4.0))
    assert gap_closed(row("load_spring", kind=BESIDE, chi2=3.0, share=0.5)) == pytest.approx(3.0)
    # 1.3 N leave 1 N of 1.44 N^2: the gap is the root of 0.44
    assert gap_closed(row("load_spring", kind=BESIDE, chi2=1.0, share=1.0 - 1.0 / 1.2)) == pytest.approx(sqrt(0.44))
    p = tempered({("a",): 0.16, NONE: 0.64, UNKNOWN: 0.2}, 2.0)
    whole = 0.16**2 + 0.64**2 + 0.2**2
    assert p == pytest.approx({("a",): 0.16**2 / whole, NONE: 0.64**2 / whole, UNKNOWN: 0.04 / whole})
    assert tempered({("a",): 0.0, NONE: 1.0, UNKNOWN: 0.0}, 1.0) == {("a",): 0.0, NONE: 1.0, UNKNOWN: 0.0}


@pytest.mark.parametrize(("share", "kept"), [(0.006, True), (0.004, False)])
def test_a_gap_of_a_tenth_of_the_noise_is_something(share, kept):
    # half a per cent off the error is a gap of a tenth of the noise: 1 - 1 / sqrt(1.01)
    c = row("load_spring", kind=BESIDE, share=share)
    assert (share > 1.0 - 1.0 / sqrt(1.01)) is kept
    p = {c.ids: 0.6, NONE: 0.3, UNKNOWN: 0.1}
    assert sizeable(rows(c), p) == (p if kept else {NONE: pytest.approx(0.9), UNKNOWN: 0.1})
    # of the output's own models nothing is slight, nor of what is not asked
    assert sizeable(rows(replace(c, kind=OUTPUT)), p) == p and sizeable(rows(c), {NONE: 0.9, UNKNOWN: 0.1}) == {NONE: 0.9, UNKNOWN: 0.1}


def test_an_error_that_has_grown_is_not_nothing_where_one_effect_would_take_most_of_it():
    taken, now = row("zero_offset", evidence=-0.3, share=0.89), replace(LOG, grown=0.98)
    words = grown(rows(taken, log=now))
    assert words.startswith("98 % of") and "zero_offset would take 89 %" in words
    # half of it is what there was; half of that is taken; sizes that are unusual; pairs, which take more whatever it is
    others = (
        rows(taken, log=replace(LOG, grown=0.5)), rows(replace(taken, share=0.5), log=now), rows(taken),
        rows(replace(taken, outside=1), log=now), rows(replace(taken, ids=("gain_error", "slack")), log=now),
    )  # fmt: skip
    assert not any(grown(x) for x in others)
    # it is said in place of nothing, and of nothing else
    p = {("zero_offset",): 0.2, NONE: 0.45, UNKNOWN: 0.35}
    said = decided(rows(taken, log=now), p, weights())
    assert (said.status, said.why, said.confidence) == ("unknown", words, pytest.approx(0.8)) and decided(
        rows(taken), p, weights()
    ).status == "none"
    likely = {("zero_offset",): 0.5, NONE: 0.3, UNKNOWN: 0.2}
    assert decided(rows(taken, log=now), likely, weights()).status == decided(rows(taken), likely, weights()).status == "ambiguous"
    # nor in place of nothing where the most probable effect takes next to nothing off
    idle = row("viscous", share=0.01)
    p = {idle.ids: 0.4, taken.ids: 0.05, NONE: 0.45, UNKNOWN: 0.1}
    assert [decided(rows(idle, taken, log=log), p, weights()).status for log in (LOG, now)] == ["none", "unknown"]


def test_what_is_reducible_is_what_the_base_leaves_beyond_the_noise():
    fault, cause = row("quantisation", kind=RECORDER, share=0.2), row("viscous", evidence=900.0, share=0.9)
    p = {fault.ids: 0.5, cause.ids: 0.25, NONE: 0.125, UNKNOWN: 0.125}
    # a third of what the base leaves is above the noise, 0.3 of all: 0.24 beside the fault
    moved = {cause.ids: 0.75, NONE: 0.125, UNKNOWN: 0.125}
    assert causes(rows(fault, cause), p) == moved
    assert causes(rows(replace(fault, share=0.25), cause), p) == p
    # of several models that of the largest share
    less = row("slack", evidence=950.0, share=0.1)
    assert causes(rows(fault, less, cause), {**p, less.ids: 0.0}) == {**moved, less.ids: 0.0}


@pytest.mark.parametrize(("found", "why"), [(0.21, True), (0.19, False)])
def test_what_is_no_candidate_is_told_where_it_is_likelier_than_all_else_without_a_name(found, why):
    c = row("stribeck", gain=30.0)
    p = {c.ids: found, ("slack",): 0.5, NONE: 0.1, UNKNOWN: 0.2}
    after, words = barred(rows(c, barred={"stribeck": "a rub"}), p)
    assert after == pytest.approx({("slack",): 0.5, NONE: 0.1, UNKNOWN: 0.2 + found})
    assert words == (
        "adding a rub gains 30 nats and leaves 0 % of the noise beyond it and what the law may be off by, and is no candidate"
        if why
        else ""
    )
    assert barred(rows(c), p) == (p, "")


def test_an_output_that_wanders_is_told_where_nothing_would_have_been_said():
    p = {("slack",): 0.2, NONE: 0.45, UNKNOWN: 0.35}
    assert wandering(rows(log=replace(LOG, wanders=DECIDES)), p) == (p, "")
    after, why = wandering(rows(log=replace(LOG, wanders=DECIDES + 0.01)), p)
    assert after == pytest.approx({("slack",): 0.2, NONE: 0.0, UNKNOWN: 0.8}) and "(4 nats)" in why
    # where it was unknown in any case it has its own reason
    assert wandering(rows(log=replace(LOG, wanders=9.0)), {NONE: 0.3, UNKNOWN: 0.7}) == ({NONE: 0.0, UNKNOWN: 1.0}, "")
    assert wandering(rows(log=replace(LOG, wanders=9.0)), {NONE: 0.5, UNKNOWN: 0.5})[1] == ""


def test_combinations_stand_by_what_their_weakest_part_adds():
    single, five, six = row("viscous", drop_one=-9.0), row("a", "b", drop_one=5.0), row("a", "c", drop_one=5.1)
    assert standing(rows(single, five, six)).candidates == (single, six)


def test_odds_of_effects_and_of_what_has_no_name():
    w = weights(viscous=log(6.0), slack=log(2.0))
    plain = probabilities(rows(row("viscous"), row("slack"), row("viscous", "slack")), w)
    # the three have odds 6, 2 and 12 among one another; named, none and unknown a third each
    assert plain == pytest.approx(
        {("viscous",): 0.1, ("slack",): 1.0 / 30.0, ("slack", "viscous"): 0.2, NONE: 1.0 / 3.0, UNKNOWN: 1.0 / 3.0}
    )
    # an unnamed one has odds of 1 to 20 beside an effect of odds 1
    barred = probabilities(rows(row("a rub"), row("drive"), barred={"a rub": "a rub"}), w)
    assert barred[("a rub",)] / barred[("drive",)] == pytest.approx(1.0 / 20.0)
    own = probabilities(rows(row("viscous"), row("slack")), w, {"viscous": 3.0})
    # 18 and 2 over 8: what is named is two and a half times as likely as without
    assert own == pytest.approx({("viscous",): 0.9 * 2.5 / 4.5, ("slack",): 0.1 * 2.5 / 4.5, NONE: 1.0 / 4.5, UNKNOWN: 1.0 / 4.5})


def test_families_sets_and_runners_up():
    p = {
        ("channel_lowpass",): 0.3,
        ("viscous",): 0.2,
        ("channel_delay",): 0.4,
        ("channel_delay", "viscous"): 0.05,
        NONE: 0.03,
        UNKNOWN: 0.02,
    }
    assert _family(("channel_lowpass",), p) == (("channel_delay",), ("channel_lowpass",))
    assert _family(("viscous",), p) == (("viscous",),)
    # a quarter of all is asked for; the first is always one
    ranked = [("a",), ("b",), ("c",)]
    assert _set(ranked, {("a",): 0.5, ("b",): 0.25, ("c",): 0.25}, 0.25) == (("a",), ("b",), ("c",))
    assert _set(ranked, {("a",): 0.5, ("b",): 0.26, ("c",): 0.24}, 0.25) == (("a",), ("b",)) and _set(ranked[:1], {("a",): 0.1}, 2.0) == (
        ("a",),
    )
    assert _runner_up({NONE: 0.1, UNKNOWN: 0.1}) == "nothing at all" and "no name" in _runner_up({NONE: 0.1, UNKNOWN: 0.11})


def test_confidence_is_between_what_was_stated_and_what_was_right():
    w = weights(reliability={"none": ((0.2, 0.4), (0.6, 0.8))})
    assert w.right("none", 0.3) == pytest.approx(0.5) and w.right("none", 0.9) == pytest.approx(0.8)
    assert w.right("identified", 0.3) == 0.3
    assert decided(rows(), {NONE: 1.0, UNKNOWN: 0.0}, w, {"slack": 1.0}).confidence is None


@pytest.mark.parametrize(("behind", "tied"), [(DECIDES - 0.01, True), (DECIDES + 0.01, False)])
def test_models_are_tied_to_49_to_1(behind, tied):
    top, other = row("viscous", evidence=100.0), row("crosstalk", evidence=100.0 - behind)
    assert _tied(rows(top, other), top.ids) == ([other.ids] if tied else [])
    # what contains it does not contradict it, what is no candidate or no model of the output is none
    with_it, fault = row("crosstalk", "viscous", evidence=200.0), row("saturation", kind=RECORDER, evidence=900.0)
    assert _tied(rows(top, with_it, fault), top.ids) == [] and _tied(rows(top, other, barred={"crosstalk": "x"}), top.ids) == []
    assert _tied(rows(fault, top), fault.ids) == []


@pytest.mark.parametrize(("ahead", "tied"), [(JOINS - DECIDES - 0.01, False), (JOINS - DECIDES + 0.01, True)])
def test_a_pair_is_tied_only_where_its_further_effect_adds_what_joining_asks(ahead, tied):
    top, pair = row("viscous", evidence=50.0), row("crosstalk", "slack", evidence=50.0 + ahead)
    assert _tied(rows(top, pair), top.ids) == ([pair.ids] if tied else [])
    # a single effect needs nothing more than a pair
    single = row("gain_error", evidence=50.0 + ahead - DECIDES + 0.01)
    assert _tied(rows(pair, single), pair.ids) == [single.ids]


@pytest.mark.parametrize(("apart", "told"), [(1.01, True), (0.99, False)])
def test_members_are_told_by_nats_that_their_laws_may_be_off_by(apart, told):
    # a share of 0.03 of 1000 nats: 1 + 2 * 0.0009 * 1000 = 2.8
    lead, other = row("channel_delay", evidence=1000.0), row("channel_lowpass", evidence=1000.0 - 2.8 * DECIDES * apart)
    assert _told(rows(lead, other), lead.ids, (lead.ids, other.ids), {"lag": 0.03}) is told
    # what 400 samples hide at most are 2 sqrt(200) nats, what they leave here 100 more: an eighth of a million
    big, far = row("channel_delay", evidence=1e6, chi2=1.5), 2.0 * (100.0 + 2.0 * sqrt(200.0))
    rest = row("channel_lowpass", evidence=1e6 - (1.0 + far) * DECIDES * apart)
    assert _told(rows(big, rest), big.ids, (big.ids, rest.ids), {"lag": 0.5}) is told


@pytest.mark.parametrize(("grown", "told"), [(0.76, False), (0.998, True), (None, True)])
def test_beside_what_an_accepted_model_leaves_a_family_is_told_by_laws_that_are_off_by_as_much(grown, told):
    """A delay and a low-pass differ at corners, which such a model misses: 400 of 950 nats are 8 where half of the error was there before."""
    lead, other = row("channel_lowpass", evidence=950.0), row("channel_delay", evidence=550.0)
    seen = rows(lead, other, log=replace(LOG, samples=2, base_chi2=1.0, grown=grown), scatters=True)
    assert _told(seen, lead.ids, (lead.ids, other.ids), {"lag": 0.01}) is told
    assert _told(replace(seen, scatters=False), lead.ids, (lead.ids, other.ids), {"lag": 0.01})


CLEAR = {("viscous",): 0.8, NONE: 0.1, UNKNOWN: 0.1}


@pytest.mark.parametrize(("p", "status"), [(0.8, "identified"), (0.79, "ambiguous")])
def test_an_effect_is_named_from_the_learned_probability_on(p, status):
    found = decided(rows(row("viscous")), {("viscous",): p, NONE: 0.1, UNKNOWN: 0.9 - p}, weights())
    assert found.status == status and found.confidence == pytest.approx(p)


@pytest.mark.parametrize(
    ("none", "unknown", "named", "quiet", "status"),
    [
        # as likely as what is likeliest, and as the learned probability
        (0.4, 0.4, 0.2, 0.4, "none"), (0.39, 0.41, 0.2, 0.1, "unknown"), (0.35, 0.2, 0.45, 0.35, "ambiguous"), (0.45, 0.1, 0.45, 0.45, "none"),
        # as all names together will do where that is less than the learned one
        (0.4, 0.2, 0.4, 0.9, "none"), (0.2, 0.4, 0.4, 0.1, "unknown"), (0.2, 0.39, 0.41, 0.1, "ambiguous"),
    ],
)  # fmt: skip
def test_which_of_nothing_a_name_and_none_is_likeliest(none, unknown, named, quiet, status):
    found = decided(rows(row("viscous")), {("viscous",): named, NONE: none, UNKNOWN: unknown}, weights(quiet=quiet))
    assert found.status == status


@pytest.mark.parametrize(("share", "status"), [(0.5, "identified"), (0.49, "ambiguous")])
def test_half_of_the_error_is_a_cause(share, status):
    assert decided(rows(row("viscous", share=share)), CLEAR, weights()).status == status


def test_what_is_no_cause_leaves_its_share_to_what_has_no_name_but_where_nothing_is_likelier():
    c = row("viscous", share=0.0)
    found = decided(rows(c), {("viscous",): 0.8, NONE: 0.05, UNKNOWN: 0.15}, weights())
    assert found.status == "unknown" and found.confidence == pytest.approx(0.75)
    # a sound bench with bristles was `unknown` for a candidate that brought it nowhere, at 0.39 for nothing and 0.21 for what has no name
    found = decided(rows(c), {("viscous",): 0.4, NONE: 0.39, UNKNOWN: 0.21}, weights())
    assert found.status == "none" and found.confidence == pytest.approx(0.65) and "looks like noise" in found.why
    # so do all others that explain nothing, not the likeliest alone
    several = [row(i, share=0.0) for i in ("viscous", "slack", "crosstalk")]
    found = decided(rows(*several), {**{c.ids: 0.2 for c in several}, NONE: 0.21, UNKNOWN: 0.19}, weights())
    assert found.status == "none" and found.confidence == pytest.approx(0.525)
    # several effects that describe a gap by sizes which none has do leave one
    together = row("viscous", "slack", outside=2, strengths=2)
    assert decided(rows(together), {together.ids: 0.4, NONE: 0.39, UNKNOWN: 0.21}, weights()).status == "unknown"
    quiet = {("viscous",): 0.3, NONE: 0.5, UNKNOWN: 0.2}
    assert decided(rows(c), quiet, weights()).status == "none"
    # as likely as all names together is no less likely
    assert decided(rows(c), {("viscous",): 0.4, NONE: 0.4, UNKNOWN: 0.2}, weights()).status == "none"


@pytest.mark.parametrize(("evidence", "share", "both"), [(25.1, 0.06, True), (25.0, 0.06, False), (25.1, 0.05, False)])
def test_a_fault_beyond_doubt_that_carries_a_twentieth_stands_beside_an_effect(evidence, share, both):
    rig, fault = row("viscous", evidence=900.0), row("saturation", kind=RECORDER, evidence=evidence, share=share)
    given, w = rows(rig, fault), weights(commit=0.3)
    said = decided(given, {rig.ids: 0.9, NONE: 0.05, UNKNOWN: 0.05}, w)
    found = _with_faults(said, given, w, None)
    assert found.effects == (("saturation", "viscous") if both else ("viscous",))
    # each is right or not by itself: 0.9 of the one, and a third of the rig's alone with weights that say nothing
    assert found.confidence == pytest.approx(0.9 / 3.0 if both else 0.9)
    assert _with_faults(replace(said, status="ambiguous"), given, w, None).effects == ("viscous",)
