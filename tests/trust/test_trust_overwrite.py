"""An output never takes the place of a file that the same call reads, nor of anything but a regular file."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from program import inside
from trust_program import write_csv, write_log

from sstl_cli.cli.options import OUTPUTS
from sstl_cli.steps.batch import FORMS

# every command that reads a file and writes one: {} is the file, named as input and as output
COMMANDS = [
    "import {} --out {}",
    "import other.csv --mapping {} --out {}",
    "import other.csv --manifest {} --out {}",
    "import --guess {} --out {}",
    "simulate --scenario {} --out {}",
    "segment other.parquet {} --out {}",
    "segment {} --out free.parquet --phases {}",
    "train {} --out {}",
    "train {} --out free.safetensors --history {}",
    "evaluate {} --theta other.parquet --out {}",
    "evaluate other.safetensors --theta {} --predictions {}",
    "compensate --theta {} --scores {}",
    "compensate --theta other.parquet --recorded {} --out {}",
    "diagnose other.parquet {} --out {}",
    "diagnose other.parquet --sim {} --save-sim {}",
    "diagnose other.parquet --against {} --next-out {}",
    "blind real {} --out {}",
    "report other.parquet {} --out {}",
    "export {} --format csv --out {}",
    "export {} --format json --out {}",
    "export {} --format onnx --out {}",
    "segment other.parquet --config {} --out {}",
]
SPELLINGS = ["same", "dotted", "whole", "symbolic", "hard"]


def spelt(name: str, how: str) -> str:
    """Return another name of a file of this folder."""
    if how == "symbolic":
        os.symlink(name, "link")
    elif how == "hard":
        os.link(name, "link")
    return {"same": name, "dotted": f"../{Path.cwd().name}/./{name}", "whole": str(Path(name).resolve())}.get(how, "link")


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_overwrites_what_it_reads(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("precious.toml", "other.csv", "other.parquet", "other.safetensors"):
        (tmp_path / name).write_text("")
    words = command.format("precious.toml", spelt("precious.toml", SPELLINGS[COMMANDS.index(command) % len(SPELLINGS)])).split()
    before = {p.name: p.stat().st_ino for p in tmp_path.iterdir()}
    done = inside(*words, "--force")
    assert done.returncode == 2 and "[E109]" in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert {p.name: p.stat().st_ino for p in tmp_path.iterdir()} == before


def test_a_picture_does_not_overwrite_what_it_shows(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.svg", runs=1)
    done = inside("plot", log, "--out", log, "--force")
    assert done.returncode == 2 and "[E109]" in done.stderr and pq.read_table(log).num_rows == 1200


@pytest.mark.parametrize("how", SPELLINGS)
def test_every_spelling_of_an_input_is_refused(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "log.csv", 50)
    before = (tmp_path / "log.csv").read_bytes()
    name = spelt("log.csv", how)
    for force in ([], ["--force"]):
        done = inside("import", "log.csv", "--out", name, *force)
        assert done.returncode == 2 and "[E109]" in done.stderr
        assert (tmp_path / "log.csv").read_bytes() == before


# the files are named after the option, and one of those names is an input's: {} is that input, named in just these words
DERIVED = [
    ("export {} --format c --config-id run-0 --out th", "th.c"),
    ("export {} --format c --config-id run-0 --out th.c", "th.h"),
    ("export theta.parquet --format c --config-id run-0 --config {} --out kept/", "kept/sstl_controller.c"),
    ("reproduce --table I --config {} --out kept", "kept/tables.tex"),
    ("reproduce --table IV --config {} --gap-logs kept", "kept/stated.parquet"),
    ("blind library {} --cases 1 --config {}", "library.parquet"),
]


@pytest.mark.parametrize(("command", "name"), DERIVED)
def test_a_name_made_from_an_option_does_not_overwrite_an_input(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "kept").mkdir()
    log = write_log(tmp_path / "log.parquet", runs=1)
    assert inside("segment", log, "--out", "theta.parquet").returncode == 0
    Path(name).write_bytes(b"" if "--config {}" in command else Path("theta.parquet").read_bytes())
    before = Path(name).read_bytes()
    done = inside(*command.replace("{}", name).split(), "--force")
    assert done.returncode == 2 and "[E109]" in done.stderr, done.stderr
    assert Path(name).read_bytes() == before


def test_every_output_of_a_batch_is_known_as_an_output() -> None:
    assert {option for form in FORMS.values() for option in form.side} <= OUTPUTS


def test_two_outputs_of_one_call_are_two_files(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.parquet", runs=1)
    done = inside("segment", log, "--out", tmp_path / "x", "--phases", tmp_path / "." / "x")
    assert done.returncode == 2 and "--phases" in done.stderr and [p.name for p in tmp_path.iterdir()] == ["log.parquet"]


def test_a_file_of_a_bag_folder_and_a_manifest_named_by_the_mapping_are_safe(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "b.db3").write_bytes(b"SQLite format 3\0")
    for guess in ([], ["--guess"]):
        done = inside("import", *guess, bag, "--out", bag / "b.db3", "--force")
        assert done.returncode == 2 and "[E109]" in done.stderr
    csv = write_csv(tmp_path / "r.csv", 50)
    (tmp_path / "runs.csv").write_text("file,config_id\nr.csv,A\n")
    (tmp_path / "m.toml").write_text('manifest = "runs.csv"\n')
    done = inside("import", csv, "--mapping", tmp_path / "m.toml", "--out", tmp_path / "runs.csv", "--force")
    assert done.returncode == 2 and "[E109]" in done.stderr and "config_id" in (tmp_path / "runs.csv").read_text()


@pytest.mark.parametrize(
    "name", ["truth.json", "hashes.json", "plan.json", "limit.json", "cases/c.parquet", "fresh/c.parquet", "results/c.json"]
)
def test_a_score_does_not_overwrite_the_sealed_set(name: str, tmp_path: Path) -> None:
    path = tmp_path / "set" / name
    path.parent.mkdir(parents=True)
    path.write_text("sealed")
    os.link(path, tmp_path / "other.json")
    for out in (path, tmp_path / "other.json"):
        done = inside("blind", "score", tmp_path / "set", "--out", out, "--force")
        assert done.returncode == 2 and "[E109]" in done.stderr and path.read_text() == "sealed"


def test_a_batch_does_not_overwrite_its_inputs(tmp_path: Path) -> None:
    log = write_log(tmp_path / "a.parquet", runs=1)
    before = log.read_bytes()
    done = inside("batch", "segment", log, "--out-dir", tmp_path, "--workers", "1", "--force")
    assert done.returncode == 2 and "[E109]" in done.stderr and log.read_bytes() == before
    sim = tmp_path / "a.toml"
    sim.write_text("# mine\n")
    words = ["--", "--sim", sim, "--save-sim", "{name}.toml"]
    done = inside("batch", "diagnose", log, "--out-dir", tmp_path, "--workers", "1", "--force", *words)
    assert done.returncode == 2 and "[E109]" in done.stderr and sim.read_text() == "# mine\n"


def test_force_overwrites_regular_files_only(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.parquet", runs=1)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for target in (pipe, Path("/dev/null")):
        for force in ([], ["--force"]):
            done = inside("segment", log, "--out", target, *force)
            assert done.returncode == 1 and "[E108]" in done.stderr and "regular file" in done.stderr
    assert stat.S_ISFIFO(pipe.stat().st_mode) and stat.S_ISCHR(os.stat("/dev/null").st_mode)
    out = tmp_path / "out"
    out.mkdir()
    os.mkfifo(out / "log.parquet")
    done = inside("batch", "segment", log, "--out-dir", out, "--workers", "1", "--force")
    assert done.returncode == 1 and "[E108]" in done.stderr and stat.S_ISFIFO((out / "log.parquet").stat().st_mode)


FOLDERS = [
    "batch segment log.parquet --workers 1 --out-dir",
    "blind make --cases 1",
    "reproduce --table I --out",
    "reproduce --table IV --gap-logs",
    "export theta.parquet --format c --out",
]


@pytest.mark.parametrize("command", FOLDERS)
def test_a_folder_that_is_a_link_to_nothing_is_named(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    log = write_log(tmp_path / "log.parquet", runs=1)
    if command.startswith("export"):
        assert inside("segment", log, "--out", "theta.parquet").returncode == 0
    (tmp_path / "link").symlink_to("nowhere")
    done = inside(*command.split(), "link/")
    assert done.returncode == 1 and "[E107]" in done.stderr and "'nowhere'" in done.stderr
    assert not (tmp_path / "nowhere").exists()


def test_a_link_is_followed_and_one_to_nothing_is_named(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.parquet", runs=1)
    (tmp_path / "far").mkdir()
    real, link = tmp_path / "far" / "theta.parquet", tmp_path / "link"
    link.symlink_to(Path("far") / "theta.parquet")
    done = inside("segment", log, "--out", link, "--force")
    assert done.returncode == 1 and "[E107]" in done.stderr and "far/theta.parquet" in done.stderr and link.is_symlink()
    real.write_text("old")
    assert "[E102]" in inside("segment", log, "--out", link).stderr
    assert inside("segment", log, "--out", link, "--force").returncode == 0
    assert link.is_symlink() and pq.read_table(real).num_rows == 1
    assert sorted(p.name for p in (tmp_path / "far").iterdir()) == ["theta.parquet"]
