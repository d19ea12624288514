"""Judging verdicts: hand-made truths and verdicts with known answers."""

from dataclasses import replace

import pytest
from made_truths import made_truth
from scipy.stats import binomtest

from sstl_cli.blind import sides
from sstl_cli.blind.calibration import reliability
from sstl_cli.blind.judge import judge, share, wilson
from sstl_cli.blind.result import Result
from sstl_cli.blind.score import Set, baselines, confusion, document
from sstl_cli.core.documents.blind import CaseDistance


def truth(effects=(), band=1.2, excluded=False, unlisted=(), poor=None, wrong_nominal=False):
    told = {"excluded": excluded, "unlisted": tuple(unlisted), "poor": poor, "wrong_nominal": wrong_nominal}
    return made_truth(effects, band=band, strength=band or 0.0, **told)


def verdict(status, effects=(), group=None, confidence=0.9, baseline=None, shrink=50.0):
    return {
        "seconds": 1.0,
        "diagnosis": {
            "verdict": {
                "status": status,
                "effects": list(effects),
                "ambiguity_group": list(group if group is not None else effects),
                "confidence": confidence,
            },
            "gap": {"shrink_pct": shrink},
            "baselines": {"smallest_rmse": baseline, "iid_bic": baseline},
        },
    }


def case(t, v, name="case-0001", realised=None):
    return judge(name, t, Result(case=name, error=None, model=None, **v), realised)


@pytest.mark.parametrize(
    ("t", "v", "exact", "wrong", "right"),
    [
        (truth(["a"]), verdict("identified", ["a"]), True, False, True),
        (truth(["a"]), verdict("identified", ["b"]), False, True, False),
        (truth(["a"]), verdict("identified", ["a", "b"]), False, True, True),
        (truth(["a"]), verdict("ambiguous", ["b"], ["b", "a"]), False, False, True),
        (truth(["a"]), verdict("ambiguous", ["b"], ["b", "c"]), False, False, False),
        (truth(["a"]), verdict("none"), False, False, False),
        (truth(["a", "b"]), verdict("identified", ["a"]), False, False, False),
        (truth(["a", "b"]), verdict("identified", ["b", "a"]), True, False, True),
        (truth(["a"], excluded=True), verdict("unknown"), False, False, True),
        (truth(["a"], excluded=True), verdict("identified", ["b"]), False, True, False),
        (truth(["hum"], unlisted=["hum"]), verdict("none"), False, False, False),
        (truth(band=None), verdict("none"), False, False, True),
        (truth(band=None), verdict("identified", ["b"]), False, True, False),
        (truth(["a"], band=None, poor="still"), verdict("unknown"), False, False, True),
        (truth(["a"], band=4.0, poor="slow"), verdict("none"), False, False, False),
        (truth(["a"]), verdict("failed", confidence=0.0), False, False, False),
    ],
)
def test_verdict_is_judged(t, v, exact, wrong, right):
    found = case(t, v)
    assert (found.exact, found.wrong_commit, found.right) == (exact, wrong, right)


@pytest.mark.parametrize(
    ("v", "wrong", "right", "recalled"),
    [
        (verdict("unknown"), False, True, True),
        (verdict("identified", ["stuck"]), False, True, True),
        (verdict("ambiguous", ["b"], ["b", "stuck"]), False, True, False),
        (verdict("identified", ["b"]), True, False, False),
        (verdict("none"), False, False, False),
    ],
)
def test_a_disturbance_from_no_list_that_the_catalogue_has_a_name_for_may_be_called_by_it(v, wrong, right, recalled):
    found = case(replace(truth(["disturbance"], unlisted=["sticks"]), also=("stuck",)), v)
    assert (found.wrong_commit, found.right, found.recalled) == (wrong, right, recalled)


@pytest.mark.parametrize(("k", "n"), [(0, 7), (3, 10), (20, 20), (57, 60)])
def test_wilson_agrees_with_scipy(k, n):
    expected = binomtest(k, n).proportion_ci(0.95, "wilson")
    assert wilson(k, n) == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_no_case_is_no_share():
    assert share([]) is None
    assert share([True, False, True]).share == pytest.approx(2 / 3)


def test_verdicts_without_a_confidence_do_not_count_as_stated():
    cases = [
        case(truth(["a"]), verdict("identified", ["a"], confidence=0.8), "c1"),
        case(truth(["a"]), verdict("unknown", confidence=None), "c2"),
    ]
    bins, ece = reliability(cases)
    assert [b.n for b in bins] == [1] and ece == pytest.approx(0.2)
    assert reliability(cases[1:]) == ([], None)
    assert document(cases, sides.compared(cases), Set()).plain()["scores"]["isolation"]["n"] == 2


def test_simulators_stand_side_by_side_and_decidable_cases_apart():
    cases = [
        case(replace(truth(["a"], 4.0), simulator="rig"), verdict("identified", ["a"]), "c1"),
        case(replace(truth(["a"], 4.0), simulator="variant"), verdict("identified", ["b"]), "c2"),
        case(replace(truth(["b"], 4.0), simulator="variant"), verdict("ambiguous", ["c"], ["c", "b"]), "c3"),
        case(replace(truth(band=None), simulator="variant"), verdict("none"), "c4"),
    ]
    told = {c: CaseDistance.model_construct(d2_base=30.0, d2_rival=90.0, decidable=c in ("c1", "c3")) for c in ("c1", "c2", "c3")}
    found = sides.compared(cases, told)
    rows = {r.simulator: r.plain() for r in found.by_simulator}
    assert list(rows) == ["rig", "variant", "all"] and [r["cases"] for r in rows.values()] == [1, 3, 4]
    assert (rows["variant"]["isolation"]["4"]["k"], rows["variant"]["isolation"]["4"]["n"]) == (0, 2)
    assert rows["variant"]["in_group"]["4"]["k"] == 1 and rows["rig"]["scores"]["false_alarm"] is None
    assert rows["all"]["scores"]["wrong_commits"]["k"] == 1
    # where nothing is missing there is nothing to decide: that case stays
    assert [r.cases for r in found.decidable] == [1, 2, 3]
    limit = found.against_limit
    assert (limit.isolation.k, limit.isolation.n, limit.both_of_a_pair) == (1, 2, None) and limit.ideal > 0.97
    # the one that is not decidable was given a wrong name
    assert (limit.undecidable_in_set.k, limit.undecidable_in_set.n) == (0, 1)
    assert sides.compared(cases).decidable is None and [r.cases for r in found.by_d2] == [0, 0, 3, 0, 0, 0]


def test_score_counts_what_was_put_in():
    cases = [
        case(truth(["a"], 4.0), verdict("identified", ["a"], shrink=80.0), "c1", 70.0),
        case(truth(["a"], 1.2), verdict("identified", ["b"], baseline="a"), "c2"),
        case(truth(["b"], 0.4), verdict("ambiguous", ["b"], ["b", "a"]), "c3"),
        case(truth(["b"], None), verdict("none"), "c4"),
        case(truth(band=None), verdict("identified", ["a"], baseline="a"), "c5"),
        case(truth(band=None, wrong_nominal=True), verdict("none"), "c6"),
        case(truth(["a", "b"], 4.0), verdict("identified", ["b", "a"]), "c7"),
        case(truth(["a"], 4.0, excluded=True), verdict("unknown"), "c8"),
        case(truth(["hum"], 1.2, unlisted=["hum"]), verdict("identified", ["b"]), "c9"),
    ]
    body = document(cases, sides.compared(cases), Set()).plain()
    scores = body["scores"]
    assert (scores["isolation"]["k"], scores["isolation"]["n"]) == (1, 2)
    assert (scores["isolation_weak"]["k"], scores["isolation_weak"]["n"]) == (0, 1)
    assert (scores["false_alarm"]["k"], scores["false_alarm"]["n"]) == (1, 2)
    assert (scores["wrong_commits"]["k"], scores["wrong_commits"]["n"]) == (2, 7)
    assert (scores["unknown_recall"]["k"], scores["unknown_recall"]["n"]) == (1, 2)
    assert (scores["both_of_a_pair"]["k"], scores["both_of_a_pair"]["n"]) == (1, 1)
    assert (scores["coverage"]["k"], scores["coverage"]["n"]) == (3, 4)
    assert body["shrink"] == [{"case": "c1", "predicted_pct": 80.0, "realised_pct": 70.0}]
    rows = {r["strength"]: r for r in body["by_strength"]}
    assert set(rows) == {0.4, 1.2, 4.0, None}
    assert rows[4.0]["isolation"]["n"] == 1 and rows[None]["false_alarm"]["n"] == 2
    assert "isolation" not in rows[None] and "false_alarm" not in rows[4.0]
    misses = {e["effect"]: [m["case"] for m in e["misses"]] for e in body["by_effect"]}
    assert misses == {"a": ["c2"], "b": ["c3", "c4"]}


def test_confusion_holds_every_case_once():
    cases = [
        case(truth(["a"]), verdict("identified", ["b"])),
        case(truth(["a"]), verdict("ambiguous", ["b"], ["b", "a"])),
        case(truth(["a"]), verdict("ambiguous", ["a"], ["b", "a"])),
        case(truth(["a", "b"]), verdict("identified", ["a", "c"])),
        case(truth(band=None), verdict("unknown")),
        case(truth(["a"], poor="slow"), verdict("none")),
    ]
    found = confusion(cases).plain()
    cells = {
        (r, c): n for r, row in zip(found["labels"], found["matrix"], strict=True) for c, n in zip(found["columns"], row, strict=True) if n
    }
    assert cells == {("a", "b"): 1, ("a", "ambiguous"): 1, ("a", "a"): 1, ("pair", "other pair"): 1, ("none", "unknown"): 1}


def test_baselines_stand_beside_each_strength():
    cases = [
        case(truth(["a"], 4.0), verdict("none", baseline="a"), "c1"),
        case(truth(["a"], 0.4), verdict("none", baseline="b"), "c2"),
        case(truth(band=None), verdict("none", baseline="b"), "c3"),
    ]
    rows = {r.name: r.plain() for r in baselines(cases)}
    assert rows["smallest RMSE at 4"]["isolation"]["k"] == 1
    assert rows["smallest RMSE at 0.4"]["wrong_commits"]["k"] == 1
    assert rows["iid BIC at 4"]["false_alarm"]["k"] == 1
    assert rows["always none at 4"]["false_alarm"]["k"] == 0
    assert not any("1.2" in name for name in rows)


def test_reasons_of_misses_are_counted_and_ties_go_by_name():
    cases = [
        case(truth(["a"]), verdict("ambiguous", ["a"], ["a", "z", "y", "x", "w"])),
        case(truth(["a"]), verdict("failed", confidence=0.0), "case-0002"),
        case(truth(["a"]), verdict("ambiguous", ["a"], ["a", "y"]), "case-0003"),
        case(truth(["a"]), verdict("identified", ["a"]), "case-0004"),
        case(truth(["a"]), verdict("ambiguous", ["a"], ["a"]), "case-0005"),
    ]
    (row,) = document(cases, sides.compared(cases), Set()).plain()["by_effect"]
    assert row["reason"] == "2 as well explained by y, w, x; 1 the diagnosis ended with an error; 1 named alone, but not surely"
