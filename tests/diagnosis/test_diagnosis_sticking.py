"""Whether an output rests and jumps where a line should slide, by hand and on made records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import SHORT, record
from scipy.stats import norm

from sstl_cli.diagnosis import sticking
from sstl_cli.diagnosis.constants import DECIDES_NATS, FEWEST_WINDOWS, WINDOW_TRAVEL
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.sticking import _mixture, _windows, rests

NOISE_N = 0.01
# strokes of a model, up and down, in steps of a fifth of the noise
STROKES = np.concatenate([s for _ in range(4) for s in (np.linspace(5.0, 15.0, 5000), np.linspace(15.0, 5.0, 5000))])


@pytest.fixture(scope="module")
def one():
    """A record whose output and noise a test chooses."""
    return prepare(record({}, moves=SHORT, configs=1), 1.0).records[0]


def _nats(one, output, noise_n=NOISE_N, step_n=0.0, unit=1.0):
    rng = np.random.default_rng(3)
    read = output + noise_n * rng.standard_normal(len(output))
    read = np.round(read / step_n) * step_n if step_n else read
    faults = replace(one.faults_out, noise_n=noise_n * unit, step_n=step_n * unit)
    made = replace(one, y_fine=unit * read, weight_fine=np.ones(len(output)), faults_out=faults)
    return rests([made], [unit * STROKES])


def _held_until(pull, by):
    """Return what follows a signal only in steps: it rests until the signal has gone ``by`` further."""
    out, at = np.empty(len(pull)), pull[0]
    for i, x in enumerate(pull):
        at = x if abs(x - at) > by else at
        out[i] = at
    return out


def test_an_output_that_rests_and_jumps_is_told_from_one_that_scatters(one):
    rng = np.random.default_rng(4)
    wander = np.interp(np.arange(len(STROKES)), np.arange(0, len(STROKES), 50), 0.2 * rng.standard_normal(len(STROKES) // 50))
    assert _nats(one, STROKES) == pytest.approx(0.0, abs=0.5)
    assert _nats(one, STROKES + wander) < DECIDES_NATS
    assert _nats(one, _held_until(STROKES, 0.5)) > 100.0
    assert _nats(one, 0.8 * STROKES + 1.0) < DECIDES_NATS


def test_it_is_the_same_in_any_unit(one):
    stuck = _held_until(STROKES, 0.5)
    assert _nats(one, stuck, unit=1000.0) == pytest.approx(_nats(one, stuck), rel=1e-6)


def test_to_wait_at_a_turn_or_at_a_limit_is_no_jump(one):
    late = np.empty(len(STROKES))
    late[0] = at = STROKES[0]
    for i, x in enumerate(STROKES):
        # backlash of 2 N
        at = min(max(at, x - 1.0), x + 1.0)
        late[i] = at
    assert _nats(one, late) < DECIDES_NATS
    assert _nats(one, np.minimum(STROKES, 13.0)) < DECIDES_NATS


def test_the_steps_of_a_converter_are_no_jumps(one):
    assert _nats(one, STROKES, step_n=0.1) < DECIDES_NATS


def test_too_few_windows_say_nothing(one):
    short = replace(one, y_fine=np.array([0.0, 0.0, 1.0, 1.0, 2.0]), weight_fine=np.ones(5))
    assert rests([short], [np.linspace(0.0, 2.0, 5)]) == 0.0


def test_windows_are_parts_of_strokes_and_begin_with_the_first_movement():
    model = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.0, 2.0])
    output = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0])
    ratio, error = _windows(output, model, np.ones(8, bool), 1.0 / WINDOW_TRAVEL, WINDOW_TRAVEL)
    # up: the first window is still, then it moves, rests and moves; down it never moves
    assert ratio.tolist() == [1.0, 0.0, 1.0] and error.tolist() == pytest.approx([1.0 / WINDOW_TRAVEL] * 3)
    # a reading that is not known ends a stroke
    known = np.array([1, 1, 1, 0, 1, 1, 1, 1], bool)
    assert _windows(output, model, known, 1.0 / WINDOW_TRAVEL, WINDOW_TRAVEL)[0].tolist() == [1.0]


@pytest.mark.parametrize(("windows", "told"), [(FEWEST_WINDOWS, True), (FEWEST_WINDOWS - 1, False)])
def test_so_many_windows_tell_that_an_output_rests(windows, told, monkeypatch, one):
    # every other window rests, all of them within the noise
    ratio = np.where(np.arange(windows) % 2, 2.0, 0.0)
    monkeypatch.setattr(sticking, "_windows", lambda *_: (ratio, np.full(windows, 0.1)))
    assert (rests([one], [np.zeros(3)]) > DECIDES_NATS) is told


def test_densities_are_those_of_a_normal_and_of_what_is_even_over_a_width():
    x = np.linspace(-8.0, 8.0, 1601)
    for sd, half in ((0.3, 2.0), (1.0, 0.5)):
        normal, even = sticking._normal(x, np.full(len(x), sd)), sticking._uniform(x, half, np.full(len(x), sd))
        assert normal == pytest.approx(norm.pdf(x, 0.0, sd), abs=1e-12) and np.trapezoid(even, x) == pytest.approx(1.0)
        # the variance of what is even is a third of the square of half its width, and the error adds to it
        assert np.trapezoid(even * x**2, x) == pytest.approx(half**2 / 3.0 + sd**2, rel=1e-4)
    assert sticking._normal(np.array([1e3]), np.array([0.1])) == sticking._uniform(np.array([1e3]), 1.0, np.array([0.1])) > 0.0


def test_what_an_output_may_be_off_by_at_rest_is_its_noise_in_means_and_a_step(one):
    def off(noise_n, step_n, thin=1):
        faults = replace(one.faults_out, noise_n=noise_n, step_n=step_n)
        return sticking._noise_n(replace(one, faults_out=faults, dt_s=thin * one.raw.dt_s))

    assert off(0.3, 0.4) == pytest.approx(0.5) and off(0.6, 0.4, 4) == pytest.approx(0.5)
    # never less than what rounding and the grid make by themselves
    assert off(0.0, 0.0) == pytest.approx(1e-4 * np.ptp(one.raw.tension_out_n))
    # of several runs the loudest counts: a rest in the other is within its noise
    quiet = [replace(one, faults_out=replace(one.faults_out, noise_n=n)) for n in (0.01, 0.02)]
    asked = []
    real = sticking._windows
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sticking, "_windows", lambda *a: asked.append(a[3]) or real(*a))
        rests(quiet, [r.y_fine for r in quiet])
    assert asked == pytest.approx([np.sqrt(2.0) * 0.02 / np.sqrt(one.thin)] * 2)


def test_the_likeliest_mixture_has_the_shares_of_its_parts():
    # three of four samples can be of the first kind alone: 3 ln(3/4) + ln(1/4)
    apart = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert _mixture(apart) == pytest.approx(3.0 * np.log(0.75) + np.log(0.25))


def test_an_output_that_never_changes_does_not_rest_between_movements(one):
    """Without noise, and without a step, there was nothing to divide by."""
    still = replace(one, raw=replace(one.raw, tension_out_n=np.full(len(one.raw), 5.0)))
    assert _nats(still, np.full(len(STROKES), 5.0), noise_n=0.0) == 0.0
