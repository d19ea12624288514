"""Libraries and what is learned from them: hand-made rows with known answers."""

import json
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_truths import made_truth

from sstl_cli import __version__
from sstl_cli.blind.library import LIBRARY, facts_of, labelled, read_library, to_table, without, write_library
from sstl_cli.blind.schedule import KINDS, Entry, Job, jobs
from sstl_cli.blind.simulators import NAMES
from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import open_table
from sstl_cli.core.provenance import Provenance, sha256
from sstl_cli.diagnosis.features import CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import probabilities, verdict
from sstl_cli.diagnosis.weights import from_document
from sstl_cli.steps import blind_learn, blind_library

EFFECTS = ("viscous", "slack", "presliding", "zero_offset")


def rows(true, rng):
    """Return rows in which the true effect is clearly the most evident one (None: nothing is)."""
    gains = {e: float(rng.uniform(0.0, 3.0)) for e in EFFECTS}
    if true:
        gains[true] = float(rng.uniform(60.0, 90.0))
    left = {e: 1.0 if e == true or not true else 1.6 for e in EFFECTS}
    candidates = tuple(
        CandidateRow(
            (e,),
            "output",
            1,
            g,
            g - 4.0,
            g - 4.0,
            left[e],
            1.0 if left[e] == 1.0 else 20.0,
            1.0,
            0,
            1.0,
            1.0,
            None if e == "slack" else 0.75,
        )
        for e, g in gains.items()
    )
    loud = 1.6 if true else 1.0
    log = LogRow(4000, 2, 2, loud, 20.0 if true else 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 0.0, 0.2, 1.0, 1.0)
    nothing = Leftover(4000, 1.0, 0.0, 3.0, 0.0, (Misfit("mean over phase", 1.0, 0.0, ""),))
    return Rows(log, candidates, nothing, nothing)


def truth_of(effects, simulator="rig", kind="single", strength=1.2, **more):
    return made_truth(effects, simulator=simulator, kind=kind, strength=strength, **more)


def many(n, seed=1):
    rng = np.random.default_rng(seed)
    for i in range(n):
        true = (*EFFECTS, None, None)[i % 6]
        simulator = NAMES[i % 7 % 3]
        kind, strength = ("single", float(rng.choice([0.4, 1.2, 4.0]))) if true else ("none", 0.0)
        yield labelled(f"{simulator}-{i}", truth_of([true] if true else [], simulator, kind, strength), rows(true, rng))


def save(path, cases, seeds=((7, 99),)):
    cases = list(cases)
    facts = {"cases": len(cases), "failed": 0, "simulators": ["rig"], "seeds": [list(s) for s in seeds], "quick": True}
    write_library(path, to_table(cases), Provenance("sstl blind library", None, {}, facts), force=True)
    return path


def test_a_library_gives_back_what_was_put_in(tmp_path):
    cases = list(many(12))
    found = read_library(save(tmp_path / "l.parquet", cases))
    assert [(e.name, e.simulator, e.kind, e.answer) for e in found] == [(c.name, c.simulator, c.kind, c.answer) for c in cases]
    for e, c in zip(found, cases, strict=True):
        assert [x.ids for x in e.rows.candidates] == [x.ids for x in c.rows.candidates]
        for a, b in zip((e.rows.log, *e.rows.candidates), (c.rows.log, *c.rows.candidates), strict=True):
            for name in vars(b):
                exact = name in ("ids", "kind") or getattr(b, name) is None
                assert getattr(a, name) == (getattr(b, name) if exact else pytest.approx(getattr(b, name), rel=1e-6))
    assert facts_of(tmp_path / "l.parquet").seeds == [[7, 99]]


def test_a_case_searched_without_its_effect_stands_for_those_of_which_nobody_can_say_it(tmp_path):
    rng = np.random.default_rng(0)
    whole = labelled("a", truth_of(["slack"]), rows("slack", rng))
    less = without(whole)
    assert (less.name, less.kind, less.answer) == ("a-without", "without", ("?",)) and less.simulator == whole.simulator
    # what could not be told, and what has no name anyway
    assert without(replace(whole, rows=rows(None, rng))) is None and without(replace(whole, answer=("?",))) is None
    drawn = labelled("b", truth_of(["stribeck"], kind="excluded", excluded=True), rows(None, rng))
    found = read_library(save(tmp_path / "l.parquet", [whole, less, drawn, replace(less, name="c-without")]))
    taught = blind_learn.told(found)
    assert [e.kind for e in taught] == ["single", "without"] and taught[1].answer == ("?",)
    # of older libraries it is taken out of the evidence
    old = blind_learn.told([e for e in found if e.kind != "without"])
    assert [e.name for e in old] == ["a", "a-without"]


def test_a_case_whose_effect_is_clear_is_searched_again_without_it(monkeypatch):
    case = SimpleNamespace(sim=None, exclude=("viscous",), runs=[], truth=truth_of(["slack"], "bristle"))
    asked = []

    def evidence(runs, options):
        asked.append(options.exclude)
        return SimpleNamespace(rows=rows(None if "slack" in options.exclude else "slack", np.random.default_rng(1)))

    monkeypatch.setattr(blind_library, "draw_job", lambda job: case)
    monkeypatch.setattr("sstl_cli.diagnosis.gathering.gather", evidence)
    found = blind_library.gather(Job(Entry("single", ("slack",), 4.0), 77, "bristle", True))
    assert asked == [("viscous",), ("slack", "viscous")]
    assert [(c.name, c.kind, c.answer) for c in found] == [("bristle-77", "single", ("slack",)), ("bristle-77-without", "without", ("?",))]
    assert found[1].rows.log.base_worst_z == 1.0


def test_cases_that_teach_nothing_stay_out_of_the_examples(tmp_path):
    rng = np.random.default_rng(0)
    cases = [
        labelled("a", truth_of(["slack"]), rows("slack", rng)),
        labelled("hidden", truth_of(["slack"], strength=0.05), rows(None, rng)),
        labelled("poor", truth_of(["slack"], kind="poor", poor="still"), rows(None, rng)),
        labelled("no-candidate", truth_of(["stribeck"]), rows(None, rng)),
        labelled("excluded", truth_of(["stribeck"], kind="excluded", excluded=True), rows(None, rng)),
        labelled("pair", truth_of(["slack", "viscous"], kind="pair"), rows("slack", rng)),
    ]
    found = read_library(save(tmp_path / "l.parquet", cases))
    # what no row tells teaches nothing, and counts in how often a verdict is right
    assert [e.name for e in found] == ["a", "no-candidate", "excluded", "pair"]
    assert [e.name for e in blind_learn.told(found)] == ["a", "a-without"]
    with pytest.raises(SstlError, match="E955"):
        read_library(save(tmp_path / "m.parquet", cases[1:3]))


def test_learned_weights_name_what_is_clear_and_say_where_they_come_from(tmp_path):
    weights, report = blind_learn.run([save(tmp_path / "l.parquet", many(180))], "w.json")
    assert weights["provenance"]["package_version"] == __version__
    assert weights["provenance"]["seeds"] == [[7, 99]] and weights["provenance"]["simulators"] == sorted(NAMES)
    assert [r.simulator for r in report.left_out] == [*sorted(NAMES), "all"]
    every = report.left_out[-1].plain()
    assert every["cases"] == 180
    assert every["false_alarm"]["share"] < 0.1 and every["wrong_commits"]["share"] < 0.05
    assert all(r["share"] > 0.8 for r in every["exact"].values())
    used = from_document(json.loads(json.dumps(weights)))
    fresh = rows("presliding", np.random.default_rng(99))
    assert verdict(fresh, used).effects == ("presliding",)
    assert verdict(rows(None, np.random.default_rng(98)), used).status == "none"


def test_one_simulator_is_too_few_to_learn_from(tmp_path):
    alone = [replace(c, simulator="rig") for c in many(80)]
    with pytest.raises(SstlError, match="E955"):
        blind_learn.run([save(tmp_path / "l.parquet", alone)], "w.json")


def test_simulators_are_dealt_in_turn_within_each_kind():
    found = jobs(90, 5, "mixed")
    assert [j.seed for j in found] == list(range(5, 95))
    for kind in KINDS:
        counts = Counter(j.simulator for j in found if j.entry.kind == kind)
        assert max(counts.values()) - min(counts.get(n, 0) for n in NAMES) <= 1
    assert {j.simulator for j in jobs(9, 5, "bristle")} == {"bristle"}
    assert [j.entry for j in found] == [j.entry for j in jobs(90, 5, "rig")]


def gathered(asked):
    def gather(job):
        asked.append(job.seed)
        if job.seed == 12:
            raise SstlError("no bench", code="E950")
        truth = truth_of(["slack"], job.simulator, "single", 1.2)
        return [labelled(f"{job.simulator}-{job.seed}", truth, rows("slack", np.random.default_rng(job.seed)))]

    return gather


def test_an_interrupted_library_goes_on_and_ends_with_the_same_bytes(tmp_path):
    out, whole, asked = tmp_path / "l.parquet", tmp_path / "w.parquet", []

    def stops(job):
        if len(asked) == 3:
            raise KeyboardInterrupt
        return gathered(asked)(job)

    with pytest.raises(KeyboardInterrupt):
        blind_library.run(out, blind_library.Options(6, 10, "mixed", True), gatherer=stops)
    assert not out.exists() and asked == [10, 11, 12]
    with pytest.raises(SstlError, match="E956"):
        blind_library.run(out, blind_library.Options(7, 10, "mixed", True), gatherer=gathered(asked))
    made = blind_library.run(out, blind_library.Options(6, 10, "mixed", True), gatherer=gathered(asked))
    assert asked == [10, 11, 12, 13, 14, 15] and not out.with_name("l.parquet.parts").exists()
    assert (made.cases, made.failed, made.seeds) == (5, 1, [[10, 15]])
    blind_library.run(whole, blind_library.Options(6, 10, "mixed", True), gatherer=gathered([]))
    assert sha256(out) == sha256(whole)
    assert len(read_library(out)) == 5
    with pytest.raises(SstlError):
        blind_library.run(out, blind_library.Options(6, 10, "mixed", True), gatherer=gathered([]))


def test_strengths_are_those_asked_for():
    found = {j.entry.strength for j in jobs(90, 5, "rig", strengths=(12.0, 40.0))}
    assert found == {0.0, 12.0, 40.0}


@pytest.mark.slow
def test_a_drawn_case_is_searched_and_kept(tmp_path):
    job = Job(Entry("single", ("zero_offset",), 4.0), 77, "variant", True)
    case = blind_library.gather(job)[0]
    assert (case.simulator, case.answer) == ("variant", ("zero_offset",))
    save(tmp_path / "l.parquet", [case])
    assert open_table(tmp_path / "l.parquet", LIBRARY).rows == len(case.rows.candidates)
    (found,) = read_library(tmp_path / "l.parquet")
    best = max(found.rows.candidates, key=lambda c: c.evidence)
    assert best.evidence > 0 and found.answer in {c.ids for c in found.rows.candidates}


def test_cases_beside_an_accepted_model_have_weights_of_their_own(tmp_path):
    plain = save(tmp_path / "l.parquet", many(180))
    # beside an accepted model half of what has evidence is nothing: the same numbers mean something else there
    other = [replace(c, answer=()) if i % 2 and c.answer else c for i, c in enumerate(many(180, seed=4))]
    path = tmp_path / "a.parquet"
    facts = {"cases": 180, "failed": 0, "simulators": ["rig"], "seeds": [[500, 679]], "quick": True, "accepted": True}
    write_library(path, to_table(other), Provenance("sstl blind library", None, {}, facts), force=True)
    alone, _ = blind_learn.run([plain], "w.json")
    both, report = blind_learn.run([path, plain], "w.json")
    assert "known" not in alone and {k: v for k, v in both.items() if k != "known"} == alone
    assert both["known"]["provenance"]["seeds"] == [[500, 679]] and report.accepted[-1].cases == 180
    used = from_document(json.loads(json.dumps(both)))
    assert used.known is not None and sorted(used.seeds) == [(7, 99), (500, 679)]
    fresh = rows("presliding", np.random.default_rng(99))
    assert probabilities(fresh, used.known)[()] > probabilities(fresh, used)[()]
