"""A step is no spike: what jumps and stays is another zero, a wrap or a corner, what returns at the next sample is a spike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import filtering, gate, samples


def moved(kind, seed, top, rate=100.0, seconds=40.0, wrap=0.4, noise=5e-4):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    if kind == "triangle":
        x = np.abs((0.2 * t) % 1.0 - 0.5) * 2.0
    else:
        w = sum(rng.normal() * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 6.28)) for f in rng.uniform(0.05, 0.5, 9))
        x = (w - w.min()) / np.ptp(w)
    x = top * (0.1 + 0.9 * x)
    y = play(x, lines(wrap))
    scatter = top * noise * rng.standard_normal((2, len(t)))
    return Run(f"{kind}{seed}", "act", t, x + scatter[0], y + scatter[1])


def spikes(v):
    piece = samples.Piece("r", {"time_s": np.arange(len(v)) / 100.0, "tension_in_n": v, "tension_out_n": v[::-1].copy()})
    return sum(f.count for f in samples.findings(piece) if f.what == "spikes" and f.column == "tension_in_n")


@pytest.mark.each_once
@pytest.mark.parametrize("kind", ["triangle", "waves"])
@pytest.mark.parametrize("top", asked((4.0, 25.0, 90.0), 25.0))
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
@pytest.mark.parametrize(("share", "at"), [(0.14, 0.37), (-0.2, 0.5), (0.3, 0.63)])
def test_a_zero_that_jumps_is_told_with_its_channel_size_and_time_at_any_size(kind, top, channel, share, at):
    sound = [moved(kind, seed, top) for seed in (1, 2, 3)]
    assert gate.remarks(sound) == ()
    r = sound[1]
    v = getattr(r, channel)
    jump = share * float(np.ptp(v))
    sound[1] = replace(r, **{channel: v + np.where(np.arange(len(r)) < at * len(r), 0.0, jump)})
    (said,) = gate.remarks(sound)
    assert said.rule == "zero_change" and said.run_ids == (r.run_id,) and channel in said.mend
    assert said.number == pytest.approx(jump, rel=0.15)


@pytest.mark.each_once
@pytest.mark.parametrize("seed", asked(range(4), 0, 1))
@pytest.mark.parametrize("wrap", [0.25, 0.7])
def test_friction_that_changes_midway_is_no_other_zero(seed, wrap):
    a, b = moved("waves", seed, 20.0, wrap=wrap), moved("waves", seed, 20.0, wrap=1.3 * wrap)
    half = len(a) // 2
    y = np.concatenate((a.tension_out_n[:half], b.tension_out_n[half:]))
    # joined where both read the same
    assert not {r.rule for r in gate.remarks([replace(a, tension_out_n=y)])} & {"zero_change"}


@pytest.mark.each_once
@pytest.mark.parametrize("seed", asked(range(6), 0, 3))
@pytest.mark.parametrize("slope", [-0.2, 0.0, 0.2])
def test_a_step_a_wrap_a_corner_and_an_end_amid_a_movement_are_no_spikes(seed, slope):
    noise = 0.008 * np.random.default_rng(seed).standard_normal(2000)
    k = np.arange(2000)
    ramp = slope * np.abs((k + 250) % 1000 - 500.0)
    assert spikes(ramp + noise + 2.5 * (k > 700)) == 0
    assert spikes(ramp + noise - 2.5 * (k > 501)) == 0
    assert spikes(np.mod(ramp + noise + 5.07, 10.0)) == 0
    assert spikes(np.where(k > 1200, 3.0, 3.0 + noise)) == 0
    assert spikes((ramp + noise)[: 1000 + 50 * seed]) == 0


def test_what_check_counts_at_the_ends_segment_bridges():
    v = 5.0 + 4.0 * np.sin(np.arange(2000) / 150.0) + 0.008 * np.random.default_rng(3).standard_normal(2000)
    v[0] += 3.0
    v[-1] -= 3.0
    assert spikes(v) == 2
    assert (filtering.bridged(v, 0.01, 0.0) != v)[[0, -1]].all()


@pytest.mark.each_once
@pytest.mark.parametrize("seed", asked(range(6), 0, 3))
@pytest.mark.parametrize("size", [0.5, -3.0, 20.0])
def test_what_returns_at_the_next_sample_is_a_spike(seed, size):
    rng = np.random.default_rng(seed)
    v = 5.0 + 4.0 * np.sin(np.arange(2000) / 150.0) + 0.008 * rng.standard_normal(2000)
    at = 20 + 100 * np.arange(10) + rng.integers(0, 50, 10)
    v[at] += size
    assert spikes(v) == 10
