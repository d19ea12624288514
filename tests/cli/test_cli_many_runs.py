"""Logs of very many runs that are too short for anything: what is told of them, and what each of them costs."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from cli_calls import run_here

from sstl_cli.cli.render import Screen
from sstl_cli.core.aside import LISTED, Aside, Ledger
from sstl_cli.core.parquet import open_table
from sstl_cli.core.runs import read_runs
from sstl_cli.core.tables import THETA
from sstl_cli.identification import SegmentOptions, gate
from sstl_cli.steps import judge, segment

MANY = 3 * LISTED


def write_log(path: Path, runs: int, samples: int = 2) -> Path:
    rng = np.random.default_rng(0)
    n = runs * samples
    into = rng.uniform(1.0, 10.0, n)
    columns = {
        "run_id": np.repeat([f"r{i:06d}" for i in range(runs)], samples),
        "config_id": np.full(n, "c"),
        "system": np.full(n, "sstl"),
        "time_s": np.tile(0.01 * np.arange(samples), runs),
        "tension_in_n": into,
        "tension_out_n": 0.5 * into,
    }
    pq.write_table(pa.table(columns), path)
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("many") / "log.parquet", MANY)


def test_check_lists_the_sensors_of_some_and_counts_the_others(monkeypatch, capsys, log) -> None:
    assert run_here(monkeypatch, "check", log, "--json") == 1
    document = json.loads(capsys.readouterr().out)
    assert len(document["sensors"]) == 2 * LISTED and document["short_left_out"] == MANY - LISTED
    assert len(document["findings"]) < 100 and document["ok"] is False
    assert run_here(monkeypatch, "check", log) == 1
    out = capsys.readouterr().out
    assert f"{MANY - LISTED} more runs too short to be measured" in out and len(out.splitlines()) < 200


def test_info_lists_some_short_runs_and_counts_the_others(monkeypatch, capsys, log) -> None:
    assert run_here(monkeypatch, "info", log, "--json") == 0
    (held,) = json.loads(capsys.readouterr().out)["files"]
    assert (held["rows"], len(held["runs"]), held["runs_left_out"]) == (2 * MANY, LISTED, MANY - LISTED)
    assert run_here(monkeypatch, "info", log) == 0
    assert f"and {MANY - 20} more rows; --json, very short ones aside, has all" in capsys.readouterr().out


def test_segment_writes_every_row_and_tells_the_first(monkeypatch, capsys, log, tmp_path) -> None:
    theta = tmp_path / "theta.parquet"
    assert run_here(monkeypatch, "segment", log, "--out", theta, "--json") == 3
    told = capsys.readouterr()
    document = json.loads(told.out)
    assert (document["runs"], document["set_aside"], document["theta_left_out"]) == (MANY, MANY, MANY - LISTED)
    assert len(document["theta"]) == len(document["set_aside_runs"]) == LISTED
    assert len(told.err.splitlines()) < 40 and f"and {MANY - 20} more" in told.err
    rows = open_table(theta, THETA).table()
    assert rows.column("run_id").to_pylist() == [f"r{i:06d}" for i in range(MANY)]
    assert set(rows.column("status").to_pylist()) == {"too few samples (2)"}


def test_diagnose_says_how_many_were_set_aside(monkeypatch, capsys, log) -> None:
    assert run_here(monkeypatch, "diagnose", log) == 1
    err = capsys.readouterr().err
    assert "E901" in err and f"and {MANY - LISTED - 1} more" in err and len(err.splitlines()) == 1


def test_the_page_says_how_many_it_leaves_out(monkeypatch, capsys, log, tmp_path) -> None:
    page = tmp_path / "page.html"
    assert run_here(monkeypatch, "report", log, "--out", page) == 3
    assert f"and {MANY - LISTED - 20} more" in capsys.readouterr().err
    assert f"{MANY - LISTED} more runs of fewer than 16 samples are left out" in page.read_text(encoding="utf-8")


def test_of_a_few_short_runs_nothing_is_left_out(monkeypatch, capsys, tmp_path) -> None:
    few = write_log(tmp_path / "few.parquet", 30)
    assert run_here(monkeypatch, "segment", few, "--out", tmp_path / "theta.parquet", "--json") == 3
    document = json.loads(capsys.readouterr().out)
    assert len(document["theta"]) == len(document["set_aside_runs"]) == 30 and "theta_left_out" not in document
    assert run_here(monkeypatch, "check", few, "--json") == 1
    document = json.loads(capsys.readouterr().out)
    assert len(document["sensors"]) == 60 and "short_left_out" not in document


def test_a_ledger_keeps_the_first_entries_and_counts_the_others() -> None:
    book = Ledger()
    book.add(Aside(f"r{i}", 2, 5, "why") for i in range(LISTED + 7))
    assert (len(book.entries), book.more, book.more_samples) == (LISTED, 7, 14)
    assert book.brief() == f"run r0: 2 of 5 samples: why, and {LISTED + 6} more"


def test_what_a_command_sets_aside_is_told_up_to_a_number(capsys) -> None:
    from typer import Exit

    from sstl_cli.core.documents.logs import InfoDocument

    with pytest.raises(Exit) as end:
        Screen().finish(InfoDocument(schema="sstl.info/1", files=[]), aside=[f"run {i}" for i in range(500)])
    lines = capsys.readouterr().err.splitlines()
    assert end.value.exit_code == 3 and len(lines) == 51 and lines[-1] == "set aside: and 450 more"


def peak(work, path: Path) -> int:
    """Return the most memory (bytes) that Python's objects took."""
    tracemalloc.start()
    try:
        kept = work(path)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    del kept
    return most


def identified(path: Path):
    return segment.identify(read_runs(path), SegmentOptions())


def judged(path: Path):
    return judge.run(("log", run) for run in read_runs(path))


# bytes a further run: 590 and 410; 6190 and 3470 with evidence of every run and a document a row
@pytest.mark.parametrize(("work", "most"), [pytest.param(identified, 1000, marks=pytest.mark.slow), (judged, 800)])
def test_a_further_short_run_takes_little_memory(work, most, tmp_path) -> None:
    sizes = (2 * LISTED, 6 * LISTED)
    paths = [write_log(tmp_path / f"{n}.parquet", n) for n in sizes]
    # what is loaded or compiled at the first call is no part of it
    work(paths[0])
    small, large = (peak(work, p) for p in paths)
    assert (large - small) / (sizes[1] - sizes[0]) < most


def test_a_further_run_takes_little_memory_in_info(monkeypatch, capsys, tmp_path) -> None:
    sizes = (2 * LISTED, 6 * LISTED)
    paths = [write_log(tmp_path / f"{n}.parquet", n) for n in sizes]
    run_here(monkeypatch, "info", paths[0])
    small, large = (peak(lambda path: run_here(monkeypatch, "info", path), p) for p in paths)
    # 570 bytes; 2120 where what only --json shows was made always
    assert (large - small) / (sizes[1] - sizes[0]) < 1000


def test_evidence_is_kept_of_all_runs_that_can_be_measured(tmp_path) -> None:
    path = write_log(tmp_path / "log.parquet", LISTED + 5, samples=40)
    found = gate.Witnesses()
    short = next(iter(read_runs(path))).cut(slice(0, 3))
    for _ in range(LISTED + 5):
        found.add(short)
    assert (len(found.log), found.short) == (LISTED, 5)
    assert found.add(next(iter(read_runs(path))), "other").run_id == "other" and len(found.log) == LISTED + 1
