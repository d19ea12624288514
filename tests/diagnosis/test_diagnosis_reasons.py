"""How much of a gap a candidate carries, by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.reasons import accounted_pct, also, carried, explained, left, nearer, only_scatters, partly, strained, without_name
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.physics.effects import get

LOG = LogRow(5000, 1, 2, 3.0, 9.0, 9.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 1.0, 1.0)
ROW = CandidateRow(("viscous",), OUTPUT, 1, 90.0, 80.0, 80.0, 1.5, 2.0, 1.0, 0, 1.0, 0.7)
LEFT = Leftover(5000, 1.5, 0.0, 0.0, 0.0, (Misfit("mean by run", 7.0, 3.0, "run a"),))
ROWS = Rows(LOG, (ROW,), LEFT, LEFT)


def test_a_model_carries_what_it_takes_off_and_no_more_than_of_what_was_held_out():
    # the base leaves 2 beyond the noise, the model a half; by size it takes off a little less
    assert carried(replace(ROW, share=0.9), ROWS) == pytest.approx(0.75) and carried(ROW, ROWS) == pytest.approx(0.7)
    assert carried(replace(ROW, held=0.2), ROWS) == pytest.approx(0.2) and carried(replace(ROW, held=0.9), ROWS) == pytest.approx(0.7)
    # noise that is believed to be loud hides that a model is no nearer: then nothing is left of the base either
    quiet = replace(ROWS, log=replace(ROWS.log, base_chi2=0.9), candidates=(replace(ROW, chi2=0.9, share=0.0),))
    assert carried(quiet.candidates[0], quiet) == 0.0 and "no nearer" in left(quiet, ("viscous",))
    assert carried(replace(ROW, kind=RECORDER, held=0.1), ROWS) == 1.0
    # where a simulator is known to leave more in some places than in others, plain size is that of those
    scatters = replace(ROWS, scatters=True)
    assert carried(ROW, scatters) == pytest.approx(0.75) and carried(replace(ROW, held=0.2), scatters) == pytest.approx(0.2)
    assert carried(replace(ROW, share=0.0), scatters) == 0.0
    # half of the error of the channel beside is a quarter of its square, of which the noise has half
    assert carried(replace(ROW, kind=BESIDE, share=0.5, chi2=2.0), ROWS) == pytest.approx(0.75 / 0.875)


def test_a_mean_over_jumps_that_is_no_nearer_only_scatters():
    jumps = replace(ROW, ids=("stribeck",), share=0.0)
    assert only_scatters(jumps, ROWS) and carried(jumps, ROWS) == 0.0 and not only_scatters(replace(jumps, share=0.1), ROWS)


def test_where_the_output_is_seen_to_jump_a_mean_over_jumps_accounts_for_what_it_leaves_as_noise():
    jumps = replace(ROW, ids=("stribeck",), share=0.0, chi2=1.0)
    seen, doubtful = (replace(ROWS, log=replace(LOG, jumps=nats)) for nats in (50.0, 1.0))
    assert carried(jumps, seen) == 1.0 and not only_scatters(jumps, seen)
    assert carried(jumps, doubtful) == 0.0 and only_scatters(jumps, doubtful)
    # what leaves more than the noise is asked for what it foretells, and other laws have to be nearer
    assert carried(replace(jumps, held=0.1), seen) == 1.0 and carried(replace(jumps, held=-0.1), seen) == -0.1
    assert carried(replace(jumps, chi2=2.5, held=0.1), seen) == 0.1 and carried(replace(ROW, share=0.0), seen) == 0.0


def test_what_jumps_account_for_is_told_of_the_law_that_is_their_mean_alone():
    jumps = replace(ROW, ids=("stick_slip",), share=0.1, chi2=1.5)
    rows = replace(ROWS, candidates=(ROW, jumps))

    def fitted(effect, parameter):
        found = get(effect)
        return SimpleNamespace(ids=(effect,), free=[SimpleNamespace(effect=found, parameter=found.parameter(parameter))])

    # the base leaves 2 beyond the noise, the mean with its scatter a half
    assert accounted_pct(fitted("stick_slip", "mean_ratio"), rows) == pytest.approx(75.0)
    assert accounted_pct(fitted("stick_slip", "ratio"), rows) is None and accounted_pct(fitted("viscous", "c_l_n_s_per_mm"), rows) is None
    assert accounted_pct(fitted("stick_slip", "mean_ratio"), ROWS) is None


def test_several_effects_of_which_no_size_is_usual_are_strained():
    pair = replace(ROW, ids=("gain_error", "viscous"), strengths=2, outside=2)
    assert strained(pair) and not strained(replace(pair, outside=1)) and not strained(replace(ROW, outside=1))


def test_reasons_tell_what_was_found_and_what_is_left():
    assert (
        explained(ROWS, ("viscous",))
        == "adding viscous gains 90 nats and leaves 87 % of the noise beyond it and what the law may be off by"
    )
    most = "even the best candidate, viscous, which explains 70 % of the squared error, leaves more than noise can be"
    assert left(ROWS, ("viscous",)) == f"{most} (mean by run, 7 sigma)"
    # the tests are those of the most evident model
    ahead = replace(ROWS, candidates=(replace(ROW, worst_z=30.0), replace(ROW, ids=("crosstalk", "viscous"), evidence=99.0)))
    assert left(ahead, ("viscous",)) == f"{most} (30 sigma)"
    little = replace(ROWS, candidates=(replace(ROW, chi2=2.2),))
    assert left(little, ("viscous",)) == "even the best candidate, viscous, leaves more than noise can be (mean by run, 7 sigma)"
    rests = replace(ROWS, log=replace(LOG, jumps=50.0))
    assert left(rests, ("viscous",)) == f"{most} (mean by run, 7 sigma); the output rests and jumps where it should slide"
    assert left(ROWS, ()) == "something is left that no candidate explains (mean by run)"
    low = replace(ROWS, candidates=(replace(ROW, held=0.2),))
    assert "removes 20 % at most of the gap of what was held out" in left(low, ("viscous",))


LOOP = replace(ROW, ids=("loop_friction",), evidence=79.0)
BESIDE_IT = replace(ROWS, candidates=(ROW, LOOP), barred={"loop_friction": "the loop rubs more"})


def test_what_has_no_name_is_said_beside_a_name_where_it_explains_as_much():
    assert also(BESIDE_IT, ("viscous",)) == "the loop rubs more would explain this data as well"
    behind = replace(BESIDE_IT, candidates=(ROW, replace(LOOP, evidence=76.0)))
    # 49 to 1 is 3.9 nats; what is not of the output has no evidence to compare
    assert also(behind, ("viscous",)) == "" and also(BESIDE_IT, ("saturation",)) == "" and also(ROWS, ("viscous",)) == ""
    assert explained(BESIDE_IT, ("loop_friction",)).startswith("adding the loop rubs more gains 90 nats")


def test_it_is_the_cause_where_it_is_beyond_all_names_and_most_of_the_error():
    own = Weighed(SimpleNamespace(ids=("loop_friction",)), 90.0, 79.0)
    found = Search(None, None, None, None, {"viscous": (Weighed(SimpleNamespace(ids=("viscous",)), 80.0, 70.0),)}, {}, (own,))
    assert without_name(found, BESIDE_IT) is own
    little = replace(BESIDE_IT, candidates=(ROW, replace(LOOP, share=0.3)))
    assert without_name(found, little) is None and without_name(replace(found, nameless=()), BESIDE_IT) is None


def short_of(row, **log):
    """Return why a candidate is not thought to be the cause, behind its name."""
    seen = replace(ROWS, log=replace(LOG, **log), candidates=(row,))
    text = left(seen, row.ids)
    assert text.startswith(f"even the best candidate, {' + '.join(row.ids)}, ")
    return text.removeprefix(f"even the best candidate, {' + '.join(row.ids)}, ")


def test_each_way_to_fall_short_has_its_words():
    pair = replace(ROW, ids=("gain_error", "viscous"), strengths=2, outside=2)
    assert short_of(pair) == "would need sizes that none of its effects usually has"
    # strained, but too little of it: that comes first
    assert short_of(replace(pair, share=0.3, held=0.3)) == "removes 30 % at most of the gap of what was held out"
    jumps = replace(ROW, ids=("stribeck",), share=0.0)
    assert short_of(jumps) == "lets the output scatter as it does, but its mean is no nearer to it than with nothing added"
    # what its scatter takes up is not what its mean explains
    loud = replace(jumps, chi2=1.2, worst_z=7.0)
    assert short_of(loud, jumps=50.0).startswith(
        "which with jumps that nobody can foretell explains 90 % of the squared error, leaves more"
    )
    # nor is there a share of what is no more than chance leaves of as many samples
    chance = 1.0 + 2.0 * np.sqrt(2.0 / LOG.samples)
    assert short_of(replace(loud, chi2=1.0), jumps=50.0, base_chi2=0.999 * chance).startswith("leaves more than noise can be")
    beside = replace(ROW, ids=("tension_loop_lag",), kind=BESIDE, share=0.1, chi2=2.0)
    # a fifth of the square beyond half of it
    assert short_of(beside) == f"explains only {100.0 * carried(beside, ROWS):.0f} % of what the channel beside shows beyond its noise"
    assert short_of(replace(ROW, share=0.04)) == "explains only 4 % of the squared error beyond the noise"
    assert short_of(replace(ROW, share=0.0)) == "brings the model no nearer to the output"
    assert short_of(replace(ROW, held=-0.1)) == "describes what was held out worse than nothing added"
    assert short_of(replace(ROW, held=0.0)) == "describes what was held out worse than nothing added"


@pytest.mark.parametrize(("z", "words"), [(7.0, "7 sigma"), (100.0, "100 sigma"), (101.0, "far beyond 100 sigma")])
def test_what_is_left_is_told_in_standard_deviations_as_far_as_they_say_anything(z, words):
    leading = replace(ROWS, best=replace(LEFT, tests=(Misfit("mean by run", z, 3.0, "run a"),)))
    assert left(leading, ROW.ids).endswith(f"leaves more than noise can be (mean by run, {words})")


@pytest.mark.parametrize(
    ("z", "strain", "words"),
    [
        (2.0, None, "is less likely than something that has no name here"),
        (2.0, 1.0, "is less likely than something that has no name here"),
        (2.0, 1.1, "explains it only beside noise that is larger than was measured"),
        (2.1, 1.1, "which explains 70 % of the squared error, leaves more than noise can be (mean by run, 2 sigma)"),
    ],
)
def test_what_fails_no_test_is_less_likely_or_needs_more_noise(z, strain, words):
    calm = replace(ROWS, log=replace(LOG, strain=strain), best=replace(LEFT, tests=(Misfit("mean by run", z, 3.0, "run a"),)))
    assert left(calm, ROW.ids) == f"even the best candidate, viscous, {words}"


def test_a_fault_of_the_recorder_is_told_by_what_it_carries_and_a_lag_by_what_it_takes_off():
    fault, lag = replace(ROW, ids=("saturation",), kind=RECORDER, share=0.25), replace(ROW, ids=("lag",), kind=BESIDE, share=0.4)
    seen = replace(ROWS, candidates=(fault, lag))
    assert explained(seen, ("saturation",)) == "saturation carries 25 % of the squared error beyond the noise"
    assert explained(seen, ("lag",)) == "lag takes 40 % off the error of the channel beside"
    # what fits within the noise leaves nothing beyond it
    assert explained(replace(ROWS, candidates=(replace(ROW, chi2=0.9),)), ROW.ids).endswith(
        "leaves 0 % of the noise beyond it and what the law may be off by"
    )
    assert (
        partly(replace(ROWS, candidates=(replace(ROW, share=0.3),)), ROW.ids)
        == "viscous explains only 30 % of the squared error beyond the noise"
    )


def test_of_jumps_that_are_accounted_for_a_part_is_nearer_though_the_mean_is_not():
    jumps = replace(ROW, ids=("stribeck",), share=0.1)
    # the base leaves 2 beyond the noise, the model a half
    assert nearer(jumps, ROWS) == pytest.approx(0.75) and nearer(replace(jumps, share=0.9), ROWS) == 0.9
    assert nearer(ROW, ROWS) == 0.7
    # of a base within the noise nothing is left to take off
    calm = replace(ROWS, log=replace(LOG, base_chi2=1.0))
    assert nearer(replace(jumps, chi2=1.0), calm) == pytest.approx(1.0) and nearer(replace(jumps, chi2=1.2), calm) == pytest.approx(0.1)
