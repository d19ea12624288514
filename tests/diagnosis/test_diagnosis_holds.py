"""Noise of the sensors from holds: made windows whose noise is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_windows import Held, coloured
from rig_logs import SHORT, record
from scipy.signal import lfilter

from sstl_cli.diagnosis.constants import ALIKE, LEVELS, MEASURED, UNKNOWN_COLOUR, UNMEASURED
from sstl_cli.diagnosis.holds import _window_costs, held_noise, moving
from sstl_cli.diagnosis.noise import measured, of_readings
from sstl_cli.diagnosis.recorder import white_beside, white_noise
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.whitening import step_of


def test_slow_noise_is_found_in_holds_whatever_drifts_and_a_few_disturbed_holds_do_not_count():
    rng = np.random.default_rng(3)
    quiet = [
        Held(0.03 * rng.standard_normal(1200) + coloured(rng, 1200, 0.01, 0.02, 0.4) + 0.1 * np.linspace(0, k, 1200)) for k in range(8)
    ]
    found, _ = held_noise(quiet, [np.zeros(1200)] * 8, 0.03, 0.03 * LEVELS)
    assert found.coloured_n == pytest.approx(0.02, rel=0.35) and 0.2 <= found.correlation_s <= 0.8
    loud = [Held(r.y + (np.arange(1200) > 600) * (i > 5)) for i, r in enumerate(quiet)]
    assert held_noise(loud, [np.zeros(1200)] * 8, 0.03, 0.03 * LEVELS)[0].coloured_n == pytest.approx(found.coloured_n, rel=0.35)


@pytest.mark.parametrize("every", [(1, 2), (3, 2, 2)], ids=["two of three", "three of seven"])
def test_a_sensor_that_is_refreshed_more_slowly_than_it_is_logged_shows_its_slow_noise_too(every):
    rng = np.random.default_rng(10)
    read = np.zeros(2400)
    at = np.cumsum(np.tile(every, 2400))
    read[at[at < 2400]] = 1.0
    records = [Held(0.03 * rng.standard_normal(2400) + coloured(rng, 2400, 0.01, 0.03, 0.2), read=read) for _ in range(8)]
    found, white = held_noise(records, [np.zeros(2400)] * 8, 0.03, 0.03 * LEVELS)
    assert found.coloured_n == pytest.approx(0.03, rel=0.2) and 0.1 <= found.correlation_s <= 0.4 and white == 0.03
    # what is no reading says nothing
    stale = [replace(r, y=np.where(read > 0.0, r.y, 7.0)) for r in records]
    assert held_noise(stale, [np.zeros(2400)] * 8, 0.03, 0.03 * LEVELS)[0] == found


def test_without_slow_noise_nothing_is_found_but_the_least_level():
    rng = np.random.default_rng(4)
    records = [Held(0.03 * rng.standard_normal(1200)) for _ in range(6)]
    assert held_noise(records, [np.zeros(1200)] * 6, 0.03, 0.03 * LEVELS)[0].coloured_n < 0.006


def test_short_holds_show_slow_noise_too_and_where_there_are_too_few_it_may_be_anything():
    rng = np.random.default_rng(6)
    # half a second each, of a signal at 100 Hz: no window of a second fits
    short = [Held(0.03 * rng.standard_normal(900) + coloured(rng, 900, 0.01, 0.1, 0.2)) for _ in range(4)]
    slides = [np.where(np.arange(900) % 90 < 50, 0.0, 1.0)] * 4
    found, _ = held_noise(short, slides, 0.03, 0.03 * LEVELS)
    assert found.coloured_n == pytest.approx(0.1, rel=0.4) and MEASURED <= found.spread <= ALIKE
    blind, _ = held_noise(short[:1], [np.where(np.arange(900) < 50, 0.0, 1.0)], 0.03, 0.03 * LEVELS)
    assert blind.coloured_n == UNKNOWN_COLOUR * 0.03 and blind.spread == UNMEASURED


def test_what_is_slower_than_a_window_may_be_there_as_far_as_is_usual():
    rng = np.random.default_rng(8)
    slow = [Held(0.03 * rng.standard_normal(1200) + coloured(rng, 1200, 0.01, 0.01, 6.0)) for _ in range(8)]
    found, white = held_noise(slow, [np.zeros(1200)] * 8, 0.03, 0.03 * LEVELS)
    assert abs(np.log(found.coloured_n / 0.01)) < 3.0 * found.spread and white == 0.03


def test_a_sensor_behind_a_filter_has_more_noise_in_means_than_from_reading_to_reading():
    rng = np.random.default_rng(9)
    records = [Held(0.03 * rng.standard_normal(1200)) for _ in range(6)]
    # third differences of such readings see but 0.022 of the 0.03
    found, white = held_noise(records, [np.zeros(1200)] * 6, 0.022, 0.022 * LEVELS)
    assert white == pytest.approx(0.03, rel=0.1) and found.coloured_n < 0.01


def test_the_cost_of_a_window_is_that_of_dense_linear_algebra():
    rng = np.random.default_rng(5)
    rows, n = rng.standard_normal((3, 40)), 40
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) * 0.01
    sigma = 0.5**2 * np.exp(-lag / 0.2) + 0.3**2 * np.eye(n)
    line = np.stack((np.ones(n), np.linspace(-1.0, 1.0, n)), axis=1)
    inverse = np.linalg.inv(sigma)
    inner = line.T @ inverse @ line
    project = inverse - inverse @ line @ np.linalg.solve(inner, line.T @ inverse)
    square = np.einsum("ij,jk,ik->i", rows, project, rows)
    log_det = 0.5 * (np.linalg.slogdet(sigma)[1] + np.linalg.slogdet(inner)[1] - np.linalg.slogdet(line.T @ line)[1])
    other, cost = _window_costs(rows, 0.3, np.array([0.1, 0.5]), step_of(1.0, 0.01 / 0.2))
    assert cost[:, 1] == pytest.approx(square) and cost[:, 0] == pytest.approx(0.5 * square + log_det)
    assert (other[:, 1] > cost[:, 1]).all()


def test_slow_noise_of_the_input_is_no_more_than_where_it_rests():
    """The output wanders in its holds, the input's sensor has white noise alone: what the output shows is not the input's."""
    records = prepare(record({}, moves=SHORT, configs=2), 1.0).records
    rng = np.random.default_rng(8)
    loud = tuple(replace(r, y=r.y + coloured(rng, len(r), r.dt_s * r.factor, 0.1, 0.4)) for r in records)
    slides = np.concatenate([moving(r, 0.02) for r in records])
    for system, sensor in measured(loud, slides).input.items():
        out = measured(loud, slides).output[system]
        assert out.coloured_n > 0.03 and sensor.coloured_n < 0.015


@pytest.mark.parametrize("hz", [100.0, 1000.0])
def test_stated_noise_is_that_of_one_reading_at_any_rate(hz):
    records = prepare(record({}, hz=hz, moves=SHORT[1:2], configs=1), 1.0).records
    found = of_readings(records, measured(records, np.ones(sum(len(r) for r in records))))
    # how far a search may go from it is no interval
    assert not found.spread and set(found.open) == set(found.output)
    for sensor in (*found.input.values(), *found.output.values()):
        assert sensor.white_n == pytest.approx(0.02, rel=0.1)


def test_the_white_part_of_quick_slow_noise_is_what_is_left_and_no_more_than_was_seen():
    rng = np.random.default_rng(11)
    n, dt, white, slow, tau = 12_000, 0.01, 0.004, 0.02, 0.08
    memory = np.exp(-dt / tau)
    wander = lfilter([1.0], [1.0, -memory], np.sqrt(1.0 - memory**2) * rng.standard_normal(n))
    seen = white_noise(slow * wander + white * rng.standard_normal(n))
    assert seen > 1.2 * white and white_beside(seen, slow, memory) == pytest.approx(white, rel=0.1)
    assert white_beside(seen, 0.0, memory) == seen and white_beside(seen, 1.0, memory) > 0.0
