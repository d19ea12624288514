"""A position beside the tension: through the stiffness of the line it must move with it, and go on where its counter does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def rig(speed=0.1, stiffness=3.0, runs=3):
    t = np.arange(0.0, 60.0, 0.02)
    found = []
    for k in range(runs):
        rng = np.random.default_rng(k)
        x = 18.0 - 15.0 * np.cos(2.0 * np.pi * speed * t + 0.3 * k)
        y = play(x, (np.exp(-0.3), 0.0, np.exp(0.3), 0.0))
        position = np.round((0.8 * x + 0.2 * y) / stiffness + 0.4, 3)
        noisy = [v + 0.02 * rng.standard_normal(len(t)) for v in (x, y)]
        found.append(Run(f"r{k}", "act", t, *noisy, config_id="c", trajectory="sine", position_in_mm=position))
    return found


@pytest.mark.parametrize(("size", "speed"), [(4.096, 0.1), (2.048, 0.1), (2.048, 0.3)])
def test_a_counter_that_wraps_around_is_told(size, speed):
    runs = rig(speed)
    assert gate.remarks(runs) == ()
    (said,) = gate.remarks([replace(r, position_in_mm=np.mod(r.position_in_mm, size)) for r in runs])
    assert (said.rule, said.severity, len(said.run_ids)) == ("position", "remark", 3)
    assert "wraps around" in said.sentence and said.number == pytest.approx(size, rel=0.03) and "position_in_mm" in said.mend


def test_a_position_that_drops_out_wraps_nothing():
    runs = rig()
    lost = np.zeros(len(runs[0]), np.bool_)
    lost[500:520] = lost[1800:1850] = True
    said = gate.remarks([replace(r, position_in_mm=np.where(lost, 0.0, r.position_in_mm)) for r in runs])
    assert not [r for r in said if "wraps" in r.sentence]


def test_a_position_that_stands_still_while_the_tension_moves_is_told():
    runs = rig()
    flat = np.full(len(runs[0]), 3.217)
    for moved, ids in (
        ([*runs[:2], replace(runs[2], position_in_mm=flat)], ("r2",)),
        ([replace(r, position_in_mm=flat) for r in runs], ("r0", "r1", "r2")),
    ):
        (said,) = gate.remarks(moved)
        assert (said.rule, said.run_ids) == ("position", ids) and "never changes" in said.sentence and "no position_in_mm" in said.mend
    # from a moment on
    off = replace(runs[1], position_in_mm=np.where(runs[1].time_s > 30.0, runs[1].position_in_mm[1500], runs[1].position_in_mm))
    (said,) = gate.remarks([runs[0], off, runs[2]])
    assert said.run_ids == ("r1",) and "stands still for 30 s from 30" in said.sentence


def test_a_position_that_is_held_while_the_tension_relaxes_is_no_fault():
    t = np.arange(0.0, 60.0, 0.02)
    position = np.interp(t, [0.0, 5.0, 55.0, 60.0], [0.0, 9.0, 9.0, 0.0])
    relaxes = np.where((t > 5.0) & (t < 55.0), 1.0 - 0.25 * (1.0 - np.exp(-(t - 5.0) / 8.0)), np.where(t >= 55.0, 0.75, 1.0))
    x = 2.0 + 3.0 * position * relaxes
    rng = np.random.default_rng(0)
    y = play(x, (np.exp(-0.3), 0.0, np.exp(0.3), 0.0))
    run = Run("a", "act", t, *(v + 0.02 * rng.standard_normal(len(t)) for v in (x, y)), position_in_mm=np.round(position, 3))
    assert not [r for r in gate.remarks([run]) if r.rule == "position"]
