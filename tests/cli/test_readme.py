"""README's console blocks run as they stand, on the sample log."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMMANDS = [
    line[2:]
    for block in re.findall(r"```console\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    for line in block.splitlines()
    if line.startswith("$ sstl")
]


def test_the_walk_through_runs(tmp_path):
    shutil.copy(ROOT / "data/samples/log.parquet", tmp_path)
    assert len(COMMANDS) >= 10
    for command in COMMANDS:
        words = [sys.executable, "-m", "sstl_cli", *shlex.split(command)[1:]]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stdout[-800:]}\n{done.stderr[-800:]}"
        assert "Traceback" not in done.stderr


def test_the_sample_is_small_and_made_as_stated():
    assert (ROOT / "data/samples/log.parquet").stat().st_size < 1_000_000


def sstl(*words, env=None, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "sstl_cli", *map(str, words)], capture_output=True, text=True, check=False,
        env={**os.environ, **(env or {})}, cwd=cwd,
    )


NAMES = ["simulate", "import", "check", "info", "segment", "train", "evaluate", "compensate", "diagnose", "blind", "reproduce", "report", "effects", "export", "plot"]


@pytest.mark.parametrize("name", NAMES)
def test_help_has_an_example(name):
    done = sstl(name, "--help")
    assert done.returncode == 0
    assert "Example" in done.stdout or "Commands:" in done.stdout


def test_help_imports_nothing_heavy():
    code = "import sys; sys.argv=['sstl','--help']\nfrom sstl_cli.cli.app import main\ntry:\n main()\nexcept SystemExit: pass\nprint([m for m in ('numpy','pyarrow','torch','numba','pandas','scipy') if m in sys.modules], file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr.strip() == "[]"


def test_usage_errors_end_with_2():
    assert sstl("nonsense").returncode == 2
    assert sstl("simulate").returncode == 2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("diagnose", "absent.parquet"), "not found"),
        (("simulate", "--scenario", "defaut", "--out", "x.parquet"), "did you mean 'default'"),
        (("simulate", "--effect", "puley_friction", "--out", "x.parquet"), "did you mean 'pulley_friction'"),
        (("simulate", "--effect", "pulley_friction:m_p=9", "--out", "x.parquet"), "outside 0..0.25"),
        (("simulate", "--effect", "slack", "--out", "x.parquet"), "position_in_mm"),
        (("simulate", "--out", "no/such/folder/x.parquet"), "folder does not exist"),
    ],
)
def test_errors_are_one_line_and_leave_nothing(tmp_path, words, says):
    done = sstl(*words, cwd=tmp_path)
    assert done.returncode == 1
    assert says in done.stderr and done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_flag_beats_environment_beats_file_beats_default(tmp_path):
    (tmp_path / "c.toml").write_text("[simulate]\nseed = 5\n")
    def seed(*words, **env):
        done = sstl("simulate", "--scenario", "sample", "--out", tmp_path / "x.parquet", "--force", "--json", *words, env=env)
        assert done.returncode == 0, done.stderr
        import json

        return json.loads(done.stdout)["seed"]

    config = ("--config", tmp_path / "c.toml")
    assert seed() == 0
    assert seed(*config) == 5
    assert seed(*config, SSTL_SIMULATE_SEED="6") == 6
    assert seed("--seed", "7", *config, SSTL_SIMULATE_SEED="6") == 7


def test_same_seed_same_bytes(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        assert sstl("simulate", "--scenario", "sample", "--seed", "3", "--out", "x.parquet", cwd=tmp_path / name).returncode == 0
    assert (tmp_path / "a/x.parquet").read_bytes() == (tmp_path / "b/x.parquet").read_bytes()


def test_an_existing_output_needs_force(tmp_path):
    (tmp_path / "x.parquet").write_text("old")
    done = sstl("simulate", "--scenario", "sample", "--out", "x.parquet", cwd=tmp_path)
    assert done.returncode == 1 and "--force" in done.stderr
    assert (tmp_path / "x.parquet").read_text() == "old"


def test_gates_end_with_4(tmp_path):
    log = ROOT / "data/samples/log.parquet"
    assert sstl("diagnose", log, "--expect", "none", "--max-effects", "1").returncode == 4
