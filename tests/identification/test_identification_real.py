"""Recordings made by others: the pull slope falls and the loop widens along the endoscope's configurations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import spearmanr

from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
needs = pytest.mark.skipif(not DATA.is_dir(), reason="the folder ../shared/data is absent")


def last_of_each_time(time, *channels):
    keep = np.append(np.flatnonzero(np.diff(time) > 0), len(time) - 1)
    return [v[keep] for v in (time, *channels)]


@needs
def test_endoscope_slope_falls_and_loop_widens():
    slope, width = [], []
    for path in sorted((DATA / "viocom-endoscope").glob("config_*.txt")):
        m = np.loadtxt(path, delimiter=",")
        t, x, y = last_of_each_time(m[:, 0], m[:, 4] - m[:, 5], m[:, 3])
        found = segment_run(Run(path.stem, "act", t, x, y))
        assert found.status == "ok", (path.name, found.status)
        mid = (y.max() + y.min()) / 2
        th = found.theta
        slope.append(th["gamma_p"])
        width.append((mid - th["beta_p"]) / th["gamma_p"] - (mid - th["beta_r"]) / th["gamma_r"])
    order = np.arange(len(slope))
    assert len(order) == 10
    assert spearmanr(order, slope).statistic <= -0.9
    assert spearmanr(order, width).statistic >= 0.9


@needs
@pytest.mark.parametrize(
    ("pattern", "skip", "x", "y", "delimiter"), [("bandbrake-capstan/*.csv", 1, 6, 7, ","), ("pneu-cylinder/*.csv", 15, 5, 6, None)]
)
def test_every_other_recording_ends_in_numbers_or_reasons(pattern, skip, x, y, delimiter):
    files = sorted(DATA.glob(pattern))[:6]
    assert files
    for path in files:
        m = np.loadtxt(path, delimiter=delimiter, skiprows=skip)
        found = segment_run(Run(path.stem, "act", *last_of_each_time(m[:, 0], m[:, x], m[:, y])))
        for name, value in found.theta.items():
            if value is None:
                assert found.status != "ok"
            else:
                assert np.isfinite(value) and np.isfinite(found.theta_se[name])
        assert len(found.phases) == len(np.unique(m[:, 0]))
