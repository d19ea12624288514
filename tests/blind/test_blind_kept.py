"""What a result keeps of a diagnosis: the rows that other weights can judge the case by."""

import json
from dataclasses import replace

import pytest
from made_truths import made_truth

from sstl_cli.blind import folder as files
from sstl_cli.blind import kept
from sstl_cli.blind.judge import by_others, judge
from sstl_cli.blind.result import SCHEMA, Result
from sstl_cli.blind.score import Set
from sstl_cli.blind.seal import Planned
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.diagnosis.features import CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.residuals import Leftover, Misfit
from sstl_cli.diagnosis.verdict import verdict
from sstl_cli.diagnosis.weights import learned
from sstl_cli.steps import blind_score


def rows(gain: float = 400.0, barred=None) -> Rows:
    """Return rows in which the spring is what the log shows, and the slack a tenth of it."""
    own = CandidateRow(("load_spring",), "output", 1, gain, gain - 5.0, gain - 5.0, 1.0, 1.0, 1.0, 0, 1.0, 1.0, float("inf"))
    other = CandidateRow(("slack",), "output", 1, 0.1 * gain, 0.1 * gain - 5.0, 0.1 * gain - 5.0, 1.5, 20.0, 9.0, 1, 1e9, 0.2, None)
    log = LogRow(4000, 2, 2, 1.6, 20.0, 15.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 0.0, 0.2, 1.0, 1.0)
    left = Leftover(4000, 1.0, 0.0, 3.0, 0.0, (Misfit("spectrum", 0.5, 0.1, "3 Hz"), Misfit("mean over phase", 1.0, 0.2, "release")))
    return Rows(log, (own, other), replace(left, chi2=1.6), left, barred or {})


def read_again(found: Rows) -> Rows:
    return kept.from_document(json.loads(json.dumps(kept.to_document(found), allow_nan=False)))


@pytest.mark.parametrize("found", [rows(), rows(6.0), rows(0.0), rows(barred={"load_spring": "a loop"})])
def test_the_verdict_of_kept_rows_is_the_verdict(found):
    assert read_again(found).candidates == found.candidates and read_again(found).log == found.log
    assert verdict(read_again(found), learned()) == verdict(found, learned())
    assert [t.name for t in read_again(found).best.tests] == ["mean over phase"]


def result(case: str, found: Rows | None, error: str | None = None) -> dict:
    said = verdict(found, learned()) if found is not None else None
    told = {"status": "failed", "effects": [], "ambiguity_group": [], "confidence": 0.0}
    if said is not None:
        told = {"status": said.status, "effects": [*said.effects], "ambiguity_group": [i for g in said.group for i in g]}
        told["confidence"] = said.confidence
    kept_rows = {} if found is None else {"rows": json.loads(json.dumps(kept.to_document(found)))}
    return {
        "case": case,
        "seconds": 1.0,
        "error": error,
        "model": None,
        "diagnosis": {"verdict": told, "gap": {"shrink_pct": None}},
        **kept_rows,
    }


def truths() -> dict[str, CaseTruth]:
    found = {"a": ("rig", ["load_spring"]), "b": ("variant", ["load_spring"]), "c": ("bristle", ["slack"])}
    return {case: made_truth(effects, band=4.0, strength=4.0, simulator=simulator) for case, (simulator, effects) in found.items()}


def score(results, weights):
    from sstl_cli.blind.seal import Truth

    return blind_score.run(
        Truth("blind", (0, 1), True, truths()), {}, {c: Result(**r) for c, r in results.items()}, None, Set(), weights=weights
    )


def test_each_simulator_is_judged_by_the_weights_that_have_not_seen_it():
    results = {"a": result("a", rows()), "b": result("b", rows()), "c": result("c", None, "line 3: no run can be used")}
    own = learned()
    # whoever has not seen the variant never commits to a name
    weights = replace(own, without={"rig": own, "variant": replace(own, commit=2.0), "bristle": own})
    document = score(results, weights)
    assert [r.simulator for r in document.left_out] == ["bristle", "rig", "variant", "all"]
    exact = {r.simulator: (r.isolation["4"].k, r.isolation["4"].n) for r in document.left_out}
    assert exact == {"bristle": (0, 1), "rig": (1, 1), "variant": (0, 1), "all": (1, 3)}
    assert {r.simulator: r.isolation["4"].k for r in document.by_simulator} == {"bristle": 0, "rig": 1, "variant": 1, "all": 2}


@pytest.mark.parametrize("lacking", ["rows", "weights"])
def test_without_rows_or_such_weights_no_simulator_counts_as_left_out(lacking):
    results = {c: result(c, rows()) for c in truths()}
    if lacking == "rows":
        results["b"].pop("rows")
    without = {} if lacking == "weights" else dict.fromkeys(("rig", "variant", "bristle"), learned())
    assert score(results, replace(learned(), without=without)).left_out is None


def test_the_package_brings_weights_without_each_simulator():
    own = learned()
    assert sorted(own.without) == ["bristle", "rig", "variant"] == sorted(own.provenance["simulators"])
    case = judge("a", truths()["a"], Result(**result("a", rows())), None)
    for other in own.without.values():
        assert other.candidate != own.candidate and other.commit == own.commit
        assert by_others(case, rows(), other).status in ("identified", "ambiguous")


def test_a_result_that_lacks_what_a_score_asks_for_is_none(tmp_path):
    folder, asked = files.Folder(tmp_path), Planned("a", "0" * 64, (), {})
    folder.result("a").parent.mkdir()
    whole = {"schema": SCHEMA, "log_sha256": asked.sha256, "exclude": [], **result("a", rows())}
    folder.result("a").write_text(json.dumps(whole))
    found = files.finished(folder, "a", asked)
    assert found is not None and found.diagnosis.verdict.status == verdict(rows(), learned()).status
    # as a program of another version may have written it: the case is diagnosed again
    folder.result("a").write_text(json.dumps({**whole, "diagnosis": {"gap": {"shrink_pct": None}}}))
    assert files.finished(folder, "a", asked) is None
