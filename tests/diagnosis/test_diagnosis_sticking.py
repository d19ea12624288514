"""Whether an output rests and jumps where a line should slide, by hand and on made records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import SHORT, record

from sstl_cli.diagnosis.constants import DECIDES_NATS, WINDOW_TRAVEL
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


def test_the_likeliest_mixture_has_the_shares_of_its_parts():
    # three of four samples can be of the first kind alone: 3 ln(3/4) + ln(1/4)
    apart = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert _mixture(apart) == pytest.approx(3.0 * np.log(0.75) + np.log(0.25))


def test_an_output_that_never_changes_does_not_rest_between_movements(one):
    """Without noise, and without a step, there was nothing to divide by."""
    still = replace(one, raw=replace(one.raw, tension_out_n=np.full(len(one.raw), 5.0)))
    assert _nats(still, np.full(len(STROKES), 5.0), noise_n=0.0) == 0.0
