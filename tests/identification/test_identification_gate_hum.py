"""Mains hum is neither a second recording nor a copy: it beats at its own frequency, and all runs share it."""

from __future__ import annotations

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def humming(k, rate=100.0, sizes=(0.0, 0.0), phases=(0.0, 0.0), hz=49.98, seconds=40.0, noise=0.02, movement=None):
    """Return a run of an ideal capstan whose cells pick up a mains by ``sizes`` (N)."""
    t, x = multisine(k if movement is None else movement, 3.0, 26.0, seconds=seconds, rate=rate)
    scatter = noise * np.random.default_rng(k).standard_normal((2, len(t)))
    hum = [size * np.sin(2.0 * np.pi * hz * t + phase) for size, phase in zip(sizes, phases, strict=True)]
    return Run(f"r{k}", "act", t, x + hum[0] + scatter[0], play(x, lines(0.4)) + hum[1] + scatter[1])


def rules(*runs):
    return [r.rule for r in gate.remarks(runs)]


@pytest.mark.each_once
@pytest.mark.parametrize("sizes", [(0.9, 0.0), (0.0, 0.9), (0.8, 0.9)])
@pytest.mark.parametrize("hz", [49.98, 50.03])
def test_hum_at_half_the_sampling_rate_is_no_second_recording(sizes, hz):
    assert "order" not in rules(humming(1, sizes=sizes, phases=(0.3, 1.4), hz=hz))


@pytest.mark.parametrize("sizes", [(0.0, 0.0), (0.05, 0.05)])
def test_two_recordings_in_turn_are_told_behind_hum_as_well(sizes):
    both = [humming(k, sizes=sizes, hz=31.0) for k in (1, 2)]
    rows = [np.stack([getattr(r, name) for r in both], 1).ravel() for name in ("tension_in_n", "tension_out_n")]
    assert "order" in rules(Run("r", "act", np.arange(len(rows[0])) / 200.0, *rows))


def test_runs_that_share_a_mains_are_no_copies():
    # the mains is in one phase where runs begin at whole seconds
    runs = [humming(k, rate=120.0, sizes=(0.06, 0.08), phases=(0.2, 0.9), hz=50.0) for k in (1, 2, 3)]
    assert "duplicate" not in rules(*runs)


def test_a_copy_in_another_unit_is_told_behind_hum():
    first, other = (humming(k, rate=120.0, sizes=(0.06, 0.08), hz=50.0) for k in (1, 2))
    copy = Run("copy", "act", first.time_s, *(np.round(v / 4.448, 4) * 4.448 for v in (first.tension_in_n, first.tension_out_n)))
    (said,) = [r for r in gate.remarks([first, other, copy]) if r.rule == "duplicate"]
    assert said.run_ids == ("copy",)
