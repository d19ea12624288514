"""A zero that jumps between the samples of which one point is the mean, and in a channel that is held between renewals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import bend, lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.jumps import channel_of, shown


def tared(run, name, by_n, at):
    return replace(run, **{name: getattr(run, name) + np.where(np.arange(len(run)) < at, 0.0, by_n)})


def held(run, name, over):
    v = getattr(run, name)
    return replace(run, **{name: np.round(v[np.arange(len(run)) // over * over] / 0.05) * 0.05})


@pytest.mark.each_once
@pytest.mark.parametrize("at", [1500, 1501])
@pytest.mark.parametrize("channel", [0, 1])
def test_a_zero_that_jumps_within_a_mean_of_samples_is_told(at, channel):
    name = ("tension_in_n", "tension_out_n")[channel]
    run = tared(bend("b050", 0.4, "act", 3), name, -3.0, at)
    change = gate.evidence_of(run).shapes.change
    assert change is not None and (change.channel, change.is_gain) == (channel, False)
    assert change.size == pytest.approx(-3.0, abs=0.3) and change.at_s == pytest.approx(run.time_s[at] - run.time_s[0], abs=0.1)


@pytest.mark.parametrize("part", asked([0.2, 0.4, 0.45, 0.55], 0.2, 0.45))
def test_a_zero_that_jumps_between_renewals_as_steep_is_told(part):
    t, x = multisine(7, 3.0, 26.0, seconds=180.0)
    t, x = t[: len(t) // 9], x[::9]
    noise = 0.02 * np.random.default_rng(3).standard_normal((2, len(t)))
    run = Run("a", "act", t, x + noise[0], play(x, lines(0.5)) + noise[1])
    change = gate.evidence_of(held(tared(run, "tension_out_n", -2.0, int(part * len(run))), "tension_out_n", 5)).shapes.change
    assert change is not None and (change.channel, change.is_gain) == (1, False)
    assert gate.evidence_of(held(run, "tension_out_n", 5)).shapes.change is None


def test_a_jump_is_what_a_channel_does_beyond_its_way():
    rng = np.random.default_rng(1)
    x, y = (np.cumsum(np.full(200, rise)) + 0.01 * rng.standard_normal(200) for rise in (0.1, 0.07))
    jumps = (channel_of(x), channel_of(y + np.where(np.arange(200) < 120, 0.0, 2.0)))
    assert shown(jumps, (0.01, 0.01), range(115, 126), 1, False, 2.0) and jumps[1].unlikeliest()[-1] == 120
    # not of another size, elsewhere, of both channels, or too small to be seen
    assert shown(jumps, (0.01, 0.01), range(115, 126), 1, False, 4.0) is False
    assert shown(jumps, (0.01, 0.01), range(95, 106), 1, False, 2.0) is False
    both = (channel_of(x + np.where(np.arange(200) < 120, 0.0, 3.0)), jumps[1])
    assert shown(both, (0.01, 0.01), range(115, 126), 1, False, 2.0) is False
    assert shown(jumps, (0.5, 0.5), range(115, 126), 1, False, 2.0) is None
