"""Recordings made by others: they import by the mappings kept here and end in a Theta row or a stated reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import spearmanr

from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, read_runs, write_runs
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import Import, run

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
MAPPINGS = Path(__file__).parent / "mappings"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"recordings made by others are not at {DATA}")
FOLDERS = {"viocom-endoscope": 10, "bandbrake-capstan": 15, "pneu-cylinder": 8}


def imported(name: str, folder: Path) -> tuple[Import, list[Run]]:
    """Import a folder of recordings and read the log back."""
    # the mapping is for a bore of 25 mm; the cylinder with the X-ring has another
    files = sorted(p for p in (DATA / name).iterdir() if p.suffix in (".txt", ".csv") and not p.name.startswith("X-ring"))
    assert len(files) == FOLDERS[name]
    result = run(files, read_mapping(MAPPINGS / f"{name}.toml"))
    write_runs(folder / "log.parquet", result.runs, Provenance("test"))
    return result, list(read_runs(folder / "log.parquet"))


def width_n(one: Run) -> float:
    """Return the loop's width in N at mid output: input where the output rises through it, less where it falls.

    Taken from the samples themselves, not from fitted lines; the median over all crossings.
    """
    middle = (one.tension_out_n.max() + one.tension_out_n.min()) / 2
    above = one.tension_out_n > middle
    up = one.tension_in_n[1:][~above[:-1] & above[1:]]
    down = one.tension_in_n[1:][above[:-1] & ~above[1:]]
    return float(np.median(up) - np.median(down))


@pytest.mark.parametrize("name", FOLDERS)
def test_every_folder_ends_in_theta_or_a_reason(name: str, tmp_path: Path) -> None:
    from sstl_cli.identification.segment import segment_run

    result, runs = imported(name, tmp_path)
    assert len({r.file for r in result.recordings}) == FOLDERS[name] and len(runs) >= FOLDERS[name]
    assert result.counts.samples_out == sum(map(len, runs))
    for one in runs:
        assert np.all(np.diff(one.time_s) > 0) and one.config_id and one.system == "act"
        row = segment_run(one)
        assert row.status
        if row.status == "ok":
            assert np.isfinite([row.theta["gamma_p"], row.theta["gamma_r"]]).all()


def test_viocom_slope_falls_and_loop_widens(tmp_path: Path) -> None:
    from sstl_cli.identification.segment import segment_run

    result, runs = imported("viocom-endoscope", tmp_path)
    assert all(505 <= len(r) <= 520 for r in runs)
    assert result.counts.set_aside == result.counts.repeated > 15_000
    bend = [float(r.config_id or "nan") for r in runs]
    assert bend == [30.0 * i for i in range(10)]
    # pulling raises the input with the angle
    assert all(np.corrcoef(r.tension_in_n, r.tension_out_n)[0, 1] > 0.3 for r in runs)
    slopes = [segment_run(r).theta["gamma_p"] for r in runs]
    assert spearmanr(bend, slopes).statistic <= -0.9
    assert spearmanr(bend, [width_n(r) for r in runs]).statistic >= 0.9


def test_pneu_input_is_pressure_times_area(tmp_path: Path) -> None:
    _, runs = imported("pneu-cylinder", tmp_path)
    raw = np.loadtxt(DATA / "pneu-cylinder" / "KDN_5bar.csv")[15:]
    mine = next(r for r in runs if r.run_id == "KDN_5bar")
    np.testing.assert_allclose(mine.tension_in_n, raw[:, 5] * 1e5 * np.pi * 0.0125**2, rtol=1e-12)
    np.testing.assert_array_equal(mine.tension_out_n, raw[:, 6])
    np.testing.assert_allclose(mine.time_s, raw[:, 0] / 1000, rtol=1e-12)
    assert mine.config_id == "KDN" and mine.trajectory == "ten strokes at 5 bar"


def test_bandbrake_columns_are_the_two_band_tensions(tmp_path: Path) -> None:
    _, runs = imported("bandbrake-capstan", tmp_path)
    name = "dataset-2__2Hz30lbtension0.5amplitude"
    raw = np.loadtxt(DATA / "bandbrake-capstan" / f"{name}.csv", delimiter=",", skiprows=1)
    mine = next(r for r in runs if r.run_id == name)
    np.testing.assert_array_equal(mine.tension_in_n, raw[:, 6])
    np.testing.assert_array_equal(mine.tension_out_n, raw[:, 7])
    assert mine.position_in_mm is not None
    np.testing.assert_array_equal(mine.position_in_mm, raw[:, 3])
