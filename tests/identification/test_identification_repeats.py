"""Repeated readings: a live sensor rests in a hold as long as its noise and its converter let it, one that is cut off or stands still does not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines
from soon import asked

from sstl_cli.identification import samples
from sstl_cli.identification.gate.live import STUCK_SAMPLES, live_of

TOLD = ("saturation", "frozen stretches")


def drawn(seed, levels, hertz):
    """Return the time (s) and input (N) of ramps of drawn lengths through drawn levels, held at all of them but the lowest."""
    rng = np.random.default_rng((seed, levels))
    at = np.sort(np.concatenate(([2.0, 30.0], rng.uniform(4.0, 28.0, levels - 2))))
    points = [(0.0, at[0])]
    for k in [*range(1, levels), *range(levels - 2, -1, -1)]:
        points.append((points[-1][0] + rng.uniform(0.5, 15.0), at[k]))
        if k:
            points.append((points[-1][0] + rng.uniform(0.5, 5.0), at[k]))
    t = np.arange(int(points[-1][0] * hertz)) / hertz
    return t, np.interp(t, *zip(*points, strict=True))


def read(v, seed, noise, step):
    """Return what a sensor of this noise reads behind a converter of this step (N)."""
    v = v + noise * np.random.default_rng(seed).standard_normal(len(v))
    return np.round(v / step) * step if step else v


def told(t, x, y):
    return {
        (f.what, f.column)
        for f in samples.findings(samples.Piece("r", {"time_s": t, "tension_in_n": x, "tension_out_n": y}))
        if f.what in TOLD
    }


@pytest.mark.parametrize(("hertz", "step", "noises"), [(10.0, 0.004, 1.5), (20.0, 0.004, 3.0), (50.0, 0.003, 50.0), (100.0, 0.002, 50.0)])
def test_a_hold_between_movements_that_repeat_nothing_is_a_hold(hertz, step, noises):
    """Of 60 of each kind: steps of the converter smaller than a sample's movement, and noise that does not lead from one to the next."""
    for seed in range(60):
        t, x = drawn(seed, 2 + seed % 3, hertz)
        y = play(x, lines(0.3 + 0.2 * (seed % 4)))
        assert told(t, read(x, seed, step / noises, step), read(y, seed + 1000, step / noises, step)) == set()


def movement(seed, hertz=100):
    t, x = multisine(seed, 3.0, 26.0, seconds=60.0)
    t, x = t[:: round(100 / hertz)], x[:: round(100 / hertz)]
    return t[: len(t) // 3], x[: len(x) // 3], play(x, lines(0.4))[: len(x) // 3]


@pytest.mark.parametrize(("noise", "step"), [(0.02, 0.0), (0.02, 0.002), (1e-5, 0.0005)])
@pytest.mark.parametrize("seed", asked(range(3), 0, 2))
def test_a_channel_that_is_cut_off_is_told_with_noise_and_without(noise, step, seed):
    t, x, y = movement(seed)
    level = float(np.quantile(x, 0.75))
    level = round(level / step) * step if step else level
    cut = np.minimum(read(x, seed, noise, step), level)
    assert told(t, cut, read(y, seed + 9, noise, step)) == {("saturation", "tension_in_n")}


@pytest.mark.parametrize(("noise", "step"), [(0.02, 0.0), (0.02, 0.002), (1e-5, 0.0005)])
@pytest.mark.parametrize("seed", asked(range(3), 0, 2))
def test_a_sensor_that_stands_still_amid_a_movement_is_told(noise, step, seed):
    t, x, y = movement(seed)
    stops = read(x, seed, noise, step)
    # where it goes fastest
    k = int(np.argmax(np.abs(x[60:-60] - x[30:-90])))
    stops[k + 30 : k + 60] = stops[k + 30]
    assert told(t, stops, read(y, seed + 9, noise, step)) == {("frozen stretches", "tension_in_n")}


def test_what_a_repeat_says_follows_from_noise_and_step():
    noise = np.random.default_rng(1).standard_normal(20_000)
    for step in (0.3, 1.0, 1.5):
        # a level is left least often from its middle
        stays = math.erf(step / 2.0 / math.sqrt(2.0))
        assert live_of(np.round(noise / step) * step, step).nats == pytest.approx(-math.log(stays), rel=0.25)
    # coarse levels, a movement, and a ramp through levels show no noise
    assert live_of(np.round(noise / 4.0 + np.arange(20_000) * 1.37), 1.0).nats < 0.02
    assert live_of(np.sin(np.arange(4000) / 300.0), 0.0).nats == 0.0
    assert live_of(np.round(np.linspace(0.0, 40.0, 4001)), 1.0).nats < 0.1
    # what stands still is no noise, nor are its readings those of a fine converter
    held = np.where(np.arange(20_000) % 2_000 < 900, noise[np.arange(20_000) // 2_000 * 2_000], noise)
    assert live_of(held, 0.0).nats > 10.0
    few = 0.05 * np.round(np.cumsum(np.random.default_rng(2).uniform(3.0, 70.0, 300)))
    assert live_of(np.repeat(few, STUCK_SAMPLES // 2), 0.0).most_repeats(len(few)) > 90.0
