"""Parts of recordings, joined rows, norms, own units, refreshed samples, clocks of another zero, bad files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from test_importers_cli import HEAD, log_csv, sstl
from test_importers_repair import even, load, write

from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, read_runs, write_runs
from sstl_cli.importers import text
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps import import_ as step

ACT = {"constants": {"system": "act"}}


def test_time_window_and_both_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "x.csv", even(200, start=1.7e9))
    result, (one,) = load(path, time={"from_s": 5.0, "to_s": 9.95})
    assert len(one) == 50 and one.tension_in_n[0] == 51 and result.counts.set_aside == 0
    assert any("150 samples outside the window" in r for r in result.counts.remarks)
    monkeypatch.setattr(text, "BLOCK_BYTES", 500)
    _, (cut,) = load(path, skip_samples=10, skip_end_samples=30)
    np.testing.assert_array_equal(cut.tension_in_n, np.arange(11, 171))
    with pytest.raises(SstlError, match="not after from_s"):
        load(path, time={"from_s": 5, "to_s": 5})


def test_time_scale_and_offset(tmp_path: Path) -> None:
    path = write(tmp_path / "x.csv", even(20, start=3.0))
    _, (one,) = load(path, columns={"time_s": {"column": "time_s", "offset": 3.0, "scale": 1.5}})
    np.testing.assert_allclose(one.time_s, 0.15 * np.arange(20), atol=1e-9)


def test_norm_and_difference_of_channels_with_their_zeros(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("t,x,y,z,a,b\n" + "".join(f"{i},{3 * i + 1},{4 * i - 2},{12 * i},{5 * i},{i}\n" for i in range(9)))
    columns = {
        "time_s": "t",
        "tension_in_n": {"norm": ["x", "y", "z"], "zeros": [1, -2, 0], "unit": "mN"},
        "tension_out_n": {"minus": ["a", "b"], "zeros": [2, 5], "unit": "N"},
    }
    _, (one,) = load(path, columns=columns, **ACT)
    np.testing.assert_allclose(one.tension_in_n, 0.013 * np.arange(9), rtol=1e-12)
    np.testing.assert_array_equal(one.tension_out_n, 4.0 * np.arange(9) + 3)
    with pytest.raises(SstlError, match="one each"):
        load(path, columns={**columns, "tension_out_n": {"minus": ["a", "b"], "zeros": [2]}}, **ACT)


def test_arrays_joined_by_row(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    a, b = rng.random(1000), rng.random(1000)
    np.save(tmp_path / "fin.npy", a)
    np.savetxt(tmp_path / "fout.txt", b, header="load", comments="")
    document = {
        "columns": {
            "time_s": {"rate_hz": 500},
            "tension_in_n": {"column": "fin", "unit": "N"},
            "tension_out_n": {"column": "load", "unit": "N"},
        },
        "files": {"merge": "rows"},
        **ACT,
    }
    _, (one,) = load([tmp_path / "fin.npy", tmp_path / "fout.txt"], **document)
    np.testing.assert_array_equal(one.tension_in_n, a)
    np.testing.assert_array_equal(one.tension_out_n, b)
    np.testing.assert_allclose(one.time_s, np.arange(1000) / 500)
    np.save(tmp_path / "fin.npy", a[:900])
    with pytest.raises(SstlError, match=r"has 900 rows.*'fout\.txt' has more"):
        load([tmp_path / "fin.npy", tmp_path / "fout.txt"], **document)


def test_only_refreshed_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [(0.01 * i, i, i // 10) for i in range(200)]
    path = write(tmp_path / "x.csv", rows)
    for size in (4 << 20, 300):
        monkeypatch.setattr(text, "BLOCK_BYTES", size)
        result, (one,) = load(path, repair={"refreshed": "tension_out_n"})
        np.testing.assert_array_equal(one.tension_out_n, np.arange(20))
        np.testing.assert_array_equal(one.tension_in_n, 10 * np.arange(20))
        assert result.document("log.parquet", {}).set_aside_by == {"not refreshed by the sensor": 180}


def test_unix_time_beside_a_clock_from_zero(tmp_path: Path) -> None:
    ta, tb = np.arange(0, 60, 0.02), np.arange(0, 60, 0.03)
    f = lambda t: 5 + np.sin(t) + 0.5 * np.sin(2.7 * t)  # noqa: E731
    np.savetxt(tmp_path / "in.csv", np.c_[1.7e9 + ta, f(ta)], fmt="%.6f", header="t,force", comments="", delimiter=",")
    np.savetxt(tmp_path / "out.csv", np.c_[tb, 2 * f(tb + 0.3)], fmt="%.6f", header="t,load", comments="", delimiter=",")
    document = {
        "columns": {
            "time_s": {"column": "t", "file": "in"},
            "tension_in_n": {"column": "force", "unit": "N"},
            "tension_out_n": {"column": "load", "unit": "N", "time": "t"},
        },
        "files": {"merge": "channels"},
        **ACT,
    }
    files = [tmp_path / "in.csv", tmp_path / "out.csv"]
    with pytest.raises(SstlError, match=r"never meet.*align = \"start\""):
        load(files, **document)
    _, (started,) = load(files, clocks={"align": "start"}, **document)
    np.testing.assert_allclose(started.tension_out_n, 2 * f(started.time_s - 1.7e9 + 0.3), atol=2e-3)
    result, (moved,) = load(files, clocks={"align": "apply"}, **document)
    assert result.clocks[0].used
    np.testing.assert_allclose(moved.tension_out_n, 2 * moved.tension_in_n, atol=2e-2)


def test_own_units_and_channels_that_are_no_tension(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("t,f,a\n" + "".join(f"{i},{i},{2 * i}\n" for i in range(40)))
    document = {
        "units": {"div": "0.25 N", "notch": "2e-3 mm"},
        "columns": {
            "time_s": "t",
            "tension_in_n": {"column": "f", "unit": "div", "offset": 4},
            "tension_out_n": {"column": "a", "unit": "px", "as": "N"},
        },
        **ACT,
    }
    _, runs = load(path, **document)
    np.testing.assert_array_equal(runs[0].tension_in_n, 0.25 * (np.arange(40) - 4))
    assert (runs[0].unit_in, runs[0].unit_out) == ("N", "px")
    write_runs(tmp_path / "log.parquet", runs, Provenance("test"))
    assert pq.read_schema(tmp_path / "log.parquet").field("tension_out_n").metadata[b"unit"] == b"px"
    (back,) = read_runs(tmp_path / "log.parquet")
    assert back.unit_out == "px"
    # the log table comes back through import in the same unit
    _, (again,) = load(tmp_path / "log.parquet")
    assert again.unit_out == "px"
    for wrong, match in (({"N": "2 N"}, "known unit"), ({"div": "2 foo"}, "a number and a known unit")):
        with pytest.raises(SstlError, match=match):
            mapping_of({**document, "units": wrong}, "test")


def test_the_unit_of_the_output_reaches_segment_info_and_check(tmp_path: Path) -> None:
    t = np.arange(6000) * 0.01
    x = 10 - 8 * np.cos(2 * np.pi * t / 10)
    out = np.empty_like(x)
    now = 0.0
    for i, v in enumerate(x):
        now = min(max(now, 0.6 * v), 0.9 * v)
        out[i] = now
    noise = np.random.default_rng(2).normal(0, 0.01, (2, len(t)))
    table = np.c_[t, x + noise[0], out + noise[1]]
    np.savetxt(tmp_path / "x.csv", table, header="t,f,a", comments="", delimiter=",", fmt="%.5f")
    (tmp_path / "m.toml").write_text(
        '[columns]\ntime_s = "t"\ntension_in_n = {column = "f", unit = "N"}\n'
        'tension_out_n = {column = "a", unit = "deg", as = "N"}\n[constants]\nsystem = "act"\n'
    )
    log = tmp_path / "log.parquet"
    assert sstl("import", tmp_path / "x.csv", "--mapping", tmp_path / "m.toml", "--out", log).returncode == 0
    done = sstl("segment", log, "--out", tmp_path / "theta.parquet", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["unit"] == "deg"
    assert "deg" in sstl("segment", log, "--out", tmp_path / "t.parquet").stdout
    fields = pq.read_schema(tmp_path / "theta.parquet")
    assert [fields.field(n).metadata[b"unit"] for n in ("gamma_p", "beta_p")] == [b"deg/N", b"deg"]
    assert "T_out deg" in sstl("info", log).stdout
    check = json.loads(sstl("check", log, "--json").stdout)
    assert not [f for f in check["findings"] if f["what"] == "wrong unit"]
    assert [f["column"] for f in check["findings"] if f["what"] == "not a tension"] == ["tension_out_n"]


def test_a_bad_file_of_a_batch_is_set_aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = log_csv(tmp_path)
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "late.csv").write_text(HEAD + "".join(f"q,act,{i},{i},{i}\n" for i in range(500)) + "q,act,500,x,1\n")
    (tmp_path / "other.csv").write_text("time,force\n" + "".join(f"{i},{i}\n" for i in range(20)))
    files = [tmp_path / "empty.csv", tmp_path / "late.csv", good, tmp_path / "other.csv"]
    done = sstl("import", *files, "--out", tmp_path / "a.parquet", "--json")
    assert done.returncode == 3, done.stderr
    document = json.loads(done.stdout)
    assert [b["file"] for b in document["files_set_aside"]] == ["empty.csv", "late.csv", "other.csv"]
    assert "[E328]" in done.stderr and document["samples_in"] == 100
    assert [r.run_id for r in read_runs(tmp_path / "a.parquet")] == ["r1", "r2"]
    alone = sstl("import", files[1], "--out", tmp_path / "b.parquet")
    assert alone.returncode == 1 and "line 502" in alone.stderr and not (tmp_path / "b.parquet").exists()
    none = sstl("import", files[0], files[1], "--out", tmp_path / "b.parquet")
    assert none.returncode == 1 and "empty.csv" in none.stderr and not (tmp_path / "b.parquet").exists()
    # what is too long to wait in memory ends the import, and nothing half-written stays
    monkeypatch.setattr(step, "HELD_SAMPLES", 10)
    monkeypatch.setattr("sstl_cli.importers.turns.AWAY_ROWS", 50)
    monkeypatch.setattr("sstl_cli.importers.repair.PIECE_ROWS", 50)
    monkeypatch.setattr(text, "BLOCK_BYTES", 1000)
    with pytest.raises(SstlError, match="line 502"):
        load([files[1], good])


def test_a_parquet_file_without_its_end_says_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "cut.parquet"
    write_runs(path, [Run("r", "act", np.arange(50.0), np.arange(50.0), np.arange(50.0))], Provenance("test"))
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(SstlError, match=r"without its end.*copy it again") as caught:
        load(path)
    assert "magic" not in str(caught.value)
