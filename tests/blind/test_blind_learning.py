"""Weights learned from a library made by hand: what separates its cases is found, and promises are kept."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_truths import made_truth

from sstl_cli.blind.learning import (
    AGAINST,
    FOR,
    Example,
    _reliability,
    _temper,
    answerable,
    calibrated,
    examples,
    is_right,
    judged_by,
    learn,
    left_out,
    right_answer,
    to_document,
    without_answer,
)
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.features import OUTPUT, RECORDER, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import CANDIDATE_TERMS, probabilities, verdict
from sstl_cli.diagnosis.weights import from_document

EFFECTS = ("pulley_friction", "viscous", "gain_error", "zero_offset", "crosstalk")
SIMULATORS = ("one", "two", "three")
LEFT = Leftover(5000, 1.0, 0.0, 0.0, 0.0, (Misfit("mean by run", 0.5, 0.3, "0"),))
QUIET = LogRow(5000, 2, 3, 1.0, 1.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0)


def row(effect, evidence, chi2, worst):
    return CandidateRow((effect,), OUTPUT, 1, evidence + 4.0, evidence, evidence, chi2, worst, worst, 0, 1.0, 1.0)


def case(kind, simulator, rng, name="x"):
    """A case whose answer is plain: one effect explains all, nothing is left to explain, or nothing explains it."""
    answer = EFFECTS[rng.integers(len(EFFECTS))]
    gap = float(np.exp(rng.uniform(4.0, 8.0)))
    base = 1.0 + gap / 2500.0
    candidates = []
    for e in EFFECTS:
        if kind == "none":
            candidates.append(row(e, rng.normal(-2.0, 0.7), 1.0, 1.0))
        elif kind == "single" and e == answer:
            candidates.append(row(e, gap, 1.0, rng.uniform(0.0, 3.0)))
        else:
            share = rng.uniform(0.0, 0.5 if kind == "single" else 0.2)
            candidates.append(row(e, share * gap, 1.0 + (1.0 - share) * (base - 1.0), 0.3 * gap))
    best = max(candidates, key=lambda c: c.evidence)
    log = QUIET
    if kind != "none":
        log = replace(QUIET, base_chi2=base, base_worst_z=0.4 * gap, base_mean_z=0.3 * gap, best_chi2=best.chi2,
                      best_worst_z=best.worst_z, best_mean_z=best.mean_z)  # fmt: skip
    right = {"single": (answer,), "none": NONE, "unlisted": UNKNOWN}[kind]
    return Example(name, simulator, kind, 0.0 if kind == "none" else 1.0, Rows(log, tuple(candidates), LEFT, LEFT), right)


@pytest.fixture(scope="module")
def library():
    rng = np.random.default_rng(1)
    kinds = ("single", "single", "none", "unlisted")
    return examples(case(kinds[i % 4], s, rng, f"{s}-{i}") for s in SIMULATORS for i in range(24))


@pytest.fixture(scope="module")
def others(library):
    return left_out(library)


def test_the_answer_of_a_simulator_that_was_left_out_is_found(library, others):
    assert set(others) == set(SIMULATORS) and len(library) == 72
    p = [probabilities(e.rows, others[e.simulator])[e.answer] for e in library]
    assert np.mean(np.array(p) > 0.5) > 0.95
    assert -np.mean(np.log(p)) < 0.25


def test_a_left_out_simulator_is_not_learned_from(library, others):
    without = [e for e in library if e.simulator != "two"]
    assert others["two"] == learn(without) and others["two"] != learn(library)


def test_thresholds_keep_wrong_commits_few_and_sets_cover(library, others):
    judged = judged_by(library, others)
    weights = calibrated(judged, learn(library), judged)
    assert 0.5 <= weights.commit < 1.0 and 0.5 <= weights.cover < 1.0
    said = [(e, verdict(e.rows, replace(others[e.simulator], commit=weights.commit, cover=weights.cover))) for e in library]
    committed = [is_right(e, v) for e, v in said if v.status == "identified"]
    assert len(committed) > 20 and sum(not r for r in committed) <= 0.02 * len(library) + 1
    assert set(weights.reliability) == {"identified", "ambiguous", "unknown", "none"}
    for rows in weights.reliability.values():
        values = [b for _, b in rows]
        assert values and values == sorted(values) and all(0.0 < v < 1.0 for v in values)


def test_a_library_of_coin_flips_is_not_committed_to(library):
    rng = np.random.default_rng(2)
    mixed = [replace(e, answer=(EFFECTS[rng.integers(5)],)) if e.kind == "single" else e for e in library]
    judged = judged_by(mixed, left_out(mixed))
    weights = calibrated(judged, learn(mixed), judged)
    sure = [e for e in mixed if e.kind == "single" and verdict(e.rows, weights).status == "identified"]
    assert len(sure) < 0.2 * sum(e.kind == "single" for e in mixed)


def test_more_evidence_never_speaks_against_a_candidate(library):
    """Here the answer is always the candidate that is furthest behind and leaves most."""
    last = [replace(e, answer=min(e.rows.candidates, key=lambda c: c.evidence).ids) if e.kind == "single" else e for e in library]
    own = learn(last).candidate
    assert FOR | AGAINST <= set(own) == set(CANDIDATE_TERMS)
    assert all(own[t] >= 0.0 for t in FOR) and all(own[t] <= 0.0 for t in AGAINST) and own["rank"] == own["log_behind_0"] == 0.0


def test_weights_survive_their_document(library):
    weights = learn(library, {"cases": len(library)})
    assert from_document(json.loads(json.dumps(to_document(weights)))) == weights


@pytest.mark.parametrize(
    ("change", "answer"),
    [
        ({"effects": ("b", "a")}, ("a", "b")),
        ({"effects": ()}, NONE),
        ({"unlisted": ("x",)}, UNKNOWN),
        ({"unlisted": ("x",), "also": ("b", "a")}, ("a", "b")),
        ({"excluded": True}, UNKNOWN),
    ],
)
def test_what_should_be_said(change, answer):
    assert right_answer(made_truth(**{"effects": ("viscous",), **change})) == answer


def test_what_is_stated_counts_causes_that_nobody_could_tell(library, others):
    """A cause that is no candidate and looks like one in every number: the same rows with another answer."""
    judged = [*judged_by(library, others)] * 4
    hidden = [(replace(e, answer=UNKNOWN), p) for e, p in judged if e.kind == "single"]
    plain, drawn = (calibrated(judged, learn(library), part) for part in (judged, [*judged, *hidden]))
    assert drawn.commit > plain.commit
    stated, honest = (max(b for _, b in w.reliability["identified"]) for w in (plain, drawn))
    assert stated > 0.9 and honest < 0.7


@pytest.mark.parametrize("change", [{"kind": "poor"}, {"strength": 0.05}])
def test_cases_that_say_nothing_are_left_out(change):
    one = case("single", "one", np.random.default_rng(0))
    assert len(examples([one])) == 1
    assert examples([replace(one, **change)]) == []


def test_what_no_row_tells_counts_and_teaches_nothing():
    one = case("single", "one", np.random.default_rng(0))
    assert answerable(one) and not answerable(replace(one, answer=("stick_slip",)))
    assert len(examples([replace(one, answer=("stick_slip",))])) == 1


def test_taking_the_answer_away_makes_it_unknown(library):
    single = next(e for e in library if e.kind == "single")
    other = without_answer(single)
    assert other is not None and other.answer == UNKNOWN
    assert all(single.answer != c.ids for c in other.rows.candidates) and len(other.rows.candidates) == 4
    assert without_answer(next(e for e in library if e.kind == "none")) is None
    assert without_answer(replace(single, strength=0.3)) is None
    # what a fault of the recorder has hurt is masked whether or not it may be named
    hurt = tuple(replace(c, kind=RECORDER) if c.ids == single.answer else c for c in single.rows.candidates)
    assert without_answer(replace(single, rows=replace(single.rows, candidates=hurt))) is None


def test_right_is_the_truth_in_the_set_or_the_right_no():
    rows = case("single", "one", np.random.default_rng(0)).rows
    said = verdict(rows, learn(examples([case("single", "one", np.random.default_rng(0))])))
    one = Example("x", "one", "single", 1.0, rows, ("viscous",))
    group = replace(said, status="ambiguous", effects=("viscous",), group=(("viscous",), ("crosstalk",)))
    assert is_right(one, group) and not is_right(replace(one, answer=("gain_error",)), group)
    assert not is_right(replace(one, answer=NONE), group)
    nothing = replace(said, status="none", effects=(), group=())
    assert is_right(replace(one, answer=NONE), nothing) and not is_right(replace(one, answer=UNKNOWN), nothing)
    assert is_right(replace(one, answer=UNKNOWN), replace(nothing, status="unknown"))


def test_what_shows_is_where_next_to_nothing_is_taken_for_nothing(library, others):
    """Effects that gained up to 20 nats were called nothing, those that gained more never."""
    judged = judged_by(library, others)
    singles = [(e, p) for e, p in judged if e.kind == "single"]
    made = []
    for k, gain in enumerate(np.linspace(1.0, 60.0, 60)):
        e, p = singles[k % len(singles)]
        candidates = tuple(replace(c, gain=gain) if c.ids == e.answer else c for c in e.rows.candidates)
        rest = dict.fromkeys(p, 0.0)
        made.append((replace(e, rows=replace(e.rows, candidates=candidates)), {**rest, (NONE if gain < 20.0 else e.answer): 1.0}))
    assert calibrated(judged, learn(library), made).shows_d2 == pytest.approx(40.0, abs=2.0)


def test_a_level_of_few_verdicts_is_stated_as_few_can_tell():
    """Sixty verdicts: of forty at 0.6 half are right, of twenty at 0.9 all: the rule of succession says 21/42 and 21/22."""
    said = [(SimpleNamespace(answer=NONE), SimpleNamespace(status="none" if right else "unknown", confidence=p))
            for p, right in [(0.6, i % 2) for i in range(40)] + [(0.9, 1)] * 20]  # fmt: skip
    rows = dict(_reliability(said))
    assert rows[0.6] == pytest.approx(0.5) and rows[0.9] == pytest.approx(21 / 22, abs=1e-4)


@pytest.mark.parametrize("sure", [0.5, 1.0])
def test_odds_that_are_too_sure_are_tempered(sure):
    rng = np.random.default_rng(3)
    judged = []
    for i, (named, none) in enumerate(zip(rng.uniform(0.05, 0.9, 4000), rng.uniform(0.05, 0.9, 4000), strict=True)):
        true = np.array([named, none, 0.2]) / (named + none + 0.2)
        stated = true ** (1.0 / sure) / np.sum(true ** (1.0 / sure))
        answer = [("viscous",), NONE, UNKNOWN][rng.choice(3, p=true)]
        judged.append((SimpleNamespace(name=str(i), answer=answer), {("viscous",): stated[0], NONE: stated[1], UNKNOWN: stated[2]}))
    assert _temper(judged) == pytest.approx(sure, rel=0.08)
