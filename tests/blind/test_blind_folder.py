"""The folder of a set: what is written, who opens what, scoring, gates and the split of purposes."""

import json
import shutil
from dataclasses import replace

import pytest
import typer
from typer.testing import CliRunner

from sstl_cli.blind import folder as files
from sstl_cli.blind import seal
from sstl_cli.blind.result import SCHEMA
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.cli import blind
from sstl_cli.core.documents.blind import CaseDistance
from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import sha256
from sstl_cli.diagnosis import weights
from sstl_cli.physics.effects import catalogue
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.figures import baselines, confusion, reliability, strength
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored
from sstl_cli.reporting.sections import blind as section
from sstl_cli.steps import blind_limit, blind_make, blind_run, blind_set, diagnose

CASES = 7


def call(*words):
    app = typer.Typer()
    blind.register(app)
    app.command("other")(lambda: None)
    found = CliRunner().invoke(app, ["blind", *map(str, words)])
    if isinstance(found.exception, SstlError):
        raise found.exception
    return found


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("blind") / "set"
    assert call("make", root, "--cases", CASES, "--quick", "--seed", 900, "--workers", 1).exit_code == 0
    return root


@pytest.fixture
def own(made, tmp_path):
    return shutil.copytree(made, tmp_path / "set")


def oracle(root, spoil=lambda name, verdict: verdict):
    """Write results that know the truth: what a perfect diagnosis would have said."""
    folder = files.Folder(root)
    truth, plan = json.loads(folder.truth.read_text()), files.read_plan(folder)
    (root / "results").mkdir(exist_ok=True)
    for name, t in truth["truths"].items():
        effects = sorted(t["effects"])
        outside = t["excluded"] or t["unlisted"]
        status = "unknown" if outside else ("identified" if effects else "none")
        named = [] if outside else effects
        rows = [{"id": e, "score": 50.0 if [e] == effects else 10.0} for e in sorted(catalogue())]
        verdict = {"status": status, "effects": named, "ambiguity_group": named, "confidence": 1.0, "why": ""}
        result = {
            "schema": SCHEMA,
            "case": name,
            "seconds": 1.0,
            "error": None,
            "model": None,
            "log_sha256": plan[name].sha256,
            "exclude": list(plan[name].exclude),
            "diagnosis": {
                "verdict": spoil(name, verdict),
                "gap": {"shrink_pct": 50.0 if named else None},
                "candidates": rows,
                "base_score": 0.0 if effects else 60.0,
                "baselines": {"smallest_rmse": "viscous", "iid_bic": None},
                "analysis": {"theta": {}},
            },
        }
        folder.result(name).write_text(json.dumps(result))


def test_nothing_outside_the_truth_file_names_what_is_withheld(made):
    truth = json.loads((made / "truth.json").read_text())
    withheld = {e for t in truth["truths"].values() for e in t["effects"]}
    assert withheld
    everything = [*catalogue(), "position_ripple", "moved_tube", "mains_hum", "kind", "unlisted"]
    for path in [*sorted((made / "cases").iterdir()), *sorted((made / "fresh").iterdir())]:
        content = path.read_bytes()
        found = [e for e in everything if e.encode() in content]
        assert found == [], path
    assert not any(e in (made / "hashes.json").read_text() for e in everything)


def test_the_provenance_is_the_same_for_every_case(made):
    import pyarrow.parquet as pq

    found = {pq.read_schema(p).metadata[b"sstl"] for p in sorted((made / "cases").iterdir())}
    assert len(found) == 1
    body = json.loads(found.pop())
    assert body["command"] == "sstl blind make" and body["seed"] is None and body["inputs"] == {}


def test_the_plan_asks_the_same_of_every_kind(made):
    plan = json.loads((made / "plan.json").read_text())
    assert {frozenset(row) for row in plan["cases"]} == {frozenset({"case", "sha256", "exclude", "sim"})}
    assert all(len(row["exclude"]) <= 1 for row in plan["cases"])
    assert all(set(row["sim"]["effects"]) <= {"tendon_elasticity"} for row in plan["cases"])


def test_hashes_are_written_before_any_recording_shows(tmp_path, monkeypatch):
    order = []
    from sstl_cli.core import files as core

    written = core.write_json
    monkeypatch.setattr(
        core, "write_json", lambda path, *a, **k: (order.append((path.name, (path.parent / "cases").exists())), written(path, *a, **k))
    )
    call("make", tmp_path / "s", "--cases", 1, "--quick", "--seed", 3, "--workers", 1)
    assert order == [("hashes.json", False), ("plan.json", True), ("truth.json", True)]


def test_the_same_seed_gives_the_same_bytes_for_any_number_of_workers(made, tmp_path):
    call("make", tmp_path / "again", "--cases", CASES, "--quick", "--seed", 900, "--workers", 2)
    for path in sorted(p for p in made.rglob("*") if p.is_file()):
        assert sha256(path) == sha256(tmp_path / "again" / path.relative_to(made)), path.name


def test_an_existing_set_is_kept(made):
    with pytest.raises(SstlError, match="E956"):
        call("make", made, "--cases", 1, "--quick")


def test_a_foreign_folder_survives_force(tmp_path):
    (tmp_path / "keep.txt").write_text("mine")
    with pytest.raises(SstlError, match="E956"):
        call("make", tmp_path, "--cases", 1, "--quick", "--force")
    assert (tmp_path / "keep.txt").exists()


@pytest.mark.parametrize("named", ["{}", "[]", '{"schema": "sstl.blind.plan/1", "cases": []}', "no json"])
def test_a_folder_whose_hashes_are_somebody_elses_survives_force(named, tmp_path):
    (tmp_path / "hashes.json").write_text(named)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "thesis.csv").write_text("mine")
    with pytest.raises(SstlError, match="E956"):
        call("make", tmp_path, "--cases", 1, "--quick", "--force")
    assert (tmp_path / "results" / "thesis.csv").read_text() == "mine" and (tmp_path / "hashes.json").read_text() == named


def test_no_name_of_a_case_leads_out_of_the_set(tmp_path):
    folder = files.Folder(tmp_path / "s")
    folder.root.mkdir()
    folder.plan.write_text(json.dumps({"schema": seal.PLAN, "cases": [{"case": "../../x", "sha256": "", "exclude": [], "sim": {}}]}))
    with pytest.raises(SstlError, match="E952"):
        files.read_plan(folder)


def test_force_replaces_the_files_of_a_set_and_no_others(tmp_path, monkeypatch):
    folder = files.Folder(tmp_path / "s")
    for part in ("cases", "results"):
        (folder.root / part).mkdir(parents=True)
    folder.hashes.write_text(json.dumps({"schema": seal.HASHES, "cases": {"case-0001": "", "case-0002": ""}}))
    for path in (folder.plan, folder.log("case-0002"), folder.result("case-0001")):
        path.write_text("old")
    (folder.root / "results" / ".case-0001.json.00aa.tmp").write_text("")
    foreign = folder.root / "results" / "thesis.csv"
    foreign.write_text("mine")
    with pytest.raises(SstlError, match="would be lost") as refused:
        call("make", folder.root, "--cases", 1, "--quick", "--force")
    assert "thesis.csv" in refused.value.line() and folder.plan.read_text() == "old"
    foreign.rename(folder.root / "thesis.csv")

    def stopped(*_: object, **__: object):
        raise SstlError("cannot be simulated", code="E950")
        yield

    with monkeypatch.context() as broken:
        broken.setattr(blind_make, "run", stopped)
        with pytest.raises(SstlError, match="E950"):
            call("make", folder.root, "--cases", 1, "--quick", "--force")
    # a set goes when the next one is there
    assert folder.plan.read_text() == "old" and folder.log("case-0002").exists()
    call("make", folder.root, "--cases", 1, "--quick", "--force", "--seed", 3, "--workers", 1)
    names = {str(p.relative_to(folder.root)) for p in folder.root.rglob("*") if p.is_file()}
    assert names >= {"thesis.csv", "hashes.json", "plan.json", "truth.json", "cases/case-0001.parquet"}
    assert not any("0002" in n or "results" in n for n in names)


@pytest.mark.slow
def test_diagnosing_needs_one_recording_and_no_name(made, tmp_path, monkeypatch):
    """The leak test: everything but the recording taken away, the case renamed: the same diagnosis."""
    # a few candidates: what could leak is the answer, not how many were asked
    real, few = diagnose.run, ("pulley_friction", "const_friction", "zero_offset")
    monkeypatch.setattr(diagnose, "run", lambda runs, options: real(runs, replace(options, effects=few, max_effects=1)))
    plan = files.read_plan(files.Folder(made))
    name = "case-0001"
    with_all = tmp_path / "all"
    shutil.copytree(made, with_all)
    (with_all / "results").mkdir()
    blind_set._diagnose_one((str(with_all), name, plan[name]))
    bare = tmp_path / "bare"
    (bare / "cases").mkdir(parents=True)
    (bare / "results").mkdir()
    shutil.copy(made / "cases" / f"{name}.parquet", bare / "cases" / "other-77.parquet")
    blind_set._diagnose_one((str(bare), "other-77", replace(plan[name], case="other-77")))
    a, b = (json.loads(p.read_text()) for p in (with_all / "results" / f"{name}.json", bare / "results/other-77.json"))
    for r in (a, b):
        assert r.pop("seconds") > 0
        r.pop("case")
    assert a == b


def test_running_never_opens_truth_or_fresh(own, monkeypatch):
    (own / "truth.json").unlink()
    shutil.rmtree(own / "fresh")
    asked = []
    monkeypatch.setattr(blind_set, "_diagnose_one", lambda job: asked.append(job[1]))
    assert call("run", own, "--workers", 1).exit_code == 0
    assert asked == [f"case-{i + 1:04d}" for i in range(CASES)]


def test_an_interrupted_run_goes_on(own, monkeypatch):
    oracle(own)
    (own / "results" / "case-0003.json").write_text("{ half")
    stale = json.loads((own / "results" / "case-0005.json").read_text())
    (own / "results" / "case-0005.json").write_text(json.dumps({**stale, "log_sha256": "0"}))
    (own / "results" / "case-0006.json").unlink()
    asked = []
    monkeypatch.setattr(blind_set, "_diagnose_one", lambda job: asked.append(job[1]))
    call("run", own, "--workers", 1)
    assert asked == ["case-0003", "case-0005", "case-0006"]


def test_a_changed_recording_is_refused(own):
    plan = files.read_plan(files.Folder(own))
    (own / "results").mkdir()
    shutil.copy(own / "cases" / "case-0002.parquet", own / "cases" / "case-0001.parquet")
    with pytest.raises(SstlError, match="E952"):
        blind_set._diagnose_one((str(own), "case-0001", plan["case-0001"]))


def test_a_failing_diagnosis_is_a_result():
    def fails(runs, sim, exclude):
        raise SstlError("nothing usable", code="E901")

    found = blind_run.run("c", [], None, (), fails)
    assert found["diagnosis"]["verdict"]["status"] == "failed" and "E901" in found["error"]


def test_an_oracle_meets_the_targets_and_draws_the_report(own, tmp_path):
    oracle(own)
    found = call("score", own, "--json", "--out", tmp_path / "score.json")
    document = json.loads(found.stdout)
    assert found.exit_code == 0 and document["cases"] == CASES
    met = {t["id"]: t["met"] for t in document["targets"]}
    # a perfect tool covers more than 90 +- 5 %
    assert met.pop("coverage") is False
    assert set(met.values()) <= {True, None} and True in met.values()
    matrix = document["confusion"]
    assert sum(map(sum, matrix["matrix"])) == CASES - document["kinds"].get("poor", 0)
    inputs = Inputs(blind=[read(Scored, {**document, "file": "score.json"})])
    for figure in (confusion, reliability, strength, baselines):
        assert figure.default(inputs, None) is not None, figure.__name__
    block = section.context(inputs)["blocks"][0]
    assert block["of"] == len(document["targets"]) and len(block["tables"]) == 4


def test_gates_fail_with_exit_4(own):
    oracle(own, lambda name, v: {**v, "status": "identified", "effects": ["slack"], "ambiguity_group": ["slack"]})
    assert call("score", own).exit_code == 0
    found = call("score", own, "--max-false-alarm", "0.05", "--min-isolation", "0.9")
    assert found.exit_code == 4
    assert "gate missed: false alarm 1" in found.stderr


def test_missing_results_are_said(own):
    oracle(own)
    (own / "results" / "case-0001.json").unlink()
    found = call("score", own, "--json")
    assert found.exit_code == 3 and json.loads(found.stdout)["missing_results"] == 1


def test_no_results_at_all_is_an_error(own):
    with pytest.raises(SstlError, match="E959"):
        call("score", own)


def test_a_truth_changed_after_the_fact_is_refused(own):
    oracle(own)
    closed = json.loads((own / "truth.json").read_text())
    closed["truths"]["case-0001"]["effects"] = {"viscous": {"c_l_n_s_per_mm": 0.01}}
    (own / "truth.json").write_text(json.dumps(closed))
    with pytest.raises(SstlError, match="E952"):
        call("score", own)


def test_without_a_seed_nobody_knows_it(tmp_path):
    words = []
    for name in ("a", "b"):
        made = call("make", tmp_path / name, "--cases", 1, "--quick", "--workers", 1, "--json")
        seed = json.loads((tmp_path / name / "truth.json").read_text())["seeds"][0]
        assert str(seed) not in made.stdout + made.stderr
        assert not any(str(seed).encode() in p.read_bytes() for p in (tmp_path / name).rglob("*.*") if p.name != "truth.json")
        words.append(seed)
    assert words[0] != words[1]


def test_a_set_of_the_weights_own_seeds_is_refused(own, monkeypatch):
    oracle(own)
    used = weights.learned()
    monkeypatch.setattr(weights, "learned", lambda: replace(used, provenance={"seeds": [[5, 6], [890, 900]]}))
    with pytest.raises(SstlError, match="E954"):
        call("score", own)
    monkeypatch.setattr(weights, "learned", lambda: replace(used, provenance={"seeds": [[5, 6], [1, 899]]}))
    assert call("score", own).exit_code == 0


def test_a_set_made_for_something_else_is_refused(own):
    closed = json.loads((own / "truth.json").read_text())
    published, closed = seal.seal(
        {n: CaseTruth.of(t) for n, t in closed["truths"].items()}, "calibration", closed["seeds"], closed["quick"]
    )
    (own / "hashes.json").write_text(json.dumps(published))
    (own / "truth.json").write_text(json.dumps(closed))
    oracle(own)
    with pytest.raises(SstlError, match="E953"):
        call("score", own)


def test_the_truth_stays_closed_while_a_case_has_no_result(own):
    oracle(own)
    (own / "results" / "case-0002.json").unlink()
    with pytest.raises(SstlError, match="E959"):
        call("limit", own)
    assert not (own / "limit.json").exists()


def test_rates_come_twice_where_distances_are_known(own, monkeypatch):
    oracle(own)
    truths = json.loads((own / "truth.json").read_text())["truths"]
    first = next(n for n, t in truths.items() if t["kind"] == "single")

    def measured(case, truth, sim, exclude):
        effects = sorted(truth.effects)
        far = 100.0 if case == first else 3.0
        known = {"d2_base": far, "d2_rival": far, "rival": "slack"} if effects else {"d2_base": None, "d2_rival": None, "rival": None}
        body = dict.fromkeys(("channel", "d2_base_known", "d2_rival_known", "d2_law", "d2_own", "why"))
        return CaseDistance(case=case, effects=effects, rivals={}, decidable=case == first, decidable_known=True, **body, **known)

    monkeypatch.setattr(blind_limit, "run", measured)
    assert call("limit", own, "--workers", 1).exit_code == 0
    document = json.loads(call("score", own, "--json").stdout)
    every, decidable = document["by_simulator"][-1], document["decidable"][-1]
    assert every["cases"] == CASES
    assert sum(r["isolation"]["n"] for r in document["by_d2"] if r["isolation"]) == document["kinds"].get("single", 0)
    assert decidable["cases"] == 1 + document["kinds"].get("none", 0)
    assert sum(x["n"] for x in decidable["isolation"].values() if x) <= 1
    other = json.loads((own / "limit.json").read_text())
    (own / "limit.json").write_text(json.dumps({**other, "seal": "0"}))
    with pytest.raises(SstlError, match="E952"):
        call("score", own)
