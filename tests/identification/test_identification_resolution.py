"""The step below which a channel never changes: grids, grids read through finer ones, and values sent once they have moved."""

from __future__ import annotations

import numpy as np
import pytest
from identification_loops import trapezoid

from sstl_cli.identification import gate
from sstl_cli.identification.gate.sensors import quantisation
from sstl_cli.physics.variant.effects.quantisation import deadband

N = 4000
RNG = np.random.default_rng(11)
MOVED = 10.0 + 6.0 * np.sin(np.arange(N) / 150.0)
NOISY = MOVED + 0.02 * RNG.standard_normal(N)


@pytest.mark.parametrize("step", [0.015, 0.04, 0.2])
def test_a_grid_and_a_value_that_is_sent_once_it_has_moved_have_a_step(step):
    assert quantisation(step * np.round(NOISY / step)) == pytest.approx(step, rel=1e-6)
    assert quantisation(step * np.floor(NOISY / step)) == pytest.approx(step, rel=1e-6)
    # nearly: the least of some changes that are a step at least
    assert step <= quantisation(deadband(NOISY, step)) < 1.08 * step


def test_a_coarse_grid_is_seen_through_a_finer_one():
    coarse = 0.04 * np.round(NOISY / 0.04)
    assert quantisation(0.007 * np.round(coarse / 0.007)) == pytest.approx(0.04, rel=0.03)


def test_a_few_readings_between_the_levels_hide_no_step():
    read = 0.04 * np.round(NOISY / 0.04)
    at = RNG.choice(N, 30, replace=False)
    read[at] += RNG.uniform(-0.04, 0.04, 30)
    assert quantisation(read) == pytest.approx(0.04, rel=0.05)


def test_noise_has_no_step_however_often_the_last_value_is_repeated():
    assert quantisation(NOISY) == 0.0
    # a slow sensor, and one that stands still for a while
    assert quantisation(np.repeat(NOISY[::10], 10)) == 0.0
    assert quantisation(np.where((np.arange(N) % 400) < 100, NOISY[0], NOISY)) == 0.0


def test_a_fine_grid_of_few_samples_shows_through_the_digits_that_they_are_written_with():
    t = np.arange(400)
    # a triangle of 0.1 N a sample on steps of 7.934 mN takes more levels than half of its samples
    read = np.round(0.0079339806 * np.round((15.0 + 9.4 * np.abs((t / 93.0) % 2.0 - 1.0) + 0.01 * np.sin(t**2)) / 0.0079339806), 5)
    assert len(np.unique(read)) > 0.5 * len(read)
    assert quantisation(read) == pytest.approx(0.0079339806, rel=1e-4)
    assert quantisation(np.round(read + 0.01 * np.sin(t**3), 9)) == 0.0


def test_a_quantised_ramp_is_no_refresh():
    t, x = trapezoid(rate=500.0)
    found = gate.sensor_of("tension_in_n", t, np.round(x / 0.1) * 0.1)
    assert not found.held and found.step_n == pytest.approx(0.1)
