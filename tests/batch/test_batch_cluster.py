"""``sstl batch --scheduler``: a real Dask scheduler with two workers on this machine, one killed in mid-run."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from batch_processes import started, wait_for
from program import inside
from trust_program import SSTL, document, write_log

from sstl_cli.core.errors import SstlError

FILES = 16


@dataclass
class Cluster:
    address: str
    scheduler: subprocess.Popen[str]
    workers: list[subprocess.Popen[str]]


@contextlib.contextmanager
def cluster(folder: Path, workers: int) -> Iterator[Cluster]:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    dask = [sys.executable, "-m", "dask"]
    flags = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder), "--death-timeout", "60"]
    with contextlib.ExitStack() as stack:
        log = stack.enter_context(open(folder / "log", "w"))
        out = {"stdout": log, "stderr": log, "cwd": folder}
        at = ["--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
        scheduler = stack.enter_context(started([*dask, "scheduler", *at], **out))
        made = [stack.enter_context(started([*dask, "worker", address, *flags, "--name", f"w{i}"], **out)) for i in range(workers)]
        yield Cluster(address, scheduler, made)


@pytest.mark.slow
def test_one_worker_killed_and_nothing_lost(tmp_path: Path) -> None:
    first = write_log(tmp_path / "first.parquet", runs=4)
    logs = [Path(shutil.copy(first, tmp_path / f"log-{i:03d}.parquet")) for i in range(FILES)]
    logs[7].write_bytes(first.read_bytes()[:900])
    local = inside("batch", "segment", *logs, "--out-dir", tmp_path / "local", "--workers", 1)
    assert local.returncode == 3, local.stderr

    far = tmp_path / "far"
    with cluster(tmp_path, 2) as dask:
        words = ["batch", "segment", *map(str, logs), "--out-dir", str(far), "--scheduler", dask.address, "--json"]
        with started([*SSTL, *words]) as running:
            wait_for(lambda: len(list(far.glob("*.parquet"))) >= 3 or running.poll() is not None)
            dask.workers[1].send_signal(signal.SIGKILL)
            made = len(list(far.glob("*.parquet")))
            out, told = running.communicate(timeout=60)
        assert 3 <= made < FILES - 1, f"the kill must fall into the run: {told}"
        # the bad file is listed, all others are done; one that the killed worker had finished is found complete
        account = json.loads(out)
        assert running.returncode == 3, told
        assert account["done"] + account["skipped"] == FILES - 1 and account["failed"] == 1 and "log-007" in told
        names = sorted(os.listdir(tmp_path / "local"))
        assert names == sorted(os.listdir(far)) and len(names) == FILES
        for path in (tmp_path / "local").glob("*.parquet"):
            assert path.read_bytes() == (far / path.name).read_bytes()

        # resumed on the worker that is left: only the bad file is tried again
        again = inside(*words)
        assert document(again)["skipped"] == FILES - 1 and document(again)["failed"] == 1


@pytest.mark.slow
def test_ctrl_c_a_deadly_file_and_a_lost_cluster_end_the_batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_cluster as far
    from sstl_cli.cli import _batch_pool as pool
    from sstl_cli.cli._batch_worker import Job
    from sstl_cli.steps import batch as step

    first = write_log(tmp_path / "first.parquet", runs=6)
    logs = [shutil.copy(first, tmp_path / f"log-{i:03d}.parquet") for i in range(60)]
    words = ["batch", "segment", *map(str, logs), "--out-dir", str(tmp_path / "out")]
    # one death is enough for dask to give a job up
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    with cluster(tmp_path, 3) as dask:
        with started([*SSTL, *words, "--scheduler", dask.address]) as running:
            wait_for(lambda: list((tmp_path / "out").glob("*.parquet")) or running.poll() is not None)
            running.send_signal(signal.SIGINT)
            _, told = running.communicate(timeout=20)
        assert running.returncode == 1 and "[E001]" in told and "Traceback" not in told

        def stand_in(job: Job) -> step.Outcome:
            if job.item.source.endswith("log-003.parquet"):
                os.kill(os.getpid(), signal.SIGKILL)
            return step.Outcome(job.item.source, job.item.output, "done", 0)

        monkeypatch.setattr(far, "run_one", stand_in)
        items = step.plan("segment", [str(log) for log in logs], [])
        jobs = [Job("segment", item, str(tmp_path / "out"), True, {}, os.getcwd()) for item in items]
        outcomes = pool.run_all(jobs, 0, dask.address, lambda _: None)
        assert [o.state for o in outcomes] == ["failed" if i == 3 else "done" for i in range(60)]
        assert outcomes[3].line.startswith("[E040]")
        left = [w for w in dask.workers if w.poll() is None]
        assert len(left) == 1, "the deadly file was tried twice"

        monkeypatch.setattr(far, "LOST_S", 1)

        def kill_the_last(_: step.Outcome) -> None:
            left[0].kill()
            left[0].wait(timeout=10)

        harmless = [job for job in jobs if job is not jobs[3]]
        with pytest.raises(SstlError, match="E043"):
            pool.run_all(harmless, 0, dask.address, kill_the_last)


def test_no_scheduler_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_cluster as far

    monkeypatch.setattr(far, "CONNECT_S", 1)
    with pytest.raises(SstlError, match="E042"), far.connected("tcp://127.0.0.1:9"):
        pass


def test_missing_package_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_cluster as far

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SstlError, match="E041"), far.connected("tcp://127.0.0.1:9"):
        pass
