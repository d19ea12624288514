"""Filter, thresholds, turning points, split and blocks, each worked by hand or by another program."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from sstl_cli.identification import filtering, labels, lines

ROOT6 = math.sqrt(6.0)


def from_second_differences(d):
    return np.concatenate(([0.0, 0.0], np.cumsum(np.cumsum(d))))


def test_noise_from_second_differences():
    assert filtering.noise_sd(np.array([1.0, 5.0])) == 0.0
    # one triple: |0 - 2 + 0| over the median of a normal, over the gain of the difference
    assert filtering.noise_sd(np.array([0.0, 1.0, 0.0])) == pytest.approx(2.0 / 0.6745 / ROOT6)
    assert filtering.noise_sd(np.tile([0.5, -0.5], 50)) == pytest.approx(2.0 / 0.6745 / ROOT6)


def test_noise_of_a_long_record_takes_every_third_triple():
    d = np.full(3 * 4096, 5.0)
    d[::3] = 1.0
    assert filtering.noise_sd(from_second_differences(d)) == pytest.approx(1.0 / 0.6745 / ROOT6)
    assert filtering.noise_sd(from_second_differences(d[: 2 * 4096 - 1])) == pytest.approx(5.0 / 0.6745 / ROOT6)


def test_noise_of_a_coarse_converter_is_the_mean_without_the_largest_twentieth():
    # 100 differences: 80 vanish, 16 are 1, 4 are 9; without the largest five, 15 ones are left
    d = np.zeros(100)
    d[::5] = 1.0
    d[::25] = 9.0
    assert filtering.noise_sd(from_second_differences(d)) == pytest.approx(1.2533 * 15.0 / 95.0 / ROOT6)
    assert filtering.noise_sd(np.zeros(30)) == 0.0


def test_sampling_is_the_median_step_to_six_digits():
    assert filtering.sampling(np.array([0.0, 0.1, 0.2, 0.9])) == 0.1
    assert filtering.sampling(1e9 + np.arange(50) / 3.0) == 0.333333
    steps = np.full(3 * 4096, 2.0)
    steps[::3] = 1.0
    assert filtering.sampling(np.concatenate(([0.0], np.cumsum(steps)))) == 1.0


def triangle(n, period, high=1.0):
    return np.interp(np.arange(n) % period, [0, period / 2, period], [0.0, high, 0.0])


def test_cut_off_is_twenty_times_the_motion():
    # 20 periods in 512 samples, not thinned; then 16 periods in 10 s, thinned to 32 samples a period
    assert filtering.default_cutoff(triangle(512, 25.6), 10.0 / 512, 0.0) == pytest.approx(0.2 * 51.2)
    assert filtering.default_cutoff(triangle(10_240, 640), 10.0 / 10_240, 0.0) == pytest.approx(32.0, rel=0.003)
    assert filtering.default_cutoff(triangle(10_240, 10_240), 10.0 / 10_240, 0.0) == 10.0
    assert filtering.default_cutoff(np.ones(600), 0.001, 0.1) == 10.0
    # a thinned step is 2 * 20 / 640: with noise of more than a quarter of that it does not count
    assert filtering.default_cutoff(triangle(10_240, 640), 10.0 / 10_240, 0.0155) == pytest.approx(32.0, rel=0.003)
    assert filtering.default_cutoff(triangle(10_240, 640), 10.0 / 10_240, 0.0158) == 10.0


def test_what_the_filter_leaves_of_white_noise():
    assert filtering.filtered_sd(2.0, 10.0, 0.002) == pytest.approx(2.0 * math.sqrt(2 * 0.83 * 0.02))
    assert filtering.filtered_sd(2.0, 400.0, 0.002) == 2.0


@pytest.mark.parametrize(("n", "hz"), [(3000, 12.0), (3000, 200.0), (40, 5.0), (400, 30.0)])
def test_low_pass_is_scipy_s_up_to_both_ends(n, hz):
    x = np.cumsum(np.random.default_rng(n).standard_normal(n))
    y = np.random.default_rng(1).standard_normal(n)
    b, a = butter(2, hz, fs=500.0)
    pad = min(n - 1, math.ceil(1.5 / (hz / 500.0) - 1e-6))
    for mine, signal in zip(filtering.low_pass(x, y, hz, 0.002), (x, y), strict=True):
        assert mine == pytest.approx(filtfilt(b, a, signal, padlen=pad), abs=1e-9)


def test_low_pass_near_half_the_rate_is_the_identity():
    x, y = np.array([1.0, 5.0, 2.0]), np.array([3.0, 1.0, 4.0])
    for mine, signal in zip(filtering.low_pass(x, y, 225.0, 0.002), (x, y), strict=True):
        assert mine.tolist() == signal.tolist() and mine is not signal


def test_despiked_bridges_what_leaves_both_neighbours_by_the_threshold():
    x = np.array([0.3, 0.0, 1.1, 0.2, 0.0, -1.1, 0.2, 0.0, 1.1, 0.2, 0.1, 5.0])
    assert filtering.despiked(x, 0.85).tolist() == pytest.approx([0.3, 0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.1, 5.0])
    assert filtering.despiked(x, 0.95).tolist() == pytest.approx([0.3, 0.0, 1.1, 0.2, 0.0, 0.1, 0.2, 0.0, 1.1, 0.2, 0.1, 5.0])
    assert filtering.despiked(x, 1.2).tolist() == x.tolist()


def test_ends_are_bridged_beyond_the_line_that_leads_to_them_and_any_movement():
    k = np.arange(200)
    line = 0.1 * k + 0.001 * (-1.0) ** k
    spoilt = line.copy()
    spoilt[0], spoilt[-1] = 3.0, 0.0
    assert filtering.ends_off(spoilt, 0.5) == (True, True) and filtering.ends_off(line, 0.5) == (False, False)
    assert filtering.bridged(spoilt, 0.05, 0.0) == pytest.approx(line, abs=0.005)
    assert filtering.bridged(line, 0.05, 0.0).tolist() == line.tolist()
    # a movement that begins with a step as fast as twice its usual one is a movement
    early = line.copy()
    early[0] = -0.15
    assert filtering.ends_off(early, 0.01) == (False, False)
    # so is one that goes as fast elsewhere, as an output that mostly rests and begins to fall with the last sample
    rests = np.concatenate((np.zeros(150), -0.3 * np.arange(4), np.full(46, -0.9))) + 0.001 * (-1.0) ** k
    rests[-1] -= 0.28
    assert filtering.ends_off(rests, 0.01) == (False, False)
    rests[-1] -= 0.28
    assert filtering.ends_off(rests, 0.01) == (False, True)
    # a channel that is renewed every fifth sample may begin with a new reading
    held = np.repeat(line, 5)
    held[0] = 9.0
    assert filtering.ends_off(held, 0.5) == (False, False)


def test_default_thresholds():
    x = 10.0
    assert labels.default_prominence(x, 0.001) == pytest.approx(0.2)
    assert labels.default_prominence(x, 0.001, 0.005) == pytest.approx(0.05)
    assert labels.default_prominence(x, 0.1) == pytest.approx(1.0)
    assert labels.default_delta(x, 0.001) == pytest.approx(0.2)
    assert labels.default_delta(x, 0.1) == pytest.approx(0.8)
    assert labels.default_prominence(x * 0, 0.0) == labels.default_delta(x * 0, 0.0) == 1e-12
    assert labels.default_tie(x, 0.001, 9.0) == pytest.approx(0.025)
    assert labels.default_tie(x, 0.1, 9.0) == pytest.approx(0.3)
    assert labels.default_tie(x, 0.1, 0.4) == pytest.approx(0.2)
    assert (labels.FIRST_FLOOR, labels.FLOOR) == (0.02, 0.005)


@pytest.mark.parametrize(
    ("sd", "cutoff", "dt", "step", "expected"),
    [
        # guard 0.3 / (10 * 0.002), retreat half of 1.5; band 1e-4 of 10 N crossed twice in 2 samples of 1 mN: hold 5 * 2
        # samples, but 0.2 s are 100
        (0.0, 10.0, 0.002, 0.01, (0.4, 15, 0.75, 1e-3, 100.0)),
        # band 4 sd = 0.08 crossed in 16 samples: hold 80
        (0.02, 10.0, 0.01, 0.01, (0.4, 3, 0.75, 0.08, 80.0)),
        (0.0, 10.0, 0.049, 0.01, (0.4, 0, 0.75, 1e-3, 5.0)),
        (0.0, 1.0, 0.06, 0.01, (0.4, 5, 0.75, 1e-3, 3.0)),
        (0.0, 1.0, 0.04, 0.01, (0.4, 8, 0.75, 1e-3, 5.0)),
    ],
)
def test_rules_of_the_split(sd, cutoff, dt, step, expected):
    xf = np.arange(1001) * step
    rules = labels.Rules(0.4, sd, 1.5, labels.Motion(xf, cutoff, dt))
    assert rules.array().tolist() == pytest.approx([*expected, 0.0, 0.0])


def test_hold_counts_the_fast_part_of_a_thinned_motion():
    # every second of 4096 samples: 0.02 N a thinned step; a twentieth stands still
    steps = np.full(4095, 0.01)
    steps[:200] = 0.0
    xf = np.concatenate(([0.0], np.cumsum(steps)))
    assert labels.Rules(0.4, 0.5, 1.5, labels.Motion(xf, 10.0, 0.1)).hold == 2000.0
    assert labels.Rules(0.4, 0.5, 1.5, labels.Motion(np.ones(50), 10.0, 0.1)).hold == 250.0


X = np.array([5.0, 5.1, 4.9, 7.0, 9.0, 8.95, 9.0, 8.96, 6.0, 3.0, 3.02, 3.04, 3.2, 5.0, 8.0])


@pytest.mark.parametrize(
    ("x", "prominence", "tie", "points", "first"),
    [
        (X, 1.0, 0.05, [2, 7, 11, 14], 1),
        (X, 1.0, 0.0, [2, 6, 9, 14], 1),
        (-X, 1.0, 0.05, [2, 7, 11, 14], -1),
        (X, 5.5, 0.05, [7, 14], -1),
        (X, 7.0, 0.05, [0, 14], 0),
        (np.array([3.0, 2.0, 1.0, 2.0]), 0.5, 0.0, [0, 2, 3], -1),
    ],
)
def test_turning_points(x, prominence, tie, points, first):
    found, direction = labels.turning_points(x, prominence, tie)
    assert (found.tolist(), direction) == (points, first)


def split(x, y, points, first, known=labels.NO_LINES, **rules):
    r = {"delta": 1.0, "guard": 0, "retreat": 9.0, "band": 0.0, "hold": 99, "pull": 0.0, "release": 0.0} | rules
    codes, use, reached = labels.split(
        np.array(x, float), np.array(y, float), np.array(points), first, np.array(list(r.values()), float), np.array(known)
    )
    return "".join("BPbp"[c] for c in codes), use.tolist(), reached.tolist()


UP = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]
OUT = [3, 3, 3, 3.2, 3.5, 4.2, 5, 6, 7, 8]


def test_split_begins_propagation_a_little_before_the_threshold():
    # 1 N above 3 is left at sample 5; it began where 0.3 N was left, at sample 4
    assert split(UP, OUT, [0, 9], 1) == ("BBBBPPPPPP", [0, 0, 0, 0, 0, 1, 1, 1, 1, 1], [1, 0])
    assert split([-v for v in UP], [-v for v in OUT], [0, 9], -1) == ("bbbbpppppp", [0, 0, 0, 0, 0, -1, -1, -1, -1, -1], [0, 1])
    assert split(UP, OUT, [0, 9], 0) == ("B" * 10, [0] * 10, [0, 0])
    assert split(UP, OUT, [0, 9], 1, delta=6.0) == ("B" * 10, [0] * 10, [0, 0])


def test_split_begins_where_more_than_three_tenths_are_left():
    y = [0, 0, 0, 3, 5, 12, 13, 14, 15, 16]
    assert split(UP, y, [0, 9], 1, delta=10.0)[0] == "BBBBPPPPPP"
    # the threshold itself must be exceeded, and the lowest output since the reversal counts
    assert split(UP, [0, 0, 0, 3, 5, 10, 13, 14, 15, 16], [0, 9], 1, delta=10.0)[1] == [0, 0, 0, 0, 0, 0, 1, 1, 1, 1]
    assert split(UP, [2, 1, 0, 3, 5, 10.5, 13, 14, 15, 16], [0, 9], 1, delta=10.0)[1] == [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]


def test_split_leaves_out_guards_at_both_ends():
    assert split(UP, OUT, [0, 9], 1, guard=2)[1] == [0, 0, 0, 0, 0, 0, 0, 1, 1, 0]


def test_split_leaves_out_a_retreat_of_the_input():
    x = [0, 1, 2, 3, 4, 5, 7, 6, 6.8, 9]
    assert split(x, OUT, [0, 9], 1, retreat=0.5)[1] == [0, 0, 0, 0, 0, 1, 1, 0, 1, 1]


def test_split_leaves_out_holds():
    x = [0, 1, 2, 3, 4, 5, 6, 6.05, 6, 6.05, 7, 8]
    y = [3, 3, 3, 3, 3, 4.2, 5, 5, 5, 5, 6, 7]
    assert split(x, y, [0, 11], 1, band=0.1, hold=4)[1] == [0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1]
    assert split(x, y, [0, 11], 1, band=0.1, hold=5)[1] == [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1]
    # a hold that lasts to the end
    assert split(x[:10], y[:10], [0, 9], 1, band=0.1, hold=3)[1] == [0, 0, 0, 0, 0, 1, 0, 0, 0, 1]


def test_split_with_known_lines_waits_until_the_line_leaves_the_held_output():
    # held output: mean of samples 0 to 3, 3.05; pull line T - 1 is above it by 1.5 from 5.55 N on
    known = [1.0, -1.0, 2.0, 0.0]
    assert split(UP, OUT, [0, 9], 1, known, pull=1.5)[1] == [0, 0, 0, 0, 0, 0, 1, 1, 1, 1]
    assert split(UP, OUT, [0, 9], 1, known, release=1.5)[1] == [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]
    down, fall = UP[::-1], [v / 2 for v in OUT[::-1]]
    fall = [4.0, 4.0, 4.0, 3.9, 2.9, 2.0, 1.5, 1.0, 0.6, 0.1]
    # release line 2 T - 4 leaves 3.975 by 2.5 below 2.74 N
    assert split(down, fall, [0, 9], -1, [1.0, 0.0, 2.0, -4.0], release=2.5) == (
        "bbbbpppppp", [0, 0, 0, 0, 0, 0, 0, -1, -1, -1], [0, 1],
    )  # fmt: skip


def test_what_comes_after_the_turn_does_not_end_the_backlash_before_it():
    assert split([0, 1, 2, 3, 2, 1], [0, 0, 0, 0.5, 2, 2], [0, 3, 5], 1)[2] == [0, 0]


def test_split_of_a_loop():
    x = [0, 2, 4, 6, 8, 6, 4, 2, 0, 0, 2]
    y = [1, 1, 2.5, 4, 6, 6, 6, 4, 1.5, 1.5, 1.5]
    assert split(x, y, [0, 4, 8, 10], 1) == ("BBPPbbbpBBB", [0, 0, 1, 1, 1, 0, 0, -1, -1, 0, 0], [1, 1])


def test_block_means_never_join_stretches():
    use = np.array([1, 1, 1, 0, 1, 1, -1, -1, 1, 1, 1, 1, 1], np.int8)
    k = np.arange(13.0)
    t, x, y, stretch = lines.block_means(k, 10 * k, k * k, use, 1, 2)
    assert t.tolist() == [0.5, 4.5, 8.5, 10.5] and x.tolist() == [5.0, 45.0, 85.0, 105.0]
    assert y.tolist() == [0.5, 20.5, 72.5, 110.5] and stretch.tolist() == [0, 1, 2, 2]
    assert lines.block_means(k, k, k, use, -1, 2)[0].tolist() == [6.5]
    assert lines.block_means(k, k, k, use, 1, 3)[0].tolist() == [1.0, 9.0]
    # a stretch that ends with a whole block counts as one
    assert lines.block_means(k, k, k, use, 1, 1)[3].tolist() == [0, 0, 0, 1, 1, 2, 2, 2, 2, 2]


def test_ransac_refuses_points_at_one_place():
    slope, bias, threshold = lines.ransac(np.full(9, 2.0), np.arange(9.0), 1.0, 0.1, False, np.random.default_rng(0).random((32, 2)))
    assert math.isnan(slope) and math.isnan(bias) and threshold == 1.0


def test_ransac_takes_pairs_at_least_a_fifth_of_the_range_apart():
    # a fifth of the range on either side: pairs within a cluster would all lie on slope -1
    x = np.concatenate((np.linspace(0.0, 0.9, 40), np.linspace(9.1, 10.0, 40)))
    y = x - 2.0 * (x - np.where(x < 5, 0.45, 9.55)) * 0.3
    slope, bias, _ = lines.ransac(x, y, 5.0, 0.1, True, np.random.default_rng(1).random((256, 2)))
    assert (slope, bias) == pytest.approx(tuple(np.polyfit(x, y, 1)), abs=1e-9)


def test_ransac_finds_the_line_of_the_majority():
    # a third of the points on another line, which least squares would mix in
    x = np.linspace(0.0, 10.0, 90)
    y = np.where(np.arange(90) % 3 == 0, 9.0 - 0.5 * x, 0.5 * x + 1.0)
    slope, bias, threshold = lines.ransac(x, y, 0.2, 0.01, True, np.random.default_rng(2).random((256, 2)))
    at = np.abs(y - 0.5 * x - 1.0) <= 0.2
    assert (slope, bias) == pytest.approx(tuple(np.polyfit(x[at], y[at], 1)), abs=1e-9)
    assert threshold == 0.2


def test_ransac_threshold_is_four_robust_deviations():
    rng = np.random.default_rng(3)
    x = np.linspace(0.0, 10.0, 4001)
    y = x + 0.1 * rng.standard_normal(4001)
    _, _, threshold = lines.ransac(x, y, 2.0, 0.01, False, rng.random((256, 2)))
    assert threshold == pytest.approx(0.4, rel=0.04)
    assert lines.ransac(x, y, 2.0, 0.6, False, rng.random((256, 2)))[2] == 0.6


def test_least_squares_needs_three_points_within_the_threshold():
    x, y = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([0.0, 1.5, 2.0, 9.0, 9.0])
    # 0.5 is within: 0, 1.5, 2 around slope 1
    assert lines._least_squares(x, y, 1.0, 0.0, 0.5) == pytest.approx((1.0, 1.0 / 6.0))
    assert lines._least_squares(x, y, 1.0, 0.0, 0.4) == (1.0, 0.0)
    assert lines._least_squares(np.ones(5), y, 0.0, 1.0, 1.0) == (0.0, 1.0)
    first, last = lines._least_squares(x[:3], np.array([0.0, 0.9, 2.0]), 1.0, 0.0, 0.2)
    assert (first, last) == pytest.approx((1.0, -1.0 / 30.0))


def test_spikes_of_more_than_ten_deviations_are_bridged_before_labels():
    """One sample 12 deviations off must not end the backlash that it falls into; a whole newton is such a spike."""
    t = np.arange(600) / 100.0
    x = np.interp(t, [0.0, 3.0, 6.0], [5.0, 30.0, 5.0])
    y = np.interp(t, [0.0, 3.0, 4.5, 6.0], [3.0, 17.0, 17.0, 6.0])
    spiked = y.copy()
    spiked[370] -= 6.0
    assert np.array_equal(labels.label_phases(t, x, spiked), labels.label_phases(t, x, y))
    assert (labels.label_phases(t, x, y)[310:440] == 2).all()


def test_labels_bridge_what_is_no_number():
    t = np.arange(600) / 100.0
    x = np.interp(t, [0.0, 3.0, 6.0], [5.0, 30.0, 5.0])
    y = np.interp(t, [0.0, 3.0, 4.5, 6.0], [3.0, 17.0, 17.0, 6.0])
    holed = x.copy()
    holed[100:103] = np.nan
    assert np.array_equal(labels.label_phases(t, holed, y), labels.label_phases(t, x, y))
    assert labels.label_phases(t[:3], x[:3], y[:3]).tolist() == [0, 0, 0]


@pytest.mark.parametrize("seed", range(6))
def test_weighted_median_is_where_half_of_the_weight_lies(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 60))
    # ties, and weights of zero
    values, weight = np.round(rng.normal(0.0, 1.0, n), seed % 3), np.round(rng.random(n), 1) + (np.arange(n) == 0)
    order = np.argsort(values)
    expected = values[order][np.searchsorted(np.cumsum(weight[order]), 0.5 * np.sum(weight) - 1e-12)]
    assert lines._weighted_median(values.copy(), weight.copy()) == expected
    assert lines._weighted_median(values.copy(), np.ones(n)) == np.sort(values)[(n - 1) // 2]


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_median_is_numpys(n):
    values = np.round(np.random.default_rng(n).normal(0.0, 1.0, n), 1)
    assert filtering.median(values) == np.median(values)
    values[n // 2] = np.nan
    assert math.isnan(filtering.median(values))


@pytest.mark.parametrize("n", [1, 2, 3, 7, 100, 1001])
@pytest.mark.parametrize("part", [0.0, 0.005, 0.1, 0.5, 0.75, 0.98, 1.0])
def test_quantile_is_numpys(n, part):
    values = np.round(np.random.default_rng(n).normal(0.0, 1.0, n), n % 5)
    assert filtering.quantile(values, part) == np.quantile(values, part)
    values[n // 2] = np.nan
    assert math.isnan(filtering.quantile(values, part))
