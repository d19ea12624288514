"""The tutorial is run as it stands, from a lab's own CSV files to the effect that is in them."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from program import inside

from sstl_cli.core.runs import read_runs

ROOT = Path(__file__).parents[2]
BENCH = ROOT / "data/samples/bench"
TEXT = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
COMMANDS = [
    line[2:] for block in re.findall(r"```console\n(.*?)```", TEXT, re.S) for line in block.splitlines() if line.startswith("$ sstl ")
]


def run(folder: Path, command: str) -> subprocess.CompletedProcess[str]:
    words = []
    for word in shlex.split(command)[1:]:
        # what a shell would do
        words += sorted(p.name for p in folder.glob(word)) if "*" in word else [word]
    return inside(*words, cwd=folder, COLUMNS="80")


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """The folder after every command of the tutorial, and what each printed."""
    folder = tmp_path_factory.mktemp("tutorial")
    for path in BENCH.glob("*.csv"):
        shutil.copy(path, folder)
    (folder / "rig.toml").write_text(re.findall(r"```toml\n(.*?)```", TEXT, re.S)[0])
    printed = {}
    for command in COMMANDS:
        done = run(folder, command)
        assert done.returncode == 0, f"{command}\n{done.stdout[-800:]}\n{done.stderr}"
        printed[command] = done.stdout
    return folder, printed


@pytest.mark.slow
def test_the_tutorial_names_the_effect_that_is_in_the_files(walked) -> None:
    folder, printed = walked
    truth = tomllib.loads((ROOT / "data/samples/bench.toml").read_text())["effects"]
    found = json.loads((folder / "diagnosis.json").read_text())
    assert found["verdict"]["status"] == "identified" and found["verdict"]["effects"] == list(truth) == ["gain_error"]
    best = next(c for c in found["candidates"] if c["id"] == "gain_error")
    gain = {p["name"]: p["estimate"] for p in best["parameters"]}
    assert gain["g_sstl"] == pytest.approx(truth["gain_error"]["g_sstl"], abs=0.005)
    assert gain.get("g_act", 1.0) == pytest.approx(1.0, abs=0.005)
    # the sentence and the number of the tutorial's text
    assert "gain_error" in TEXT and "0.93" in TEXT
    assert printed[next(c for c in COMMANDS if "--save-sim" in c)].startswith(found["sentence"][:40])


@pytest.mark.slow
def test_what_the_tutorial_shows_is_what_is_printed(walked) -> None:
    folder, printed = walked
    blocks = [b.strip("\n") for b in re.findall(r"```text\n(.*?)```", TEXT, re.S)]
    everything = "\n".join(printed.values())
    names, head, *screens = blocks
    assert sorted(names.split()) == sorted(p.name for p in folder.glob("bend*.csv"))
    assert (folder / "bend20_slow_act.csv").read_text().startswith(head)
    for screen in screens:
        assert screen in everything, screen


@pytest.mark.slow
def test_the_guess_is_the_mapping_but_for_the_names(walked) -> None:
    folder, _ = walked
    guess, mapping = (tomllib.loads((folder / name).read_text()) for name in ("guess.toml", "rig.toml"))
    assert guess["columns"] == mapping["columns"] and guess["format"] == mapping["format"]


@pytest.mark.slow
def test_pages_and_pictures_were_made(walked) -> None:
    folder, _ = walked
    assert "gain_error" in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "where.png").read_bytes().startswith(b"\x89PNG")


def test_the_files_are_those_of_the_stated_rig(tmp_path: Path) -> None:
    """Same scenario, same seed: every file comes out again, whatever else the simulator has learned since."""
    done = run(tmp_path, f"sstl simulate --scenario {ROOT / 'data/samples/bench.toml'} --seed 3 --out bench.parquet")
    assert done.returncode == 0, done.stderr
    subprocess.run([sys.executable, ROOT / "tools/bench_files.py", "bench.parquet", "made"], cwd=tmp_path, check=True)
    assert len(list(read_runs(tmp_path / "bench.parquet"))) == 8
    for path in BENCH.glob("*.csv"):
        ours = np.loadtxt(tmp_path / "made" / path.name, delimiter=",", skiprows=1)
        np.testing.assert_allclose(ours, np.loadtxt(path, delimiter=",", skiprows=1), atol=2e-4)
