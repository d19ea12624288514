"""What decided a result stands in the output: inputs of every kind, the configuration file, SSTL_* values."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from short_sample import write

from sstl_cli.cli._batch_worker import call_program
from sstl_cli.core.provenance import inputs_of

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copy(SAMPLE, tmp_path / "log.parquet")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: object, **environment: str) -> tuple[int, str, str]:
    return call_program([str(w) for w in words], environment)


def made(path: Path) -> dict:
    return json.loads(pq.read_schema(path).metadata[b"sstl"])


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_a_value_of_the_environment_is_recorded(folder: Path) -> None:
    assert run("segment", "log.parquet", "--out", "a.parquet", SSTL_SEGMENT_CUTOFF_HZ="20", SSTL_SEGMENT_FORCE="1")[0] == 0
    origin = made(folder / "a.parquet")
    assert origin["extra"]["environment"] == {"SSTL_SEGMENT_CUTOFF_HZ": "20"}, "force decides no byte"
    # the screen told of the command line alone, which does not give this table again
    assert "  with SSTL_SEGMENT_CUTOFF_HZ=20" in run("info", "a.parquet")[1].splitlines()
    # a flag wins: then the value decided nothing
    words = ("segment", "log.parquet", "--cutoff-hz", "20", "--out", "b.parquet")
    assert run(*words, SSTL_SEGMENT_CUTOFF_HZ="30")[0] == 0
    assert made(folder / "b.parquet")["extra"] == {}
    assert run("segment", "log.parquet", "--out", "c.parquet", SSTL_TRAIN_SEEDS="3")[0] == 0
    assert made(folder / "c.parquet")["extra"] == {}


def test_the_configuration_file_is_an_input(folder: Path) -> None:
    config = folder / "mine.toml"
    config.write_text("[segment]\ncutoff_hz = 20.0\n")
    assert run("segment", "log.parquet", "--out", "a.parquet", "--config", "mine.toml")[0] == 0
    assert made(folder / "a.parquet")["inputs"] == {"log.parquet": digest(SAMPLE), "mine.toml": digest(config)}
    # the next call in this process knows nothing of it
    assert run("segment", "log.parquet", "--out", "b.parquet")[0] == 0
    assert list(made(folder / "b.parquet")["inputs"]) == ["log.parquet"]


def test_a_path_in_the_environment_gives_the_same_bytes_anywhere(folder: Path) -> None:
    (folder / "deep").mkdir()
    (folder / "s.toml").write_text(Path(SAMPLE.parents[2] / "sstl_cli/physics/scenarios/default.toml").read_text())
    shutil.copy(folder / "s.toml", folder / "deep/s.toml")
    for name, text in (("a", "s.toml"), ("b", str(folder / "deep/s.toml"))):
        assert run("simulate", "--out", f"{name}.parquet", SSTL_SIMULATE_SCENARIO=text)[0] == 0
    # the command lines name their outputs
    a, b = (made(folder / f"{n}.parquet") for n in "ab")
    assert {**a, "command": ""} == {**b, "command": ""}
    assert a["inputs"] == {"s.toml": digest(folder / "s.toml")}
    assert a["extra"]["environment"] == {"SSTL_SIMULATE_SCENARIO": "s.toml"}


def test_a_diagnosis_names_its_simulator_and_its_configuration(folder: Path) -> None:
    write(folder / "brief.parquet")
    (folder / "rig.toml").write_text('schema = "sstl.scenario/1"\n')
    (folder / "mine.toml").write_text("max_effects = 1\n")
    words = ("diagnose", "brief.parquet", "--sim", "rig.toml", "--config", "mine.toml", "--json")
    code, out, _ = run(*words, SSTL_DIAGNOSE_EFFECTS="const_friction")
    document = json.loads(out)
    assert code == 0 and set(document["inputs"]) == {"brief.parquet", "rig.toml", "mine.toml"}
    assert document["inputs"]["rig.toml"] == digest(folder / "rig.toml")
    assert document["environment"] == {"SSTL_DIAGNOSE_EFFECTS": "const_friction"}


def test_inputs_of_one_name_are_all_there(tmp_path: Path) -> None:
    paths = [tmp_path / d / "log.parquet" for d in "ab"]
    for i, path in enumerate(paths):
        path.parent.mkdir()
        path.write_text(str(i))
    found = inputs_of(paths)
    assert found == inputs_of(paths[::-1]) and set(found) == {"log.parquet", "log.parquet (2)"}
    assert set(found.values()) == {digest(p) for p in paths}
    assert len(inputs_of([paths[0], paths[0]])) == 1


@pytest.mark.parametrize(
    "words",
    [
        ("diagnose", "log.parquet", "--effects", "foo"), ("diagnose", "log.parquet", "--exclude", "foo"),
        ("diagnose", "log.parquet", "--expect", "foo"), ("simulate", "--effect", "foo", "--out", "x.parquet"),
        ("simulate", "--effect", "viscous:nope=1", "--out", "x.parquet"), ("effects", "show", "foo"),
        ("blind", "real", "log.parquet", "--plant", "foo"),
    ],
)  # fmt: skip
def test_an_unknown_effect_is_wrong_usage(words, folder: Path) -> None:
    code, _, err = run(*words)
    assert (code == 2 and "--" in err) or "ID" in err
    assert err.count("\n") == 1 and not (folder / "x.parquet").exists()


@pytest.mark.parametrize("words", [["diagnose", "log.parquet", "--prior"], ["blind", "real", "log.parquet", "--inject"]])
@pytest.mark.parametrize("line", ["foo = 1.0", "zero_offset = -1.0"])
def test_a_file_with_an_unknown_effect_or_a_wrong_number_is_named(words: list[str], line: str, folder: Path) -> None:
    (folder / "effects.toml").write_text(line + "\n")
    code, _, err = run(*words, "effects.toml")
    assert code == 2 and "effects.toml: " in err and f"'{line.split()[0]}'" in err and err.count("\n") == 1


def test_export_makes_a_folder_that_ends_in_a_slash(folder: Path) -> None:
    assert run("segment", "log.parquet", "--out", "t.parquet")[0] == 0
    export = ("export", "t.parquet", "-f", "c", "--config-id", "CP-020", "--out")
    assert run(*export, f"firmware{os.sep}")[0] == 0
    assert sorted(p.name for p in (folder / "firmware").iterdir()) == ["sstl_controller.c", "sstl_controller.h"]
    assert run(*export, "plain")[0] == 0 and (folder / "plain.c").is_file(), "a name without slash is a file"
    code, _, err = run(*export, "none/firmware/")
    assert code == 1 and "[E103] none" in err
    code, _, err = run(*export, "log.parquet/")
    assert code == 1 and "[E103] log.parquet: is a file" in err
    # a call that fails makes none
    assert run("export", "t.parquet", "-f", "c", "--config-id", "nope", "--out", "other/")[0] != 0
    assert not (folder / "other").exists()


def test_a_missing_mcap_library_names_the_log_not_a_temporary_file(folder: Path, monkeypatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    code, _, err = run("export", "log.parquet", "-f", "mcap", "--out", "x.mcap")
    assert code == 1 and "[E308] log.parquet: MCAP needs" in err and ".tmp" not in err
