"""Rests of a latent input: an input that stood still is a level, and not a path that wanders about it by its own error."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from sstl_cli.diagnosis import latent as of
from sstl_cli.diagnosis.latent import Slow, Told, latent
from sstl_cli.diagnosis.rests import levels, resting, stopped
from sstl_cli.diagnosis.smoother import Reading, chain, follow

RATE_HZ, DRAWS = 100.0, 24
TIME = np.arange(0.0, 24.0, 1.0 / RATE_HZ)
LEVELS, RAMP_S, DWELL_S = (4.0, 12.0, 7.0, 15.0, 4.0), 1.5, 4.0
SLOW = Slow(0.02, 0.3)


def staircase(creep=0.0):
    """Return an input that goes from level to level and stays on each, or creeps there (N/s)."""
    times, values = [0.0], [LEVELS[0]]
    for level in LEVELS[1:]:
        for after, value in ((DWELL_S, values[-1] + creep * DWELL_S), (RAMP_S, level)):
            times.append(times[-1] + after)
            values.append(value)
    return np.interp(TIME, times, values)


def noise(seed, white_n, slow=None):
    rng = np.random.default_rng(seed)
    found = white_n * rng.standard_normal(len(TIME))
    if slow is None:
        return found
    kept = slow.kept(1.0 / RATE_HZ)
    return found + lfilter([slow.sd_n * np.sqrt(1.0 - kept**2)], [1.0, -kept], rng.standard_normal(len(TIME) + 500))[500:]


def read(true, seed, white_n, slow=None):
    return latent(true + noise(seed, white_n, slow), 1.0 / RATE_HZ, white_n, told=Told() if slow is None else Told(slow))


def dwells(true):
    """Return the samples of each rest, well away from its ends."""
    still = np.flatnonzero(np.abs(np.diff(true, prepend=true[0] - 1.0)) < 1e-9)
    return [part[60:-60] for part in np.split(still, np.flatnonzero(np.diff(still) > 1) + 1) if len(part) > 200]


@pytest.mark.parametrize(("white_n", "slow"), [(0.005, None), (0.02, SLOW)], ids=["white", "slow"])
def test_a_level_is_no_further_out_than_it_was(white_n, slow, monkeypatch):
    """Extremes of a path that wandered were 0.9 and 1.1 stated errors beyond the level, on whichever side the line holds them."""
    true = staircase()
    over = {}
    for rests in (True, False):
        if not rests:
            monkeypatch.setattr(of, "_resting", lambda y, use, noise, path: path)
        found = [read(true, seed, white_n, slow) for seed in range(DRAWS)]
        z = [((f.value - true)[part], np.sqrt(f.variance[part].mean())) for f in found for part in dwells(true)]
        over[rests] = np.array([[e.max() / sd, e.min() / sd] for e, sd in z])
        # errors are of the size that is stated, with rests as without
        assert 0.7 < np.mean([np.mean(e**2) / sd**2 for e, sd in z]) < 1.5
    highest, lowest = over[True].mean(axis=0)
    assert abs(highest) < 0.35 and abs(lowest) < 0.35
    assert over[False].mean(axis=0)[0] > 0.6 and over[False].mean(axis=0)[1] < -0.6


def test_a_level_is_better_known_than_a_path_and_rests_are_found():
    true = staircase()
    told, wandering = read(true, 1, 0.02, SLOW), latent(true + noise(1, 0.02, SLOW), 1.0 / RATE_HZ, 0.02)
    for part in dwells(true):
        assert np.ptp(told.value[part]) < 1e-3 < np.ptp(wandering.value[part])
    moving = np.abs(np.diff(true, prepend=true[0])) > 1e-9
    assert np.all(np.abs(np.diff(told.value, prepend=told.value[0] - 1.0)[moving]) > 1e-4)


def test_what_creeps_or_turns_without_a_corner_does_not_rest():
    # 0.05 N/s over a dwell is ten times the noise of a reading
    creeping = staircase(creep=0.05)
    found = read(creeping, 2, 0.02)
    for k in range(4):
        begin = round((k * (DWELL_S + RAMP_S) + 1.0) * RATE_HZ)
        moved = found.value[begin + 200] - found.value[begin]
        assert moved == pytest.approx(0.1, abs=0.03)
    slow_sine = 8.0 + 4.0 * np.sin(2.0 * np.pi * TIME / 12.0)
    rates = np.abs(np.diff(read(slow_sine, 3, 0.02).value))
    assert np.mean(rates < 1e-7) < 0.01


def test_levels_are_the_longest_windows_within_a_band():
    steps = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 5.0, 5.2, 5.1])
    assert list(levels(steps, 0.3, 2)) == [(0, 2), (2, 5), (5, 8)]
    assert list(levels(steps, 0.3, 3)) == [(2, 5), (5, 8)] and not list(levels(steps, 0.3, 4))
    # of a ramp each window begins a sample after the one before; none lies inside another
    assert list(levels(np.arange(5) / 10.0, 0.25, 3)) == [(0, 3), (1, 4), (2, 5)]
    assert list(levels(np.array([3.0, 3.1, 2.9, 3.0]), 0.2 + 1e-9, 2)) == [(0, 4)]


def test_behind_a_drive_that_lags_there_is_no_corner_and_yet_a_rest():
    true = staircase()
    b, a = butter(2, 2.0, fs=RATE_HZ)
    smooth = lfilter(b, a, true - true[0]) + true[0]
    found = read(smooth, 4, 0.02)
    still = np.abs(np.diff(found.value, prepend=found.value[0] - 1.0)) < 1e-5
    for part in dwells(true):
        # it comes to rest some time after it was told to
        assert still[part[100:]].mean() > 0.8
        assert np.abs(found.value - smooth)[part[still[part]]].max() < 0.012
    assert not still[np.abs(np.gradient(smooth)) > 5e-3].any()
    # a fifth of a second is a path as any other
    short = latent(4.0 + noise(5, 0.02)[:20], 1.0 / RATE_HZ, 0.02)
    assert np.isfinite(short.value).all()


def test_a_rest_has_to_be_likelier_than_all_the_places_where_it_could_be():
    n = 400
    y, use, reading = 0.02 * np.random.default_rng(6).standard_normal(n), np.ones(n, bool), Reading(0.02**2)
    steps = (np.full(n, 1e-9), np.full(n, 1e-11))
    path = follow(*chain(y, use, reading, *steps))[:2]
    everywhere = resting(y, use, reading, steps, (path[0][:, 0], path[1]), np.array([], np.int64))
    assert everywhere[n // 4 : -n // 4].all() and not everywhere[0]
    corners, bends = stopped(steps, everywhere)
    assert not corners[everywhere].any() and not bends[everywhere].any() and np.array_equal(corners[~everywhere], steps[0][~everywhere])
    moving = np.linspace(0.0, 4.0, n) + y
    path = follow(*chain(moving, use, reading, *steps))[:2]
    assert not resting(moving, use, reading, steps, (path[0][:, 0], path[1]), np.array([], np.int64)).any()
    assert not resting(y, use, reading, steps, (path[0][:, 0], np.zeros(n)), np.array([], np.int64)).any()
