"""The latent input: its error is as large as it says, corners stay, straight lines are averaged."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from sstl_cli.diagnosis import latent as of
from sstl_cli.diagnosis.constants import FINEST, SHORTEST_SMOOTHED
from sstl_cli.diagnosis.latent import Slow, Told, block_mean, latent

DT = 0.01
TIME = np.arange(0.0, 30.0, DT)
SIGNALS = {
    "triangle": 2.0 + 20.0 * np.abs((TIME / 8.0) % 1.0 * 2.0 - 1.0),
    "plateaus": np.clip(2.0 + 20.0 * np.abs((TIME / 8.0) % 1.0 * 2.0 - 1.0), 5.0, 18.0),
    "sine": 12.0 + 10.0 * np.sin(2.0 * np.pi * TIME / 6.0),
}


def read(name, sd, seed=0):
    return SIGNALS[name] + sd * np.random.default_rng(seed).standard_normal(len(TIME))


@pytest.mark.parametrize("sd", [0.005, 0.03])
@pytest.mark.parametrize("name", sorted(SIGNALS))
def test_the_error_is_as_large_as_it_says(name, sd):
    found = latent(read(name, sd), DT, sd)
    error = found.value - SIGNALS[name]
    # squared errors over stated variances: between half and one and a half, whatever the movement
    assert 0.5 < np.mean(error**2 / found.variance) < 1.5
    assert np.sqrt(np.mean(error**2)) < 0.5 * sd


def test_a_straight_line_is_averaged_over_far_and_a_corner_is_not_rounded():
    sd = 0.02
    found = latent(read("triangle", sd), DT, sd)
    assert np.median(found.variance) < sd**2 / 20.0
    # a mean over those twenty samples would cut the peak of slope 5 N/s by 0.25 N
    assert abs(found.value.max() - SIGNALS["triangle"].max()) < 2.0 * sd


@pytest.mark.each_once
@pytest.mark.parametrize("sd", [0.005, 0.03])
@pytest.mark.parametrize("late", [0.0, 0.4])
def test_a_corner_is_whole_wherever_between_samples_it_is(sd, late):
    """What a line holds is the input at a corner: split in two halves it was up to four stated errors too low, everywhere alike."""
    true = 2.0 + 20.0 * np.abs(((TIME + late * DT) / 8.0) % 1.0 * 2.0 - 1.0)
    at = np.flatnonzero(np.abs(np.diff(true, 2)) > 1e-3) + 1
    errors = []
    for seed in range(40):
        found = latent(true + sd * np.random.default_rng(seed).standard_normal(len(true)), DT, sd)
        errors.append(((found.value - true) / np.sqrt(found.variance))[at])
    assert np.mean(np.square(errors)) < 1.4
    # peaks are not cut, in the mean over all of them (beside the error of the mean)
    peaks = np.mean(np.array(errors)[:, true[at] > true.mean()])
    assert abs(peaks) < 0.8


def test_a_path_is_as_sure_beside_a_corner_as_the_readings_are_of_its_place():
    """Noise as large as the change of a step: which sample a corner is at nobody knows; by one place alone errors were 1.5 times too large."""
    sd, true = 0.04, np.clip(2.0 + 15.0 * np.abs((TIME / 8.0) % 1.0 * 2.0 - 1.0), 4.0, 14.0)
    at = np.flatnonzero(np.abs(np.diff(true, 2)) > 1e-3) + 1
    near = np.unique(np.concatenate([at + k for k in range(-4, 5)]))
    squares, one_place = [], []
    for seed in range(20):
        found = latent(true + sd * np.random.default_rng(seed).standard_normal(len(true)), DT, sd)
        error = (found.value - true)[near]
        squares.append(error**2 / (found.variance + found.doubt**2)[near])
        one_place.append(error**2 / found.variance[near])
    assert 0.6 < np.mean(squares) < 1.1 < np.mean(one_place)


def test_where_nothing_bends_a_path_has_no_other_place():
    found = latent(read("sine", 0.02), DT, 0.02)
    assert np.median(found.doubt) == 0.0
    path = of._Path((np.ones(9), np.ones(9)), (1.0, 1.0), np.zeros((9, 4)), mean=np.zeros((9, 4)))
    assert not len(of._places(path))
    squares = np.zeros((40, 4))
    # the largest of those that are near one another, and none at an end
    squares[[1, 12, 15, 30, 39], 0] = [9.0, 3.0, 4.0, 2.0, 9.0]
    assert of._places(of._Path((np.ones(40), np.ones(40)), (1.0, 1.0), squares)).tolist() == [15, 30]


@pytest.mark.parametrize("sd", [0.01, 0.04])
def test_a_curvature_that_changes_all_the_time_is_followed_as_surely_as_it_says(sd):
    """A sweep: few sharp bends fit its readings as well, and between them errors were up to seven stated ones."""
    phase = 2.0 * np.pi * (0.05 * TIME + 0.02 * TIME**2)
    true = 12.0 + 6.0 * np.sin(phase)
    squares = []
    for seed in range(10):
        found = latent(true + sd * np.random.default_rng(seed).standard_normal(len(true)), DT, sd)
        squares.append((found.value - true) ** 2 / (found.variance + found.doubt**2))
    assert 0.6 < np.mean(squares) < 1.2 and np.max(squares) < 6.0**2


def test_a_bend_that_the_readings_show_stays_sharp():
    curve = np.where(TIME < 15.0, 0.0, 4.0 * (TIME - 15.0) ** 2)
    y, use = curve + 1e-5 * np.random.default_rng(1).standard_normal(len(TIME)), np.ones(len(TIME), bool)
    bends = np.full(len(TIME), 1e-16)
    bends[1500] = (8.0 * DT**2) ** 2
    noise, steps = of.Reading(1e-10), (np.full(len(TIME), 1e-18), bends)
    nats = float(of.costs(y, use, noise, *steps).sum())
    path = of._by(y, use, noise, of._Path((), (1e-16, 1e-16), np.zeros((len(TIME), 4))), steps, nats)
    assert of._as_smooth(y, use, noise, path) is path


def test_the_rate_is_the_slope():
    found = latent(read("triangle", 0.005), DT, 0.005)
    assert np.median(np.abs(found.rate)) == pytest.approx(5.0, rel=0.02)


def test_without_noise_the_signal_stays():
    found = latent(SIGNALS["sine"], DT, 0.0)
    assert np.array_equal(found.value, SIGNALS["sine"]) and not found.variance.any()


def test_unknown_samples_are_bridged_and_less_certain():
    known = np.ones(len(TIME), bool)
    known[1000:1040] = False
    y = read("sine", 0.02)
    y[1000:1040] = 99.0
    found = latent(y, DT, 0.02, known)
    assert np.abs(found.value - SIGNALS["sine"])[1000:1040].max() < 0.5
    assert found.variance[1020] > 5.0 * np.median(found.variance)


def test_block_mean_is_the_mean_of_blocks():
    assert block_mean(np.arange(7.0), 3).tolist() == [1.0, 4.0]


def test_slow_noise_that_nobody_told_of_has_no_part_in_the_law():
    law = latent(read("triangle", 0.02), DT, 0.02).chain
    # transitions from and to the slow noise, and its variance
    assert not law[:, [3, 7, 11, 12, 13, 14, 15, 19, 22, 24, 25]].any()


def test_units_and_origins_of_signal_and_time_are_of_no_matter():
    y = read("triangle", 0.02)
    plain, other = latent(y, DT, 0.02), latent(1000.0 * y - 7.0, 5.0 * DT, 20.0)
    assert other.value == pytest.approx(1000.0 * plain.value - 7.0, rel=1e-6) and other.variance == pytest.approx(
        1e6 * plain.variance, rel=1e-4
    )
    assert other.rate == pytest.approx(200.0 * plain.rate, rel=1e-4, abs=1e-3)


def test_what_is_short_or_free_of_noise_is_taken_as_it_is():
    y = np.arange(float(SHORTEST_SMOOTHED)) ** 2
    short = latent(y[:-1], 0.5, 1.0)
    assert np.array_equal(short.value, y[:-1]) and short.rate[1:-1] == pytest.approx(4.0 * np.arange(1.0, 6.0)) and short.nats == 0.0
    assert not short.chain.any() and latent(y, 0.5, 1.0).variance.all() and latent(y[:1], 0.5, 1.0).rate.tolist() == [0.0]
    assert not latent(y, 0.5, FINEST * np.ptp(y)).variance.any() and latent(y, 0.5, 1.01 * FINEST * np.ptp(y)).variance.all()


def test_slow_noise_keeps_its_share_over_a_time_and_a_step_is_a_median():
    assert Slow(1.0, 0.5).kept(0.25) == pytest.approx(np.exp(-0.5)) and Slow(0.0, 1.0).kept(0.0) == 1.0
    y = np.array([0.0, 1.0, 4.0, 9.0, 17.0, 25.0])
    # second differences 2, 2, 3, 0
    assert (
        of._typical_step(y, 2) == pytest.approx(4.0)
        and of._typical_step(y, 3) == 0.0
        and of._typical_step(y[:4], 2) == 0.0 < of._typical_step(y[:5], 2)
    )


def test_readings_with_slow_noise_are_followed_less_when_that_is_known():
    rng = np.random.default_rng(4)
    slow = np.zeros(len(TIME))
    for k in range(1, len(TIME)):
        slow[k] = np.exp(-DT / 0.2) * slow[k - 1] + 0.05 * np.sqrt(1.0 - np.exp(-2.0 * DT / 0.2)) * rng.standard_normal()
    y = read("triangle", 0.01) + slow
    plain, told = latent(y, DT, 0.01), latent(y, DT, 0.01, told=Told(Slow(0.05, 0.2)))
    off = [np.sqrt(np.mean((f.value - SIGNALS["triangle"]) ** 2)) for f in (plain, told)]
    assert off[1] < 0.7 * off[0] and told.nats < plain.nats - 50.0
    assert 0.4 < np.mean((told.value - SIGNALS["triangle"]) ** 2 / told.variance) < 2.0


@pytest.mark.parametrize("sd", [0.02, 0.03])
def test_readings_say_over_how_many_samples_a_drive_rounds_corners(sd):
    corners = np.interp(TIME % 3.0, [0.0, 1.3, 1.7, 3.0], [0.0, 13.0, 13.0, 0.0])
    for lag, least, most in ((0.0, -1, -1), (3.0, 0, 2)):
        signal = corners if lag == 0.0 else of_first_order(corners, lag)
        liked = latent(signal + sd * np.random.default_rng(4).standard_normal(len(TIME)), DT, sd).rounds
        best = int(np.argmax(liked)) if liked.max() > 4.0 else -1
        assert least <= best <= most, (lag, liked)


def of_first_order(signal, lag):
    """Return a signal behind a lag of so many samples, marched fifty times finer."""
    fine = np.interp(np.arange(len(signal) * 50) / 50.0, np.arange(len(signal)), signal)
    kept = np.exp(-1.0 / (50.0 * lag))
    return lfilter([1.0 - kept], [1.0, -kept], fine - fine[0])[::50] + fine[0]


def test_an_input_that_was_told_to_be_rounded_is_off_by_what_it_says_behind_a_drive_that_lags():
    signal = of_first_order(np.interp(TIME % 3.0, [0.0, 1.3, 1.7, 3.0], [0.0, 13.0, 13.0, 0.0]), 3.0)
    noisy = signal + 0.03 * np.random.default_rng(5).standard_normal(len(TIME))
    sharp, round_ = latent(noisy, DT, 0.03), latent(noisy, DT, 0.03, told=Told(rounded=2.0))
    nees = [float(np.mean((x.value - signal) ** 2 / x.variance)) for x in (sharp, round_)]
    assert nees[1] < 1.3 < nees[0]


def test_variances_that_are_spread_keep_their_sum_and_fall_off_on_both_sides():
    w = np.full(40, 1e-3)
    w[20] = 1.0
    out = of._spread(w, 2.0)
    assert out[10:31].sum() == pytest.approx(w[10:31].sum(), rel=1e-3)
    assert out[21] / out[20] == pytest.approx(np.exp(-1.0), rel=0.02) and out[19] == pytest.approx(out[21])
