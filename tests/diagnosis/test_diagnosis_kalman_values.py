"""Pieces of the innovations filter by hand: what a reading costs, what a rest holds on, what a slip leaves behind."""

from __future__ import annotations

from math import log

import numpy as np
import pytest

from sstl_cli.diagnosis.kalman import (
    DOUBT,
    GAIN,
    JUMPS,
    REST,
    SLIDE,
    STEEP,
    _cost,
    _error_moves_on,
    _held_on,
    _learned,
    _left_behind,
    _moved,
    _read,
    _slipped,
)


def phase(slide: float = 0.0, gain: float = 0.0, doubt: float = 0.0, jumps: float = 0.0) -> np.ndarray:
    found = np.zeros(STEEP + 1)
    found[[SLIDE, GAIN, DOUBT, JUMPS]] = slide, gain, doubt, jumps
    return found


@pytest.mark.parametrize("shown", [0.0, 0.7])
@pytest.mark.parametrize(("slide", "gain"), [(0.0, 1.5), (0.4, 1.5), (1.0, 0.6)])
def test_a_reading_costs_what_a_normal_of_all_that_is_in_it_does(slide: float, gain: float, shown: float) -> None:
    # input as it enters, what is held and the sensor's noise: their means, and a covariance of all three
    mean, rng = np.array([0.3, -0.2, 0.5]), np.random.default_rng(1)
    root = rng.standard_normal((3, 3))
    cov = root @ root.T
    weights = np.array([slide * gain, 1.0 - slide, shown])
    var = weights @ cov @ weights + 0.09
    new = 1.7 - weights @ mean
    known = (mean[0], cov[0, 0], cov[0, 1], cov[0, 2]), mean[1:].copy(), cov[1:, 1:].copy()
    assert _cost(phase(slide, gain), known, shown, 1.7, 0.09) == pytest.approx(new**2 / var + log(var))


def test_a_line_at_rest_costs_what_it_holds() -> None:
    known = (5.0, 9.0, 2.0, 0.0), np.array([0.25, 0.0]), np.array([[0.5, 0.0], [0.0, 0.0]])
    assert _cost(REST, known, 0.0, 1.25, 0.5) == pytest.approx(1.0)


def test_a_rest_goes_on_by_as_much_as_it_is_off_the_model_where_the_input_turns() -> None:
    residual, output = np.array([0.1, 0.2, 0.4, 0.8]), np.array([1.0, 3.0, 6.0, 10.0])
    # the model was at 2.8 N where the line came to rest, and is at 9.2 N now
    held, shift, rests = _held_on((residual, output), (3, 1), 0.5, 0.25)
    assert (held, shift, rests) == (pytest.approx(0.5 - 6.4), pytest.approx(0.25 - 6.4), False)


def test_what_may_have_slipped_is_left_until_the_next_slide() -> None:
    assert _slipped(phase(doubt=3.0, jumps=4.0)) == 25.0
    # what was left before counts as far as it is still held
    assert _left_behind(phase(doubt=2.0), phase(0.5, doubt=3.0), 0.0) == pytest.approx(9.0 - 0.25 * 4.0)
    assert _left_behind(phase(doubt=9.0), phase(0.5, doubt=3.0), 0.0) == 0.0
    # half of a slide has ended: the line holds half of the error of its end
    assert _left_behind(phase(0.8, 1.5), phase(0.4, 9.0), 0.2) == pytest.approx(0.5 * 2.25 * 0.2)
    assert _left_behind(phase(0.8, 1.5), phase(0.8, 9.0), 0.2) == 0.0 == _left_behind(phase(0.4, 1.5), phase(0.8, 9.0), 0.2)


def test_the_error_of_the_input_moves_on_by_its_law() -> None:
    rng = np.random.default_rng(2)
    row, x, p = rng.standard_normal(36), rng.standard_normal(6), rng.standard_normal((6, 6))
    move, mean = row[:16].reshape(4, 4), row[16:20]
    m, e, after = np.zeros((6, 6)), np.zeros(6), x.copy()
    _moved(p, row, m, e)
    assert m[:4] == pytest.approx(move @ p[:4]) and e == pytest.approx(mean @ p[:4]) and not m[4:].any()
    _error_moves_on(after, row)
    assert after[:4] == pytest.approx(move @ x[:4]) and after[4:].tolist() == x[4:].tolist()


def test_a_reading_is_a_mix_of_what_enters_what_is_held_and_the_sensor_s_noise() -> None:
    rng = np.random.default_rng(3)
    root = rng.standard_normal((3, 3))
    cov = root @ root.T
    follows, hold, decay, enters, rest, shown, slip = 0.3, 0.6, 0.8, 0.5, 0.4, 0.7, 0.11
    own = np.array([0.8, 0.0, 0.7, 0.05, 0.21])
    p, e, z = np.zeros((6, 6)), np.zeros(6), np.zeros(6)
    p[4:, 4:], e[4:] = cov[1:, 1:], cov[0, 1:]
    mean, held, noise = np.array([enters, rest, shown]), np.array([follows, hold, 0.0]), np.array([0.0, 0.0, decay])
    var = _read(z, p, e, cov[0, 0], (follows, hold, decay), (enters, rest, shown), own, slip)
    # what slips is in what is held and in the reading; what is new in the sensor's noise in both as it says
    assert var == pytest.approx(mean @ cov @ mean + slip + 0.21)
    assert z[4] == pytest.approx(held @ cov @ mean + slip) and z[5] == pytest.approx(noise @ cov @ mean + 0.05)


def test_a_reading_teaches_by_its_gain() -> None:
    rng = np.random.default_rng(4)
    q = np.triu(rng.standard_normal((6, 6)))
    z, x, p = rng.standard_normal(6), rng.standard_normal(6), np.zeros((6, 6))
    before, old = z.copy(), x.copy()
    _learned(x, p, q, z, 0.5, 3.0)
    # 0.5 is one over the standard deviation of the innovation
    assert z == pytest.approx(0.5 * before) and x == pytest.approx(old + 0.25 * before * 3.0)
    full = q + np.triu(q, 1).T
    assert p == pytest.approx(full - 0.25 * np.outer(before, before))
