"""Recordings with two clocks read in pieces: the same numbers as whole, in bounded memory."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.importers import npz, overlap, repair, text, thinned
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps import import_ as step

COLUMNS = {
    "time_s": {"column": "t", "file": "in"},
    "tension_in_n": {"column": "force", "unit": "N"},
    "tension_out_n": {"column": "load", "unit": "N", "time": "t"},
    "position_in_mm": {"column": "pos", "unit": "mm", "time": "t", "file": "out"},
}


def motion(t: np.ndarray) -> np.ndarray:
    """Return a movement that does not repeat, in N."""
    return 5 + np.sin(t) + 0.5 * np.sin(2.7 * t)


def imported(folder: Path, a: np.ndarray, b: np.ndarray, **document: object) -> tuple[step.Import, list[Run]]:
    """Write input (t, force) and output (t, load, pos) and import both."""
    np.savetxt(folder / "in.csv", a, header="t,force", comments="", delimiter=",")
    np.savetxt(folder / "out.csv", b, header="t,load,pos", comments="", delimiter=",")
    whole = {"columns": COLUMNS, "constants": {"system": "act"}, "files": {"merge": "channels"}, **document}
    result = step.run([folder / "in.csv", folder / "out.csv"], mapping_of(whole, "test"))
    return result, list(result.runs)


def rows(runs: list[Run]) -> np.ndarray:
    """Return all samples of runs below one another, shape (n, 4)."""
    empty = [np.full(len(r), np.nan) if r.position_in_mm is None else r.position_in_mm for r in runs]
    return np.concatenate([np.c_[r.time_s, r.tension_in_n, r.tension_out_n, p] for r, p in zip(runs, empty, strict=True)])


def two(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return input and output whose clocks are unsteady, the output with dropouts inside and none at its ends."""
    rng = np.random.default_rng(seed)
    ta = np.cumsum(rng.uniform(0.01, 0.03, 1200))
    tb = np.cumsum(rng.uniform(0.015, 0.045, 700)) + 1.0
    b = np.c_[tb, 2 * motion(tb - 0.4), tb]
    b[rng.integers(20, 650, 30), 1] = np.nan
    b[:9, 2] = b[-60:, 2] = np.nan
    return np.c_[ta, motion(ta)], b


@pytest.mark.each_once
@pytest.mark.parametrize("align", ["report", "apply", "start", "none"])
@pytest.mark.parametrize("restart", [False, True])
def test_pieces_give_what_the_whole_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, align: str, restart: bool) -> None:
    a, b = two(1)
    if restart:
        # the recorder of the input begins anew: the output is read again from its beginning
        a[700:, 0] -= a[700, 0] - a[40, 0]
    document = {"clocks": {"align": align}, "skip_samples": 5}
    whole, expected = imported(tmp_path, a, b, **document)
    monkeypatch.setattr(text, "BLOCK_BYTES", 700)
    monkeypatch.setattr(overlap, "LEAST_ROWS", 200)
    pieces, found = imported(tmp_path, a, b, **document)
    np.testing.assert_array_equal(rows(found), rows(expected))
    # what counts as a gap is learned from the first piece
    told = [r.document("log.parquet", {}).model_copy(update={"step_s": None, "gap_s": None}) for r in (whole, pieces)]
    assert len(rows(found)) > 200 and told[0] == told[1]


def test_an_end_far_behind_is_looked_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = two(2)
    b[200:500, 1] = np.nan
    b = b[:550]
    whole, expected = imported(tmp_path, a, b)
    monkeypatch.setattr(text, "BLOCK_BYTES", 700)
    monkeypatch.setattr(overlap, "WAITING_ROWS", 50)
    pieces, found = imported(tmp_path, a, b)
    np.testing.assert_array_equal(rows(found), rows(expected))
    assert whole.counts.notes.set_aside == pieces.counts.notes.set_aside
    # behind the gap there are values again
    assert rows(found)[-1, 0] > b[500, 0]


def test_a_thinned_series_keeps_offset_and_drift(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = two(3)
    b[:, 1:] = np.c_[2 * motion(b[:, 0] * (1 - 2e-3) - 0.4), b[:, 0]]
    (whole,) = imported(tmp_path, a, b)[0].clocks
    monkeypatch.setattr(thinned, "MOST", 200)
    (few,) = imported(tmp_path, a, b)[0].clocks
    assert whole.offset_s is not None and few.offset_s == pytest.approx(whole.offset_s, abs=2e-3)
    assert few.drift_ppm == pytest.approx(whole.drift_ppm, abs=5 * (few.drift_se_ppm or 0) + 20)


def test_a_thinned_series_is_means_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thinned, "MOST", 8)
    series = thinned.Thinned()
    t = np.arange(31.0)
    for part in np.split(t, [3, 4, 17, 30]):
        series.add(part, 2 * part)
    series.add(np.array([5.0, np.nan]), np.array([0.0, 0.0]))
    time, values = series.arrays()
    assert len(time) <= 8 and np.all(np.diff(time) > 0)
    np.testing.assert_allclose(values, 2 * time)
    np.testing.assert_allclose(time[:7], np.arange(1.5, 28, 4))


def test_memory_does_not_grow_with_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thinned, "MOST", 1 << 14)
    monkeypatch.setattr(npz, "ROWS_PER_BLOCK", 8192)
    monkeypatch.setattr(repair, "PIECE_ROWS", 8192)
    peaks = []
    for n in (100_000, 400_000):
        path = tmp_path / f"{n}.npz"
        ta, tb = np.arange(n) * 1e-3, np.arange(n // 2) * 2e-3
        np.savez(path, ta=ta, fin=motion(ta), tb=tb, fout=motion(tb))
        document = {
            "columns": {
                "time_s": "ta",
                "tension_in_n": {"column": "fin", "unit": "N"},
                "tension_out_n": {"column": "fout", "unit": "N", "time": "tb"},
            },
            "constants": {"system": "act"},
        }
        tracemalloc.start()
        samples = sum(len(run) for run in step.run([path], mapping_of(document, "test")).runs)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert samples > 0.99 * n
    assert peaks[1] < 1.3 * peaks[0]


@pytest.mark.parametrize("same", [True, False])
def test_no_lag_is_told_between_copies_of_one_clock(same: bool, tmp_path: Path) -> None:
    """Friction delays the output; between channels of one recorder that was told as 0.18 s and -4305 ppm of its clock."""
    t = np.linspace(0.0, 20.0, 1000)
    table = np.c_[t, motion(t), t if same else t * (1 + 1e-6), motion(t - 0.2)]
    np.savetxt(tmp_path / "a.csv", table, header="t1,force,t2,load", comments="", delimiter=",", fmt="%.8f")
    columns = {
        "time_s": "t1",
        "tension_in_n": {"column": "force", "unit": "N"},
        "tension_out_n": {"column": "load", "unit": "N", "time": "t2"},
    }
    result = step.run([tmp_path / "a.csv"], mapping_of({"columns": columns, "constants": {"system": "act"}}, "test"))
    list(result.runs)
    assert len(result.clocks) == (0 if same else 1)
    assert same or "not a clock fault where friction delays the output" in result.clocks[0].sentence()


def played(x: np.ndarray, pull: float, release: float) -> np.ndarray:
    """Return what a play operator passes on of an input (N)."""
    out = [pull * float(x[0])]
    for value in x[1:]:
        out.append(min(max(out[-1], pull * float(value)), release * float(value)))
    return np.array(out)


@pytest.mark.parametrize(("wave", "friction"), [("sine", 0.1), ("sine", 0.5), ("sum", 0.5), ("triangle", 0.5)])
def test_the_loop_of_friction_is_no_drift(wave: str, friction: float, tmp_path: Path) -> None:
    t = np.arange(0.0, 40.0, 0.01)
    waves = {
        "sine": -np.cos(0.8 * t),
        "sum": 0.6 * np.sin(0.7 * t) + 0.3 * np.sin(2.7 * t + 1),
        "triangle": 4 * np.abs((t / 7) % 1 - 0.5) - 1,
    }
    x = 7 + 5 * waves[wave]
    y = played(x, np.exp(-friction), np.exp(friction))
    rng = np.random.default_rng(2)
    a, b = x + rng.normal(0, 0.01, len(t)), y + rng.normal(0, 0.01, len(t))
    result, _ = imported(tmp_path, np.c_[t, a], np.c_[t + 1e-4, b, x])
    [report] = result.clocks
    assert report.estimated and report.drift_ppm is None and "drift" not in report.sentence()


def test_a_drift_beyond_the_loop_is_told(tmp_path: Path) -> None:
    t = np.arange(0.0, 60.0, 0.01)
    x = motion(t)
    result, _ = imported(tmp_path, np.c_[t, x], np.c_[t * 1.01, played(x, 0.99, 1.01), x])
    [report] = result.clocks
    assert report.drift_ppm == pytest.approx(9900, abs=500) and "drift" in report.sentence()


def test_empty_cells_of_a_shorter_clock_are_not_set_aside(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.01)
    lines = [
        f"{v:.2f},{w:.5f}," + (f"{t[2 * i] + 0.001:.3f},{motion(t[2 * i]):.5f}" if 2 * i < len(t) else ",")
        for i, (v, w) in enumerate(zip(t, motion(t), strict=True))
    ]
    (tmp_path / "a.csv").write_text("t1,force,t2,load\n" + "\n".join(lines) + "\n")
    columns = {
        "time_s": "t1",
        "tension_in_n": {"column": "force", "unit": "N"},
        "tension_out_n": {"column": "load", "unit": "N", "time": "t2"},
    }
    result = step.run([tmp_path / "a.csv"], mapping_of({"columns": columns, "constants": {"system": "act"}}, "test"))
    assert sum(len(run) for run in result.runs) > 0.99 * len(t)
    assert not any("second clock" in reason for reason in result.counts.notes.set_aside)
