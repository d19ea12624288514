"""An output that is late, and one that is filtered: friction alone, with a delay and with a low-pass leave different things of slow and fast parts."""

from __future__ import annotations

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate

NOISE = 0.01


def swept(seconds=30.0, rate=100.0, low=3.0, high=25.0, slow=0.1, fast=1.2):
    t = np.arange(round(seconds * rate)) / rate
    return t, low + (high - low) * 0.5 * (1.0 - np.cos(2.0 * np.pi * (slow * t + 0.5 * (fast - slow) * t**2 / seconds)))


def wandering(seed, seconds=40.0, rate=50.0, low=0.4, high=6.0):
    t = np.arange(round(seconds * rate)) / rate
    rng = np.random.default_rng(seed)
    w = sum(rng.normal() * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 6.28)) for f in rng.uniform(0.05, 0.6, 9))
    return t, low + (high - low) * (w - w.min()) / np.ptp(w)


def low_passed(v, dt, tau):
    out, state, part = [], v[0], 1.0 - np.exp(-dt / tau)
    for value in v.tolist():
        state += part * (value - state)
        out.append(state)
    return np.array(out)


def late(t, x, y, size):
    return x[t > size], np.interp(t - size, t, y)[t > size], t[t > size]


def recorded(name, t, x, y, seed):
    sd = NOISE * float(np.ptp(y)) * 0.1
    noise = sd * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(name, "act", t, x + noise[0], y + noise[1], config_id=name)


MOVES = [swept(), wandering(1), wandering(4, rate=200.0, low=5.0, high=80.0), swept(rate=250.0, low=0.3, high=2.0, fast=0.8)]


@pytest.mark.each_once
@pytest.mark.parametrize("move", range(len(MOVES)))
@pytest.mark.parametrize("size", asked((0.25, 0.32, 0.5), 0.32))
def test_a_late_output_is_late_and_not_slow(move, size):
    t, x = MOVES[move]
    runs = []
    for i, wrap in enumerate((0.25, 0.5)):
        a, b, when = late(t, x, play(x, lines(wrap)), size)
        runs.append(recorded(f"b{i}", when, a, b, 7 + i))
    (said,) = gate.remarks(runs)
    assert said.rule == "lead" and said.number == pytest.approx(size, abs=0.02) and len(said.run_ids) == 2


@pytest.mark.each_once
@pytest.mark.parametrize("move", range(len(MOVES)))
@pytest.mark.parametrize("size", [0.25, 0.4, 0.9])
def test_a_filtered_output_is_slow_with_its_time_constant(move, size):
    t, x = MOVES[move]
    runs = [recorded(f"b{i}", t, x, low_passed(play(x, lines(w)), t[1], size), i) for i, w in enumerate((0.25, 0.5))]
    (said,) = gate.remarks(runs)
    assert said.rule == "slow" and said.number == pytest.approx(size, rel=0.1) and len(said.run_ids) == 2


@pytest.mark.parametrize("move", range(len(MOVES)))
def test_the_same_filter_on_both_sides_and_friction_alone_are_sound(move):
    t, x = MOVES[move]
    y = play(x, lines(0.4))
    assert gate.remarks([recorded("a", t, x, y, 1)]) == ()
    both = [low_passed(v, t[1], 0.02) for v in (x, y)]
    assert gate.remarks([recorded("b", t, *both, 2)]) == ()


@pytest.mark.parametrize("drag", asked([0.02, 0.05, 0.15], 0.15))
def test_friction_that_grows_with_speed_is_no_filter(drag):
    for t, x in MOVES:
        speed = np.abs(np.gradient(x, t))
        share = 1.0 + drag * 10.0 * speed / (np.quantile(speed, 0.9) + speed)
        low, high = np.exp(-0.3 * share) * x, np.exp(0.3 * share) * x
        out, v = [], low[0]
        for a, b in zip(low.tolist(), high.tolist(), strict=True):
            v = min(max(v, a), b)
            out.append(v)
        assert not {r.rule for r in gate.remarks([recorded("a", t, x, np.array(out), 3)])} & {"slow", "lead"}
