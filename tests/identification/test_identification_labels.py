"""Phase labels against hand-worked loops."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from identification_loops import ACT, multisine, play, record, trapezoid

from sstl_cli.identification import PHASE_NAMES, label_phases
from sstl_cli.identification.filtering import despiked, low_pass, noise_sd
from sstl_cli.identification.labels import turning_points


def test_names_and_codes():
    assert PHASE_NAMES == ("PB", "PP", "RB", "RP")


def test_trapezoid_phases_begin_where_they_must():
    # up 5 -> 30 N in 4.8 s on the pull line, hold 0.6 s, down in 6 s; release at (15.96 + 1.04) / 1.69 = 10.06 N
    t, x = trapezoid()
    codes = label_phases(t, x, play(x, ACT))
    truth_rp = 5.4 + 6.0 * (30 - 10.06) / 25
    assert (codes[(t > 0.3) & (t < 5.3)] == 1).all()
    assert (codes[(t > 5.6) & (t < truth_rp - 0.15)] == 2).all()
    assert (codes[(t > truth_rp + 0.25)] == 3).all()


def test_a_hold_keeps_the_phase_it_began_in():
    t, x = trapezoid(cycles=2)
    run = record(t, x, ACT, 1)
    codes = label_phases(t, run.tension_in_n, run.tension_out_n)
    hold = (t > 4.9) & (t < 5.3)
    low_hold = (t > 11.5) & (t < 11.9)
    assert (codes[hold] == 1).mean() > 0.98 and (codes[low_hold] == 3).mean() > 0.98


def test_minor_loops_follow_the_play_operator():
    t, x = multisine(5, rate=100.0, seconds=120.0)
    run = record(t, x, ACT, 2)
    y = play(x, ACT)
    codes = label_phases(t, run.tension_in_n, run.tension_out_n)
    moving = np.abs(np.gradient(x, t)) > 0.5
    pull = np.abs(y - ACT[0] * x - ACT[1]) < 1e-9
    release = np.abs(y - ACT[2] * x - ACT[3]) < 1e-9
    rising = np.gradient(x, t) > 0
    truth = np.select([rising & pull, rising, release], [1, 0, 3], 2)
    assert (codes == truth)[moving].mean() > 0.93


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 5, 17])
def test_short_and_strange_inputs_give_a_code_a_sample(n):
    t = np.arange(n) / 10.0
    codes = label_phases(t, np.full(n, np.nan), np.zeros(n))
    assert codes.shape == (n,) and codes.dtype == np.uint8


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-50, 50), min_size=2, max_size=60), st.floats(0.1, 10))
def test_turning_points_alternate_and_differ_by_the_prominence(levels, prominence):
    x = np.interp(np.linspace(0, 1, 400), np.linspace(0, 1, len(levels)), levels)
    points, first = turning_points(x, prominence, 0.0)
    inner = x[points]
    if first == 0:
        assert np.ptp(x) <= prominence + 1e-9
        return
    steps = np.diff(inner)[:-1]
    assert (np.abs(steps) >= prominence * 0.999).all()
    assert (np.sign(steps) == first * (-1.0) ** np.arange(len(steps))).all()


def test_noise_makes_no_reversals():
    t, x = trapezoid(cycles=3)
    rng = np.random.default_rng(0)
    slow = np.interp(t, np.arange(0, 37, 0.3), rng.normal(0, 0.02, 124))
    points, first = turning_points(x + slow, 0.25, 0.05)
    assert first == 1 and len(points) == 2 * 3 + 1


def test_low_pass_keeps_lines_has_no_phase_and_damps_noise():
    t = np.arange(4000) / 500.0
    ramp, wave = 3.0 + 2.0 * t, np.sin(2 * np.pi * 1.0 * t)
    a, b = low_pass(ramp, wave, 10.0, 0.002)
    assert a == pytest.approx(ramp, abs=1e-4)
    # |H|^2 of a second-order Butterworth at a tenth of the cut-off, run twice: 1 / (1 + 1e-4)
    assert b[500:-500] == pytest.approx(wave[500:-500] / (1 + 1e-4), abs=2e-4)
    noise = np.random.default_rng(1).standard_normal(200_000)
    filtered, _ = low_pass(noise, noise, 10.0, 0.002)
    from sstl_cli.identification.filtering import filtered_sd

    assert filtered.std() == pytest.approx(filtered_sd(1.0, 10.0, 0.002), rel=0.05)


def test_low_pass_agrees_with_scipy():
    from scipy.signal import butter, filtfilt

    x = np.cumsum(np.random.default_rng(2).standard_normal(3000))
    b, a = butter(2, 12.0, fs=500.0)
    mine, _ = low_pass(x, x, 12.0, 0.002)
    assert mine[300:-300] == pytest.approx(filtfilt(b, a, x)[300:-300], abs=1e-6)


def test_despiked_touches_spikes_only():
    x = np.sin(np.arange(200) / 20.0)
    dirty = x.copy()
    dirty[50] += 3.0
    clean = despiked(dirty, 0.5)
    assert clean[50] == pytest.approx(x[50], abs=0.01)
    assert np.array_equal(np.delete(clean, 50), np.delete(x, 50))


def test_noise_sd_ignores_motion():
    rng = np.random.default_rng(3)
    x = 10 * np.sin(np.arange(50_000) / 800.0) + 0.03 * rng.standard_normal(50_000)
    assert noise_sd(x) == pytest.approx(0.03, rel=0.06)
