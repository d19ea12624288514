"""What a stated confidence is worth: verdicts with known answers, and what chance makes of a few hundred of them."""

import numpy as np
import pytest
from made_truths import made_truth
from sklearn.linear_model import LogisticRegression

from sstl_cli.blind.calibration import calibrated, chance, reliability, slope
from sstl_cli.blind.judge import Judged, share
from sstl_cli.blind.targets import targets
from sstl_cli.core.documents.blind import AgainstLimit, Scores


def said(confidence, right, case="c"):
    name = "a" if right else "b"
    return Judged(case, made_truth(["a"]), "identified", (name,), (name,), confidence, 1.0, {}, None, None)


def drawn(n, true_slope, seed=3):
    """Return stated confidences, and draws that are right with the logit ``true_slope`` times as large."""
    rng = np.random.default_rng(seed)
    stated = rng.uniform(0.3, 0.98, n)
    logit = true_slope * np.log(stated / (1.0 - stated))
    return stated, (rng.random(n) < 1.0 / (1.0 + np.exp(-logit))).astype(float)


def test_reliability_of_a_liar():
    # always 0.95 sure and right in half of the cases: the error is 0.45
    bins, ece = reliability([said(0.95, i % 2 == 0) for i in range(20)])
    assert ece == pytest.approx(0.45)
    assert [b.n for b in bins] == [20]
    assert bins[0].share_right == 0.5


def test_chance_alone_shows_an_error_that_falls_with_the_cases():
    # one bin: the error is |k / n - 0.5|, whose mean is sqrt(2 / pi) times its standard deviation
    mean, most = chance(np.full(400, 0.5))
    assert mean == pytest.approx(np.sqrt(2.0 / np.pi) * 0.025, rel=0.05)
    assert most == pytest.approx(1.96 * 0.025, rel=0.05)
    assert chance(np.full(100, 0.5))[0] == pytest.approx(2.0 * mean, rel=0.1)
    assert chance(np.full(400, 0.5)) == (mean, most)
    assert chance(np.empty(0)) == (None, None)


def test_the_slope_is_that_of_a_logistic_regression():
    stated, right = drawn(500, 0.7)
    found, low, high = slope(stated, right)
    logit = np.log(stated / (1.0 - stated))[:, None]
    expected = LogisticRegression(C=np.inf, tol=1e-10, max_iter=1000).fit(logit, right).coef_[0, 0]
    assert found == pytest.approx(expected, rel=1e-4)
    assert low < 0.7 < high and found == pytest.approx((low + high) / 2.0)


def test_the_interval_of_the_slope_holds_the_truth():
    hits = 0
    for seed in range(200):
        _, low, high = slope(*drawn(300, 1.0, seed))
        hits += low <= 1.0 <= high
    assert 180 <= hits <= 198


@pytest.mark.parametrize(
    ("stated", "right"), [([0.6, 0.8, 0.9], [1, 1, 1]), ([0.6, 0.8], [0, 0]), ([0.6, 0.7, 0.9], [0, 0, 1]), ([0.8, 0.8], [0, 1]), ([], [])]
)
def test_what_lies_apart_has_no_slope(stated, right):
    assert slope(np.array(stated, float), np.array(right, float)) is None


def test_a_row_says_all_of_it():
    row = calibrated("all", [said(0.9, True), said(0.6, False), said(0.7, True), said(0.8, False), said(None, True)])
    assert (row.cases, row.n, row.right) == ("all", 4, 0.5) and row.stated == pytest.approx(0.75)
    assert row.ece_chance < row.ece_chance_95 and row.slope_low < row.slope < row.slope_high
    empty = calibrated("none", [])
    assert (empty.n, empty.stated, empty.ece, empty.ece_chance, empty.slope) == (0, None, None, None, None)


EMPTY = dict.fromkeys(("isolation", "isolation_weak", "wrong_commits", "unknown_recall", "both_of_a_pair", "coverage"))


def test_targets_without_cases_are_neither_met_nor_missed():
    scores = Scores(**{**EMPTY, "false_alarm": share([False] * 49 + [True]), "ece": 0.2})
    met = {t.id: t.met for t in targets(scores)}
    assert met["false_alarm"] is True and met["ece"] is False
    assert met["isolation"] is None and met["coverage"] is None and met["slope"] is None


@pytest.mark.parametrize(("ece", "chance_95", "met"), [(0.05, 0.06, True), (0.07, 0.06, False), (0.025, 0.02, True), (0.04, None, False)])
def test_an_error_no_larger_than_chance_meets_its_target(ece, chance_95, met):
    found = {t.id: t for t in targets(Scores(**EMPTY, false_alarm=None, ece=ece, ece_chance=chance_95))}
    assert (found["ece"].met, found["ece"].chance, found["ece"].target) == (met, chance_95, 0.03)


def test_targets_of_what_could_be_decided_and_of_the_slope():
    calibration = calibrated("all", [said(0.9, True), said(0.6, False), said(0.7, True), said(0.8, False)])
    limit = AgainstLimit(
        isolation=share([True] * 19 + [False]),
        unknown_recall=None,
        both_of_a_pair=share([False]),
        ideal=0.99,
        undecidable_in_set=share([True]),
    )
    found = {t.id: t for t in targets(Scores(**EMPTY, false_alarm=None, ece=None, slope=1.09), calibration, limit)}
    assert found["slope"].met is True and found["slope"].high == calibration.slope_high
    met = {i: t.met for i, t in found.items() if i.startswith("limit_")}
    assert met == {
        "limit_isolation": True,
        "limit_unknown_recall": None,
        "limit_unknown_recall_joined": None,
        "limit_both_of_a_pair": False,
        "limit_undecidable_in_set": True,
    }
    assert (found["limit_isolation"].k, found["limit_isolation"].n) == (19, 20)
