"""Every way into every status, on evidence and weights made by hand: no learned number decides here.

The weights are zero but for intercepts, so that each case states the probabilities itself; evidence then decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import pytest

from sstl_cli.core.groups import spelled_out
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.constants import DECIDES_NATS, JOINS_NATS
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, LogRow, Rows, leading
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import (
    CANDIDATE_TERMS,
    LOG_TERMS,
    Verdict,
    Weights,
    candidate_terms,
    decided,
    log_terms,
    probabilities,
    standing,
    verdict,
)

SAMPLES = 5000
LOG = LogRow(SAMPLES, 2, 3, 2.0, 50.0, 40.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0)
CALM = Leftover(SAMPLES, 1.0, 0.0, 0.0, 0.0, (Misfit("mean by run", 0.5, 0.3, "0"),))
LOUD = Leftover(SAMPLES, 2.0, 0.5, 3.0, 0.0, (Misfit("mean by speed", 40.0, 90.0, "fast"), Misfit("mean by run", 3.0, 2.0, "0")))
COMMIT, MEMBER, QUIET, COVER = 0.8, 0.03, 0.3, 0.2
LARGE = SAMPLES / 2.0


@dataclass(frozen=True)
class Seen:
    """A candidate and the probability that the weights of the case give it."""

    p: float
    row: CandidateRow


def seen(*ids, p, evidence=1000.0, kind=OUTPUT, share=1.0, drop=None, gain=LARGE, **more):
    row = CandidateRow(tuple(sorted(ids)), kind, len(ids), gain, evidence, evidence if drop is None else drop, 1.0, 1.0, 0.5, 0, 1.0, share)
    return Seen(p, replace(row, **more))


def weights(candidates=(), none=0.1, unknown=0.1, reliability=MappingProxyType({})):
    """Return weights under which each candidate has just its probability; of one combination ``more`` makes up the rest."""
    effect = {c.row.ids[0]: float(np.log(c.p)) for c in candidates if len(c.row.ids) == 1}
    pair = [float(np.log(c.p)) - sum(effect.get(i, 0.0) for i in c.row.ids) for c in candidates if len(c.row.ids) > 1]
    own, one = dict.fromkeys(CANDIDATE_TERMS, 0.0), dict.fromkeys(LOG_TERMS, 0.0)
    # none and unknown stand beside all that is named together
    named = sum(c.p for c in candidates) or 1.0
    return Weights(
        {**own, "more": sum(pair)}, {**one, "one": float(np.log(none / named))}, {**one, "one": float(np.log(unknown / named))},
        effect, COMMIT, {"lag": MEMBER}, QUIET, COVER, 24.0, reliability,
    )  # fmt: skip


def said(*candidates, none=0.1, unknown=0.1, log=LOG, best=LOUD, prior=None, reliability=MappingProxyType({})):
    rows = Rows(log, tuple(c.row for c in candidates), LOUD, best)
    return verdict(rows, weights(candidates, none, unknown, reliability), prior)


# what loses by evidence, and what does not
FAR, NEAR = 1000.0 - DECIDES_NATS - 0.1, 1000.0 - DECIDES_NATS + 0.1
# the same between members of a family, whose laws are off by a share of what they explain
APART = DECIDES_NATS * (1.0 + 2.0 * MEMBER**2 * 1000.0)
TOLD, UNTOLD = 1000.0 - APART - 0.1, 1000.0 - APART + 0.1

WAYS = {
    "probable, alone": (
        [seen("viscous", p=0.9), seen("crosstalk", p=0.02, evidence=FAR)], 0.04, 0.04, "identified", ("viscous",), (("viscous",),), 0.9),
    "probable, but another explains as well": (
        [seen("viscous", p=0.9), seen("crosstalk", p=0.02, evidence=NEAR)], 0.04, 0.04, "ambiguous", ("viscous",), (("viscous",), ("crosstalk",)), 0.92),
    "a more evident rival ties too": (
        [seen("viscous", p=0.9), seen("crosstalk", p=0.02, evidence=2000.0)], 0.04, 0.04, "ambiguous", ("viscous",), (("viscous",), ("crosstalk",)), 0.92),
    "a larger model without the probable effect says that it may be another": (
        [seen("gain_error", p=0.85), seen("zero_offset", "sensor_nonlinearity", p=0.1, evidence=1100.0)], 0.03, 0.02,
        "ambiguous", ("gain_error",), (("gain_error",), ("sensor_nonlinearity", "zero_offset")), 0.95),
    "a larger model without the probable effect that is behind": (
        [seen("gain_error", p=0.85), seen("zero_offset", "sensor_nonlinearity", p=0.1, evidence=FAR)], 0.03, 0.02,
        "identified", ("gain_error",), (("gain_error",),), 0.85),
    "a larger model is no tie": (
        [seen("viscous", p=0.9), seen("viscous", "crosstalk", p=0.02, evidence=1010.0)], 0.04, 0.04, "identified", ("viscous",), (("viscous",),), 0.9),
    "a family, none of its members told": (
        [seen("channel_delay", p=0.5), seen("channel_lowpass", p=0.35, evidence=UNTOLD)], 0.1, 0.05,
        "ambiguous", ("channel_delay",), (("channel_delay",), ("channel_lowpass",)), 0.85),
    "a family, one member more probable, but less evident": (
        [seen("channel_delay", p=0.85, evidence=TOLD), seen("channel_lowpass", p=0.05)], 0.05, 0.05,
        "ambiguous", ("channel_delay",), (("channel_delay",), ("channel_lowpass",)), 0.9),
    "a family that is likelier than nothing, though none of its members is": (
        [seen("channel_delay", p=0.2), seen("channel_lowpass", p=0.2, evidence=UNTOLD), seen("viscous", p=0.15, evidence=FAR)], 0.35, 0.05,
        "ambiguous", ("channel_delay",), (("channel_delay",), ("channel_lowpass",), ("viscous",)), 0.55),
    "a family, untold, and another explains as well": (
        [seen("channel_delay", p=0.5), seen("channel_lowpass", p=0.35, evidence=UNTOLD), seen("viscous", p=0.05, evidence=NEAR)], 0.05, 0.05,
        "ambiguous", ("channel_delay",), (("channel_delay",), ("channel_lowpass",), ("viscous",)), 0.9),
    "a family sure, its member told by the evidence": (
        [seen("channel_delay", p=0.5), seen("channel_lowpass", p=0.35, evidence=TOLD)], 0.1, 0.05,
        "identified", ("channel_delay",), (("channel_delay",),), 0.85),
    "a large effect of a family, its member told: the other law would have to be off just so that this one fits": (
        [seen("channel_delay", p=0.5, evidence=1e6, gain=1e6), seen("channel_lowpass", p=0.35, evidence=996_000.0, gain=1e6)], 0.1, 0.05,
        "identified", ("channel_delay",), (("channel_delay",),), 0.85),
    "a large effect of a family whose leading law is off itself": (
        [seen("channel_delay", p=0.5, evidence=1e6, gain=1e6, chi2=1.4), seen("channel_lowpass", p=0.35, evidence=996_000.0, gain=1e6)], 0.1, 0.05,
        "ambiguous", ("channel_delay",), (("channel_delay",), ("channel_lowpass",)), 0.85),
    "a family of which one alone is a candidate": (
        [seen("channel_delay", p=0.85)], 0.1, 0.05, "identified", ("channel_delay",), (("channel_delay",),), 0.85),
    "a set: not sure, and no family": (
        [seen("viscous", p=0.4), seen("crosstalk", p=0.3), seen("zero_offset", p=0.1)], 0.1, 0.1,
        "ambiguous", ("viscous",), (("viscous",), ("crosstalk",)), 0.7),
    "one name, but nothing at all is not ruled out": (
        [seen("viscous", p=0.7), seen("crosstalk", p=0.01)], 0.19, 0.1, "ambiguous", ("viscous",), (("viscous",),), 0.7),
    "unknown by probability": (
        [seen("viscous", p=0.2)], 0.1, 0.7, "unknown", (), (), 0.7),
    "a part: the probable one explains less than half": (
        [seen("viscous", p=0.9, chi2=1.51)], 0.05, 0.05, "ambiguous", ("viscous",), (("viscous",),), 0.9),
    "unknown: the probable one comes no nearer": (
        [seen("viscous", p=0.9, share=0.0, chi2=0.9)], 0.02, 0.08, "unknown", (), (), 0.8),
    "half explained is enough": (
        [seen("viscous", p=0.9, chi2=1.5)], 0.05, 0.05, "identified", ("viscous",), (("viscous",),), 0.9),
    "jumps are explained though nobody knows their moments": (
        [seen("stribeck", p=0.9, share=0.1, chi2=0.9)], 0.05, 0.05, "identified", ("stribeck",), (("stribeck",),), 0.9),
    "none by probability": (
        [seen("viscous", p=0.2)], 0.7, 0.1, "none", (), (), 0.7),
    "none, although the probable one explains less than half": (
        [seen("viscous", p=0.2, chi2=1.9)], 0.7, 0.1, "none", (), (), 0.7),
    "no candidate at all, and quiet": ([], 0.9, 0.1, "none", (), (), 0.9),
    "no candidate at all, and loud": ([], 0.1, 0.9, "unknown", (), (), 0.9),
    "a pair": (
        [seen("viscous", p=0.05, evidence=500.0), seen("crosstalk", p=0.03, evidence=400.0), seen("viscous", "crosstalk", p=0.9)], 0.01, 0.01,
        "identified", ("crosstalk", "viscous"), (("crosstalk", "viscous"),), 0.9),
    "a pair that a single effect ties": (
        [seen("viscous", p=0.05, evidence=NEAR), seen("crosstalk", p=0.03, evidence=400.0), seen("viscous", "crosstalk", p=0.9)], 0.01, 0.01,
        "ambiguous", ("crosstalk", "viscous"), (("crosstalk", "viscous"), ("viscous",)), 0.95),
    "a fault of the recorder": (
        [seen("acquisition_faults", p=0.9, kind=RECORDER), seen("viscous", p=0.02, share=0.02)], 0.04, 0.04,
        "identified", ("acquisition_faults",), (("acquisition_faults",),), 0.9),
    "a fault of the recorder that carries little may still be the cause": (
        [seen("acquisition_faults", p=0.9, kind=RECORDER, share=0.1)], 0.05, 0.05, "identified", ("acquisition_faults",), (("acquisition_faults",),), 0.9),
    "a fault of the recorder that is there, beside a cause that carries more": (
        [seen("quantisation", p=0.6, kind=RECORDER, share=0.1), seen("viscous", p=0.2, share=0.7), seen("crosstalk", p=0.06, evidence=200.0)],
        0.05, 0.09, "ambiguous", ("quantisation", "viscous"), (("quantisation", "viscous"), ("crosstalk", "quantisation")), 0.86),
    "a lag beside the output whose gap is next to nothing": (
        [seen("tension_loop_lag", p=0.9, kind=BESIDE, share=0.002)], 0.06, 0.04, "none", (), (), 0.96),
    "a lag beside the output": (
        [seen("tension_loop_lag", p=0.9, kind=BESIDE)], 0.05, 0.05, "identified", ("tension_loop_lag",), (("tension_loop_lag",),), 0.9),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_each_way_into_a_status(way):
    candidates, none, unknown, status, effects, group, confidence = WAYS[way]
    found = said(*candidates, none=none, unknown=unknown)
    total = sum(c.p for c in candidates) + none + unknown
    assert (found.status, found.effects, found.group) == (status, effects, group)
    assert found.confidence == pytest.approx(confidence / total)
    assert sum(found.probabilities.values()) == pytest.approx(1.0)


def test_just_below_the_learned_probability_nothing_is_identified():
    above = said(seen("viscous", p=COMMIT + 0.01), none=0.1, unknown=0.1 - 0.01)
    below = said(seen("viscous", p=COMMIT - 0.01), none=0.1, unknown=0.1 + 0.01)
    assert (above.status, below.status) == ("identified", "ambiguous")


def test_nothing_is_said_when_it_is_as_probable_as_quiet_or_as_all_names_together():
    two = [seen("viscous", p=0.2), seen("crosstalk", p=0.2)]
    # the most probable answer, but below QUIET and below all names together
    quiet = [replace(c, p=0.24) for c in (*two, seen("zero_offset", p=0.24))]
    assert said(*quiet, none=0.26, unknown=0.02).status == "ambiguous"
    assert said(*two, none=0.31, unknown=0.29).status == "none"


def test_nothing_says_so_where_all_that_may_be_there_together_is_likelier():
    two = [seen("viscous", p=0.2, gain=90.0), seen("crosstalk", p=0.2)]
    unsure, sure = said(*two, none=0.31, unknown=0.29), said(*two, none=0.5, unknown=0.1)
    assert (unsure.status, sure.status) == ("none", "none")
    assert "though not than all of them together, of which crosstalk" in unsure.why and "looks like noise" in sure.why


@pytest.mark.parametrize(
    ("strain", "why"), [(1.1, "beside noise that is larger than was measured"), (0.9, "less likely than something"), (None, "less likely")]
)
def test_what_fails_no_test_is_no_leftover(strain, why):
    found = said(seen("viscous", p=0.2), none=0.1, unknown=0.7, log=replace(LOG, strain=strain), best=CALM)
    assert found.status == "unknown" and why in found.why and "sigma" not in found.why
    assert "40 sigma" in said(seen("viscous", p=0.2), none=0.1, unknown=0.7, log=replace(LOG, strain=strain)).why


def test_without_propagation_nothing_is_said_whatever_the_evidence():
    found = said(seen("viscous", p=0.97), log=replace(LOG, propagates=0.0))
    assert (found.status, found.effects, found.confidence, found.group) == ("unknown", (), None, ())
    assert "never leaves its hold" in found.why and "larger stroke" in found.why


@pytest.mark.parametrize("prior, confidence", [(None, 0.9), ({}, 0.9), ({"crosstalk": 1.0}, None)])
def test_a_prior_of_ones_own_was_tried_by_nobody(prior, confidence):
    found = said(seen("viscous", p=0.9), none=0.05, unknown=0.05, prior=prior)
    assert found.status == "identified" and found.confidence == (None if confidence is None else pytest.approx(confidence))


@pytest.mark.parametrize("odds, status", [(1.0, "identified"), (0.01, "unknown")])
def test_a_prior_against_an_effect_takes_its_name_away(odds, status):
    assert said(seen("viscous", p=0.9), none=0.03, unknown=0.07, prior={"viscous": odds}).status == status


def test_the_prior_of_a_pair_is_the_product_of_its_parts():
    both = (seen("viscous", p=0.2), seen("crosstalk", p=0.2), seen("viscous", "crosstalk", p=0.2))
    rows, w = Rows(LOG, tuple(c.row for c in both), LOUD, LOUD), weights(both)
    plain, own = probabilities(rows, w), probabilities(rows, w, {"viscous": 2.0, "crosstalk": 3.0})
    pair = ("crosstalk", "viscous")
    assert own[pair] / own[NONE] == pytest.approx(6.0 * plain[pair] / plain[NONE])


def test_confidence_is_read_from_what_was_right_elsewhere():
    found = said(seen("viscous", p=0.9), none=0.05, unknown=0.05, reliability={"identified": ((0.5, 0.2), (1.0, 0.7))})
    assert found.confidence == pytest.approx(0.6)


def test_a_combination_whose_part_adds_too_little_does_not_stand():
    single, weak = seen("viscous", p=0.3, evidence=500.0), seen("viscous", "crosstalk", p=0.5, drop=JOINS_NATS)
    strong = replace(weak, row=replace(weak.row, drop_one=JOINS_NATS + 0.1))
    assert [c.ids for c in standing(Rows(LOG, (single.row, weak.row), LOUD, LOUD)).candidates] == [("viscous",)]
    assert weak.row.ids not in said(single, weak).probabilities and strong.row.ids in said(single, strong).probabilities


def test_why_tells_what_was_seen():
    assert "gains 2500 nats" in said(seen("viscous", p=0.9)).why
    assert "crosstalk explains this data as well" in said(seen("viscous", p=0.9), seen("crosstalk", p=0.02)).why
    assert "mean by speed, 40 sigma" in said(seen("viscous", p=0.2), unknown=0.7).why
    assert "mean by speed" in said(none=0.1, unknown=0.9).why
    assert "10 % of the squared error" in said(seen("acquisition_faults", p=0.9, kind=RECORDER, share=0.1)).why
    assert "takes 95 % off" in said(seen("tension_loop_lag", p=0.9, kind=BESIDE, share=0.95)).why
    assert "nothing at all is not ruled out" in said(seen("viscous", p=0.7), none=0.2, unknown=0.1).why
    assert "something that has no name here is not ruled out" in said(seen("viscous", p=0.7), none=0.1, unknown=0.2).why
    members = said(seen("channel_delay", p=0.5), seen("channel_lowpass", p=0.35, evidence=UNTOLD)).why
    assert "which of channel_delay, channel_lowpass it is" in members


@pytest.mark.parametrize(
    "group, classes",
    [
        ((("viscous",), ("channel_delay",)), {}),
        ((("channel_lowpass",), ("channel_delay",)), {"lag: channel_delay | channel_lowpass": ("channel_delay", "channel_lowpass")}),
        ((("stribeck",), ("stick_slip",), ("viscous",)), {"stick-slip: stick_slip | stribeck": ("stick_slip", "stribeck")}),
        ((("channel_delay", "viscous"), ("channel_lowpass",)), {}),
    ],
)
def test_a_class_stands_where_several_of_its_members_do(group, classes):
    assert Verdict("ambiguous", group[0], 0.9, group, {}, "").classes == classes


def test_a_class_and_a_pair_are_spelled_out_by_their_members():
    title = "lag: channel_delay | channel_lowpass"
    members = {title: ["channel_delay", "channel_lowpass"], "crosstalk+viscous": ["crosstalk", "viscous"]}
    told = spelled_out([title, "crosstalk+viscous", "zero_offset"], members)
    assert set(told) == {"channel_delay", "channel_lowpass", "crosstalk", "viscous", "zero_offset"}
    assert spelled_out(["viscous"], None) == ("viscous",)


def test_the_lead_is_of_the_output_only():
    a, b = seen("viscous", p=0.5, evidence=3.0).row, seen("acquisition_faults", p=0.5, evidence=9e4, kind=RECORDER).row
    rows = Rows(LOG, (a, b), LOUD, LOUD)
    assert leading(rows) is a and leading(replace(rows, candidates=(b,))) is None
    assert leading(replace(rows, candidates=(replace(a, evidence=0.0),))) is None


def numbers(row, rows):
    return dict(zip(CANDIDATE_TERMS, candidate_terms(row, rows), strict=True))


def test_the_numbers_of_a_candidate():
    lead, behind = seen("viscous", p=0.5, evidence=1000.0).row, seen("crosstalk", p=0.5, evidence=970.0, gain=980.0).row
    rows = Rows(LOG, (lead, behind), LOUD, LOUD)
    first, second = numbers(lead, rows), numbers(behind, rows)
    assert first["behind"] == first["rank"] == 0.0 and second["rank"] == 1.0
    assert first["ahead"] == pytest.approx(np.log10(31.0)) and second["ahead"] == 0.0
    assert second["behind"] == pytest.approx(-3.0) and second["log_behind_0"] == pytest.approx(-np.log10(31.0))
    # a law off by a tenth: 1000 nats of difference in what is predicted count 1 + 2 * 0.01 * 1000 = 21 times less
    assert second["log_behind_0.1"] == pytest.approx(-np.log10(1.0 + 30.0 / 21.0))
    assert first["left_share"] == 0.0 and first["recorder"] == first["beside"] == first["more"] == 0.0


def test_what_a_fault_of_the_recorder_leaves_is_what_the_base_leaves():
    row = seen("saturation", p=0.5, kind=RECORDER, share=0.3, gain=99.0).row
    found = numbers(row, Rows(replace(LOG, base_chi2=1.01, base_worst_z=9.0, base_mean_z=99.0), (row,), LOUD, LOUD))
    # 0.01 of 5000 samples are 25 nats beside a gain of 99
    assert found["left_share"] == pytest.approx(25.0 / 124.0) and found["means"] == pytest.approx(2.0)
    assert (
        found["recorder"] == 1.0
        and found["recorder_share"] == pytest.approx(np.log10(4.0))
        and found["recorder_gain"] == pytest.approx(2.0)
    )
    assert found["rank"] == found["ahead"] == found["behind"] == found["unstable"] == found["beside_gain"] == 0.0


def test_what_lies_beside_is_no_model_of_the_output():
    first = seen("tension_loop_lag", p=0.5, kind=BESIDE, share=0.4, evidence=99.0, chi2=10.0).row
    second = seen("load_spring", p=0.5, kind=BESIDE, evidence=9.0).row
    rows = Rows(LOG, (first, second, seen("viscous", p=0.1, evidence=5000.0).row), LOUD, LOUD)
    found = numbers(first, rows)
    assert (found["beside"], found["beside_share"], found["beside_gain"]) == pytest.approx((1.0, 0.4, 2.0))
    assert found["rank"] == numbers(second, rows)["rank"] == 0.0 and found["beside_out"] == pytest.approx(np.log10(5001.0))


def test_a_weak_part_of_a_combination_is_told_by_its_share_of_the_evidence():
    pair = seen("viscous", "crosstalk", p=0.5, evidence=1000.0, drop=9.0, unstable=10.0, outside=2).row
    found = numbers(pair, Rows(LOG, (pair,), LOUD, LOUD))
    assert found["weak_part"] == pytest.approx(np.log10(10.0))
    assert found["unstable"] == pytest.approx(1.0) and found["outside"] == 1.0 and found["strengths"] == 2.0


def test_what_two_models_share_does_not_discount_their_difference():
    shared = seen("viscous", p=0.5, evidence=900.0).row
    lead = seen("viscous", "crosstalk", p=0.5, evidence=1000.0, drop=100.0).row
    rival = seen("viscous", "zero_offset", p=0.5, evidence=970.0, drop=70.0).row
    found = numbers(rival, Rows(LOG, (shared, lead, rival), LOUD, LOUD))
    assert found["log_behind_0.1"] == pytest.approx(-np.log10(1.0 + 30.0 / (1.0 + 0.02 * 100.0))) and found["more"] == 1.0


def test_the_numbers_of_a_log_are_of_its_best_model_else_of_its_base():
    loud = replace(LOG, base_chi2=2.0)
    none = dict(zip(LOG_TERMS, log_terms(Rows(loud, (), LOUD, LOUD)), strict=True))
    assert none["best"] == none["nats"] == none["little"] == 0.0 and none["one"] == 1.0
    assert none["left_rms"] == pytest.approx(np.log10(11.0)) and none["left_share"] == pytest.approx(2500.0 / 2501.0)
    one = dict(zip(LOG_TERMS, log_terms(Rows(loud, (seen("viscous", p=0.5, evidence=9.0).row,), LOUD, LOUD)), strict=True))
    assert one["best"] == pytest.approx(1.0) and one["nats"] == pytest.approx(9.0 / 2.5) and one["left_share"] == 0.0
    assert one["base_rms"] == none["base_rms"] == pytest.approx(np.log10(11.0))
    ends = replace(seen("viscous", p=0.5, evidence=9.0).row, outside=1, share=0.75, chi2=2.0, worst_z=9.0, mean_z=99.0)
    at_end = dict(zip(LOG_TERMS, log_terms(Rows(loud, (ends,), LOUD, LOUD)), strict=True))
    assert one["outside"] == 0.0 and at_end["outside"] == 1.0 and at_end["little"] == 0.25
    assert (at_end["worst"], at_end["means"]) == pytest.approx((1.0, 2.0)) and at_end["left_rms"] == none["left_rms"]


def test_the_inclusive_value_of_the_candidates_is_one_of_the_numbers_of_a_log():
    # two candidates of odds 3 and 1: the sum of both is 4, its logarithm times -1/2 half as likely as without it
    both = [seen("viscous", p=3.0).row, seen("crosstalk", p=1.0).row]
    one, own = dict.fromkeys(LOG_TERMS, 0.0), dict.fromkeys(CANDIDATE_TERMS, 0.0)
    weigh = Weights(own, {**one, "inclusive": -0.5}, one, {"viscous": float(np.log(3.0))}, COMMIT, {}, QUIET, COVER, 24.0, {})
    found = probabilities(Rows(LOG, tuple(both), LOUD, CALM), weigh)
    assert found[()] == pytest.approx(0.5 / 2.5) and found[UNKNOWN] == pytest.approx(1.0 / 2.5)
    assert found[("viscous",)] == pytest.approx(0.75 / 2.5)
    # without any candidate there is none
    assert probabilities(Rows(LOG, (), LOUD, CALM), weigh)[()] == pytest.approx(0.5)


def test_what_is_left_of_a_channel_beside_counts_whoever_explains_it():
    beside = seen("load_spring", p=0.5, kind=BESIDE, share=0.5, chi2=25.0)
    assert dict(zip(LOG_TERMS, log_terms(Rows(LOG, (beside.row,), LOUD, CALM)), strict=True))["beside_base"] == pytest.approx(2.0)
    assert dict(zip(LOG_TERMS, log_terms(Rows(LOG, (), LOUD, CALM)), strict=True))["beside_base"] == 0.0


def test_nothing_and_the_unnamed_are_always_among_the_answers():
    assert set(said().probabilities) == {NONE, UNKNOWN}


def test_calm_or_loud_alone_decides_nothing():
    args = {"none": 0.05, "unknown": 0.05}
    assert said(seen("viscous", p=0.9), best=CALM, **args) == said(seen("viscous", p=0.9), best=LOUD, **args)


@pytest.mark.parametrize(("alone", "status"), [(48_000.0, "identified"), (0.0, "ambiguous")])
def test_members_within_a_pair_are_told_by_what_they_explain_themselves(alone, status):
    rest = seen("crosstalk", p=0.0, evidence=alone)
    late, low = (seen("crosstalk", i, p=0.0, evidence=e) for i, e in (("channel_delay", 51_000.0), ("channel_lowpass", 50_900.0)))
    rows = Rows(LOG, tuple(c.row for c in (rest, late, low)), LOUD, LOUD)
    p = {late.row.ids: 0.8, low.row.ids: 0.15, rest.row.ids: 0.01, NONE: 0.01, UNKNOWN: 0.03}
    assert decided(rows, p, weights()).status == status


def test_what_was_found_and_is_no_candidate_is_unknown_and_not_nothing():
    fault = seen("acquisition_faults", p=0.7, kind=RECORDER, evidence=900.0, share=0.8)
    other = seen("viscous", p=0.1, evidence=1.0)
    rows = Rows(LOG, (fault.row, other.row), LOUD, CALM)
    w = weights((fault, other), none=0.15, unknown=0.05)
    assert verdict(rows, w).effects == ("acquisition_faults",) or verdict(rows, w).status == "ambiguous"
    barred = verdict(replace(rows, barred={"acquisition_faults": "acquisition_faults"}), w)
    assert barred.status == "unknown" and barred.effects == () and barred.group == ()
    assert barred.probabilities[UNKNOWN] == pytest.approx(0.75) and ("acquisition_faults",) not in barred.probabilities
    assert barred.why == "acquisition_faults carries 80 % of the squared error beyond the noise, and is no candidate"
    # as little of it as chance brings is no reason
    slight = [replace(fault, p=0.01), replace(other, p=0.1)]
    rest = verdict(replace(rows, barred={"acquisition_faults": "acquisition_faults"}), weights(slight, none=0.7, unknown=0.19))
    assert rest.status == "none"
    # what a library keeps is of the candidates alone
    named = replace(rows, barred={"acquisition_faults": "acquisition_faults"}).named
    assert [c.ids for c in named.candidates] == [("viscous",)] and not named.barred
