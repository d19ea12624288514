"""Outputs under kill -9, a full disk, a folder that cannot be written, and two writers at once."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
from pathlib import Path

import pytest
from kill_writers import run
from program import inside
from soon import asked
from trust_program import SSTL, sstl, write_csv, write_log


# `make kill` does it two hundred times
@pytest.mark.slow
def test_kill_at_random_moments(tmp_path: Path) -> None:
    told = run(6, seed=3, folder=tmp_path, commands=("import", "segment", "batch"), rerun_every=2)
    assert sum(hits for _, hits, _ in told.values()) >= 3, "too few kills fell into a run to say anything"


@pytest.mark.slow
def test_two_hundred_kills(tmp_path: Path) -> None:
    told = run(200, seed=4, folder=tmp_path)
    assert sum(hits for _, hits, _ in told.values()) >= 100


@pytest.mark.parametrize("command", asked(("import", "segment", "batch"), "import", "batch"))
def test_disk_full(command: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    if command == "import":
        words = ["import", write_csv(tmp_path / "r.csv", 20_000), "--out", out / "r.parquet", "--force"]
    else:
        log = write_log(tmp_path / "r.parquet")
        words = ["segment", log, "--out", out / "r.parquet", "--force"]
        if command == "batch":
            words = ["batch", "segment", log, "--out-dir", out, "--workers", "1", "--force"]
    (out / "r.parquet").write_bytes(b"old")

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500))

    done = subprocess.run([*SSTL, *map(str, words)], capture_output=True, text=True, preexec_fn=limit, check=False, timeout=60)
    assert done.returncode == 1, done
    assert "[E106]" in done.stderr and "Traceback" not in done.stderr
    assert (out / "r.parquet").read_bytes() == b"old"
    assert [p.name for p in out.iterdir() if p.name != ".batch"] == ["r.parquet"]


@pytest.mark.parametrize("where", ["/proc/r.parquet", "file/r.parquet", "missing/r.parquet"])
def test_folder_that_cannot_be_written(where: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    log = write_log(tmp_path / "log.parquet", runs=1)
    done = inside("segment", log, "--out", tmp_path / where)
    assert done.returncode == 1 and done.stderr.startswith("sstl: [E10") and done.stderr.count("\n") == 1
    done = inside("batch", "segment", log, "--out-dir", (tmp_path / where).parent if where != "missing/r.parquet" else "/proc/x")
    assert done.returncode == 1 and done.stderr.startswith("sstl: [E03"), done.stderr


def test_two_processes_one_output(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.parquet")
    out = tmp_path / "theta.parquet"
    words = [*SSTL, "segment", str(log), "--out", str(out)]
    both = [subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    told = [p.communicate(timeout=60)[1] for p in both]
    codes = [p.returncode for p in both]
    assert sorted(codes) == [0, 1], told
    assert any(code in told[codes.index(1)] for code in ("E102", "E105"))
    assert sstl("check", out).returncode == 0
    assert [p.name for p in tmp_path.iterdir() if "tmp" in p.name] == []


# every kind of input beside the tables, which are opened in one place
PIPES = [
    "import {}.csv --out out",
    "import log.csv {}.csv --format text --out out",
    "import log.csv --manifest {}.csv --out out",
    "import log.csv --mapping {}.toml --out out",
    "info log.csv --config {}.toml",
    "simulate --scenario {}.toml --out out",
    "diagnose log.csv --sim {}.toml",
    "diagnose log.csv --prior {}",
    "compensate --sim {}.toml",
    "compensate --theta {}.json",
    "export {}.json --out out",
    "plot {} --out out.svg",
    "report {} --out out",
    "watch log.csv --mapping {}.toml --once",
    "blind real log.parquet --inject {}.toml",
]


@pytest.mark.parametrize("command", PIPES)
def test_a_pipe_as_any_input_is_refused(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of these waited for a writer for ever."""
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "log.csv", 50)
    write_log(tmp_path / "log.parquet", runs=1)
    there = set(os.listdir())

    def waited(*_: object) -> None:
        raise TimeoutError("waited for a writer")

    before = signal.signal(signal.SIGALRM, waited)
    words = command.format("pipe").split()
    os.mkfifo(next(w for w in words if w.startswith("pipe")))
    signal.alarm(20)
    try:
        done = inside(*words)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    errors = [line for line in done.stderr.splitlines() if line.startswith("sstl:")]
    assert done.returncode == 1 and len(errors) == 1 and "pipe" in errors[0], done
    assert "E003" not in errors[0] and {n for n in os.listdir() if not n.startswith("pipe")} == there
