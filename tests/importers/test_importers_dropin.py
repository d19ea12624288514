"""A new log format is one new file: found, detected, guessed at and imported with nothing else changed."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from sstl_cli import importers
from sstl_cli.cli import app as program
from sstl_cli.core.runs import read_runs
from sstl_cli.importers.base import detect, formats

FORMAT = '''
"""Records of three little-endian doubles after the word RIG1."""

from __future__ import annotations

import numpy as np

from sstl_cli.importers.base import Block, Channel

ID = "rig1"
TITLE = "a RIG1 record"
EXTENSIONS = (".rig",)
RANK = 5
NAMES = ("clock", "pull", "far_end")


def sniff(head, path):
    return head.startswith(b"RIG1")


def channels(path, layout):
    return [Channel(name, (path.stat().st_size - 4) // 24) for name in NAMES]


def read(path, numbers, labels, layout, notes):
    rows = np.frombuffer(path.read_bytes()[4:], "<f8").reshape(-1, 3)
    yield Block({n: rows[:, NAMES.index(n)].copy() for n in numbers}, path.stat().st_size)
'''


@pytest.fixture
def dropped_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = tmp_path / "formats"
    folder.mkdir()
    (folder / "rig1.py").write_text(FORMAT)
    monkeypatch.setattr(importers, "__path__", [*importers.__path__, str(folder)])
    yield
    sys.modules.pop("sstl_cli.importers.rig1", None)


def test_a_dropped_in_importer_is_found(dropped_in, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.arange(40) * 2.0
    rows = np.column_stack([t, 10 + np.sin(t / 9), 6 + np.sin(t / 9)])
    record, out = tmp_path / "a.bin", tmp_path / "log.parquet"
    record.write_bytes(b"RIG1" + rows.astype("<f8").tobytes())
    assert detect(record).ID == "rig1" and "rig1" in formats()
    words = ["import", str(record), "--out", str(out), "--map"]
    words += ["time_s=clock:ms,tension_in_n=pull:N,tension_out_n=far_end:mN,system=act"]
    monkeypatch.setattr(sys, "argv", ["sstl", *words])
    with pytest.raises(SystemExit) as end:
        program.main()
    assert end.value.code == 0
    (run,) = read_runs(out)
    np.testing.assert_allclose(run.time_s, t / 1000, rtol=1e-15)
    np.testing.assert_array_equal(run.tension_in_n, rows[:, 1])
    np.testing.assert_allclose(run.tension_out_n, rows[:, 2] / 1000, rtol=1e-15)


def test_without_its_file_it_is_gone(tmp_path: Path) -> None:
    assert "rig1" not in formats()
