"""Samples that no sensor gave: a gap filled by a straight line, and a channel that is renewed far more slowly than it is logged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from soon import asked
from test_identification_gate_bookkeeping import loop

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def filled(r: Run, a: float, b: float) -> Run:
    keep = (r.time_s < a) | (r.time_s > b)
    x, y = (np.interp(r.time_s, r.time_s[keep], v[keep]) for v in (r.tension_in_n, r.tension_out_n))
    return replace(r, tension_in_n=x, tension_out_n=y)


@pytest.mark.each_once
@pytest.mark.parametrize("top", asked((3.0, 24.0, 120.0), 24.0))
@pytest.mark.parametrize("noise", [2e-4, 2e-3])
@pytest.mark.parametrize(("at", "length"), [(7.0, 1.0), (22.5, 3.0), (10.0, 8.0)])
def test_a_gap_that_was_filled_is_told_with_its_place_and_length(top, noise, at, length):
    runs = [loop(f"r{i}", i, 0.2 + 0.2 * i, top, noise=noise) for i in range(3)]
    assert gate.remarks(runs) == ()
    runs[1] = filled(runs[1], at, at + length)
    (said,) = gate.remarks(runs)
    assert said.rule == "filled" and said.run_ids == ("r1",) and said.failed == (length > 4.0)
    assert said.number == pytest.approx(length, abs=0.1) and "interpolation" in said.sentence


def test_a_jittering_clock_does_not_hide_it_and_a_simulation_without_noise_is_not_filled():
    r = loop("r", 1, 0.4)
    t = r.time_s + 0.003 * np.random.default_rng(3).random(len(r))
    (said,) = gate.remarks([filled(replace(r, time_s=t), 12.0, 15.0)])
    assert said.rule == "filled"
    t = np.arange(4000) / 100.0
    ramps = 3.0 + 20.0 * np.clip(1.5 * np.abs((0.1 * t) % 1.0 - 0.5) * 2.0 - 0.2, 0.0, 1.0)
    assert "filled" not in {s.rule for s in gate.remarks([Run("s", "act", t, ramps, 0.6 * ramps)])}


@pytest.mark.each_once
@pytest.mark.parametrize("stride", [12, 25, 60])
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
def test_a_channel_renewed_far_more_slowly_than_the_log_is_told_calmly(stride, channel):
    r = loop("r", 2, 0.4)
    at = np.arange(len(r)) // stride * stride
    said = [s for s in gate.remarks([replace(r, **{channel: getattr(r, channel)[at]})]) if s.rule == "refresh"]
    assert len(said) == 1 and not said[0].failed and said[0].number == pytest.approx(100.0 / stride, rel=0.01)
    both = replace(r, tension_in_n=r.tension_in_n[at], tension_out_n=r.tension_out_n[at])
    assert "refresh" not in {s.rule for s in gate.remarks([both])}


@pytest.mark.parametrize("seconds", [0.5, 2.0])
def test_a_command_in_steps_is_no_slow_channel(seconds):
    rng = np.random.default_rng(5)
    t = np.arange(4000) / 100.0
    x = (2.0 + 20.0 * rng.random(200))[(t / seconds).astype(int)]
    y = np.concatenate((x[:3], x[:-3])) * 0.7 + 0.01 * rng.standard_normal(len(t))
    assert "refresh" not in {s.rule for s in gate.remarks([Run("c", "act", t, x, y)])}
