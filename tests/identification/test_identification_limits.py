"""Small laws of the identification: block lengths worked by hand, limits that must fall and rise."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run
from sstl_cli.identification.change import LEARN, LIMITS, LOOPS, limit
from sstl_cli.identification.lines import block_length, ransac, travel
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig


@pytest.mark.parametrize(
    ("samples", "dt_s", "length"), [(100, 0.001, 10), (100, 0.01, 1), (100, 0.5, 1), (4096, 1.0, 1), (4097, 1.0, 2), (1_000_000, 0.01, 245)]
)
def test_blocks_of_ten_ms_and_at_most_4096(samples: int, dt_s: float, length: int) -> None:
    assert block_length(samples, dt_s) == length


def test_limits_fall_with_learning_and_rise_with_loops() -> None:
    assert LIMITS.shape == (len(LEARN), len(LOOPS))
    assert (np.diff(LIMITS, axis=0) < 0).all() and (np.diff(LIMITS, axis=1) > 0).all()
    # no jump: neighbours in a row differ by less than half, as a simulation leaves them
    assert (LIMITS[:, 1:] / LIMITS[:, :-1]).max() < 1.4 and (LIMITS[:-1] / LIMITS[1:]).max() < 1.5


def test_limit_of_numbers_in_the_table_and_beyond() -> None:
    assert limit(20, 500) == pytest.approx(8.0)
    assert limit(10, 50) == limit(5, 10) == pytest.approx(6.1)
    assert limit(100, 5000) == limit(1000, 1e6) == pytest.approx(6.3)


def test_ransac_leaves_outliers_out() -> None:
    rng = np.random.default_rng(0)
    x = np.linspace(5.0, 30.0, 400)
    y = 0.6 * x + 0.3 + rng.normal(0, 0.01, 400)
    y[::5] += 4.0
    slope, bias, threshold = ransac(x, y, 1.0, 0.001, False, rng.random((256, 2)))
    assert slope == pytest.approx(0.6, abs=2e-3) and bias == pytest.approx(0.3, abs=0.05)
    # four robust standard deviations; the outliers make the median a little larger
    assert 0.03 < threshold < 0.07
    assert ransac(x, y, 1.0, 0.001, True, rng.random((256, 2)))[2] == 1.0
    assert ransac(x, y, 1.0, 0.5, False, rng.random((256, 2)))[2] == 0.5


def recorded(theta: float, system: str, presliding: bool) -> Run:
    """Return a 12 s trapezoid on the elastic rig, which knows nothing of the identification."""
    low, high = {"act": (1.0, 30.0), "sstl": (0.2, 80.0)}[system]
    t = np.arange(6000) * 0.002
    x = low + (high - low) * np.interp(t / 12.0, [0.0, 0.4, 0.45, 0.95, 1.0], [0.0, 1.0, 1.0, 0.0, 0.0])
    effects = {"presliding": {"breakaway_mm": 0.17, "spread": 0.5}} if presliding else {}
    made = simulate_rig(RigSpec(pretension_n=1.0), RigRun(system, theta, "ND", t, "tension", x), effects, NoiseSpec(), 3)
    return Run("r", system, made.time_s, made.tension_in_n, made.tension_out_n)


@pytest.mark.parametrize(("system", "theta"), [("act", 0.57), ("act", 0.62), ("act", 0.68), ("sstl", 0.68), ("sstl", 0.72)])
def test_a_rounded_corner_does_not_outvote_the_line(system: str, theta: float) -> None:
    """Presliding: by samples the nearly level approach outvotes the release line, by the output's travel it cannot."""
    sharp, rounded = (segment_run(recorded(theta, system, presliding)) for presliding in (False, True))
    assert (sharp.status, rounded.status) == ("ok", "ok")
    for name in ("gamma_p", "gamma_r"):
        assert rounded.theta[name] == pytest.approx(sharp.theta[name], rel=0.02)


def test_travel_counts_the_way_of_the_output_within_each_stretch() -> None:
    y = np.array([0.0, 0.0, 0.0, 2.0, 4.0, 10.0, 10.0])
    stretch = np.array([0, 0, 0, 0, 0, 1, 1])
    assert travel(y, stretch).tolist() == [0.0, 0.0, 1.0, 2.0, 2.0, 0.0, 0.0]


def test_a_weighted_search_follows_the_weight() -> None:
    x = np.concatenate([np.linspace(0.0, 10.0, 80), np.linspace(0.0, 10.0, 20)])
    y = np.concatenate([0.1 * x[:80], 3.0 * x[80:]])
    few = np.concatenate([np.full(80, 0.1), np.full(20, 3.0)])
    for weight, slope in ((None, 0.1), (few, 3.0)):
        found = ransac(x, y, 0.05, 0.01, False, np.random.default_rng(0).random((256, 2)), weight)
        assert found[0] == pytest.approx(slope, abs=1e-9)
