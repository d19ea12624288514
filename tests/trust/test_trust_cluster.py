"""``sstl batch --scheduler``: a real Dask scheduler with two workers on this machine, one killed in mid-run."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from trust_program import SSTL, document, inside, write_log

FILES = 40


def _start(words: list[str], folder: Path) -> subprocess.Popen[bytes]:
    with open(folder / f"{words[0]}-{words[-1]}.log", "wb") as log:
        return subprocess.Popen([sys.executable, "-m", "dask", *words], stdout=log, stderr=log, cwd=folder)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    folder = tmp_path_factory.mktemp("cluster")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    scheduler = _start(["scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"], folder)
    flags = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder)]
    workers = [_start(["worker", address, *flags, "--name", f"w{i}"], folder) for i in range(2)]
    yield address, workers
    for process in [*workers, scheduler]:
        process.kill()
        process.wait()


def test_one_worker_killed_and_nothing_lost(
    cluster: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    address, workers = cluster
    first = write_log(tmp_path / "first.parquet")
    logs = [shutil.copy(first, tmp_path / f"log-{i:03d}.parquet") for i in range(FILES)]
    local = inside("batch", "segment", *logs, "--out-dir", tmp_path / "local")
    assert local.returncode == 0, local.stderr

    words = ["batch", "segment", *map(str, logs), "--out-dir", str(tmp_path / "far"), "--scheduler", address, "--json"]
    running = subprocess.Popen([*SSTL, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 30
    while len(list((tmp_path / "far").glob("*.parquet"))) < 3 and time.monotonic() < deadline:
        time.sleep(0.005)
    workers[1].send_signal(signal.SIGKILL)
    made = len(list((tmp_path / "far").glob("*.parquet")))
    assert 3 <= made < FILES, "the kill must fall into the run"
    out, told = running.communicate(timeout=60)
    assert running.returncode == 0, told
    assert '"failed": 0' in out
    names = sorted(os.listdir(tmp_path / "local"))
    assert names == sorted(os.listdir(tmp_path / "far")) and len(names) == FILES + 1
    for path in (tmp_path / "local").glob("*.parquet"):
        assert path.read_bytes() == (tmp_path / "far" / path.name).read_bytes()

    # resumed on the cluster: nothing is left to do
    again = inside(*words)
    assert document(again)["skipped"] == FILES


def test_no_scheduler_is_one_clear_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_pool as pool
    from sstl_cli.core.errors import SstlError

    monkeypatch.setattr(pool, "CONNECT_S", 1)
    with pytest.raises(SstlError, match="E042"), pool._cluster("tcp://127.0.0.1:9"):
        pass


def test_missing_package_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from sstl_cli.cli import _batch_pool as pool
    from sstl_cli.core.errors import SstlError

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SstlError, match="E041"), pool._cluster("tcp://127.0.0.1:9"):
        pass
