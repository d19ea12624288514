"""Every JSON document validates against its published schema; a failure is a document too."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from program import inside
from short_sample import SAMPLE, write
from told import checked, closed

from sstl_cli.cli import app as program
from sstl_cli.cli.render import Screen
from sstl_cli.control import parameters
from sstl_cli.control.controller import Options, Theta
from sstl_cli.core import documents
from sstl_cli.core.documents.error import of
from sstl_cli.core.documents.outputs import ReproduceDocument
from sstl_cli.core.documents.watch import NamedChange
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.files import dumps
from sstl_cli.paper.better import Rung
from sstl_cli.paper.distal import Bent
from sstl_cli.paper.probe import Probe
from sstl_cli.paper.tendons import Together
from sstl_cli.steps.watch_name import Naming

ROOT = Path(__file__).parents[2]
# written to files of their own, not printed
FILES = {
    "sstl.blind.hashes/1", "sstl.blind.plan/1", "sstl.blind.truth/1", "sstl.blind.result/1", "sstl.scenario/1",
    "sstl.controller/1", "sstl.batch-record/1", "sstl.weights/1", "sstl.blind.limit.case/1", "sstl.blind.library.plan/1",
}  # fmt: skip
FEW = ("--effects", "pulley_friction,const_friction", "--max-effects", 1)
ONE = ("--methods", "proposed", "--config-id", "CP-020", "--cycles", 1)
# words of a call, and the documents it prints; in the order of the work, in one folder
CALLS = [
    (("simulate", "--scenario", "sample-40", "--out", "training.parquet", "--seed", 1), ["simulate"]),
    (("check", "log.parquet"), ["check"]),
    (("info", "log.parquet"), ["info"]),
    (("segment", "log.parquet", "--out", "theta.parquet"), ["segment"]),
    (("segment", "training.parquet", "--out", "tt.parquet"), ["segment"]),
    (("info", "theta.parquet"), ["info"]),
    (("train", "tt.parquet", "--variants", "linear", "--seeds", 2, "--out", "m.safetensors"), ["train"]),
    (("evaluate", "m.safetensors", "--theta", "tt.parquet", "--tables"), ["evaluate"]),
    (("evaluate", "m.safetensors", "--theta", "tt.parquet", "--max-rmse", 0), ["evaluate"]),
    (("compensate", "--theta", "theta.parquet", "--model", "m.safetensors", *ONE, "--out", "c.parquet"), ["compensate"]),
    (("compensate", "--theta", "theta.parquet", "--max-rmse", 0), ["compensate"]),
    (("diagnose", "c.parquet"), ["stages"]),
    (("diagnose", "log.parquet", "--out", "d.json", *FEW), ["diagnosis"]),
    (("diagnose", "--plan", "sample", "--effects", "zero_offset,viscous"), ["diagnosis.plan"]),
    (("export", "theta.parquet", "-f", "json", "--out", "p.json"), ["export"]),
    (("export", "log.parquet", "-f", "csv", "--out", "log.csv"), ["export"]),
    (("import", "log.csv", "--out", "again.parquet"), ["import"]),
    (("import", "log.csv", "--guess"), ["import-guess"]),
    (("watch", "log.csv", "--once", "--learn", 10, "--model", "m.safetensors"), ["watch.loop", "watch.alarm", "watch"]),
    (("report", "log.parquet", "d.json", "--out", "r.html"), ["report"]),
    (("plot", "theta.parquet", "--out", "t.png"), ["plot"]),
    (("effects", "list"), ["effects"]),
    (("effects", "show", "viscous"), ["effect"]),
    (("batch", "segment", "log.parquet", "--out-dir", "many", "--workers", 1), ["batch"]),
    (("doctor",), ["doctor"]),
    (("schema",), ["schemas"]),
    (("reproduce", "--table", "I"), ["reproduce"]),
    (("blind", "make", "set", "--cases", 1, "--quick", "--workers", 1), ["blind.make"]),
    (("segment", "nope.parquet", "--out", "x.parquet"), ["error"]),
    (("watch", "nope-*.csv", "--once"), ["watch", "error"]),
]
# minutes to hours: tests/blind/test_blind_documents.py
ELSEWHERE = {"blind.run", "blind.score", "blind.limit", "blind.library", "blind.learn", "blind.real", "blind.inject"}


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> dict[int, list[dict]]:
    """What every call of CALLS printed."""
    folder = tmp_path_factory.mktemp("documents")
    write(folder / "log.parquet")
    return {i: _documents(_call(folder, *words, "--json")[1]) for i, (words, _) in enumerate(CALLS)}


def _call(folder: Path, *words: object) -> tuple[int, str]:
    """Run the program in this process in a folder; return exit code and standard output."""
    done = inside(*words, cwd=folder)
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout


def _documents(text: str) -> list[dict]:
    try:
        return [json.loads(text)]
    except json.JSONDecodeError:
        return [json.loads(line) for line in text.splitlines()]


@pytest.mark.parametrize("number", range(len(CALLS)), ids=lambda i: " ".join(map(str, CALLS[i][0][:3])))
def test_every_document_validates(number: int, printed) -> None:
    found = printed[number]
    names = {documents.short(d["schema"]) for d in found}
    assert names and names <= set(CALLS[number][1])
    for document in found:
        checked(document)


def test_the_calls_show_every_document(printed) -> None:
    seen = {documents.short(d["schema"]) for found in printed.values() for d in found}
    assert seen == set(documents.catalogue()) - ELSEWHERE


def test_every_schema_is_a_schema_and_every_printed_id_has_one() -> None:
    for model in documents.catalogue().values():
        jsonschema.Draft202012Validator.check_schema(model.json_schema())
    text = "\n".join(p.read_text(encoding="utf-8") for p in (ROOT / "sstl_cli").rglob("*.py"))
    used = set(re.findall(r'"(sstl\.[a-z.-]+/1)"', text))
    assert used - FILES == {m.schema_name() for m in documents.catalogue().values()}


def test_the_committed_schemas_are_those_of_the_models() -> None:
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import schemas
    finally:
        sys.path.pop(0)
    committed = {p.name: p.read_text(encoding="utf-8") for p in (ROOT / "docs/schemas").glob("*.json")}
    assert committed == schemas.texts(), "run python tools/schemas.py"


def test_a_field_that_is_not_declared_fails() -> None:
    document = {"schema": "sstl.plot/1", "out": "a.png", "kind": "loop", "description": "a loop"}
    assert checked(document) == document
    with pytest.raises(jsonschema.ValidationError, match="'colour' was unexpected"):
        checked({**document, "colour": "blue"})
    row = {"run_id": "r", "samples": 1, "of": 2, "why": "w"}
    assert checked({**document, "data_set_aside": [row]})
    with pytest.raises(jsonschema.ValidationError, match="'reason': ''"):
        checked({**document, "data_set_aside": [{**row, "reason": ""}]})
    # wherever the program shows one while a test runs it, too
    with pytest.raises(AssertionError, match=r"sstl\.plot/1 has fields that it does not declare: \.colour"):
        Screen(True).document(documents.get("plot").joined(**document, colour="blue"))
    # what is published lets it pass: a later version may have added it
    published = documents.get("plot").json_schema()
    assert jsonschema.Draft202012Validator(published).is_valid({**document, "colour": "blue"}) and closed(published) != published


def test_a_schema_refuses_what_is_no_such_document() -> None:
    validator = jsonschema.Draft202012Validator(documents.get("diagnosis").json_schema())
    assert not validator.is_valid({"schema": "sstl.diagnosis/1"})
    assert not jsonschema.Draft202012Validator(documents.get("error").json_schema()).is_valid({"schema": "sstl.error/1"})


@pytest.mark.parametrize(
    ("words", "code", "stable"),
    [
        (("segment", "nope.parquet", "--out", "x.parquet"), 1, "E130"),
        (("segment",), 2, "E004"),
        (("segment", "log.parquet", "--out", "x.parquet", "--cutoff-hz", "-1"), 2, "E210"),
        (("segment", "log.parquet", "--out", "x.parquet", "--nope"), 2, "E004"),
        (("compensate", "--theta", "log.parquet", "--methods", "nope"), 2, "E404"),
        (("schema", "nope"), 2, "E160"),
        (("nope",), 2, "E004"),
    ],
)
def test_a_failure_is_a_document(words, code, stable, tmp_path: Path) -> None:
    shutil.copy(SAMPLE, tmp_path / "log.parquet")
    ended, out = _call(tmp_path, *words, "--json")
    document = json.loads(out)
    assert ended == code == document["exit_code"]
    assert document["schema"] == "sstl.error/1" and document["code"] == stable and document["message"]
    jsonschema.validate(document, documents.get("error").json_schema())
    assert _call(tmp_path, *words) == (code, ""), "without --json nothing on standard output"


def test_json_of_a_batch_is_no_wish_for_json_of_the_failure_within(tmp_path: Path) -> None:
    # what stands after -- is for the subcommand
    code, out = _call(tmp_path, "batch", "segment", "--", "--json")
    assert code == 2 and out == ""


def test_a_failed_check_in_a_batch_leaves_no_error_document_behind(tmp_path: Path) -> None:
    shutil.copy(SAMPLE, tmp_path / "log.parquet")
    (tmp_path / "bad.parquet").write_bytes(b"PAR1 nothing")
    code, out = _call(tmp_path, "batch", "info", "log.parquet", "bad.parquet", "--out-dir", "o", "--workers", 1, "--json")
    states = {Path(r["input"]).name: r["state"] for r in json.loads(out)["results"]}
    assert code == 3 and states == {"log.parquet": "done", "bad.parquet": "failed"}
    assert [p.name for p in (tmp_path / "o").glob("*.json")] == ["log.json"]


def test_error_document_of_any_error() -> None:
    document = of(UsageError("bad \x9b value", where="--x", fix="give y", code="E999")).model_dump(by_alias=True)
    assert document["message"] == "--x: bad \\x9b value" and document["exit_code"] == 2
    assert of(SstlError("lost")).fix == ""


@pytest.mark.parametrize("character", ["\x7f", "\x9b", "\x85", "\u2028", "\u202e", "\u200b", "\ufeff", "\udc80"])
def test_json_holds_no_raw_control_character(character: str) -> None:
    text = dumps({"run_id": f"a{character}b", "name": "Γ ± é"})
    assert character not in text and "Γ ± é" in text
    assert json.loads(text)["run_id"] == f"a{character}b"
    assert dumps({"g": "Γ"}, ascii_only=True).isascii()


def test_json_stays_json_where_the_stream_is_ascii(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sstl_cli", "effects", "list", "--json"],
        capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, check=True,
    )  # fmt: skip
    assert done.stdout.isascii() and json.loads(done.stdout)["effects"]
    text = subprocess.run(
        [sys.executable, "-m", "sstl_cli", "effects", "list"],
        capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, check=True,
    )  # fmt: skip
    assert text.stdout.isascii() and b"viscous" in text.stdout and text.stderr == b""


def test_a_stream_of_ascii_spells_out_signs_and_draws_with_stars() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sstl_cli", "info", str(SAMPLE)],
        capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "100"}, check=True,
    )  # fmt: skip
    lines = done.stdout.decode("ascii").splitlines()
    # no escape, a rule under the heading, the loop as a picture
    assert not [line for line in lines if "\\u" in line] and any(set(line) == {"-"} for line in lines)
    drawn = lines[next(i for i, line in enumerate(lines) if line.startswith("loop of")) + 1 :][:11]
    assert all("*" in line for line in drawn)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device here")
@pytest.mark.parametrize("words", [("effects", "list"), ("effects", "list", "--json"), ("--help",)])
def test_a_full_disk_behind_the_output_is_one_line(words) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-m", "sstl_cli", *words], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "[E005] standard output" in done.stderr and "No space left" in done.stderr
    with open("/dev/full", "w") as full:
        # nor does the code depend on whether the line could be written; unless Python is told not to, it keeps what was not
        kept = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
        assert subprocess.run([sys.executable, "-m", "sstl_cli", *words], stdout=full, stderr=full, env=kept).returncode == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device here")
def test_narration_that_cannot_be_written_ends_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "p.json").write_text(json.dumps(parameters.document({"A": Theta(0.6, 0.1, 1.6, 0.1)}, Options(), "DI").plain()))
    rows = [f"r,act,{0.01 * k:.2f},{5 - 4 * np.cos(0.02 * k):.4f},{3 - 2 * np.cos(0.02 * k - 0.1):.4f}" for k in range(1200)]
    (tmp_path / "l.csv").write_text("\n".join(["run_id,system,time_s,tension_in_n,tension_out_n", *rows, "r,act,12,inf,1"]) + "\n")
    (tmp_path / "input.csv").write_text("1.0,0.6\n")
    # unless Python is told not to, it keeps what could not be written and tries again at its end
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
    calls = [(["compensate", "--theta", "p.json", "--stream"], 0), (["watch", "l.csv", "--once", "--json"], 3), (["segment", "--nope"], 2)]
    for words, code in calls:
        with open(tmp_path / "input.csv") as stdin:
            monkeypatch.setattr(sys, "stdin", stdin)
            told = inside(*words, cwd=tmp_path)
        with open("/dev/full", "w") as err:
            made = subprocess.run(
                [sys.executable, "-m", "sstl_cli", *words],
                input="1.0,0.6\n",
                stdout=subprocess.PIPE,
                stderr=err,
                text=True,
                cwd=tmp_path,
                env=kept,
            )
        assert made.returncode == told.returncode == code and made.stdout == told.stdout and told.stderr, words


def test_closed_streams_do_no_harm() -> None:
    command = f"{sys.executable} -m sstl_cli effects list --json >&- 2>&-"
    assert subprocess.run(command, shell=True).returncode == 0


def test_a_second_call_in_one_process_forgets_the_first(capsys, monkeypatch) -> None:
    for words, expected in ((["effects", "list", "--json"], 0), (["effects", "show", "nope", "--json"], 2)):
        monkeypatch.setattr(sys, "argv", ["sstl", *words])
        with pytest.raises(SystemExit) as end:
            program.main()
        assert (end.value.code or 0) == expected
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["code"] == "E700"


def test_numbers_stay_whole() -> None:
    value = float(np.nextafter(0.1, 1))
    assert json.loads(dumps([value, np.float64("nan"), np.arange(2)])) == [value, None, [0, 1]]


def test_what_takes_hours_to_print_has_the_fields_of_its_document() -> None:
    by = {"sinusoid": (0.4, float("nan"))}
    rows = {
        "better": Rung("+ loop-lag lead", by, by, by, by, by, by),
        "probe": Probe("trapezoid", 2.0, 30.0, 0.01, None, 0.2),
        "tendons": Together("a map each", 0.01, 0.009, {"t1": 0.3}),
        "distal": Bent("joint not known", {"random": 0.3}, {"random": 1.2}, 0.01, 0.009),
    }
    for name, row in rows.items():
        part = ReproduceDocument.model_fields[name].annotation.__args__[0]
        assert set(asdict(row)) == set(part.model_fields)
        part.model_validate(asdict(row))
    named = Naming("identified", ("viscous",), (), 0.9, (0.5, 0.6), "").document()
    assert set(named.plain()) == set(NamedChange.model_fields) and named.theta_now == 0.6
