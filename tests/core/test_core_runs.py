"""Runs survive the file; what cannot be a run is refused."""

from __future__ import annotations

import dataclasses
import itertools
import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.core import parquet, run_parts
from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.run_parts import LABELS, SIGNALS
from sstl_cli.core.runs import Run, read_runs, recorded_runs, run_table, write_runs

MADE = Provenance("sstl test", 1)


def make(run_id: str = "a", n: int = 5, **more: object) -> Run:
    t = np.arange(n) * 0.002
    values = {"run_id": run_id, "system": "act", "time_s": t, "tension_in_n": 10 * t, "tension_out_n": 6 * t}
    return Run(**{**values, **more})


def same(a: Run, b: Run) -> None:
    assert [getattr(a, n) for n in LABELS] == [getattr(b, n) for n in LABELS]
    for name in SIGNALS:
        x, y = getattr(a, name), getattr(b, name)
        assert (x is None) == (y is None), name
        if x is not None:
            np.testing.assert_array_equal(x, y)


def raw(path: Path, **columns: object) -> Path:
    """A log as a foreign program writes it: four samples of run a unless stated."""
    base = {"run_id": ["a"] * 4, "system": ["act"] * 4, "time_s": [0.0, 1, 2, 3]}
    base |= {"tension_in_n": [1.0] * 4, "tension_out_n": [1.0] * 4}
    pq.write_table(pa.table({**base, **columns}), path)
    return path


def test_round_trip_with_nulls_nan_and_tendon(tmp_path: Path) -> None:
    gaps = np.array([0.5, np.nan, 1.0, np.nan, 2.0])
    runs = [
        make("a", config_id="CP-020", location="CP", lead_mm=20.0, trajectory="sine", tendon="left"),
        make("b", system="sstl", position_in_mm=gaps, tension_ref_n=np.full(5, 3.0)),
        make("c", n=1, tension_out_n=np.array([np.nan])),
    ]
    path = tmp_path / "log.parquet"
    assert write_runs(path, iter(runs), MADE) == 11
    found = list(recorded_runs(path))
    assert len(found) == 3
    for a, b in zip(runs, found, strict=True):
        same(a, b)
    assert [r.passes for r in found] == [1, 2, 1]
    assert found[0].dt_s == pytest.approx(0.002) and np.isnan(found[2].dt_s)


def test_nan_of_an_optional_channel_is_null_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    write_runs(path, [make(position_in_mm=np.array([0.0, np.nan, 1, 2, 3]))], MADE)
    assert pq.read_table(path).column("position_in_mm").null_count == 1


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(1, 7), st.sampled_from(["act", "sstl"]), st.none() | st.text(max_size=4), st.integers(0, 8)),
        min_size=1,
        max_size=9,
    ),
    st.integers(1, 9),
)
def test_blocks_of_any_size_give_the_same_runs(tmp_path_factory: pytest.TempPathFactory, shape: list, rows: int) -> None:
    # the position is there from some sample on: in every, in some and in no block of its run
    positions = [np.where(np.arange(n) < missing, np.nan, 1.0) if missing < n else None for n, _, _, missing in shape]
    labels = [{"system": s, "config_id": c, "trajectory": c} for _, s, c, _ in shape]
    runs = [make(f"r{i}", shape[i][0], position_in_mm=p, **labels[i]) for i, p in enumerate(positions)]
    path = tmp_path_factory.mktemp("runs") / "log.parquet"
    write_runs(path, runs, MADE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parquet, "ROWS_PER_BLOCK", rows)
        for a, b in itertools.zip_longest(runs, read_runs(path)):
            same(a, b)


def test_same_runs_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_runs(tmp_path / name, [make("x", 3000), make("y", 10)], MADE)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_no_run_writes_no_file(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="E120"):
        write_runs(tmp_path / "log.parquet", [], MADE)
    assert list(tmp_path.iterdir()) == []


def test_failing_source_leaves_no_file(tmp_path: Path) -> None:
    def source():
        yield make("a")
        raise SstlError("broken")

    with pytest.raises(SstlError, match="broken"):
        write_runs(tmp_path / "log.parquet", source(), MADE)
    assert list(tmp_path.iterdir()) == []


def test_run_in_two_pieces(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="E122.*run 'a'.*two pieces.*sort"):
        list(read_runs(raw(tmp_path / "l.parquet", run_id=["a", "b", "b", "a"])))


@pytest.mark.parametrize("rows", [1, 2, 3, 100])
@pytest.mark.parametrize("ids", [["x", "x", "y", "y"], ["x", None, None, None], [None, "x", "x", "x"], ["x", "x", "x", "y"]])
def test_label_that_changes_within_a_run(tmp_path: Path, ids: list, rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet, "ROWS_PER_BLOCK", rows)
    with pytest.raises(SstlError, match="E123.*run 'a'.*config_id changes"):
        list(read_runs(raw(tmp_path / "l.parquet", config_id=ids)))


@pytest.mark.parametrize("rows", [1, 2, 3, 100])
def test_labels_may_change_between_runs(tmp_path: Path, rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet, "ROWS_PER_BLOCK", rows)
    path = raw(tmp_path / "l.parquet", run_id=["a", "a", "b", "c"], config_id=["x", "x", None, "x"])
    assert [(r.run_id, r.config_id, len(r)) for r in read_runs(path)] == [("a", "x", 2), ("b", None, 1), ("c", "x", 1)]


def test_text_stored_in_other_ways(tmp_path: Path) -> None:
    ids = ["a", "a", "b", "b"]
    twice = pa.DictionaryArray.from_arrays(pa.array([0, 1, 2, 2]), pa.array(["a", "a", "b"]))
    for column in (pa.array(ids, pa.large_string()), pa.array(ids).dictionary_encode(), twice, pa.array([1, 1, 2, 2])):
        runs = list(read_runs(raw(tmp_path / "l.parquet", run_id=column)))
        assert [len(r) for r in runs] == [2, 2] and [r.run_id for r in runs] in (["a", "b"], ["1", "2"])
        (tmp_path / "l.parquet").unlink()


def test_unknown_system_and_null_run_id(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="E124.*'ACT'.*'act' or 'sstl'"):
        list(read_runs(raw(tmp_path / "l.parquet", system=["ACT"] * 4)))
    with pytest.raises(SstlError, match="E136.*run_id"):
        list(read_runs(raw(tmp_path / "m.parquet", run_id=["a", None, "a", "a"])))


def test_run_table_has_the_schema_of_the_log() -> None:
    table = run_table(make())
    assert table.schema.field("tension_in_n").metadata[b"unit"] == b"N"
    assert table.column("config_id").null_count == 5
    assert run_table(make(tendon="left"), with_tendon=True).column("tendon").to_pylist() == ["left"] * 5


def test_runs_are_read_one_by_one(tmp_path: Path) -> None:
    path = tmp_path / "l.parquet"
    write_runs(path, (make(f"r{i}", 10) for i in range(50)), MADE)
    stream = read_runs(path)
    assert next(stream).run_id == "r0" and next(stream).run_id == "r1"
    assert dataclasses.is_dataclass(next(stream))


def test_columns_not_needed_are_not_read(tmp_path):
    t = np.arange(50) * 0.1
    runs = [Run(f"r{i}", "act", t, t + 1, t + 2, config_id="c", trajectory="x", position_in_mm=t) for i in range(3)]
    write_runs(tmp_path / "x.parquet", runs, Provenance("t"))
    for one, whole in zip(
        read_runs(tmp_path / "x.parquet", ("position_in_mm", "trajectory")), read_runs(tmp_path / "x.parquet"), strict=True
    ):
        assert one.position_in_mm is None and one.trajectory is None
        assert whole.position_in_mm is not None and whole.trajectory == "x"
        assert (one.run_id, one.config_id, one.system) == (whole.run_id, whole.config_id, whole.system)
        np.testing.assert_array_equal(one.tension_out_n, whole.tension_out_n)


def test_channels_that_hold_nothing_are_not_decoded(tmp_path, monkeypatch):
    write_runs(tmp_path / "x.parquet", [make("a", 300), make("b", 300)], MADE)
    asked = []
    whole = pq.ParquetFile.iter_batches

    def counted(self, rows, *args, columns, **more):
        # one row is read to have the footer looked at
        asked.extend(columns if rows > 1 else ())
        return whole(self, rows, *args, columns=columns, **more)

    monkeypatch.setattr(pq.ParquetFile, "iter_batches", counted)
    runs = list(read_runs(tmp_path / "x.parquet"))
    # the labels are known from the statistics too
    assert asked == ["time_s", "tension_in_n", "tension_out_n"]
    assert [(r.run_id, r.system, r.position_in_mm, r.lead_mm) for r in runs] == [("a", "act", None, None), ("b", "act", None, None)]


def test_memory_of_reading_does_not_grow_with_the_number_of_runs(tmp_path):
    rng = np.random.default_rng(0)
    t = np.arange(4000) * 0.01
    sizes = {}
    # five blocks and fifteen: what is held is the block at hand, the next one, and what is being decoded
    for count in (300, 900):
        runs = (Run(f"r{i}", "act", t, *rng.normal(5, 1, (2, len(t)))) for i in range(count))
        write_runs(tmp_path / f"{count}.parquet", runs, Provenance("t"))
        before, most = pa.total_allocated_bytes(), 0
        for _ in read_runs(tmp_path / f"{count}.parquet"):
            most = max(most, pa.total_allocated_bytes() - before)
        sizes[count] = most
    # one reader over all row groups held everything: three times as much
    assert sizes[900] < 1.5 * sizes[300]


def test_a_run_of_many_blocks_is_never_held_twice(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "ROWS_PER_BLOCK", 20_000)
    n = 400_000
    position = np.where(np.arange(n) < 70_000, np.nan, 1.5)
    made = make("a", n=n, position_in_mm=position)
    write_runs(tmp_path / "log.parquet", [made], MADE)
    blocks, add = [], run_parts.Pending.add

    def watched(pending: run_parts.Pending, part: run_parts.Part) -> None:
        add(pending, part)
        blocks.append(pa.total_allocated_bytes() - before)

    monkeypatch.setattr(run_parts.Pending, "add", watched)
    before = pa.total_allocated_bytes()
    tracemalloc.start()
    (found,) = read_runs(tmp_path / "log.parquet")
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    same(found, made)
    # four channels; blocks of a twentieth of them come and go, and no steps of the whole clock are made
    whole = 4 * 8 * n
    assert most < 1.2 * whole and len(blocks) == 19 and max(blocks) < 0.5 * whole
