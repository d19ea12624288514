"""Mapping, units, clocks and the repair of time: hand-made recordings with known faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.units import conversion, unit_of
from sstl_cli.importers import repair, text
from sstl_cli.importers.clocks import compare
from sstl_cli.importers.follow import TextFollower
from sstl_cli.importers.inline import inline_mapping
from sstl_cli.importers.mapping import Mapping, mapping_of
from sstl_cli.importers.sources import read_manifest
from sstl_cli.steps.import_ import Import, run

HEAD = "system,time_s,tension_in_n,tension_out_n\n"


def write(path: Path, rows: list[tuple[object, ...]]) -> Path:
    path.write_text(HEAD + "".join("act," + ",".join(map(str, r)) + "\n" for r in rows))
    return path


def load(path: Path | list[Path], **document: object) -> tuple[Import, list]:
    result = run(path if isinstance(path, list) else [path], mapping_of(dict(document), "test"))
    return result, list(result.runs)


def even(n: int, start: float = 0.0) -> list[tuple[object, ...]]:
    return [(round(start + 0.1 * i, 6), i + 1, 2 * i + 1) for i in range(n)]


@pytest.mark.parametrize(
    ("unit", "options", "target", "raw", "expected"),
    [
        ("mN", {}, "force", 1500, 1.5),
        ("kgf", {}, "force", 2, 19.6133),
        ("lbf", {}, "force", 1, 4.4482216152605),
        ("V", {"gain": 20.0, "offset": 0.5}, "force", 1.5, 20.0),
        ("mV", {"gain": 20.0}, "force", 500, 10.0),
        ("bar", {"area_mm2": 100.0}, "force", 1, 10.0),
        ("deg", {"radius_mm": 10.0}, "length", 180, 31.41592653589793),
        ("in", {}, "length", 1, 25.4),
        ("ns", {}, "time", 5e9, 5.0),
        ("min", {}, "time", 2, 120.0),
        ("N", {"sign": -1}, "force", 3, -3.0),
    ],
)
def test_units(unit: str, options: dict, target: str, raw: float, expected: float) -> None:
    c = conversion(unit, target, **options)
    assert c.factor * (raw - c.offset) == pytest.approx(expected, rel=1e-12)


def test_wrong_units_name_the_nearest() -> None:
    with pytest.raises(SstlError, match="did you mean 'kgf'"):
        unit_of("KGF")
    with pytest.raises(SstlError, match="not a force"):
        conversion("s", "force")
    with pytest.raises(SstlError, match="needs a gain"):
        conversion("V", "force")
    with pytest.raises(UsageError, match="did you mean 'lbf'"):
        inline_mapping("tension_in_n=col2:lbff")


def test_inline_mapping_reads_difference_sign_pattern_and_constants(tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_text("".join(f"{i * 10} {5 + i} {1 + 2 * i} {-3 * i}\n" for i in range(5)))
    m = inline_mapping("time_s=col1:ms,tension_in_n=col2-col3:N,tension_out_n=-col4:mN,system=sstl,config_id=c7,lead_mm=4.5")
    (one,) = run([path], m).runs
    np.testing.assert_allclose(one.time_s, np.arange(5) * 0.01)
    np.testing.assert_array_equal(one.tension_in_n, 4.0 - np.arange(5))
    np.testing.assert_allclose(one.tension_out_n, 0.003 * np.arange(5))
    assert (one.system, one.config_id, one.lead_mm, one.run_id) == ("sstl", "c7", 4.5, "x")


def test_misspelt_column_names_the_nearest(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("time_s,tension_in,tension_out_n,system\n0,1,2,act\n1,2,3,act\n")
    with pytest.raises(SstlError, match=r"'tension_in_n'.*did you mean 'tension_in'"):
        load(path)
    with pytest.raises(SstlError, match="did you mean 'tension_in'"):
        load(path, columns={"tension_in_n": "tension_inn"})
    with pytest.raises(SstlError, match="did you mean 'tension_in_n'"):
        load(path, columns={"tension_inn": "tension_in"})


def test_text_in_a_number_column_gives_line_and_column(tmp_path: Path) -> None:
    path = write(tmp_path / "x.csv", [(0, 1, 2), (1, 2, 3), (2, "abc", 3)])
    with pytest.raises(SstlError, match=r"line 4: column 'tension_in_n' holds 'abc'"):
        load(path)
    path.write_text(HEAD + "act,0,1,2\nact,1,2\nact,2,3,4\n")
    with pytest.raises(SstlError, match="line 3: has 3 columns"):
        load(path)


@pytest.mark.parametrize(
    "body",
    [
        "t;fin;fout\n0,0;1,5;2,5\n0,1;2,5;3,5\n",
        "# rig 7\nt fin fout\n0.0   1.5 2.5 \n 0.1\t2.5  3.5\n",
        "t\tfin\tfout\ns\tN\tN\n0\t1.5\t2.5\n0.1\t2.5\t3.5\n",
        "\ufefft,fin,fout\r\n0,1.5,2.5\r\n0.1,2.5,3.5",
        "LabVIEW Measurement\nX 1\n***End_of_Header***\nt\tfin\tfout\n0\t1.5\t2.5\n0.1\t2.5\t3.5\n",
    ],
)
def test_text_dialects(body: str, tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_bytes(body.encode())
    columns = {"time_s": "t", "tension_in_n": {"column": "fin", "unit": "N"}, "tension_out_n": {"column": "fout", "unit": "N"}}
    _, (one,) = load(path, columns=columns, constants={"system": "act"})
    np.testing.assert_array_equal(one.tension_in_n, [1.5, 2.5])
    np.testing.assert_array_equal(one.time_s, [0, 0.1])


def test_repeated_time_keeps_the_row_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path / "x.csv", [(0, 1, 1), (0, 2, 2), (0.1, 3, 3), (0.2, 4, 4), (0.2, 5, 5), (0.2, 6, 6)])
    result, (last,) = load(path)
    np.testing.assert_array_equal(last.tension_in_n, [2, 3, 6])
    assert result.counts.set_aside == 3
    _, (first,) = load(path, time={"repeated": "first"})
    np.testing.assert_array_equal(first.tension_in_n, [1, 3, 4])
    with pytest.raises(SstlError, match="repeated"):
        load(path, time={"repeated": "fail"})


@pytest.mark.parametrize(("same", "other", "told"), [(1, 1, True), (0, 0, False), (1, 0, False)])
def test_rows_that_share_a_stamp_and_differ_are_told(same: int, other: int, told: bool, tmp_path: Path) -> None:
    """Of packets stamped as they arrive most readings would go without a word; copies, and rows that bring the news of one channel, are none."""
    rows = [(0.04 * (k // 4), k if same else k // 4, k if other else k // 4) for k in range(80)]
    result, (one,) = load(write(tmp_path / "x.csv", rows))
    assert len(one) == 20 and any("rate_hz" in r for r in result.remarks) == told


def test_gaps(tmp_path: Path) -> None:
    path = write(tmp_path / "x.csv", [*even(30), *even(30, 5.0)])
    result, runs = load(path)
    assert [len(r) for r in runs] == [30, 30] and [r.run_id for r in runs] == ["x", "x-2"]
    assert result.counts.set_aside == 0 and result.counts.found["gaps"] == 1
    _, (filled,) = load(path, time={"on_gap": "fill"})
    np.testing.assert_allclose(np.diff(filled.time_s), 0.1, rtol=1e-6)
    assert len(filled) == 80
    with pytest.raises(SstlError, match=r"gaps.*2\.1 s at 2\.9 s"):
        load(path, time={"on_gap": "fail"})
    assert len(load(path, time={"gap_s": 3.0})[1]) == 1


def test_backward_time(tmp_path: Path) -> None:
    path = write(tmp_path / "x.csv", [*even(10), *even(10)])
    assert [len(r) for r in load(path)[1]] == [10, 10]
    path = write(tmp_path / "x.csv", [*even(10), (0.55, 99, 99), *even(5, 1.0)])
    result, (one,) = load(path, time={"backward": "drop"})
    assert len(one) == 15 and 99 not in one.tension_in_n and result.counts.set_aside == 1
    with pytest.raises(SstlError, match="goes back"):
        load(path, time={"backward": "fail"})


def test_dropouts_and_spikes(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    rows: list = [(0.1 * i, 5 + np.sin(i / 20) + 0.01 * rng.standard_normal(), 3 + np.sin(i / 20)) for i in range(300)]
    rows[40] = (rows[40][0], "nan", rows[40][2])
    rows[41] = (rows[41][0], "", rows[41][2])
    rows[100] = (rows[100][0], 50.0, rows[100][2])
    path = write(tmp_path / "x.csv", rows)
    result, (one,) = load(path)
    assert len(one) == 298 and result.counts.dropouts == 2 and result.counts.spikes == 1 and one.tension_in_n.max() == 50
    result, (one,) = load(path, repair={"dropouts": "interpolate", "spikes": "interpolate"})
    assert len(one) == 300 and one.tension_in_n.max() < 6.1 and result.counts.set_aside == 0
    assert one.tension_in_n[40] == pytest.approx(5 + np.sin(2), abs=0.05)
    with pytest.raises(SstlError, match=r"2 dropouts.*sample 41"):
        load(path, repair={"dropouts": "fail"})


def test_channels_with_rows_of_their_own_name_the_line_that_joins_them(tmp_path: Path) -> None:
    """Every row has one cell that is empty: without a word of it the import ended at "check the file and the mapping"."""
    path = write(tmp_path / "x.csv", [(t, x, "") if i % 2 else (t, "", y) for i, (t, x, y) in enumerate(even(40))])
    with pytest.raises(SstlError, match=r'E345.*40 dropouts.*write dropouts = "interpolate" in \[repair\]'):
        load(path)
    _, (one,) = load(path, repair={"dropouts": "interpolate"})
    assert len(one) == 38
    # it fills nothing where a tension has no number, or begins when the other has ended
    for rows in ([(t, x, "") for t, x, _ in even(40)], [(t, x, "") if i < 20 else (t, "", y) for i, (t, x, y) in enumerate(even(40))]):
        with pytest.raises(SstlError, match="check the file and the mapping"):
            load(write(path, rows))


def test_one_sample_and_empty(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="no run of at least 2 samples"):
        load(write(tmp_path / "x.csv", even(1)))
    (tmp_path / "e.csv").write_text("")
    with pytest.raises(SstlError, match="is empty"):
        load(tmp_path / "e.csv")
    with pytest.raises(SstlError):
        load(write(tmp_path / "h.csv", []))


def test_block_size_does_not_change_the_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    t = np.cumsum(rng.choice([0.0, 0.1, 0.1, 0.1, 3.0], 4000, p=[0.1, 0.3, 0.3, 0.297, 0.003]))
    path = write(tmp_path / "x.csv", [(float(a), i, -i) for i, a in enumerate(t.round(6))])
    whole = load(path, time={"gap_s": 1.0})[1]
    monkeypatch.setattr(text, "BLOCK_BYTES", 1000)
    monkeypatch.setattr(repair, "PIECE_ROWS", 50)
    pieces = load(path, time={"gap_s": 1.0})[1]
    assert len(whole) > 3
    for one in whole:
        mine = [p for p in pieces if p.run_id == one.run_id]
        np.testing.assert_array_equal(np.concatenate([p.time_s for p in mine]), one.time_s)
        np.testing.assert_array_equal(np.concatenate([p.tension_in_n for p in mine]), one.tension_in_n)


def test_clock_offset_and_drift_are_found() -> None:
    rng = np.random.default_rng(7)
    ta = np.arange(0, 120, 0.01)
    tb = np.arange(0, 118, 0.013)

    def content(t: np.ndarray) -> np.ndarray:
        return np.sin(0.9 * t) + 0.6 * np.sin(2.3 * t + 1) + 0.3 * np.sin(5.1 * t + 2)

    true = tb - 1.37 - 180e-6 * (tb - 60)
    report = compare(
        "a", "b", ta, content(ta) + 0.02 * rng.standard_normal(len(ta)), tb, 4 + 2.5 * content(true) + 0.02 * rng.standard_normal(len(tb))
    )
    assert report.estimated
    np.testing.assert_allclose(report.to_reference(tb), true, atol=1e-3)
    assert report.drift_ppm == pytest.approx(180, abs=5 * report.drift_se_ppm + 1)
    flat = compare("a", "b", ta, np.zeros_like(ta), tb, content(tb))
    assert not flat.estimated and "flat" in flat.sentence()


def test_two_files_with_their_own_clocks(tmp_path: Path) -> None:
    ta, tb = np.arange(0, 60, 0.02), np.arange(0, 60, 0.03)
    f = lambda t: 5 + np.sin(t) + 0.5 * np.sin(2.7 * t)  # noqa: E731
    shift = 0.8
    np.savetxt(tmp_path / "in.csv", np.c_[ta, f(ta), f(ta)], header="t,force,sync", comments="", delimiter=",")
    np.savetxt(tmp_path / "out.csv", np.c_[tb, 2 * f(tb - shift), f(tb - shift)], header="t,load,sync", comments="", delimiter=",")
    document = {
        "columns": {
            "time_s": {"column": "t", "unit": "s", "file": "in"},
            "tension_in_n": {"column": "force", "unit": "N"},
            "tension_out_n": {"column": "load", "unit": "N", "time": "t"},
        },
        "constants": {"system": "act"},
        "files": {"merge": "channels"},
        "clocks": {
            "align": "apply",
            "content": [{"column": "sync", "file": "in", "time": "t"}, {"column": "sync", "file": "out", "time": "t"}],
        },
    }
    result, (one,) = load([tmp_path / "in.csv", tmp_path / "out.csv"], **document)
    (report,) = result.clocks
    assert report.used and report.offset_s == pytest.approx(shift, abs=2e-3)
    assert np.abs(one.tension_out_n - 2 * one.tension_in_n).max() < 0.02
    assert result.counts.set_aside > 0
    document["clocks"] = {}
    result, (one,) = load([tmp_path / "in.csv", tmp_path / "out.csv"], **document)
    assert not result.clocks[0].used and np.abs(one.tension_out_n - 2 * one.tension_in_n).max() > 0.5


def test_a_lead_is_read_with_the_decimal_comma_of_its_log(tmp_path: Path) -> None:
    """check, info and watch took the file, the import ended."""
    rows = [f"a;act;20,5;{0.01 * k:.2f};{1 + 0.1 * k:.3f};{0.5 + 0.1 * k:.3f}".replace(".", ",") for k in range(30)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["run_id;system;lead_mm;time_s;tension_in_n;tension_out_n", *rows]) + "\n")
    (one,) = run([path], Mapping()).runs
    assert one.lead_mm == 20.5 and one.tension_in_n[1] == 1.1
    assert [r.lead_mm for r in TextFollower(path, Mapping()).look(last=True)][-1] == 20.5
    path.write_text(path.read_text().replace("20,5", "wide"))
    with pytest.raises(SstlError, match="E335"):
        list(run([path], Mapping()).runs)


def test_files_appended_and_manifest(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.csv", even(10)), write(tmp_path / "b.csv", even(10))
    _, (one,) = load([a, b], files={"merge": "append", "shift": True}, constants={"run_id": "ab"})
    assert len(one) == 20 and one.run_id == "ab" and np.all(np.diff(one.time_s) > 0)
    (tmp_path / "m.csv").write_text("file,config_id,lead_mm\na.csv,NP-01,1.5\nb.csv,CP-02,\n")
    result = run([a, b], Mapping(), manifest=read_manifest(tmp_path / "m.csv"))
    assert [(r.config_id, r.lead_mm) for r in result.runs] == [("NP-01", 1.5), ("CP-02", None)]
    (tmp_path / "m.csv").write_text('file,config_id,lead_mm\na.csv,NP-01,"1,5"\nb.csv,CP-02,1.5\n')
    assert [r.lead_mm for r in run([a, b], Mapping(), manifest=read_manifest(tmp_path / "m.csv")).runs] == [1.5, 1.5]
    (tmp_path / "m.csv").write_text("file,config_id\naa.csv,NP-01\n")
    with pytest.raises(SstlError, match="did you mean 'aa"):
        list(run([a], Mapping(), manifest=read_manifest(tmp_path / "m.csv")).runs)


def test_a_manifest_tells_files_of_one_name_by_their_folders(tmp_path: Path) -> None:
    for bend in ("bend30", "bend60"):
        (tmp_path / bend).mkdir()
    files = [write(tmp_path / bend / "act.csv", even(10)) for bend in ("bend30", "bend60")]
    manifest = tmp_path / "m.csv"
    manifest.write_text("file,config_id\nbend60\\act.csv,60\nC:/rig/bend30/act.csv,30\n")
    assert [r.config_id for r in run(files, Mapping(), manifest=read_manifest(manifest)).runs] == ["30", "60"]
    manifest.write_text("file,config_id\na/act.csv,60\nb/act.csv,30\n")
    with pytest.raises(SstlError, match="may be either of the manifest's rows"):
        list(run(files[:1], Mapping(), manifest=read_manifest(manifest)).runs)
    manifest.write_text("file,config_id\nact.csv,60\nact.csv,30\n")
    with pytest.raises(SstlError, match=r"lists 'act\.csv' more than once"):
        read_manifest(manifest)


def test_file_name_pattern(tmp_path: Path) -> None:
    path = write(tmp_path / "bend_CP_040.csv", even(5))
    _, (one,) = load(path, file_name=r"bend_(?P<location>\w\w)_(?P<lead_mm>\d+)", constants={"config_id": "{location}-{lead_mm}"})
    assert (one.location, one.lead_mm, one.config_id) == ("CP", 40.0, "CP-040")
    with pytest.raises(SstlError, match="does not fit the pattern"):
        load(path, file_name="x(?P<location>.)")


def test_runs_that_are_all_too_short_are_told(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [(name, "act", *row) for row in even(1) for name in "ab"]
    path.write_text("run_id," + HEAD + "".join(",".join(map(str, r)) + "\n" for r in rows))
    with pytest.raises(SstlError, match=r"E345.*\(2 run shorter than 2 samples\); check the file and the mapping"):
        load(path)


@pytest.mark.parametrize(("behind", "dropouts"), [([], 0), ([(2.9, 30, 59)], 5)])
def test_empty_rows_at_the_end_are_no_dropouts_unless_more_follow(behind: list[tuple[object, ...]], dropouts: int, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    lines = [",".join(map(str, r)) for r in even(20)] + [",,"] * 5 + [",".join(map(str, r)) for r in behind]
    path.write_text("time_s,tension_in_n,tension_out_n\n" + "\n".join(lines) + "\n")
    result, runs = load(path, constants={"system": "act"}, time={"on_gap": "split", "gap_s": 5.0})
    assert result.counts.dropouts == dropouts and sum(len(r) for r in runs) == 20 + len(behind)
    assert result.counts.samples_in == 20 + dropouts + len(behind)
