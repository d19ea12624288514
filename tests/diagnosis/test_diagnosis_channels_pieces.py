"""Numbers of the channels beside the output, by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from rig_logs import sound

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import channels
from sstl_cli.diagnosis.channels import ChannelGap, log_gain, loop_gaps
from sstl_cli.diagnosis.constants import LOOP_SLEWS, MIN_SAMPLES, NO_LOOP, SAME_SLOPE, SLOWEST_LOOP
from sstl_cli.diagnosis.evidence import strengths_charge
from sstl_cli.physics.filters import first_order

T = np.arange(0.0, 30.0, 0.02)
REFERENCE = 10.0 + 5.0 * np.sin(2.0 * np.pi * T / 5.0)


def gap(base=4.0, left=1.0, noise=0.5, gain=900.0):
    return ChannelGap("tension_in", "N", "tension_loop_lag", {"tau_s": 0.1, "inverse_slew_s_per_n": 0.0}, base, left, noise, gain)


def run(reference, tension, n=len(T)):
    return Run("r", "act", T[:n], tension[:n], tension[:n], tension_ref_n=reference[:n])


def test_a_gap_as_a_row_of_the_verdict():
    row = gap().row()
    assert row.evidence == row.drop_one == pytest.approx(900.0 - strengths_charge(2, 1800.0)) and row.gain == 900.0
    assert (row.chi2, row.share, row.worst_z, row.mean_z, row.outside, row.unstable) == (4.0, 0.75, 0.0, 0.0, 0, 1.0)
    assert gap(gain=-9.0).row().evidence == pytest.approx(-9.0 - strengths_charge(2, 0.0))
    assert np.isfinite([gap(noise=0.0).row().chi2, gap(base=0.0, left=0.0).row().share]).all()


def test_independent_samples_are_counted_up_to_where_correlation_ends():
    rng = np.random.default_rng(1)
    x = np.convolve(rng.standard_normal(401), [1.0, 1.0], "valid")
    n, y = len(x), x - x.mean()
    rho = np.array([y[k:] @ y[: n - k] / (n - k) for k in range(n)])
    rho /= rho[0]
    total, k = 0.0, 0
    while rho[2 * k] + rho[2 * k + 1] > 0.0:
        total += rho[2 * k] + rho[2 * k + 1]
        k += 1
    assert channels._independent(x) == pytest.approx(n / (2.0 * total - 1.0)) and total > 1.2
    # what swings from sample to sample counts each of them, and no more
    assert channels._independent(np.tile([1.0, -1.0], 50)) == 100.0


def test_a_gain_is_the_logarithm_of_what_is_left():
    a, b = np.full(100, 2.0), np.full(100, 0.5)
    white = np.tile([1.0, -1.0], 50)
    assert log_gain(a, b, white) == pytest.approx(100.0 * np.log(4.0)) and channels._rms(np.array([3.0, -4.0])) == pytest.approx(
        np.sqrt(12.5)
    )


def test_origin_and_stiffness_are_free():
    x, columns = np.array([1.0, 2.0, 4.0, 9.0, 16.0]), [np.array([0.0, 1.0, 2.0, 3.0, 4.0])]
    assert channels._affine(3.0 + 7.0 * columns[0], columns) == pytest.approx(np.zeros(5), abs=1e-9)
    left = channels._affine(x, columns)
    assert (
        left @ np.ones(5) == pytest.approx(0.0, abs=1e-9) and left @ columns[0] == pytest.approx(0.0, abs=1e-9) and np.abs(left).max() > 1.0
    )


@pytest.mark.parametrize(
    ("slope", "tracks"),
    [(1.0 + 0.95 * SAME_SLOPE, True), (1.0 + 1.05 * SAME_SLOPE, False), (1.0 - 0.95 * SAME_SLOPE, True), (1.0 - 1.05 * SAME_SLOPE, False)],
)
def test_an_input_of_nearly_the_reference_s_slope_follows_it(slope, tracks):
    assert channels._tracks(run(REFERENCE, 3.0 + slope * REFERENCE)) is tracks


def test_a_reference_has_to_move_and_to_be_recorded():
    rng = np.random.default_rng(2)
    # half a newton is enough, a correlation of 0.9 is too
    for span, tracks in ((0.51, True), (0.49, False)):
        small = 10.0 + 0.5 * span * np.sin(2.0 * np.pi * T / 5.0)
        assert channels._tracks(run(small, small)) is tracks
    for noise, tracks in ((1.4, True), (2.2, False)):
        # a sine of 5 N has 3.54 N: a correlation of 0.93, of 0.85
        assert channels._tracks(run(REFERENCE, REFERENCE + noise * rng.standard_normal(len(T)))) is tracks
    holes = np.where(np.arange(len(T)) % 2, REFERENCE, np.nan)
    assert channels._tracks(run(holes, REFERENCE, 2 * MIN_SAMPLES)) and not channels._tracks(run(holes, REFERENCE, 2 * MIN_SAMPLES - 1))


def test_a_slew_limit_is_found_as_one_and_runs_are_fitted_together():
    noise = 0.01 * np.random.default_rng(3).standard_normal((2, len(T)))
    quick = np.interp(T % 10.0, [0.0, 4.0, 4.1, 9.0, 9.1, 10.0], [5.0, 5.0, 15.0, 15.0, 5.0, 5.0])
    records = [
        SimpleNamespace(raw=run(r, first_order(r, 0.02, 0.0, 0.05) + x), faults_in=sound(len(T), s))
        for r, x, s in ((REFERENCE, noise[0], 0.01), (quick, noise[1], 0.03))
    ]
    (found,) = loop_gaps(records)
    assert found.values == {"tau_s": pytest.approx(0.0, abs=0.01), "inverse_slew_s_per_n": pytest.approx(0.05, rel=0.05)}
    assert (found.channel, found.unit, found.effect, found.noise) == ("tension_in", "N", "tension_loop_lag", pytest.approx(0.02))
    lags = [r.raw.tension_in_n - r.raw.tension_ref_n for r in records]
    assert found.rmse_base == pytest.approx(np.sqrt(np.mean(np.concatenate(lags) ** 2))) and found.rmse_with == pytest.approx(0.01, rel=0.1)
    # a run that follows something else has no part in it
    other = SimpleNamespace(raw=run(REFERENCE, 30.0 - REFERENCE), faults_in=sound(len(T), 9.0))
    assert loop_gaps([*records, other]) == [found]


def piece(asked, dt_s=0.1):
    asked = np.asarray(asked, float)
    return channels._Piece(asked, asked.copy(), np.ones(len(asked), bool), dt_s)


def test_a_loop_is_looked_for_as_a_lag_as_a_limit_and_as_both():
    # asked for 40 N/s at most: slew limits from there to 5 N/s
    asked = piece([0.0, 4.0, 4.0, 2.0])
    slews = np.geomspace(1.0 / 40.0, SLOWEST_LOOP[1], LOOP_SLEWS)
    best = np.array([SLOWEST_LOOP[0] / 8.0, slews[7]])
    lag, limit, both = channels._starts(lambda p: (p - best) / best, [asked])
    assert lag == pytest.approx([best[0], NO_LOOP[1]]) and limit == pytest.approx([NO_LOOP[0], best[1]]) and both == pytest.approx(best)
    # the quickest of several pieces counts; one in which nothing is asked for has no rate
    quick = channels._starts(lambda p: p - [0.0, 1.0 / 80.0], [asked, piece([0.0, 8.0]), piece([1.0])])
    assert quick[1] == pytest.approx([NO_LOOP[0], 1.0 / 80.0])
    # lags halve from half of the slowest on
    tried = []
    channels._starts(lambda p: tried.append(tuple(p)) or p, [asked])
    assert sorted({t[0] for t in tried}) == pytest.approx([NO_LOOP[0], *(SLOWEST_LOOP[0] * 0.5**k for k in range(6, 0, -1))])
    # what is asked for so slowly that no limit shows is looked for as a lag alone
    slow = piece([0.0, 0.4, 0.8])
    assert [s[1] for s in channels._starts(lambda p: p, [slow])] == [NO_LOOP[1]]


def test_a_piece_begins_with_its_first_reading_and_ends_at_a_gap():
    n = 300
    gap = np.where((np.arange(n) > 100) & (np.arange(n) < 110), 1.0, 0.0)
    reference = REFERENCE[:n].copy()
    reference[[0, 1, 50]] = np.nan
    one = replace(run(reference, REFERENCE, n), extra={"gap": gap})
    first, second = channels._pieces(SimpleNamespace(raw=one, faults_in=sound(n, 0.01)))
    assert (len(first.given), len(second.given)) == (99, 190) and first.dt_s == pytest.approx(0.02)
    assert first.given[0] == REFERENCE[2] and np.array_equal(second.given, REFERENCE[110:n])
    # what nobody asked for is a straight line, and no reading
    assert np.flatnonzero(~first.known).tolist() == [48] and first.asked[48] == pytest.approx(0.5 * (REFERENCE[49] + REFERENCE[51]))
    # what is left of a loop that gives what it is asked for is nothing, and one that lags leaves its lag
    assert first.left(0.0, 0.0) == pytest.approx(np.zeros(98), abs=1e-12)
    late = first_order(first.asked, 0.02, 0.3, 0.0, float(first.given[0]))
    assert first.left(0.3, 0.0) == pytest.approx((first.given - late)[first.known])
    spoilt = SimpleNamespace(raw=one, faults_in=replace(sound(n, 0.01), spike=np.arange(n) < 110))
    assert [len(p.given) for p in channels._pieces(spoilt)] == [190]


def test_samples_in_which_a_model_differs_only_where_it_is_off_count_for_less():
    base = np.concatenate((np.full(50, 2.0), np.full(50, 0.5)))
    white = np.tile([1.0, -1.0], 50)
    # all that differs is where the best model leaves all that it does: half of the samples count
    left, best = np.where(np.arange(100) < 50, 1.0, 0.5), np.where(np.arange(100) < 50, white, 0.0)
    even = channels._independent(best) * 0.5
    ratio = np.sqrt(np.mean(base**2) / np.mean(left**2))
    assert log_gain(base, left, best) == pytest.approx(even * np.log(ratio))
    # where the two have nothing to do with one another all of them count, and no more than all
    apart = np.where(np.arange(100) < 50, 0.0, white)
    assert log_gain(base, left, apart) == pytest.approx(channels._independent(apart) * np.log(ratio))
    assert log_gain(base, base, white) == 0.0 and np.isfinite(log_gain(base, 0.0 * base, 0.0 * base))
