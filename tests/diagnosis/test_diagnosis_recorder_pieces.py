"""Pieces of the search for recorder faults, sample by sample, at their thresholds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis import recorder
from sstl_cli.diagnosis.constants import FEW, SPIKE_SIGMA, UNSEEN
from sstl_cli.diagnosis.recorder import (
    FOURTHS_ERROR,
    Faults,
    fourths,
    limited,
    scan,
    slow_noise,
    white_beside,
    white_noise,
    white_of_fourths,
)

RNG = np.random.default_rng(11)
NONE = np.zeros(3, bool)


def flags(text):
    return np.array([c == "x" for c in text])


def test_stretches_begin_at_the_first_and_end_behind_the_last():
    assert stretches(flags("xx..x.xxx")) == [(0, 2), (4, 5), (6, 9)] and stretches(flags("....")) == []


def test_rounding_is_even_over_a_step_and_a_limit_is_a_reading():
    f = Faults(flags("x.."), flags(".x."), flags("..x"), 1.0, 0.6, 0.1)
    assert f.rounding_n == pytest.approx(0.6 / np.sqrt(12.0)) and f.bad.tolist() == [True, True, False]


def test_third_differences_of_one_sample_have_the_binomial_weights():
    assert np.abs(recorder.THIRD).tolist() == [1.0, 3.0, 3.0, 1.0] and recorder.THIRD.sum() == 0.0


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.95])
def test_the_white_part_beside_slow_noise_is_what_its_third_differences_leave(memory):
    slow, white = 0.04, 0.03
    lag = np.abs(np.subtract.outer(range(4), range(4)))
    weights = np.array([1.0, -3.0, 3.0, -1.0])
    seen = np.sqrt(weights @ (slow**2 * memory ** lag.astype(float) + white**2 * np.eye(4)) @ weights / 20.0)
    assert white_beside(seen, slow, memory) == pytest.approx(white)
    # never less than what could not be seen beside it
    assert white_beside(0.01, 1.0, 0.5) == pytest.approx(UNSEEN * 0.01)


def test_noise_is_read_where_it_is_asked_for_if_that_is_enough():
    quiet = 0.01 * RNG.standard_normal(1200)
    mixed = quiet + np.where(np.arange(1200) < 600, 0.0, 0.1 * RNG.standard_normal(1200))
    first = np.arange(1200) < 600
    assert white_noise(mixed, first) == pytest.approx(0.01, rel=0.1) and white_noise(mixed, ~first) > 0.05
    # 403 samples in a row hold 400 third differences, and one fewer does not
    assert white_noise(mixed, np.arange(1200) < 403) < 0.012 < white_noise(mixed, np.arange(1200) < 402)
    assert white_noise(mixed[:4]) == 0.0 < white_noise(mixed[:5])


def test_a_slow_sensor_s_noise_is_what_a_parabola_through_three_readings_misses():
    n = 40
    time = np.cumsum(RNG.choice([1.0, 2.0, 3.0], n))
    signal = RNG.standard_normal(n)
    missed = []
    for i in range(n - 3):
        t, y = time[i : i + 4], signal[i : i + 4]
        # normal to all parabolas: what is left of the readings, in standard deviations
        q = np.linalg.qr(np.vander(t - t[0], 3), mode="complete")[0][:, 3]
        missed.append(abs(q @ y))
    assert slow_noise(signal, time) == pytest.approx(np.quantile(missed, 0.3) / norm.ppf(0.65))
    assert slow_noise(signal, 7.0 * time + 3.0) == pytest.approx(slow_noise(signal, time))
    assert slow_noise(signal[:4], time[:4]) == 0.0 < slow_noise(signal[:5], time[:5])


def test_a_slow_sensor_s_noise_is_known_as_well_as_it_says_where_it_rests():
    found = []
    for _ in range(200):
        signal = 0.02 * RNG.standard_normal(400)
        signal[200:] += np.cumsum(RNG.random(200))
        missed = fourths(signal, np.arange(400.0), np.arange(400) < 200)
        assert len(missed) == 197
        found.append(white_of_fourths(missed))
    assert np.mean(found) == pytest.approx(0.02, rel=0.03)
    # neighbours share three readings: a little less is known than of as many independent ones
    assert FOURTHS_ERROR / np.sqrt(197) < np.std(np.log(found)) < 2.0 * FOURTHS_ERROR / np.sqrt(197)


def test_noise_that_third_differences_show_is_known_as_well_as_it_says():
    rng = np.random.default_rng(31)
    found = [recorder.white_of_thirds(np.abs(np.diff(0.05 * rng.standard_normal(403), 3))) for _ in range(600)]
    assert np.mean(found) == pytest.approx(0.05, rel=0.01)
    # differences that overlap are alike: less is known than of as many independent ones; without the loudest a little more so
    assert 1.2 * np.sqrt(np.pi / 2.0 - 1.0) < recorder.THIRDS_ERROR
    assert pytest.approx(np.std(np.log(found)), rel=0.15) == recorder.THIRDS_ERROR / 20.0


def test_the_noise_of_a_share_of_readings_lies_where_the_normal_says():
    assert norm.cdf(recorder.LIES_AT) - norm.cdf(-recorder.LIES_AT) == pytest.approx(recorder.BELOW) and recorder.BELOW == 0.3
    # a quantile is known to the root of p (1 - p) over the density of sizes there
    density = 2.0 * norm.pdf(recorder.LIES_AT)
    assert pytest.approx(np.sqrt(0.3 * 0.7) / density / recorder.LIES_AT) == FOURTHS_ERROR


@pytest.mark.parametrize("at", [0, 1, 2, -3, -2, -1])
def test_a_spike_at_the_end_of_a_record_is_seen(at):
    slow = 10.0 + 4.0 * np.sin(np.arange(300) / 100.0) + 0.01 * np.random.default_rng(0).standard_normal(300)
    assert not recorder.scan(slow).spike.any()
    slow[at] += 1.0
    assert np.flatnonzero(recorder.scan(slow).spike).tolist() == [at % 300]


def test_a_record_that_begins_or_ends_with_a_movement_has_no_spike_there():
    # a ramp, the top of a curve, and a step after two samples: what came before is not known
    for y in (np.arange(40.0), -(np.arange(40.0) ** 2), np.repeat([0.0, 50.0], [2, 38])):
        assert not recorder._spikes(y, 0.1, np.zeros(40, bool)).any() and not recorder._spikes(y[::-1], 0.1, np.zeros(40, bool)).any()


@pytest.mark.parametrize("samples", [1500, 1733, 1801, 1990])
def test_the_ends_of_a_fast_movement_are_no_spikes(samples):
    """A sine of a hundred samples a period that swings by 2000 times its noise, begun and ended anywhere in it."""
    t = 0.01 * np.arange(samples)
    for seed in range(40):
        y = 9.0 * np.sin(2.0 * np.pi * t + seed) + 0.01 * np.random.default_rng(seed).standard_normal(samples)
        assert not scan(y).spike.any(), seed


def test_a_spike_leaves_by_more_than_noise_and_comes_back_within_two_samples():
    flat = np.zeros(40)
    for height, seen in ((1.01 * SPIKE_SIGMA, True), (0.99 * SPIKE_SIGMA, False)):
        y = flat.copy()
        y[20] = -height
        assert recorder._spikes(y, 1.0, flat > 0).any() == seen
    y = flat.copy()
    y[[10, 20, 21, 30, 31, 32]] = 100.0
    assert np.flatnonzero(recorder._spikes(y, 1.0, flat > 0)).tolist() == [10, 20, 21]
    assert np.flatnonzero(recorder._spikes(y, 1.0, np.arange(40) == 10)).tolist() == [20, 21]
    # a ramp hides none, a corner and a jump are none
    ramp = 10.0 * np.arange(40.0)
    ramp[20] += 1.01 * SPIKE_SIGMA
    assert np.flatnonzero(recorder._spikes(ramp, 1.0, flat > 0)).tolist() == [20]
    for bent in (np.maximum(ramp, 200.0), np.minimum(ramp, 150.0), np.where(np.arange(40) < 17, 0.0, 300.0)):
        bent[20] = bent[19] if bent[19] == bent[21] else bent[20]
        assert not recorder._spikes(bent, 1.0, flat > 0).any()


def test_what_rises_and_falls_over_several_samples_is_no_spike_but_a_clock_that_is_off_smears_one():
    y = np.zeros(60)
    y[[19, 20, 21]] = [-40.0, -100.0, -45.0]
    y[[39, 40, 41]] = [3.0, 100.0, 15.0]
    assert np.flatnonzero(recorder._spikes(y, 0.5, y > 1e9)).tolist() == [40]


def test_spikes_close_to_one_another_hide_none_of_them():
    y = np.zeros(60)
    at = [20, 23, 26, 29, 32]
    y[at] = [5.0, 30.0, 90.0, 20.0, 7.0]
    assert np.flatnonzero(recorder._spikes(y, 0.5, y > 1e9)).tolist() == at


@pytest.mark.parametrize(("repeats", "seen"), [(FEW - 1, False), (FEW, True)])
def test_so_many_equal_readings_in_a_row_are_no_chance(repeats, seen):
    y = np.arange(30.0)
    y[10 : 10 + repeats] = 10.0
    found = np.flatnonzero(recorder._frozen(y, 0.1, 0.0)).tolist()
    assert found == (list(range(11, 10 + repeats)) if seen else [])


def test_a_coarser_converter_repeats_more_often_by_chance():
    y = np.arange(3000.0)
    y[10:20] = 10.0
    # step = noise: a level is repeated with 0.28 / 0.96 = 0.29, and 3000 0.29^k < 1e-3 from k = 13 on
    rounded = np.sqrt(1.0 - 1.0 / 12.0)
    need = 1 + int(np.ceil(np.log(1e-3 / 3000.0) / np.log(1.0 / (2.0 * np.sqrt(np.pi) * rounded))))
    for length in (need - 1, need):
        y = np.arange(3000.0)
        y[10 : 10 + length] = 10.0
        assert recorder._frozen(y, 1.0, 1.0).any() == (length >= need)
    # less noise than half a step: a hold repeats its level for ever, and so does what has no noise
    assert not recorder._frozen(np.zeros(300), 0.5, 1.0).any() and not recorder._frozen(np.zeros(300), 0.0, 0.0).any()


@pytest.mark.parametrize(("noise", "seen"), [(np.sqrt(1.0 / 3.0) - 0.01, False), (np.sqrt(1.0 / 3.0) + 0.01, True)])
def test_a_sensor_s_own_noise_of_half_a_step_repeats_no_level_for_ever(noise, seen):
    # a step of 1 N adds 1/12 N^2 of rounding to a quarter of its own
    assert recorder._frozen(np.zeros(300), noise, 1.0).any() == seen


def test_levels_that_arithmetic_tells_apart_are_one():
    levels, counts = recorder._levels(np.array([1.0, 2.0, 1.0, 2.0 + 1e-13, 5.0]))
    assert levels.tolist() == [1.0, 2.0, 5.0] and counts.tolist() == [2, 2, 1]


def test_readings_pile_up_at_a_limit_and_not_at_a_highest_reading():
    base = np.linspace(0.0, 10.0, 400) + 0.02 * RNG.standard_normal(400)
    y = np.minimum(base, 9.0)
    clipped, level = recorder._clipped(y, 0.02, 0.0)
    assert level == 9.0 and np.array_equal(clipped, y == 9.0) and np.array_equal(limited(y), clipped)
    assert recorder._clipped(base, 0.02, 0.0)[1] == np.inf and not limited(base).any()
    # two are chance; and a signal that never leaves its limit has none
    two = np.append(base, [base.max()])
    assert not recorder._clipped(two, 0.02, 0.0)[0].any() and recorder._clipped(np.append(two, [base.max()] * 8), 0.02, 0.0)[0].sum() == 10
    assert not recorder._clipped(np.append(np.full(300, 9.0), base[:30]), 0.02, 0.0)[0].any()
    # without noise a plateau is a plateau
    assert not limited(np.minimum(np.linspace(0.0, 10.0, 400), 9.0)).any()


def test_on_a_grid_a_limit_is_held_in_a_row_and_often():
    rng = np.random.default_rng(3)
    rest = np.concatenate((np.linspace(0.0, 9.0, 200), np.tile([9.0, 8.9], 20), np.linspace(9.0, 0.0, 200)))
    on_grid = 0.1 * np.round((rest + 0.02 * rng.standard_normal(len(rest))) / 0.1)
    assert recorder._clipped(np.minimum(on_grid, 9.0), 0.05, 0.1)[1] == np.inf
    held = np.concatenate((rest[:200], np.full(40, 9.0), rest[240:]))
    assert recorder._clipped(held, 0.05, 0.1)[1] == 9.0


def test_how_many_chance_puts_on_a_level_goes_by_the_step_and_not_by_the_levels_that_were_met():
    # 60 readings in six steps below the top: ten on each, so that 40 are no chance; by levels of 0.3 N it were 30
    y = np.repeat([0.0, 8.5, 8.8, 9.0], [100, 30, 30, 40])
    assert recorder._clipped(y, 0.05, 0.1)[1] == 9.0 and recorder._clipped(y, 0.05, 0.0)[1] == np.inf
    # further down than six steps nobody is counted
    lower = np.repeat([0.0, 8.3, 9.0], [100, 600, 40])
    assert recorder._clipped(lower, 0.05, 0.1)[1] == 9.0


def test_three_readings_are_the_fewest_that_pile_up():
    # two readings a thousandth apart within 0.12 N of the top: 0.017 on a level by chance, so that three are one in a million
    low = np.linspace(0.0, 5.0, 50)
    for count, piled in ((2, False), (3, True)):
        y = np.concatenate((low, [8.95, 8.951], np.full(count, 9.0)))
        assert (recorder._clipped(y, 0.02, 0.0)[1] == 9.0) is piled
    # four hundredths apart they are 0.7 on a level: three are nothing then
    assert recorder._clipped(np.concatenate((low, [8.91, 8.95], np.full(3, 9.0))), 0.02, 0.0)[1] == np.inf


def test_short_and_noiseless_signals_have_no_faults():
    short = scan(np.array([0.0, 1.0] * 7))
    assert not short.bad.any() and len(short.spike) == 14 and (short.clip_level_n, short.step_n, short.noise_n) == (np.inf, 0.0, 0.0)
    flat = scan(np.minimum(np.linspace(0.0, 10.0, 300), 9.0))
    assert not (flat.bad | flat.clipped).any() and flat.step_n == 0.0 and flat.clip_level_n == np.inf


def test_a_channel_that_drops_out_for_three_readings_and_comes_back_says_nothing_there():
    t = np.arange(900) / 100.0
    line = 8.0 + 3.0 * np.sin(t) + 0.02 * np.random.default_rng(4).standard_normal(900)
    gone = line.copy()
    gone[300:303] = 0.0
    gone[500:506] = 0.0
    found = scan(np.round(gone, 3))
    assert np.flatnonzero(found.bad).tolist() == [300, 301, 302, *range(500, 506)]
    # what stays there has moved, what is on its way repeats nothing off it
    gone[600:] -= 4.0
    assert recorder._dropped(np.round(gone, 3), 0.02).sum() == 9
    # a sensor that is held between its readings repeats all of them, also where it turns
    held = np.repeat(np.where(np.arange(300) % 40 == 20, 12.0, line[::3]), 3)
    assert not recorder._dropped(held, 0.02).any()


def test_two_samples_on_either_side_tell_whether_a_spike_is_back_and_with_fewer_one_side_alone():
    # behind the next two samples the line bends by 10 N: one side alone cannot tell
    y = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 10.0, 20.0, 30.0, 40.0])
    assert recorder._back(y, 2, 3, 0.1) and not recorder._back(y[1:], 1, 2, 0.1)
    back = y[::-1]
    assert recorder._back(back, 6, 7, 0.1) and not recorder._back(back[:-1], 6, 7, 0.1)
    # one side alone that goes on straight does, by more than noise and than the line goes anywhere from one reading to the next
    for slope in (0.0, 1.0):
        for share, seen in ((1.01, True), (0.99, False)):
            straight = slope * np.arange(6.0)
            straight[0] += share * (SPIKE_SIGMA * 0.1 + slope)
            assert recorder._back(straight, 0, 1, 0.1) is seen and recorder._back(straight[::-1], 5, 6, 0.1) is seen


def test_a_slow_sensor_that_begins_just_before_its_line_comes_to_rest_has_no_spike_there():
    # a line that is released by 0.3 N a reading, held, and pulled again: begun at its last reading before the hold
    line = np.concatenate((8.9 - 0.3 * np.arange(3.0), np.full(20, 8.0), 8.0 + 0.3 * np.arange(20.0)))
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(line))
    assert not recorder._spikes((line + noise)[2:], 0.01, np.zeros(len(line) - 2, bool)).any()
    # nowhere else does it move by as much as this
    line[2] += 2.0
    assert np.flatnonzero(recorder._spikes((line + noise)[2:], 0.01, np.zeros(len(line) - 2, bool))).tolist() == [0]


@pytest.mark.parametrize("slope", [0.0, 3.0])
def test_a_cubic_through_two_neighbours_on_either_side_misses_what_stands_alone(slope):
    line = slope * np.arange(20.0) + 0.05 * np.arange(20.0) ** 2
    for height, seen in ((1.3, True), (0.7, False)):
        y = line.copy()
        y[10] += height
        # a parabola changes its step by 0.6 over the samples around: 8 noises of 0.05 N and that
        assert np.flatnonzero(recorder._alone(y, 0.05)).tolist() == ([10] if seen else [])
    # the first and the last three have too few neighbours
    for at in (2, 17):
        y = line.copy()
        y[at] += 50.0
        assert not recorder._alone(y, 0.05)[at]
    corner = 5.0 * np.abs(np.arange(20.0) - 10.0)
    assert not recorder._alone(corner, 0.05).any() and not recorder._alone(np.where(np.arange(20) < 10, 0.0, 9.0), 0.05).any()


def test_a_channel_drops_out_beyond_noise_and_beyond_what_moves_beside():
    def dropped(depth, moved=0.0, length=4):
        y = np.full(200, 5.0) + 0.001 * np.sin(np.arange(200.0) * 7.0)
        y[98:100] -= [0.0, moved]
        y[100 : 100 + length] = 5.0 - depth
        return np.flatnonzero(recorder._dropped(y, 0.1)).tolist()

    assert dropped(0.81) == [100, 101, 102, 103] and dropped(0.79) == []
    # up as well as down; of two samples it is a spike, which others look for
    assert dropped(-0.81) == [100, 101, 102, 103] and dropped(0.9, length=2) == []
    # a movement of 0.2 N beside it hides one and a half times as much more
    assert dropped(1.5, 0.2) == [100, 101, 102, 103] and dropped(1.1, 0.2) == []
    # two readings on either side are enough, one is not
    for before, behind, seen in ((2, 2, True), (1, 2, False), (2, 1, False)):
        y = np.concatenate((np.full(before, 5.0), np.full(4, 3.0), np.full(behind, 5.0))) + 1e-6 * np.arange(before + 4 + behind)
        y[before : before + 4] = 3.0
        assert recorder._dropped(y, 0.1).any() == seen
    # a step is no drop: it does not come back
    step = np.where(np.arange(200) < 100, 5.0, 3.0)
    assert not recorder._dropped(step, 0.1).any()


@pytest.mark.parametrize("step", [0.5, 2.0])
@pytest.mark.parametrize(("over_step", "limit"), [(0.4, False), (0.65, True)])
def test_on_a_coarse_grid_a_rest_at_the_highest_level_is_no_limit_and_beside_more_noise_it_is(monkeypatch, step, over_step, limit):
    # every rest repeats its level as often as the highest one does
    y = np.repeat(np.tile([0.0, 1.0, 2.0, 3.0], 8), 25) * step
    flat = y == y.max()
    noise = float(np.hypot(over_step * step, step / np.sqrt(12.0)))
    monkeypatch.setattr(recorder, "white_noise", lambda *_: noise)
    monkeypatch.setattr(recorder, "quantisation", lambda _: step)
    monkeypatch.setattr(recorder, "_clipped", lambda *_: (flat, float(y.max())))
    found = scan(y)
    # more noise of its own than half a step repeats no level for so long
    assert np.array_equal(found.clipped, flat & limit) and found.clip_level_n == (y.max() if limit else np.inf)
