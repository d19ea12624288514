"""From readings to the grid of the simulation, on a handful of samples."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.latent import WHITE_ONLY, Latent
from sstl_cli.diagnosis.means import bridged, latent_means, of_readings, unread_n, white_of

ALL = np.ones(8, bool)


def test_what_is_not_good_lies_on_the_line_between_its_neighbours():
    signal = np.array([1.0, 9.0, 9.0, 4.0])
    assert bridged(signal, np.array([True, False, False, True])).tolist() == [1.0, 2.0, 3.0, 4.0]
    assert bridged(signal, np.ones(4, bool)) is signal


def test_every_sample_a_reading_gives_plain_means():
    signal = np.arange(8.0)
    means, readings, share = of_readings(signal, signal, ALL, ALL, 1, 4)
    assert means.tolist() == [1.5, 5.5] and readings.tolist() == [4.0, 4.0] and share.tolist() == [0.25] * 8


def test_of_a_slow_sensor_only_fresh_sound_readings_count():
    signal = np.array([2.0, 2.0, 6.0, 6.0, 1.0, 1.0, 1.0, 1.0])
    fresh = np.array([True, False, True, False, True, False, False, False])
    good = np.array([True, True, True, True, False, True, True, True])
    means, readings, share = of_readings(signal, signal, good, fresh, 1, 4)
    # two readings of 2 and 6; the second block has none that is sound: its mean as it was recorded, of one reading
    assert means.tolist() == [4.0, 1.0] and readings.tolist() == [2.0, 1.0]
    assert share.tolist() == [0.5, 0.0, 0.5, 0.0, 0.25, 0.25, 0.25, 0.25]


def test_what_is_bridged_is_no_reading_of_the_block_that_it_reaches_into():
    signal = np.array([2.0, 2.0, 2.0, 2.0, 50.0, 60.0, 4.0, 4.0])
    good = np.array([True, True, True, True, False, False, True, True])
    fine = np.array([2.0, 2.0, 2.7, 4.0])
    means, readings, share = of_readings(signal, fine, good, ALL, 2, 2)
    # of the second block the later step alone, which is the mean of two samples as every step is
    assert means.tolist() == [2.0, 4.0] and readings.tolist() == [2.0, 1.0] and share.tolist() == [0.5, 0.5, 0.0, 1.0]
    means, readings, share = of_readings(signal, fine, good & (np.arange(8) < 4), ALL, 2, 2)
    assert means == pytest.approx([2.0, 3.35]) and readings.tolist() == [2.0, 1.0] and share.tolist() == [0.5] * 4


def test_steps_of_two_samples_share_a_block_by_their_readings():
    signal = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    read = np.array([1, 1, 1, 0, 0, 0, 0, 1, 0], bool)
    means, readings, share = of_readings(signal, np.zeros(4), np.ones(9, bool), read, 2, 2)
    assert means.tolist() == [2.0, 8.0] and readings.tolist() == [3.0, 1.0] and share == pytest.approx([2 / 3, 1 / 3, 0.0, 1.0])


def test_noise_is_never_below_the_rounding():
    still = np.full(400, 3.0)
    assert white_of(still, np.ones(400, bool), 0.02, 0.01, WHITE_ONLY) == pytest.approx(0.02)
    noisy = 3.0 + 0.1 * np.random.default_rng(1).standard_normal(4000)
    assert white_of(noisy, np.ones(4000, bool), 0.02, 0.01, WHITE_ONLY) == pytest.approx(0.1, rel=0.1)


def test_the_latent_signal_is_smoother_than_its_readings_and_as_long_as_the_grid():
    t = np.arange(2000) * 0.01
    truth = 10.0 + 5.0 * np.sin(0.5 * t)
    read = truth + 0.05 * np.random.default_rng(2).standard_normal(2000)
    found = latent_means(read, np.ones(2000, bool), np.ones(2000, bool), 0.0, 2, 1000, 0.02)
    grid = truth.reshape(-1, 2).mean(axis=1)
    assert len(found.value) == 1000
    assert np.std(found.value - grid) < 0.5 * 0.05 / np.sqrt(2.0)


def test_before_the_first_reading_a_line_may_have_moved_as_far_as_after_it():
    value = np.array([9.0, 8.6, 8.2, 7.8, 7.5, 7.2, 7.2, 7.2])
    out = Latent(value, np.zeros(8), np.full(8, 0.09), np.zeros((8, 26)), 0.0, np.zeros(8), np.zeros(4))
    read = np.array([0, 0, 1, 0, 1, 0, 1, 0], bool)
    # two steps before the first reading, beside the smoother's 0.3 N: 8.2 to 7.5 N
    assert unread_n(out, read, 0) == pytest.approx(np.hypot(0.3, 0.7))
    # at a reading, and between two of them, the smoother knows; behind the last one nothing is ahead
    assert [unread_n(out, read, k) for k in (2, 3, 4, 7)] == pytest.approx([0.3] * 4)
    # nor is anything ahead where nobody has read for long
    assert unread_n(out, read[:6] & (np.arange(6) < 3), 5) == pytest.approx(0.3)
    # one whose readings come later than the record is long after them
    assert unread_n(out, np.arange(8) == 6, 0) == pytest.approx(np.hypot(0.3, value[7] - value[6]))
