"""A command is smooth down to the rounding of its digits, however little it comes before the output; a sensor is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.rounding import digit_of, ramps, rounding_of
from sstl_cli.identification.gate.sensors import quantisation

T = np.arange(4000) / 200.0
AHEAD = 10
MOVEMENTS = {
    "triangles": 4.0 + 8.75 * np.abs((T / 6.321) % 1.0 - 0.5) * 2.0,
    "trapezoids": np.clip(2.0 + 12.0 * np.abs((T / 5.113) % 1.0 - 0.5) * 2.0, 4.0, 12.0),
    "sines": multisine(5, 3.0, 12.0, rate=200.0, seconds=20.0)[1],
}


def recorded(movement, step=0.0, noise=0.008):
    """Return a run of which both channels have noise, and that with the command (a few samples ahead, five digits) as the input."""
    x = MOVEMENTS[movement]
    rng = np.random.default_rng(4)
    a, b = (v + noise * rng.standard_normal(len(T)) for v in (x, play(x, lines(0.4))))
    sensed = Run("a", "act", T, np.round(a / step) * step if step else a, b)
    return sensed, replace(sensed, tension_in_n=np.round(np.append(x[AHEAD:], np.full(AHEAD, x[-1])), 5))


@pytest.mark.parametrize("movement", MOVEMENTS)
def test_a_command_a_few_samples_ahead_is_told(movement):
    sensed, command = recorded(movement)
    assert "noiseless" in [r.rule for r in gate.remarks([command])]
    assert "noiseless" not in [r.rule for r in gate.remarks([sensed])]
    assert gate.sensors_of(command)[0].computed and not gate.sensors_of(sensed)[0].computed


@pytest.mark.each_once
@pytest.mark.parametrize("movement", MOVEMENTS)
@pytest.mark.parametrize("step", [0.05, 0.0977])
def test_a_coarse_converter_is_no_command(movement, step):
    sensed, _ = recorded(movement, step)
    assert gate.sensors_of(sensed)[0].step_n == pytest.approx(step)
    assert "noiseless" not in [r.rule for r in gate.remarks([sensed])]


def test_a_ramp_that_comes_back_to_its_own_numbers_is_no_converter():
    up = np.round(0.00553 * np.arange(500), 5)
    up_and_down = np.concatenate((up, up[::-1], up, up[::-1]))
    assert quantisation(up_and_down) > 0.0 and ramps(up_and_down) and rounding_of(up_and_down) == 1e-5
    # read by a converter it rests and steps by turns
    read = np.round(up_and_down / 0.02) * 0.02
    assert quantisation(read) == pytest.approx(0.02) and not ramps(read)


def test_the_last_digit_is_found_in_text_and_in_either_precision():
    v = 3.0 + np.sin(T)
    assert digit_of(np.round(v, 3)) == 1e-3 and digit_of(v) < 1e-15
    assert 1e-7 < digit_of(v.astype(np.float32).astype(np.float64)) < 1e-6
    smooth, noisy = v, v + 1e-6 * np.random.default_rng(1).standard_normal(len(T))
    assert rounding_of(smooth) and rounding_of(np.round(smooth, 5)) == 1e-5
    assert not rounding_of(noisy) and not rounding_of(np.round(noisy, 8))
