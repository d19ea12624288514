"""Atomic files, tables, runs and errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sstl_cli.core.config import Model, parse, read_toml
from sstl_cli.core.errors import SstlError, UsageError, nearest, printable
from sstl_cli.core.files import atomic, dumps, make_folder, read_json, require_outputs, write_text
from sstl_cli.core.parquet import open_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run, read_runs, write_runs
from sstl_cli.core.tables import LOG, THETA


def run(name="r", n=20, **more):
    t = np.arange(n) * 0.1
    return Run(name, "act", t, 1.0 + t, 0.5 + t, config_id="c", **more)


def test_a_failed_write_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError), atomic(tmp_path / "x") as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_a_failed_overwrite_leaves_the_old_file(tmp_path):
    (tmp_path / "x").write_text("old")
    with pytest.raises(RuntimeError), atomic(tmp_path / "x", force=True) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


def test_a_file_made_meanwhile_is_not_overwritten(tmp_path):
    with pytest.raises(SstlError, match="another process"), atomic(tmp_path / "x") as temporary:
        temporary.write_text("mine")
        (tmp_path / "x").write_text("theirs")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["theirs"]


def test_runs_round_trip(tmp_path):
    made = [run("a", lead_mm=2.5, position_in_mm=np.arange(20.0)), run("b", tension_ref_n=np.full(20, 3.0))]
    write_runs(tmp_path / "x.parquet", made, Provenance("test"))
    back = list(read_runs(tmp_path / "x.parquet"))
    assert [r.run_id for r in back] == ["a", "b"]
    for a, b in zip(made, back, strict=True):
        for name in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n"):
            x, y = getattr(a, name), getattr(b, name)
            assert (x is None and y is None) or np.array_equal(x, y)
        assert (a.lead_mm, a.config_id, a.location) == (b.lead_mm, b.config_id, b.location)


def test_units_and_provenance_stand_in_the_file(tmp_path):
    write_runs(tmp_path / "x.parquet", [run()], Provenance("sstl test", seed=3, inputs={"a": "00"}))
    schema = pq.read_schema(tmp_path / "x.parquet")
    assert schema.field("tension_in_n").metadata[b"unit"] == b"N"
    assert b'"seed": 3' in schema.metadata[b"sstl"] and b'"schema": "sstl.log"' in schema.metadata[b"sstl"]


def test_a_run_in_two_pieces_is_an_error(tmp_path):
    write_runs(tmp_path / "x.parquet", [run("a"), run("b")], Provenance("t"))
    table = pq.read_table(tmp_path / "x.parquet")
    pq.write_table(pa.concat_tables([table, table.slice(0, 20)]), tmp_path / "y.parquet")
    with pytest.raises(SstlError, match="two pieces"):
        list(read_runs(tmp_path / "y.parquet"))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: t.drop_columns(["tension_in_n"]), "misses column 'tension_in_n'"),
        (lambda t: t.rename_columns([c.replace("tension_in_n", "tension_inn") for c in t.column_names]), "did you mean 'tension_inn'"),
        (lambda t: t.set_column(7, "tension_in_n", pa.array(["x"] * t.num_rows)), "column 'tension_in_n' holds string"),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, change, says):
    write_runs(tmp_path / "x.parquet", [run()], Provenance("t"))
    pq.write_table(change(pq.read_table(tmp_path / "x.parquet")), tmp_path / "y.parquet")
    with pytest.raises(SstlError, match=says):
        open_table(tmp_path / "y.parquet", LOG).table()


def test_another_table_or_version_is_refused(tmp_path):
    write_runs(tmp_path / "x.parquet", [run()], Provenance("t"))
    with pytest.raises(SstlError, match="not 'sstl.theta'"):
        open_table(tmp_path / "x.parquet", THETA)
    table = pq.read_table(tmp_path / "x.parquet")
    newer = table.replace_schema_metadata({"sstl": table.schema.metadata[b"sstl"].replace(b'"schema_version": 1', b'"schema_version": 9')})
    pq.write_table(newer, tmp_path / "y.parquet")
    with pytest.raises(SstlError, match="version 9"):
        open_table(tmp_path / "y.parquet", LOG)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b"PAR1", "cut off or damaged; copy it again"),
        (b"a,b\n1,2\n", "is text.*sstl import x"),
        (b'{"schema": "sstl.diagnosis/1"}', "is a JSON document.*sstl info x"),
        (b"\x89HDF\r\n\x1a\n\0\0\0", "is no Parquet file.*sstl import x"),
        (b"\x02\0\0\0\0\0\0\0{}", "is a model file"),
    ],
)
def test_what_is_no_parquet_says_what_reads_it(tmp_path, content, said):
    (tmp_path / "x.parquet").write_bytes(content)
    with pytest.raises(SstlError, match=said):
        open_table(tmp_path / "x.parquet", LOG)


def test_truncated_parquet_is_refused(tmp_path):
    write_runs(tmp_path / "x.parquet", [run()], Provenance("t"))
    data = (tmp_path / "x.parquet").read_bytes()
    (tmp_path / "y.parquet").write_bytes(data[: len(data) // 2])
    with pytest.raises(SstlError):
        list(read_runs(tmp_path / "y.parquet"))


def test_a_dash_is_no_name_of_an_output(tmp_path, monkeypatch):
    """Others mean the standard output by it; a file of that name is hard to remove."""
    monkeypatch.chdir(tmp_path)
    for write in (
        lambda: require_outputs(True, tmp_path / "-2", Path("-")),
        lambda: make_folder(Path("-")),
        lambda: write_text(Path("-"), "x"),
    ):
        with pytest.raises(UsageError, match=r"E115.*no file.*give the name of a file"):
            write()
    assert list(tmp_path.iterdir()) == []


class Small(Model):
    speed: float = 1.0


def test_a_wrong_key_or_value_is_named(tmp_path):
    with pytest.raises(SstlError, match="did you mean 'speed'"):
        parse(Small, {"sped": 1}, "x.toml")
    with pytest.raises(SstlError, match="'speed'"):
        parse(Small, {"speed": "fast"}, "x.toml")
    (tmp_path / "x.toml").write_text("a = [")
    with pytest.raises(SstlError, match="not valid TOML"):
        read_toml(tmp_path / "x.toml")


def test_json_has_no_nan_and_is_checked(tmp_path):
    assert '"a": null' in dumps({"a": float("nan")})
    write_text(tmp_path / "x.json", "{")
    with pytest.raises(SstlError, match="not valid JSON"):
        read_json(tmp_path / "x.json")


@given(st.text())
def test_errors_hold_no_control_characters(text):
    line = SstlError(text, where=text).line()
    assert line.isprintable()
    assert printable(text).isprintable()


def test_streams_depend_on_names_not_on_order():
    a = stream(1, "noise", "run-1").random(3)
    stream(1, "noise", "run-2").random(3)
    assert np.array_equal(a, stream(1, "noise", "run-1").random(3))
    assert not np.array_equal(a, stream(2, "noise", "run-1").random(3))


def test_nearest_lists_names_where_none_is_close():
    assert nearest("zzz", ["alpha", "beta"]) == "known: alpha, beta"
