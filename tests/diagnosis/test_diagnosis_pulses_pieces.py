"""What makes a pulse, on readings without noise: where it begins, how long it lasts and what a line beside it takes away."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis import pulses as of
from sstl_cli.diagnosis.constants import AT_MOST, BESIDE_PULSE, LONGEST_PULSE, SPIKE_SIGMA

NOISE, AT = 0.02, 40
LIMIT = SPIKE_SIGMA * NOISE


def hit(height, kept, at=AT, n=100):
    """Return readings of a parabola that a pulse has hit."""
    t = np.arange(float(n))
    return 0.01 * t + 0.0005 * t**2 + np.where(t >= at, height * kept ** np.maximum(t - at, 0.0), 0.0)


@pytest.mark.parametrize(
    ("before", "beyond", "jumps"),
    [
        ((0.0, 0.0), 1.01, True), ((0.0, 0.0), 0.99, False),
        # beyond the smaller one of the two steps before it
        ((1.0, 1.0), 1.01, True), ((1.0, 1.0), 0.99, False), ((5.0, 1.0), 1.01, True), ((1.0, 5.0), 1.01, True), ((5.0, 5.0), -3.0, False),
    ],
)  # fmt: skip
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_jump_is_far_larger_than_the_steps_before_it(before, beyond, jumps, way):
    # steps of nothing, the two before, and one beyond the smaller of them
    steps = np.array([0.0, 0.0, *before, min(before) + beyond * LIMIT])
    signal = way * np.concatenate(([0.0], np.cumsum(steps)))
    assert of._jumps(signal, NOISE)[4] == jumps


def test_a_window_takes_away_a_parabola_and_a_jump_that_stays():
    for length in (2, 5, LONGEST_PULSE):
        w = of._window(length)
        assert len(w.where) == length + 2 * BESIDE_PULSE and np.flatnonzero(w.inside).tolist() == list(range(6, 6 + length))
        assert w.where[w.inside].tolist() == list(range(length))
        parabola = 3.0 - 0.7 * w.where + 0.05 * w.where**2
        pulse = np.where(w.inside, RNG.standard_normal(len(w.where)), 0.0)
        # the line is read off what is beside: what is inside stays whole
        assert w.beside @ (parabola + pulse) == pytest.approx(pulse, abs=1e-9)
        stays = np.where(w.where >= 0.0, 2.0, 0.0)
        assert w.stays @ (parabola + stays) == pytest.approx(0.0, abs=1e-9)
        # of what comes back the least squares leave what they must
        left = w.stays @ pulse
        assert left @ w.stays @ parabola == pytest.approx(0.0, abs=1e-9) and left @ left == pytest.approx(pulse @ left)


RNG = np.random.default_rng(50)


@pytest.mark.parametrize(("height", "kept"), [(1.0, 0.5), (-1.0, 0.5), (0.6, 0.7), (5.0, 0.3)])
def test_a_pulse_lasts_until_it_is_less_than_the_noise(height, kept):
    gone = int(np.ceil(np.log(NOISE / abs(height)) / np.log(kept)))
    assert of._length(hit(height, kept), AT, NOISE) == gone
    assert np.flatnonzero(of.pulses(hit(height, kept), NOISE)).tolist() == list(range(AT, AT + gone))


def test_a_pulse_needs_six_readings_on_either_side():
    gone = 6
    # begins at the sixth reading, and ends six before the last
    for at, n, length in ((6, 60, gone), (5, 60, 0), (40, 52, gone), (40, 51, 0)):
        assert of._length(hit(1.0, 0.5, at, n), at, NOISE) == length


@pytest.mark.parametrize(
    ("height", "kept"),
    [
        # its second reading is within noise, so that it is a reading alone
        (1.0, 0.9 * AT_MOST * NOISE),
        # no more than any noise makes
        (0.9 * LIMIT, 0.7),
        # it is still there behind the longest pulse
        (1.0, 0.9),
        # it stays, or grows
        (1.0, 1.0), (0.5, 1.05),
    ],
)  # fmt: skip
def test_what_is_one_reading_or_noise_or_does_not_come_back_in_time_is_none(height, kept):
    assert of._length(hit(height, kept), AT, NOISE) == 0


def test_what_is_not_like_a_pulse_within_noise_is_none():
    # up, and back to where it was by steps of its own
    shape = np.zeros(100)
    shape[AT : AT + 5] = [1.0, 0.2, 0.9, 0.1, 0.02]
    assert of._length(shape, AT, NOISE) == 0
    shape[AT : AT + 5] = [1.0, 0.4, 0.16, 0.064, 0.0256]
    assert of._length(shape, AT, NOISE) in (4, 5)
