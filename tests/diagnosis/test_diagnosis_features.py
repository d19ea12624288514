"""The numbers that a verdict is made from, where they are known by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.diagnosis.constants import EXAMINED
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.features import _at_most, _examined, _independent, _means, _share, instability, rows
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import Hypothesis, full
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.whitening import Noise, Sensor

OUT = Hypothesis(("zero_offset",), tuple(f for f in full("zero_offset", ("act",)).free if f.parameter.name == "z_out_act_n"))


@pytest.mark.parametrize(
    "removed, reducible, share", [(1.0, 2.0, 0.5), (2.0, 2.0, 1.0), (3.0, 2.0, 1.0), (-1.0, 2.0, 0.0), (0.0, -1.0, 0.0), (0.1, -1.0, 1.0)]
)
def test_the_share_of_what_is_reducible(removed, reducible, share):
    assert _share(removed, reducible) == share


def test_a_model_without_strengths_or_of_one_run_is_not_unstable():
    assert instability(simulator(), made(1.0)) == 1.0


@pytest.mark.parametrize("by_run, stable", [([1.0, 1.0, 1.0, 1.0], True), ([1.0, 1.0, -1.0, -1.0], False)])
def test_strengths_on_which_two_halves_of_the_runs_disagree_are_unstable(by_run, stable):
    # of four runs the first two are one half, the last two the other
    left = 0.05 * np.array(by_run)[simulator().run]
    found = instability(simulator(), made(left, OUT, (0.1,)))
    assert found < 1e-6 if stable else found > 100.0


def record(samples=100, **known):
    made_up = {"weight": np.ones(samples), "misfit_n": None, "misfit_s": 1.0, "system": "act", "factor": 1, "dt_s": 0.1}
    return SimpleNamespace(**{**made_up, **known})


def search(*records):
    noise = SimpleNamespace(output={"act": SimpleNamespace(white_n=0.5)})
    return SimpleNamespace(noise=noise, sim=SimpleNamespace(problem=SimpleNamespace(records=records)))


@pytest.mark.parametrize(
    "known, alone",
    [
        ({}, 100.0),
        # 1 N^2 beside 0.25 N^2 of noise is four fifths, and stays for 2 x 1 s: 20 samples say what one does
        ({"misfit_n": np.ones(100)}, 100.0 / (1.0 + 0.8 * 19.0)),
        # of means of four readings the noise is a quarter
        ({"misfit_n": np.full(100, 2.0)}, 100.0 / (1.0 + 16.0 / 17.0 * 19.0)),
        ({"misfit_n": np.ones(100), "factor": 4}, 100.0 / (1.0 + 16.0 / 17.0 * 4.0)),
        ({"misfit_n": np.zeros(100)}, 100.0),
        # shorter than a sample
        ({"misfit_n": np.ones(100), "misfit_s": 0.01}, 100.0),
    ],
)
def test_a_slow_known_scatter_says_the_same_for_as_long_as_it_lasts(known, alone):
    assert _independent(search(record(**known)), 100) == round(alone)
    both = _independent(search(record(**known), record()), 200)
    assert both == round(200 * (alone + 100.0) / 200.0)


def test_samples_without_weight_are_none():
    weight = np.repeat([1.0, 0.0], 50)
    assert _independent(search(record(weight=weight, misfit_n=np.ones(100))), 50) == round(50 / (1.0 + 0.8 * 19.0))
    assert _independent(search(record(weight=np.zeros(100))), 0) == 1


def test_the_best_of_each_size_their_parts_and_the_best_without_a_leading_effect_are_examined():
    leaders = [SimpleNamespace(ids=("a", f"{i}")) for i in range(EXAMINED)]
    more = SimpleNamespace(ids=("a", "more"))
    singles = [SimpleNamespace(ids=(name,)) for name in (*"uvwxyz", "a", "last")]
    other = SimpleNamespace(ids=("b", "c"))
    found = _examined([*leaders, more, other, *singles])
    # combinations do not crowd out the single effect that they all contain, nor the six best singles
    assert found[:EXAMINED] == singles[:EXAMINED] and found[EXAMINED : 2 * EXAMINED] == leaders
    assert found[2 * EXAMINED :] == [singles[6], other]


def test_the_tests_of_means_are_picked_by_their_name():
    tests = (Misfit("mean by run", 2.0, 1.0, ""), Misfit("mean by speed", 5.0, 1.0, ""), Misfit("spread by run", 9.0, 1.0, ""))
    assert _means(replace(Leftover(10, 1.0, 0.0, 0.0, 0.0, tests))) == 5.0


GAIN = Hypothesis(("gain_error",), tuple(f for f in full("gain_error", ("act",)).free if f.parameter.name == "g_act"))


def found(*models, combined=()):
    """Return a search on four runs whose base leaves an offset of 0.1 N."""
    sensor = Noise({"act": Sensor(0.01, 0.002, 0.2)}, {"act": Sensor(NOISE_N, 0.01, 0.2)}, {"act": 1.0})
    twice = Noise({"act": Sensor(0.02, 0.004, 0.2)}, {"act": Sensor(2 * NOISE_N, 0.02, 0.2)}, {"act": 1.0})
    base = made(noise() + 0.1)
    return Search(simulator(), sensor, twice, base, {w.ids[0]: (w,) for w in models}, {tuple(sorted(w.ids)): w for w in combined})


def weighed(left, h, values, gain, evidence):
    return Weighed(made(left, h, values), gain, evidence)


def test_the_row_of_the_log_tells_what_base_and_best_model_leave():
    best = weighed(noise(), OUT, (0.1,), 900.0, 890.0)
    other = weighed(noise() + 0.09, GAIN, (1.01,), 20.0, 10.0)
    log = rows(found(other, best)).log
    assert (log.samples, log.systems, log.configurations) == (len(simulator().y), 1, 2)
    # 0.1 N over a noise of 0.02 N
    assert log.base_chi2 == pytest.approx(26.0, rel=0.03) and log.best_chi2 == pytest.approx(1.0, rel=0.05)
    assert log.base_mean_z > 100.0 > log.best_mean_z and log.base_worst_z >= log.base_mean_z
    assert log.coloured == pytest.approx(0.5) and log.noise_ratio == pytest.approx(0.5) and log.propagates == 1.0


@pytest.mark.parametrize("evidence, best_is_base", [(0.1, False), (0.0, True), (-3.0, True)])
def test_a_model_that_is_no_more_evident_than_the_base_is_not_the_best(evidence, best_is_base):
    made_up = rows(found(weighed(noise(), OUT, (0.1,), 1.0, evidence)))
    assert (made_up.best is made_up.base) is best_is_base and (made_up.log.best_chi2 == made_up.log.base_chi2) is best_is_base
    assert rows(found()).best == rows(found()).base


def test_the_row_of_a_candidate_tells_its_share_and_what_it_leaves():
    half = weighed(noise() + 0.1 / np.sqrt(2.0), GAIN, (1.01,), 20.0, 10.0)
    whole = weighed(noise(), OUT, (0.1,), 900.0, 890.0)
    told = {c.ids: c for c in rows(found(half, whole)).candidates}
    assert told[("zero_offset",)].share == pytest.approx(1.0, abs=0.02) and told[("zero_offset",)].chi2 == pytest.approx(1.0, rel=0.05)
    assert told[("gain_error",)].share == pytest.approx(0.5, abs=0.03) and told[("gain_error",)].chi2 == pytest.approx(13.5, rel=0.05)
    assert all(c.kind == "output" and c.strengths == 1 and c.outside == 0 for c in told.values())
    assert [told[i].drop_one for i in told] == [told[i].evidence for i in told]


def test_a_pair_is_worth_what_it_adds_to_the_better_of_its_parts():
    parts = weighed(noise() + 0.05, GAIN, (1.01,), 120.0, 100.0), weighed(noise(), OUT, (0.1,), 900.0, 890.0)
    pair = weighed(noise(), OUT.joined(GAIN), (0.1, 1.01), 920.0, 900.0)
    told = {c.ids: c for c in rows(found(*parts, combined=[pair])).candidates}
    assert told[("gain_error", "zero_offset")].drop_one == pytest.approx(10.0) and told[("gain_error", "zero_offset")].strengths == 2


def test_a_triple_is_compared_with_the_pairs_that_were_fitted():
    parts = weighed(noise() + 0.05, GAIN, (1.01,), 120.0, 100.0), weighed(noise(), OUT, (0.1,), 900.0, 890.0)
    drift = Hypothesis(("zero_drift",), tuple(f for f in full("zero_drift", ("act",)).free if f.parameter.name == "r_out_act_n"))
    pair = weighed(noise(), OUT.joined(GAIN), (0.1, 1.01), 920.0, 900.0)
    triple = weighed(noise(), OUT.joined(GAIN).joined(drift), (0.1, 1.01, 0.0), 940.0, 915.0)
    told = {c.ids: c for c in rows(found(*parts, combined=[pair, triple])).candidates}
    assert told[("gain_error", "zero_drift", "zero_offset")].drop_one == pytest.approx(15.0)


def test_a_strength_at_the_end_of_its_range_is_outside():
    top = OUT.free[0].parameter.high
    (row,) = rows(found(weighed(noise(), OUT, (top,), 900.0, 890.0))).candidates
    assert row.outside == 1


def test_candidates_beside_follow_those_of_the_output():
    beside = replace(rows(found(weighed(noise(), OUT, (0.1,), 900.0, 890.0))).candidates[0], ids=("saturation",), kind="recorder")
    told = rows(found(weighed(noise(), OUT, (0.1,), 900.0, 890.0)), [beside], propagates=0.0)
    assert [c.ids for c in told.candidates] == [("zero_offset",), ("saturation",)] and told.log.propagates == 0.0


def test_what_a_model_may_at_most_remove_of_what_was_held_out():
    """Ten blocks with a gap of 4 each: all of it removed, half, nothing, or half in one block alone; and a gap that is none."""
    gap = np.full(10, 4.0)
    assert _at_most(gap, gap) == pytest.approx(1.0)
    assert _at_most(0.5 * gap, gap) == pytest.approx(0.5)
    assert _at_most(0.0 * gap, gap) == pytest.approx(0.0)
    alone = np.zeros(10)
    alone[3] = 20.0
    # 20 of 40, with a spread over blocks of sqrt((9 * 2^2 + 18^2) * 10 / 9) / 40
    # and the 97.5 % quantile of Student's t with 9 degrees of freedom; one block says nothing
    assert _at_most(alone, gap) == pytest.approx(0.5 + 2.2621572 * 0.5, rel=1e-6) and _at_most(alone[3:4], gap[3:4]) == float("inf")
    assert _at_most(gap, np.linspace(-4.0, 3.9, 10)) == float("inf")
