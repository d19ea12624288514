"""Runs whose rows take turns, as a database gives them by time, come out as the same runs as one after the other."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.importers import text, turns
from sstl_cli.importers.chunk import Chunk
from sstl_cli.importers.counts import Counts
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import Import, run

SAMPLES = 240


def recorded(names: list[str], samples: int = SAMPLES, apart_s: float = 0.0) -> pd.DataFrame:
    """Runs that were recorded at once, each a little after the one before; a system and a bend each, in the order of the runs."""
    parts = []
    for i, name in enumerate(names):
        t = 0.01 * np.arange(samples) + 0.001 * i + apart_s * i
        system, bend = ("act", "sstl")[i % 2], f"CP-{i // 2:02}"
        force = 5 + i + np.sin(t)
        parts.append(
            pd.DataFrame(
                {"run_id": name, "config_id": bend, "system": system, "time_s": t, "tension_in_n": force, "tension_out_n": 0.8 * force}
            )
        )
    return pd.concat(parts, ignore_index=True)


def by_time(table: pd.DataFrame) -> pd.DataFrame:
    return table.sort_values("time_s", kind="stable", ignore_index=True)


def write(table: pd.DataFrame, path: Path) -> Path:
    table.to_parquet(path) if path.suffix == ".parquet" else table.to_csv(path, index=False)
    return path


def load(path: Path, **document: object) -> tuple[Import, dict[str, Run]]:
    result = run([path], mapping_of(dict(document), "test"))
    found: dict[str, Run] = {}
    last = ""
    for piece in result.runs:
        # pieces of a run follow one another
        assert piece.run_id == last or piece.run_id not in found
        last = piece.run_id
        found[last] = piece if last not in found else _and(found[last], piece)
    return result, found


def _and(first: Run, second: Run) -> Run:
    names = ("time_s", "tension_in_n", "tension_out_n")
    return replace(first, **{n: np.concatenate([getattr(first, n), getattr(second, n)]) for n in names})


def same(a: dict[str, Run], b: dict[str, Run]) -> None:
    assert list(a) == list(b)
    for one, other in zip(a.values(), b.values(), strict=True):
        assert (one.run_id, one.system, one.config_id) == (other.run_id, other.system, other.config_id)
        for name in ("time_s", "tension_in_n", "tension_out_n"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_rows_by_time_are_the_runs_that_rows_by_run_are(tmp_path: Path, kind: str) -> None:
    table = recorded(["a", "b", "c", "d"])
    plain, wanted = load(write(table, tmp_path / f"by_run.{kind}"))
    mixed, found = load(write(by_time(table), tmp_path / f"by_time.{kind}"))
    same(found, wanted)
    assert plain.remarks == [] and plain.counts.runs == mixed.counts.runs == 4 and not mixed.set_aside
    assert mixed.counts.samples_out == 4 * SAMPLES
    assert [r for r in mixed.remarks if "4 runs were brought together by run_id" in r and "sorted by time?" in r]


def test_many_runs_and_rows_wait_in_a_file_and_none_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = recorded([f"r{i:02}" for i in range(40)])
    _, wanted = load(write(table, tmp_path / "by_run.csv"))
    monkeypatch.setattr(turns, "AWAY_ROWS", 50)
    monkeypatch.setattr(turns, "MOST_ROWS", 1000)
    path = write(by_time(table), tmp_path / "by_time.csv")
    monkeypatch.setattr(text, "BLOCK_BYTES", 4096)
    fetched = []
    back = turns._Runs._back
    monkeypatch.setattr(turns._Runs, "_back", lambda self, place: fetched.append(place) or back(self, place))
    same(load(path)[1], wanted)
    # nine batches of a thousand rows, of which the last stays in memory
    assert len(fetched) > 8 * 40


def test_memory_does_not_grow_with_the_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "AWAY_ROWS", 500)
    monkeypatch.setattr(turns, "MOST_ROWS", 5000)

    def taking_turns(chunks: int) -> Iterator[Chunk]:
        for i in range(chunks):
            k = np.arange(1000 * i, 1000 * (i + 1))
            time = 0.01 * (k // 20) + 0.0001 * (k % 20)
            yield Chunk(
                {"time_s": time, "tension_in_n": time + 1.0, "tension_out_n": time + 2.0}, {"run_id": pa.array([f"r{n % 20}" for n in k])}
            )

    peaks = []
    for chunks in (20, 20, 80):
        tracemalloc.start()
        assert sum(map(len, turns.by_run(taking_turns(chunks), None, Counts(), "x"))) == 1000 * chunks
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # the first one loads what is needed
    assert peaks[2] < 1.3 * peaks[1]


def test_runs_that_begin_to_take_turns_late_are_whole_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "AWAY_ROWS", 100)
    monkeypatch.setattr(text, "BLOCK_BYTES", 4096)
    alone = recorded(["first", "second"], 500, apart_s=100.0)
    pair = recorded(["first", "second", "third", "fourth"]).iloc[2 * SAMPLES :].assign(time_s=lambda t: t.time_s + 1000.0)
    table = pd.concat([alone, pair], ignore_index=True)
    _, wanted = load(write(table, tmp_path / "by_run.csv"))
    mixed, found = load(write(by_time(table), tmp_path / "by_time.csv"))
    same(found, wanted)
    assert mixed.counts.runs == 4


def test_systems_beside_one_another_without_a_run_id_are_two_runs(tmp_path: Path) -> None:
    table = recorded(["a", "b"]).drop(columns="run_id")
    _, found = load(write(by_time(table), tmp_path / "pair.csv"))
    assert [(r.system, len(r)) for r in found.values()] == [("act", SAMPLES), ("sstl", SAMPLES)]


@pytest.mark.parametrize("on_gap", ["split", "fill"])
def test_a_bend_that_comes_back_later_is_another_run(tmp_path: Path, on_gap: str) -> None:
    """Bends in turn, each for a while: what was one run after the other stays so."""
    table = recorded(["a", "b", "c"], 60, apart_s=0.6).assign(config_id=["20"] * 60 + ["80"] * 60 + ["20"] * 60, system="act")
    result, found = load(write(table.drop(columns="run_id"), tmp_path / "bends.csv"), time={"on_gap": on_gap})
    assert [(r.config_id, len(r)) for r in found.values()] == [("20", 60), ("80", 60), ("20", 60)]
    assert result.remarks == [] and result.counts.filled == 0


def test_a_run_id_used_twice_is_two_runs_as_before(tmp_path: Path) -> None:
    table = recorded(["a", "b", "a"], 60, apart_s=0.0).assign(system="act", config_id="c")
    table["time_s"] = np.tile(0.01 * np.arange(60), 3)
    _, found = load(write(table, tmp_path / "again.csv"))
    assert {k: len(v) for k, v in found.items()} == {"a": 60, "b": 60, "a-2": 60}


def test_labels_that_change_within_a_run_are_told_in_turns_too(tmp_path: Path) -> None:
    table = by_time(recorded(["a", "b"]))
    table.loc[table.index >= SAMPLES, "config_id"] = "other"
    with pytest.raises(Exception, match="E355.*config_id changes within a run"):
        load(write(table, tmp_path / "labels.csv"))
