"""Noise of inputs, of holds, and beside the output: what smoothing, whitening and the channels make of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import inv, sqrtm
from scipy.signal import lfilter

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.channels import loop_gap
from sstl_cli.diagnosis.evidence import Score, advantage, block_index, scores
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.smoothing import corner_preserving, half_widths, smoothed
from sstl_cli.diagnosis.whitening import fit_whitener
from sstl_cli.physics.filters import first_order

RATE = 500.0
WHITE = 0.037
WIDTHS = (75, 50, 30, 15, 8)


def trapezoid(dwell_s: float) -> np.ndarray:
    """Three strokes between 2 and 26 N with dwells of a length at both ends."""
    t = np.arange(int(18 * RATE)) / RATE
    ramp = 3.0 - dwell_s
    return np.interp(t % 6.0, [0, ramp, 3.0, 3.0 + ramp, 6.0], [2.0, 26.0, 26.0, 2.0, 2.0])


@pytest.mark.parametrize("dwell_s", [0.1, 0.28, 1.0])
def test_dwells_shorter_than_the_window_keep_their_level(dwell_s):
    rng = np.random.default_rng(1)
    clean = trapezoid(dwell_s)
    noisy = clean + WHITE * rng.standard_normal(len(clean))
    found = smoothed(noisy, half_widths(noisy, WHITE, WIDTHS))
    dwell = clean > 26.0 - 1e-9
    assert abs(np.mean(found[dwell] - 26.0)) < 0.25 * WHITE
    # ... and ramps are still averaged over a wide window
    middle = np.abs(clean - 14.0) < 6.0
    assert np.std((found - clean)[middle]) < 0.2 * WHITE


def test_one_width_for_all_would_round_them():
    clean = trapezoid(0.1)
    noisy = clean + WHITE * np.random.default_rng(1).standard_normal(len(clean))
    dwell = (clean > 26.0 - 1e-9)
    assert 26.0 - corner_preserving(noisy, WIDTHS[0])[dwell].min() > WHITE


def test_the_first_sample_is_smoothed_like_the_others():
    ramp = np.arange(2000) * 0.01
    errors = [
        corner_preserving(ramp + WHITE * np.random.default_rng(s).standard_normal(2000), 50)[[0, -1]] - ramp[[0, -1]]
        for s in range(40)
    ]
    assert np.std(errors) < 0.4 * WHITE


def test_holds_are_whitened_as_their_covariance_says():
    """One run, white noise and one hold: the map is (I + t^2 w w')^(-1/2)."""
    n, level, rng = 400, 0.5, np.random.default_rng(3)
    held = np.zeros((30, n), bool)
    held[:, 100:200] = True
    held[:, 260:300] = True
    x = 0.1 * rng.standard_normal((30, n))
    x[:, 100:200] += level * rng.standard_normal((30, 1))
    x[:, 260:300] += level * rng.standard_normal((30, 1))
    slices = [slice(k * n, (k + 1) * n) for k in range(30)]
    white = fit_whitener(x.ravel(), np.ones(30 * n), slices, ["act"] * 30, held=held.ravel())
    assert white.level[0] == pytest.approx(level, rel=0.25)
    assert white.scale[0] == pytest.approx(0.1, rel=0.05)
    w = white.holds[0].unit[:n]
    one = np.zeros((30 * n, n))
    one[:n] = np.eye(n)
    mapped = white(one)[:n]
    plain = np.stack([lfilter(white.coefficients[0], [1.0], row) for row in np.eye(n)], axis=1) / white.scale[0]
    plain *= white.keep[:n, None]
    second = white.holds[1].unit[:n]
    exact = plain
    for u in (w, second):
        exact = np.real(inv(sqrtm(np.eye(n) + white.level[0] ** 2 * np.outer(u, u)))) @ exact
    assert np.allclose(mapped, exact, atol=1e-6)
    # and the whitened holds are no louder than the rest
    y = white(x.ravel()).reshape(30, n)
    assert np.mean(y[:, 100:200] ** 2) == pytest.approx(1.0, abs=0.1)
    assert np.var(y[:, 100:200].sum(axis=1)) < 2.0 * 100


def test_a_level_that_no_hold_has_is_not_invented():
    n, rng = 400, np.random.default_rng(4)
    held = np.tile(np.arange(n) // 50 % 2 == 1, 20)
    x = lfilter([0.1], [1.0, -0.6], rng.standard_normal(20 * n))
    slices = [slice(k * n, (k + 1) * n) for k in range(20)]
    white = fit_whitener(x, np.ones(20 * n), slices, ["act"] * 20, held=held)
    assert white.level[0] < 0.05


def loop_runs(tau_s: float, seed: int = 0) -> list[Run]:
    """Four runs whose input follows its reference with a lag, under white and coloured noise."""
    runs = []
    for k in range(4):
        rng = np.random.default_rng([seed, k])
        t = np.arange(6000) / 200.0
        ref = 15.0 + 8.0 * np.sin(2 * np.pi * (0.1 + 0.05 * k) * t)
        colour = lfilter([np.sqrt(1 - 0.975**2)], [1.0, -0.975], rng.standard_normal(6000))
        t_in = first_order(ref, 0.005, tau_s, 0.0) + 0.02 * colour + 0.019 * rng.standard_normal(6000)
        out = 0.6 * t_in + 0.02 * rng.standard_normal(6000)
        runs.append(Run(f"r{k}", "act", t, t_in, out, config_id="c", trajectory=f"k{k}", tension_ref_n=ref))
    return runs


def test_a_lag_below_the_noise_is_seen_and_none_is_not_invented():
    found = loop_gap(prepare(loop_runs(0.004)).records)
    assert found is not None and found.effects == ("tension_loop_lag",)
    assert found.values["tau_s"] == pytest.approx(0.004, rel=0.4)
    assert all(loop_gap(prepare(loop_runs(0.0, seed)).records) is None for seed in range(5))


def test_scores_charge_parameters_and_blocks_discount():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal(5000)
    one, same = scores([noise, noise], [0, 3], 0, [5000], [0.02])
    assert one.score - same.score == pytest.approx(1.5 * np.log(5000))
    assert list(np.unique(block_index([500, 250], [0.02, 0.02]))) == [0, 1, 2]
    steady, jumpy = Score(-100.0, np.full(20, -5.0)), Score(0.0, np.zeros(20))
    assert advantage(jumpy, steady) == pytest.approx(100.0)
    once = Score(0.0, np.r_[95.0, np.full(19, -5.0)])
    assert advantage(once, steady) < 10.0
