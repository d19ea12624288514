"""``benchmarks/run.py`` on one small job: rows, table, and what counts as a fall. No time is judged."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benchmarks import run, show  # noqa: E402
from benchmarks.harness import Row, fell  # noqa: E402


def test_one_quick_job_runs_and_writes_nothing() -> None:
    stored = run.RESULTS.read_bytes() if run.RESULTS.is_file() else None
    words = [sys.executable, str(ROOT / "benchmarks" / "run.py"), "--quick", "--only", "compensate"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert "| compensate offline" in done.stdout and "same controller in plain Python" in done.stdout
    assert (run.RESULTS.read_bytes() if run.RESULTS.is_file() else None) == stored


def test_results_are_stored_and_a_fall_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"before\n{show.BEGINS}\nold\n{show.ENDS}\nafter\n")
    monkeypatch.setattr(run, "RESULTS", tmp_path / "results.json")
    monkeypatch.setattr(run, "PAGES", (page,))

    def one(value: float) -> int:
        monkeypatch.setattr(run, "measure", lambda chosen, quick: [Row("train/torch", "train", "a loop", 8.0, (value,))])
        return run.main(["--only", "train"])

    assert one(10.0) == 0
    assert page.read_text() == (
        f"before\n{show.BEGINS}\n| job | against | measured (spread) | goal | |\n|---|---|---|---|---|\n"
        f"| train | a loop | 10x (10 to 10) | >= 8x | met |\n{show.ENDS}\nafter\n"
    )
    assert one(7.5) == 0, "25 % less is within the noise of a machine"
    assert one(4.0) == 1 and "fell: train/torch" in capsys.readouterr().err
    # what fell is not stored, or the next run would pass
    assert json.loads(run.RESULTS.read_text())["rows"][0]["median"] == 7.5
    assert json.loads(run.RESULTS.read_text())["rows"][0]["met"] is False


@pytest.mark.parametrize(("at_least", "old", "new", "worse"), [
    (True, 10.0, 6.9, True), (True, 10.0, 7.1, False), (False, 2.0, 2.9, True), (False, 2.0, 2.8, False), (False, 2.0, 0.1, False),
])  # fmt: skip
def test_what_counts_as_a_fall(at_least: bool, old: float, new: float, worse: bool) -> None:
    rows = [Row("a/b", "a", "b", None, (v,), at_least).document() for v in (new, old)]
    assert fell(*rows) is worse


def test_every_job_has_a_place_in_the_order() -> None:
    assert sorted(run.ORDER) == sorted(run.names())
