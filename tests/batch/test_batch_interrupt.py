"""Ctrl-C and other ends in mid-batch: one line, no process left, and the next batch takes up where it stopped."""

from __future__ import annotations

import os
import shutil
import signal
from pathlib import Path

import pytest
from batch_processes import group, started, wait_for
from program import inside
from soon import asked
from trust_program import SSTL, document, write_log

FILES = 24
# so many that a fast machine is not through before it is asked to stop
MANY = 80


@pytest.mark.parametrize(("workers", "whole_group"), asked(((1, False), (2, True)), (2, True), several=True))
def test_ctrl_c_ends_at_once_and_is_resumed(tmp_path: Path, workers: int, whole_group: bool) -> None:
    first = write_log(tmp_path / "first.parquet", runs=10)
    logs = [shutil.copy(first, tmp_path / f"log-{i:02d}.parquet") for i in range(FILES)]
    out = tmp_path / "out"
    words = ["batch", "segment", *map(str, logs), "--out-dir", str(out), "--workers", str(workers)]
    with started([*SSTL, *words]) as running:
        wait_for(lambda: len(list(out.glob("*.parquet"))) >= 2 or running.poll() is not None)
        # a terminal sends Ctrl-C to all processes in front, `kill -INT` to one
        (os.killpg if whole_group else os.kill)(running.pid, signal.SIGINT)
        _, told = running.communicate(timeout=20)
        wait_for(lambda: not group(running.pid), 10)
    made = len(list(out.glob("*.parquet")))
    assert running.returncode == 1
    assert told.count("\n") == 1 and "[E001]" in told, told
    assert made < FILES

    # an output whose record was not yet written counts as unfinished, and is made again to the same bytes
    before = {p.name: p.read_bytes() for p in out.glob("*.parquet")}
    again = inside("batch", "segment", *[tmp_path / name for name in sorted(before)], "--out-dir", out, "--workers", 1, "--json")
    assert document(again)["skipped"] >= made - workers and document(again)["failed"] == 0
    assert {p.name: p.read_bytes() for p in out.glob("*.parquet")} == before
    assert not list((out / ".batch").glob("work-*"))


# a closed terminal takes the way of SIGTERM: tests/core/test_core_interrupt.py
@pytest.mark.parametrize("how", asked((signal.SIGTERM, signal.SIGKILL), signal.SIGTERM))
def test_workers_end_with_the_program(tmp_path: Path, how: signal.Signals) -> None:
    first = write_log(tmp_path / "first.parquet", runs=10)
    logs = [shutil.copy(first, tmp_path / f"log-{i:02d}.parquet") for i in range(MANY)]
    out = tmp_path / "out"
    words = ["batch", "segment", *map(str, logs), "--out-dir", str(out), "--workers", "2"]
    with started([*SSTL, *words]) as running:
        wait_for(lambda: len(list(out.glob("*.parquet"))) >= 2 or running.poll() is not None)
        assert len(group(running.pid)) > 1
        os.kill(running.pid, how)
        _, told = running.communicate(timeout=20)
        wait_for(lambda: not group(running.pid), 10)
    assert len(list(out.glob("*.parquet"))) < MANY
    assert not list((out / ".batch").glob("work-*"))
    if how is signal.SIGKILL:
        assert running.returncode == -how
    else:
        assert running.returncode == 1 and told.count("\n") == 1 and "[E001]" in told, told
