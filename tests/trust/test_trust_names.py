"""Names out of recordings reach terminal, CSV and HTML only as text."""

from __future__ import annotations

import csv
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from program import inside
from trust_program import write_log

HOSTILE = ["\x1b[31mred\x1b[2J", '=HYPERLINK("http://x")', "<script>alert(1)</script>", "a\nb\rc", "\u202eexe.gpj"]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("names") / "log.parquet", runs=len(HOSTILE), names=HOSTILE)


def _plain(text: str) -> bool:
    return all(c.isprintable() or c == "\n" for c in text)


@pytest.mark.parametrize("command", ["segment", "check", "info", "diagnose"])
def test_terminal(command: str, log: Path, tmp_path: Path) -> None:
    words = [command, log] + (["--out", tmp_path / "t.parquet"] if command == "segment" else [])
    words += ["--effects", "viscous", "--max-effects", "1"] if command == "diagnose" else []
    done = inside(*words)
    assert done.returncode in (0, 3), done.stderr
    assert _plain(done.stdout) and _plain(done.stderr)


def test_error_lines(tmp_path: Path) -> None:
    done = inside("segment", tmp_path / "\x1b[2J\nx.parquet", "--out", tmp_path / "t.parquet")
    assert done.returncode == 1 and _plain(done.stderr) and done.stderr.count("\n") == 1


def test_formulas_in_csv(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "log.csv"
    assert inside("export", log, "--format", "csv", "--out", out).returncode == 0
    with open(out, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    cells = {cell for row in rows for cell in row if cell}
    assert not [c for c in cells if c[0] in "=@\t\r" or (c[0] in "+-" and not _number(c))]
    assert any("HYPERLINK" in c for c in cells)


def test_html(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.html"
    assert inside("report", log, "--out", out).returncode == 0
    assert "<script>alert(1)" not in out.read_text(encoding="utf-8")


def test_batch_lists_hostile_file_names(tmp_path: Path) -> None:
    pq.write_table(pa.table({"a": [1]}), tmp_path / "\x1b[2J.parquet")
    done = inside("batch", "segment", tmp_path / "\x1b[2J.parquet", "--out-dir", tmp_path / "out")
    assert done.returncode == 1 and _plain(done.stderr)


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
