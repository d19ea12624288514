"""The play operator against hand-worked loops, and its properties."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.transmission import activate, play_operator, predict
from sstl_cli.physics.transmission.model import drive_of

tensions = st.lists(st.floats(0.0, 50.0), min_size=2, max_size=60).map(lambda x: np.array(x, float))


def test_hand_worked_loop():
    # pull line 0.5 T, release line 2 T: up to 20 the output is pulled to 10, held down to 5, then released
    path = np.array([2.0, 10.0, 20.0, 12.0, 5.0, 4.0, 1.0, 3.0, 6.0])
    assert play_operator(path, 0.5, 0.0, 2.0, 0.0, 2.0).tolist() == [2.0, 5.0, 10.0, 10.0, 10.0, 8.0, 2.0, 2.0, 3.0]


def test_slopes_of_both_systems():
    path = np.concatenate([np.linspace(1, 40, 500), np.linspace(40, 0.5, 500)])
    for system, n in (("act", 1), ("sstl", 2)):
        out = predict(drive_of(system, "CP", 0.01, path, Mechanics()), 0.5, activate({}), 0.5)
        assert out[499] == np.float64(40 * np.exp(-n * 0.5)) or np.isclose(out[499], 40 * np.exp(-n * 0.5))
        assert np.isclose(out[-1], 0.5 * np.exp(n * 0.5))


@settings(max_examples=60, deadline=None)
@given(tensions, st.floats(0.05, 1.2))
def test_output_stays_between_the_lines(path, theta):
    out = play_operator(path, np.exp(-theta), 0.0, np.exp(theta), 0.0, float(path[0]))
    assert np.all(out >= np.exp(-theta) * path - 1e-9) and np.all(out <= np.exp(theta) * path + 1e-9)


@settings(max_examples=60, deadline=None)
@given(tensions, st.floats(0.1, 10.0))
def test_scaling_tensions_scales_the_output(path, c):
    a = play_operator(path, 0.6, -1.0, 1.7, 0.5, float(path[0]))
    b = play_operator(path * c, 0.6, -c, 1.7, 0.5 * c, float(path[0]) * c)
    assert np.allclose(b, c * a, rtol=1e-9, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(tensions, st.integers(1, 50))
def test_a_run_may_be_cut_and_continued(path, at):
    at = min(at, len(path) - 1)
    whole = play_operator(path, 0.6, 0.0, 1.7, 0.0, float(path[0]))
    first = play_operator(path[:at], 0.6, 0.0, 1.7, 0.0, float(path[0]))
    second = play_operator(path[at:], 0.6, 0.0, 1.7, 0.0, float(first[-1]))
    assert np.array_equal(whole, np.concatenate([first, second]))
