"""When two verdicts say different things, and by how much they differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.diagnosis import odd
from sstl_cli.diagnosis.odd import differs
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED, NOTHING, Verdict
from sstl_cli.diagnosis.wander import turned
from sstl_cli.diagnosis.whitening import white


def said(status, effects, *group, **probabilities):
    return Verdict(status, effects, None, group, {(k,): v for k, v in probabilities.items()}, "")


A, B, C = ("a",), ("b",), ("c",)


@pytest.mark.parametrize(
    ("one", "other", "differ"),
    [
        (said(AMBIGUOUS, A, A, B), said(AMBIGUOUS, B, B, A), False),
        # each has to hold what the other puts first
        (said(AMBIGUOUS, A, A, B), said(AMBIGUOUS, B, B, C), True),
        (said(AMBIGUOUS, A, A, C), said(AMBIGUOUS, B, B, A), True),
        (said(AMBIGUOUS, A, A, B), said(AMBIGUOUS, C, C), True),
        (said(IDENTIFIED, A, A), said(AMBIGUOUS, A, A, B), True),
        (said(IDENTIFIED, ("a", "b")), said(IDENTIFIED, ("b", "a")), False),
        (said(IDENTIFIED, A), said(IDENTIFIED, B), True),
        (said(NOTHING, ()), said(NOTHING, ()), False),
    ],
)
def test_verdicts_differ_in_what_they_say_and_not_in_what_comes_first(one, other, differ):
    assert differs(one, other) is differ


def test_verdicts_are_as_far_apart_as_their_probabilities():
    assert odd._moved(said(IDENTIFIED, A, a=0.7, b=0.3), said(IDENTIFIED, A, a=0.2, c=0.8)) == pytest.approx(0.8)
    assert odd._moved(said(IDENTIFIED, A, a=1.0), said(IDENTIFIED, A, a=1.0)) == 0.0


def test_tests_fall_as_the_excess_over_chance_does_without_a_run():
    left = odd._Left(np.zeros(3), np.array([150.0, 75.0, 400.0]), 300.0)
    # 200 more than chance in all: of 75 samples that are left 75, none, and more than there were
    assert [odd._calmer(left, i, 75.0, 100.0) for i in range(3)] == pytest.approx([0.375, 0.0, 1.0])
    assert odd._calmer(odd._Left(np.zeros(1), np.array([50.0]), 90.0), 0, 75.0, 100.0) == 1.0


def test_the_log_determinant_without_a_run_counts_what_is_known_to_vary():
    rng = np.random.default_rng(3)
    runs = [slice(0, 20), slice(20, 50), slice(50, 60)]
    stretches = [slice(0, 12), slice(12, 20), slice(20, 50), slice(50, 60)]
    alone = white(0.5, np.ones(60), [0, 20, 50])
    often, whole = rng.standard_normal((60, 2)), rng.standard_normal((60, 3))
    every = np.arange(60)
    turns = (turned(often, [every[s] for s in stretches]), turned(whole, [slice(0, len(every))]))
    whiten = replace(alone, known=turns, log_det=alone.log_det + sum(t.log_det for t in turns))

    def log_det(kept):
        within = np.eye(60) + sum(
            (p := np.where((np.arange(60) >= s.start) & (np.arange(60) < s.stop), 1.0, 0.0)[:, None] * often) @ p.T for s in stretches
        )
        return sum(np.linalg.slogdet(c[np.ix_(kept, kept)])[1] for c in (0.25 * np.eye(60), within, np.eye(60) + whole @ whole.T))

    everything = np.arange(60)
    assert whiten.log_det == pytest.approx(log_det(everything))
    without = [log_det(np.delete(everything, s)) for s in runs]
    assert whiten.log_det - odd._log_dets(whiten, runs) == pytest.approx(without)


def test_the_log_determinant_without_a_run_counts_its_jerks():
    rng = np.random.default_rng(4)
    runs = [slice(0, 20), slice(20, 60)]
    whiten = white(0.5, np.ones(60), [0, 20])
    heavy = whiten.trusting(rng.standard_t(3, 60), np.full(60, 3.0))
    more = [heavy.log_det - odd._log_dets(heavy, runs)[i] - (whiten.log_det - odd._log_dets(whiten, runs)[i]) for i in (0, 1)]
    assert more == pytest.approx([heavy.beyond[20:].sum(), heavy.beyond[:20].sum()]) and abs(more[0]) > 0.1
