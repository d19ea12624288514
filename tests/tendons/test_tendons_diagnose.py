"""Several tendons, one sensing loop: each gets a diagnosis of its own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from program import inside
from tendon_logs import log, without_tendons
from typer.testing import CliRunner

from sstl_cli.cli import _gates
from sstl_cli.cli.app import _register, app
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.files import dumps
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import write_runs
from sstl_cli.diagnosis.neighbours import with_neighbours
from sstl_cli.steps import diagnose, diagnose_tendons
from sstl_cli.steps.diagnose import DiagnoseOptions

OPTIONS = DiagnoseOptions(max_effects=1, workers=2, effects=("asymmetric_friction", "const_friction", "gain_error"))


@pytest.fixture(scope="module")
def runs():
    return log({}, {"gain_error": {"g_act": 1.05}})


@pytest.fixture(scope="module")
def found(runs):
    return diagnose_tendons.run(runs, OPTIONS).document()


def test_each_tendon_has_its_own_verdict(found):
    a, b = found["tendons"]
    assert (a["tendon"], b["tendon"]) == ("A", "B")
    assert a["verdict"]["effects"] == [] and a["gap"]["rmse_retuned_n"] < 0.05
    assert b["verdict"]["status"] in ("identified", "ambiguous") and "gain_error" in b["verdict"]["ambiguity_group"]
    for block in (a, b):
        assert sum(row["share_pct"] for row in block["where"]) == pytest.approx(100.0)


def test_the_tendon_with_the_largest_gap_speaks_for_the_log(found):
    assert found["schema"] == "sstl.diagnosis/1" and found["tendon"] == "B"
    for key in ("verdict", "gap", "where", "candidates", "next_experiment"):
        assert found[key] == found["tendons"][1][key]
    assert found["sentence"].startswith("Tendon B: ")


@pytest.mark.slow
def test_one_tendon_is_diagnosed_as_ever(runs):
    alone = without_tendons(runs)
    one = replace(OPTIONS, effects=("gain_error",))
    document = diagnose_tendons.run(alone, one).document()
    assert dumps(document) == dumps(diagnose.run(alone, one).document())
    assert "tendons" not in document


@pytest.mark.slow
def test_a_tendon_that_cannot_be_judged_is_said_to_be(runs):
    still = [replace(r, tension_in_n=np.full(len(r), 5.0)) if r.tendon == "A" else r for r in runs]
    still = [r for r in still if r.system == "act"]
    document = diagnose_tendons.run(still, OPTIONS).document()
    assert document["tendon"] == "B"
    assert document["tendons"][0]["verdict"]["status"] == "unknown"
    assert "never changes" in document["tendons"][0]["sentence"]
    assert sorted(document["analysis"]["set_aside"]) == sorted(r.run_id for r in still if r.tendon == "A")


@pytest.mark.slow
def test_the_command_says_so_and_its_gates_see_the_worst(runs, tmp_path):
    _register()
    write_runs(tmp_path / "log.parquet", runs, Provenance("test"))
    words = ["diagnose", str(tmp_path / "log.parquet"), "--effects", ",".join(OPTIONS.effects), "--max-effects", "1"]
    done = CliRunner().invoke(app, [*words, "--expect", "none", "--out", str(tmp_path / "d.json")])
    assert done.exit_code == 4
    said = {line.split(":")[0]: line for line in done.stdout.splitlines() if line.startswith("tendon ")}
    assert "The gap comes from" in said["tendon B"] and "The gap comes from" not in said["tendon A"]
    document = json.loads((tmp_path / "d.json").read_text())
    assert [b["tendon"] for b in document["tendons"]] == ["A", "B"]


def test_neighbours_are_found_by_configuration_movement_and_time(runs):
    own = next(r for r in runs if r.run_id == "c1-steps-A")
    other = next(r for r in runs if r.run_id == "c1-steps-B")
    beside = with_neighbours(own, runs).extra["neighbour_n"]
    np.testing.assert_allclose(beside, other.tension_in_n)
    without = [r for r in runs if r.run_id != "c1-steps-B"]
    assert "neighbour_n" not in with_neighbours(own, without).extra
    twice = [*runs, replace(other, run_id="again")]
    assert "neighbour_n" not in with_neighbours(own, twice).extra
    later = [replace(r, time_s=r.time_s + 30.0) if r is other else r for r in runs]
    assert "neighbour_n" not in with_neighbours(own, later).extra


def test_a_picture_names_its_tendon_and_another_can_be_asked_for(found, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("d.json").write_text(dumps(found))
    for kind in ("where", "waterfall", "candidates"):
        pictures = {}
        for words, name in (([], "B"), (["--tendon", "A"], "A"), (["--tendon", "B"], "B")):
            done = inside("plot", "d.json", "--kind", kind, *words, "--out", "p.svg", "--force", "--json")
            assert json.loads(done.stdout)["description"].startswith(f"Tendon {name}: "), done
            pictures[" ".join(words)] = Path("p.svg").read_text()
        assert pictures[""] == pictures["--tendon B"] != pictures["--tendon A"]
    for words, code, said in (
        (["d.json", "--tendon", "C"], 2, "known: A, B"),
        (["d.json", "--tendon", "A", "--kind", "isolability"], 1, "nothing about tendon A"),
        (["d.json", "--run", "A"], 1, "E609"),
    ):
        done = inside("plot", *words, "--out", "q.svg")
        assert done.returncode == code and said in done.stderr


def test_a_summary_has_every_tendon(found):
    text = _gates.markdown(DiagnosisDocument.model_validate(found), [])
    first, a, b = text.split("#### tendon ")
    assert a.startswith("A: ") and b.startswith("B: ") and "RMSE" not in first
    assert (
        "| noise floor |" in a
        and "| noise floor |" in b
        and a.count("| share of the gap / % |") == b.count("| share of the gap / % |") == 1
    )
