"""Noise and faults of small signals whose answer is known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.recorder import scan, white_noise

T = np.arange(0.0, 40.0, 0.01)
RNG = np.random.default_rng(5)
NOISE = RNG.standard_normal(len(T))


@pytest.mark.parametrize("movement", [np.zeros_like(T), 5.0 * T, 10.0 * np.sin(6.0 * T), 10.0 * np.abs(T % 4.0 - 2.0)])
@pytest.mark.parametrize("sd", [0.01, 0.04])
def test_white_noise_is_found_whatever_moves(movement, sd):
    assert white_noise(movement + sd * NOISE) == pytest.approx(sd, rel=0.05)


def test_white_noise_has_the_unit_of_the_signal():
    y = np.sin(T) + 0.02 * NOISE
    assert white_noise(1e3 * y) == pytest.approx(1e3 * white_noise(y), rel=1e-9)


def test_a_spike_is_flagged_where_it_is():
    y = np.sin(T) + 0.01 * NOISE
    y[700] += 1.0
    assert np.flatnonzero(scan(y).spike).tolist() == [700]


def test_a_frozen_stretch_is_flagged_and_a_slow_movement_is_not():
    y = np.sin(T) + 0.01 * NOISE
    y[500:540] = y[500]
    # the first of them is a reading, the others repeat it
    assert np.flatnonzero(scan(y).frozen).tolist() == list(range(501, 540))


def test_a_clipped_top_is_flagged_with_its_level():
    y = np.minimum(np.sin(T) + 0.01 * NOISE, 0.8)
    found = scan(y)
    assert found.clip_level_n == 0.8 and np.array_equal(found.clipped, y == 0.8)
    assert not scan(np.sin(T) + 0.01 * NOISE).clipped.any()


def test_a_converter_has_a_step():
    y = np.round((np.sin(T) + 0.05 * NOISE) / 0.02) * 0.02
    assert scan(y).step_n == pytest.approx(0.02) and scan(np.sin(T) + 0.05 * NOISE).step_n == 0.0


def test_a_coarse_converter_repeats_its_highest_level_without_being_at_a_limit():
    time = np.arange(2000) / 100.0
    # rests at the top and at the bottom, as the output of a play has them
    wave = np.clip(12.0 * np.sin(2.0 * np.pi * 0.2 * time), -8.0, 8.0) + 20.0
    rounded = 0.25 * np.round((wave + 0.01 * np.random.default_rng(1).standard_normal(2000)) / 0.25)
    found = scan(rounded)
    assert found.step_n == pytest.approx(0.25) and not found.clipped.any() and not found.frozen.any()
    noisy = 20.0 + 12.0 * np.sin(2.0 * np.pi * 0.2 * time) + 0.1 * np.random.default_rng(2).standard_normal(2000)
    limited = np.minimum(0.25 * np.round(noisy / 0.25), 24.0)
    assert scan(limited).clip_level_n == 24.0


def test_a_limit_is_found_where_noise_leaves_it_again_and_again():
    # the tension rests below the limit, noise goes beyond it: no stretch is long
    y = np.minimum(np.clip(3.0 * np.sin(T), -1.0, 0.99) + 0.02 * NOISE, 1.0)
    assert scan(y).clip_level_n == 1.0 and np.array_equal(scan(y).clipped, y == 1.0)
    assert not scan(np.clip(3.0 * np.sin(T), -1.0, 0.99) + 0.02 * NOISE).clipped.any()


def test_digits_of_a_file_pile_up_nowhere():
    y = np.clip(3.0 * np.sin(T), -1.0, 0.99) + 0.02 * NOISE
    assert not scan(np.round(y, 3)).clipped.any() and scan(np.minimum(np.round(y, 3), 1.0)).clip_level_n == 1.0


def test_a_limit_is_found_although_a_reading_lies_a_little_beyond():
    y = np.minimum(np.sin(T) + 0.01 * NOISE, 0.8)
    y[np.flatnonzero(y == 0.8)[7]] += 1e-4
    assert scan(y).clip_level_n == 0.8 and scan(y).clipped.sum() == np.sum(y >= 0.8)


def test_levels_that_arithmetic_tells_apart_are_one():
    y = 0.004 * np.round((10.0 * np.sin(0.2 * T) + 0.008 * NOISE) / 0.004)
    # a unit and back again
    told = y * RNG.choice([1.0, 1.0 + 4e-16, 1.0 - 4e-16], len(y), p=[0.9, 0.05, 0.05])
    assert len(np.unique(told)) > len(np.unique(y)) + 100
    assert scan(told).step_n == pytest.approx(scan(y).step_n)
    assert not scan(y).clipped.any() and not scan(told).clipped.any()
    assert np.array_equal(scan(np.minimum(told, 9.9)).clipped, told > 9.898)


def test_a_limit_with_nothing_just_below_it_has_no_level_beside():
    y = np.where(np.arange(4000) % 400 < 300, 10.0, 0.0) + np.where(np.arange(4000) % 400 < 300, 0.0, 0.01 * NOISE)
    assert scan(y).clip_level_n == 10.0


def test_what_is_bridged_or_stands_still_has_no_noise():
    rng = np.random.default_rng(5)
    y = 10.0 + 0.05 * rng.standard_normal(4000)
    recorded = np.arange(4000) % 400 >= 120
    # a bridge goes on evenly
    y[~recorded] = 10.0 + 1e-6 * np.arange(np.count_nonzero(~recorded))
    assert scan(y).noise_n < 0.042 and scan(y, recorded=recorded).noise_n == pytest.approx(0.05, rel=0.05)
    y[~recorded] = np.repeat(y[np.flatnonzero(np.diff(recorded.astype(int), prepend=1) < 0) - 1], 120)
    found = scan(y)
    assert found.frozen.sum() > 1000 and found.noise_n == pytest.approx(0.05, rel=0.05)
