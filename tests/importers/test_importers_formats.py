"""Every format reads back what other libraries wrote, without a mapping where columns are canonical."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from seeds import SHORT, WRITERS, N, rosbag2, signals

from sstl_cli.core.errors import SstlError
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, read_runs, write_runs
from sstl_cli.importers.base import detect, formats
from sstl_cli.importers.inline import inline_mapping
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps import export_log
from sstl_cli.steps.import_ import run


def mapping_for(name: str) -> Mapping:
    return inline_mapping(SHORT[name]) if name in SHORT else Mapping()


def test_every_importer_has_a_seed() -> None:
    assert set(formats()) == set(WRITERS)


@pytest.mark.parametrize("name", WRITERS)
def test_reads_what_others_wrote(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path)
    assert name == detect(path).ID
    runs = list(run([path], mapping_for(name)).runs)
    assert [(r.system, len(r)) for r in runs] == [("act", N)]
    expected = signals()
    np.testing.assert_allclose(runs[0].time_s, expected["time_s"], atol=1e-9)
    np.testing.assert_array_equal(runs[0].tension_in_n, expected["tension_in_n"])
    np.testing.assert_array_equal(runs[0].tension_out_n, expected["tension_out_n"])


# text that ends early is still text, and an SQLite file that ends early may hold all pages that are asked for
@pytest.mark.parametrize("name", [n for n in WRITERS if n not in ("text", "rosbag2")])
def test_truncated_is_one_clear_error(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    with pytest.raises(SstlError) as caught:
        list(run([path], mapping_for(name), wanted=name).runs)
    assert str(path) in caught.value.line() and "\n" not in caught.value.line()


def test_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = WRITERS["mcap"](tmp_path)
    monkeypatch.setitem(__import__("sys").modules, "mcap.stream_reader", None)
    with pytest.raises(SstlError, match=r"sstl-cli\[robot\]"):
        list(run([path], Mapping()).runs)


def test_bag_folder_and_its_links(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    rosbag2(folder)
    assert len(list(run([folder], mapping_for("rosbag2")).runs)) == 1
    (folder / "other.db3").symlink_to("/etc/hostname")
    with pytest.raises(SstlError, match="link"):
        list(run([folder], mapping_for("rosbag2")).runs)


def test_matlab_struct_array_is_several_runs(tmp_path: Path) -> None:
    from scipy.io import savemat

    s = signals()
    kind = [(n, object) for n in (*s, "run_id", "system")]
    savemat(tmp_path / "two.mat", {"log": np.array([(*s.values(), "a", "act"), (*s.values(), "b", "sstl")], dtype=kind)})
    runs = list(run([tmp_path / "two.mat"], Mapping()).runs)
    assert [(r.run_id, r.system) for r in runs] == [("a", "act"), ("b", "sstl")]


def test_big_endian_matlab_and_numpy(tmp_path: Path) -> None:
    s = {k: v.astype(">f8") for k, v in signals().items()}
    np.savez(tmp_path / "be.npz", **s, system="act")
    (one,) = run([tmp_path / "be.npz"], Mapping()).runs
    np.testing.assert_array_equal(one.tension_in_n, signals()["tension_in_n"])


@pytest.fixture
def log(tmp_path: Path) -> Path:
    s = signals()
    runs = [
        Run("=cmd|' /C'!A0", "act", s["time_s"], s["tension_in_n"], s["tension_out_n"], config_id="c1", lead_mm=2.5),
        Run("b", "sstl", s["time_s"] + 3, s["tension_in_n"] / 3, s["tension_out_n"] * 7, position_in_mm=s["time_s"] * 2),
    ]
    write_runs(tmp_path / "log.parquet", runs, Provenance("test"))
    return tmp_path / "log.parquet"


@pytest.mark.parametrize("fmt", export_log.FORMATS)
def test_export_comes_back_bit_for_bit(fmt: str, log: Path, tmp_path: Path) -> None:
    out = tmp_path / f"back.{fmt}"
    assert export_log.run(log, out, fmt).samples == 2 * N
    back = list(run([out], Mapping()).runs)
    for a, b in zip(read_runs(log), back, strict=True):
        np.testing.assert_array_equal(a.tension_out_n, b.tension_out_n)
        np.testing.assert_array_equal(a.time_s, b.time_s)
        assert (a.system, a.config_id, a.lead_mm) == (b.system, b.config_id, b.lead_mm)
    again = tmp_path / f"again.{fmt}"
    export_log.run(log, again, fmt)
    assert again.read_bytes() == out.read_bytes()


@pytest.mark.parametrize("fmt", export_log.FORMATS)
@pytest.mark.parametrize("end", [0, -200])
def test_what_is_no_log_is_told_with_its_own_name(fmt: str, end: int, log: Path, tmp_path: Path) -> None:
    if fmt == "mcap":
        pytest.importorskip("mcap")
    bad = tmp_path / "bad.parquet"
    whole = log.read_bytes()
    # text, and a log whose footer is damaged
    bad.write_bytes(whole[: end - 200] + b"Z" * 200 + whole[end:] if end else b"run_id,time_s\na,1\n")
    with pytest.raises(SstlError, match=r"E130.*bad\.parquet") as error:
        export_log.run(bad, tmp_path / f"x.{fmt}", fmt)
    assert error.value.fix and not (tmp_path / f"x.{fmt}").exists()


@pytest.mark.parametrize("unit", ["deg", "div"])
@pytest.mark.parametrize("fmt", export_log.FORMATS)
def test_export_keeps_the_unit_of_an_output_that_is_no_tension(fmt: str, unit: str, tmp_path: Path) -> None:
    s = signals()
    log = tmp_path / "log.parquet"
    write_runs(log, [Run("a", "act", s["time_s"], s["tension_in_n"], s["tension_out_n"], unit_out=unit)], Provenance("test"))
    out = tmp_path / f"back.{fmt}"
    export_log.run(log, out, fmt)
    (back,) = run([out], Mapping()).runs
    assert (back.unit_in, back.unit_out) == ("N", unit)
    np.testing.assert_array_equal(back.tension_out_n, s["tension_out_n"])


def test_export_escapes_formulas(log: Path, tmp_path: Path) -> None:
    export_log.run(log, tmp_path / "x.csv", "csv")
    assert "\n'=cmd" in (tmp_path / "x.csv").read_text()
    with pytest.raises(SstlError, match="did you mean 'mcap'"):
        export_log.run(log, tmp_path / "x.mcap", "mcapp")
    assert not (tmp_path / "x.mcap").exists()


@pytest.mark.parametrize("name", ["mat5", "npz"])
def test_large_arrays_are_read_in_pieces(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tracemalloc

    from scipy.io import savemat

    from sstl_cli.importers import mat5, npz
    from sstl_cli.importers.base import Layout, Notes

    n = 1_000_000
    t = np.arange(n) * 0.5
    log = {"time_s": t, "tension_in_n": t, "tension_out_n": 2 * t}
    path = tmp_path / ("a.mat" if name == "mat5" else "a.npz")
    if name == "mat5":
        savemat(path, log, do_compression=True)
        monkeypatch.setattr(mat5, "SPOOL_BYTES", 1 << 20)
        monkeypatch.setattr(mat5, "PIECE_BYTES", 1 << 20)
    else:
        np.savez_compressed(path, **log)
    module = {"mat5": mat5, "npz": npz}[name]
    tracemalloc.start()
    rows = 0
    for block in module.read(path, list(log), [], Layout(), Notes()):
        np.testing.assert_array_equal(block.columns["tension_out_n"], 2 * t[rows : rows + len(block)])
        rows += len(block)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert rows == n
    # the three channels are 24 MB and were copied once more; now it is two blocks of 6 and what compares them
    assert most < 24e6, most
