"""What chosen numbers do, at the sizes that the comments above them state: each from either side, in the function that uses it."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, log10, pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from made_sims import sim as windows

from sstl_cli.control.plant import Plant
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import (
    channels,
    clock,
    constants,
    downstream,
    following,
    holds,
    movements,
    noise,
    readings,
    reasons,
    recorder,
    records,
    shrink,
    stages,
    starts,
    state,
    tails,
    where,
    white,
)
from sstl_cli.diagnosis import sentence as said_of
from sstl_cli.diagnosis.faults import squared_errors
from sstl_cli.diagnosis.features import OUTPUT, CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.free import LINE, LOOP, RUNS
from sstl_cli.diagnosis.heldout import blocks, make_folds
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.propagation import propagates
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.residuals import Leftover, Misfit, _names, _spectrum
from sstl_cli.diagnosis.rounding import _without, with_rounding
from sstl_cli.diagnosis.scaling import unit_of
from sstl_cli.diagnosis.whitening import Sensor
from sstl_cli.physics.scenario import Scenario, Trajectory

NONE = np.zeros(100, bool)


class Output(SimpleNamespace):
    """A record of which the output is read alone."""

    def __len__(self):
        return len(self.y)


def pulled(tension, output=None, ref=None, dt=0.01, **more):
    u = np.asarray(tension, float)
    y = 0.5 * u if output is None else np.asarray(output, float)
    return Run("r", "act", dt * np.arange(len(u)), u, y, tension_ref_n=ref, **more)


@pytest.mark.parametrize(("top", "unit"), [(3.0, 1.0), (2.9, 0.14), (60.0, 1.0), (70.0, 3.5), (1000.0, 50.0), (0.0, 1.0)])
def test_tensions_of_three_to_sixty_newtons_are_fitted_as_they_are_and_others_at_twenty(top, unit):
    assert unit_of([pulled(np.full(1000, top))]) == unit
    # but for a hundredth of spikes
    u = np.full(1000, 30.0)
    u[:9] = 2000.0
    assert unit_of([pulled(u)]) == 1.0
    u[:12] = 2000.0
    assert unit_of([pulled(u)]) > 1.0


@pytest.mark.parametrize(("step", "count", "moves"), [(7.95, 40, True), (7.8, 40, False), (9.0, 21, True), (9.0, 20, False)])
def test_an_output_leaves_its_hold_by_eight_usual_steps_in_means_of_nine_samples(step, count, moves):
    # up and down by 1: means of nine differ by a ninth beside the step between both halves
    y = np.where(np.arange(count) < count // 2, 0.0, step) + np.where(np.arange(count) % 2, 0.5, -0.5)
    assert propagates(SimpleNamespace(records=(Output(y=y),))) is moves


@pytest.mark.parametrize(("height", "seen"), [(8.1, True), (7.9, False)])
def test_a_spike_stands_eight_deviations_off(height, seen):
    y = np.zeros(40)
    y[20] = height
    assert recorder._spikes(y, 1.0, y > 1e9).any() == seen


@pytest.mark.parametrize(("depth", "seen"), [(1.35, True), (1.25, False)])
def test_a_drop_is_one_and_a_half_times_further_than_what_moves_beside_it(depth, seen):
    # eight deviations of 0.1 N, 0.2 N beside one and a half times, and as much less deep from there
    y = np.full(200, 5.0) + 0.001 * np.sin(np.arange(200.0) * 7.0)
    y[99] -= 0.2
    y[100:104] = 5.0 - depth
    assert recorder._dropped(y, 0.1).any() == seen


def test_a_thousandth_of_chance_makes_a_frozen_run():
    # a level is repeated once in ten: five in a row come 12e-4 times in 12 samples, six 1.2e-4 times
    sensor = 1.0 / (2.0 * sqrt(pi) * 0.1)
    noise_n = sqrt(sensor**2 + 1.0 / 12.0)
    for length, seen in ((5, False), (6, True)):
        y = np.arange(12.0)
        y[3 : 3 + length] = 3.0
        assert recorder._frozen(y, noise_n, 1.0).any() == seen


@pytest.mark.parametrize(("share", "limit"), [(0.89, True), (0.91, False)])
def test_nine_tenths_of_a_run_are_not_all_at_a_limit(share, limit):
    count = int(300 * share)
    y = np.concatenate((np.linspace(0.0, 8.0, 300 - count), np.full(count, 9.0)))
    assert recorder._clipped(y, 0.02, 0.0)[0].any() == limit


@pytest.mark.parametrize(("off", "counted"), [(0.61, True), (0.59, False)])
def test_a_clipped_input_went_beyond_by_six_deviations(off, counted):
    faults = Faults(NONE, NONE, ~NONE, 8.0, 0.0, 0.1)
    r = SimpleNamespace(raw=pulled(np.full(100, 8.0)), u=np.full(100, 8.0 + off), faults_in=faults, faults_out=faults)
    assert squared_errors(r, np.full(100, 4.0))[2].any() == counted


@pytest.mark.parametrize(
    ("noise_n", "step_n", "repeated", "copies"),
    [(1.0, 0.0, 0.11, True), (1.0, 0.0, 0.09, False), (1.0, 0.5, 0.44, True), (1.0, 0.5, 0.41, False), (1.2e-5, 0.0, 0.5, True), (0.9e-5, 0.0, 0.5, False)],
)  # fmt: skip
def test_repeated_samples_are_copies_beyond_a_tenth_and_three_times_chance(noise_n, step_n, repeated, copies):
    # a step of half the noise repeats 0.5 / (2 sqrt(pi)) = 0.141 of the readings by chance
    assert readings._copies(SimpleNamespace(held=False, noise_n=noise_n, step_n=step_n), repeated) is copies


@pytest.mark.parametrize(("renewals", "equal"), [(2, 1), (3, 2), (4, 0)])
def test_two_equal_renewals_are_chance_and_three_are_a_sensor_that_stands_still(renewals, equal):
    fresh = np.zeros(1200, bool)
    fresh[::10] = True
    # renewals in a row that would have changed nothing
    fresh[600 : 600 + 10 * (renewals - 1) : 10] = False
    found = readings._alike(fresh, np.arange(1200.0), 10.0)
    assert found.sum() == equal


@pytest.mark.parametrize(
    ("moved", "noise_n", "hidden"),
    # eleven steps of 1 N are due over a gap of ten samples: off by a quarter of the way and three deviations
    [(14.5, 0.0, False), (14.8, 0.0, True), (18.0, 1.0, False), (19.33, 1.0, True), (9.0, 0.0, False), (8.7, 0.0, True)],
)
def test_an_input_goes_on_over_a_gap_within_a_quarter_of_the_way(moved, noise_n, hidden):
    gap = (np.arange(60) >= 20) & (np.arange(60) < 30)
    u = np.concatenate((np.arange(20.0), np.full(10, np.nan), 19.0 + moved + np.arange(30.0)))
    assert bool(clock.hiding(gap, u, np.ones(60), noise_n)) is hidden


@pytest.mark.parametrize(("off", "even"), [(0.009, True), (0.012, False)])
def test_steps_that_differ_by_less_than_a_hundredth_are_the_same(off, even):
    time = np.arange(50.0)
    time[20:] += off
    assert clock._even(time, 1.0) is even


@pytest.mark.parametrize(("span", "noise_n", "used"), [(0.21, 0.0, True), (0.19, 0.0, False), (2.0, 0.1, True), (1.0, 0.1, False)])
def test_an_input_moves_by_a_fifth_of_a_newton_and_twenty_times_its_noise(span, noise_n, used):
    rng = np.random.default_rng(0)
    u = 5.0 + span * np.linspace(0.0, 1.0, 400) + noise_n * rng.standard_normal(400)
    reason, checked = records._usable(pulled(u, 3.0 + span * np.linspace(0.0, 1.0, 400)))
    assert (checked is not None) is used and ("hardly moves" in reason) is not used


@pytest.mark.parametrize(("extra", "worse"), [(2.1, ["act PB"]), (1.9, [])])
def test_a_region_is_worse_by_a_fiftieth_of_the_whole(extra, worse):
    one = SimpleNamespace(
        problem=SimpleNamespace(systems=("act",), records=(SimpleNamespace(system="act"),)), run=np.zeros(100, int), weight=np.ones(100)
    )
    code = np.where(np.arange(100) == 0, 0, 1)
    other = np.where(code == 0, sqrt(1.0 + extra), 1.0)
    assert shrink.worse_regions(one, np.ones(100), other, code) == worse


@pytest.mark.parametrize(
    ("slope", "scatter", "swing", "tracks"),
    [(1.19, 0.0, 2.0, True), (1.21, 0.0, 2.0, False), (0.81, 0.0, 2.0, True), (0.79, 0.0, 2.0, False), (1.0, 0.45, 2.0, True), (1.0, 0.52, 2.0, False), (1.0, 0.0, 0.51, True), (1.0, 0.0, 0.49, False)],
)  # fmt: skip
def test_an_input_follows_its_reference_to_a_fifth_and_a_correlation_of_nine_tenths(slope, scatter, swing, tracks):
    t = np.arange(2000) / 100.0
    ref = swing * (0.5 + 0.5 * np.sin(2.0 * pi * t))
    # what is beside it has another frequency: a correlation of 1 / sqrt(1 + scatter^2), 0.912 and 0.887
    u = slope * ref + scatter * swing * 0.5 * np.sin(2.0 * pi * 3.0 * t)
    assert channels._tracks(pulled(u, ref=ref)) is tracks


def test_what_is_promised_and_listed_has_an_end():
    assert said_of._sure(0.9999) == " (right in 99 of 100 such cases)" and said_of._sure(None) == ""
    assert said_of._listed(list("abcdef")) == "a, b, c, d and 2 more" and said_of._listed(list("abcd")) == "a, b, c, d"
    places = [SimpleNamespace(system="act", phase=p, share_pct=v) for p, v in (("PP", 40.0), ("PB", 30.0), ("RP", 20.0), ("RB", 10.0))]
    assert said_of._places(places) == "  it lies in   act PP 40 %   act PB 30 %   act RP 20 %   elsewhere 10 %"
    tests = tuple(Misfit(f"mean by {i}", 9.0 - i, 1.0, "") for i in range(9))
    left = Leftover(100, 1.0, 0.0, 0.0, 0.0, tests)
    assert [t.z for t in left.told()] == [9.0, 8.0, 7.0, 6.0] and [t.z for t in replace(left, tests=tests[5:]).told()] == [4.0, 3.0]


@pytest.mark.parametrize(("z", "told"), [(99.6, "100 sigma"), (101.0, "far beyond 100 sigma")])
def test_beyond_a_hundred_deviations_their_number_says_nothing_more(z, told):
    lead = CandidateRow(("viscous",), OUTPUT, 1, 90.0, 80.0, 80.0, 1.5, z, 1.0, 0, 1.0, 0.7)
    left = Leftover(5000, 1.5, 0.0, 0.0, 0.0, (Misfit("mean by run", z, 3.0, "run a"),))
    log_row = LogRow(5000, 1, 2, 3.0, 9.0, 9.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 1.0, 1.0)
    assert told in reasons.left(Rows(log_row, (lead,), left, left), ("viscous",))


def test_tables_and_tests_have_the_bands_that_they_state():
    one = windows((np.linspace(0.0, 1.0, 200), {}))
    found = where.bands(one, np.ones(200))
    assert [b.low for b in found["time_since_reversal_s"]] == [0.0, 0.2, 0.5, 1.0, 2.0, 5.0]
    assert [b.low for b in found["frequency_hz"]] == [0.0, 0.05, 0.2, 1.0, 5.0]
    one.dispersion = {}
    names = [n.split(", ")[1] for n in _names(one)["phase and time since reversal"][:5]]
    assert names == [f"{x} s after a reversal" for x in ("0-0.1", "0.1-0.3", "0.3-1", "1-3", "3-inf")]
    for hz, band in ((0.05, "0-0.1"), (0.2, "0.1-0.5"), (0.6, "0.5-2"), (2.5, "2-8")):
        tone = windows((np.zeros(800), {"dt_s": 0.05}))
        tone.dispersion = {}
        z = 9.0 * np.sin(2.0 * pi * hz * 0.05 * np.arange(800))
        assert _spectrum(tone, z, np.ones(800, bool), False).peak == f"{band} Hz"


def test_a_hold_moves_by_less_than_a_thousandth_of_the_fast_steps():
    # 5 % of the steps are faster than the percentile that says how fast fast ones are
    u = np.cumsum(np.concatenate((np.full(50, 1.0), np.full(50, -0.0012), np.full(50, -0.0008))))
    code = where.phases(windows((u, {})), np.arange(150.0))
    assert (code[:49] == 1).all() and (code[52:98] == 3).all() and (code[102:] == 3).all()
    still = np.concatenate((np.full(50, 1.0), np.full(100, -0.0008)))
    assert (where.phases(windows((np.cumsum(still), {})), np.arange(150.0)) == 1).all()
    for slope, held in ((0.9e-6, True), (1.1e-6, False)):
        assert bool((where.phases(windows((np.arange(50.0), {})), slope * np.arange(50.0)) == 1).all()) is not held


def test_movements_that_are_proposed_last_as_long_as_they_say():
    assert [(t.label, t.kind, t.duration_s, t.hold_s if t.kind == "ramp_hold" else None) for t in constants.MENU] == [
        ("fast trapezoid", "trapezoid", 8.0, None), ("slow trapezoid", "trapezoid", 80.0, None), ("ramps with holds", "ramp_hold", 60.0, 4.0),
        ("minor loops", "minor_loops", 40.0, None), ("chirp", "chirp", 60.0, None), ("random", "random", 120.0, None),
    ]  # fmt: skip


@pytest.mark.parametrize(("last_s", "fits"), [(1150.0, True), (1250.0, False)])
def test_a_movement_is_slowed_by_a_little_more_than_asked_and_to_twenty_minutes_at_most(last_s, fits):
    path = Trajectory(kind="trapezoid", label="t", duration_s=80.0, low_n=5.0, high_n=15.0, drive="tension")
    fastest = following._slowed(path, "act", 0.1, 1e9)
    usual = float(np.abs(np.diff(fastest.tension_n)).max()) / 0.1
    slow = following._slowed(path, "act", 0.1, usual * 80.0 / last_s)
    assert (slow is not None) is (last_s / 0.98 < 1200.0) is fits
    if slow is not None:
        assert slow.trajectory.duration_s / slow.trajectory.speed == pytest.approx(last_s / 0.98, rel=1e-3)


def test_a_scenario_takes_a_thousand_newtons_at_most():
    problem = SimpleNamespace(unit_n=50.0, records=(SimpleNamespace(system="act", u=np.array([3.0, 40.0])),), systems=("act",))
    assert movements._range_n(problem, "act") == (150.0, 1000.0)
    assert movements._range_n(SimpleNamespace(**{**vars(problem), "unit_n": 1.23456}), "act") == (3.7, 49.4)
    flat = SimpleNamespace(unit_n=50.0, records=(SimpleNamespace(system="act", u=np.array([39.0, 40.0])),), systems=("act",))
    assert movements._range_n(flat, "act") == (500.0, 1000.0)
    Trajectory(kind="sinusoid", low_n=500.0, high_n=1000.0)
    for end in ("low_n", "high_n"):
        with pytest.raises(ValueError, match="less than or equal to 1000"):
            Trajectory(kind="sinusoid", **{end: 1000.1})


def test_the_task_of_the_controller_is_a_full_stroke_in_a_hundred_seconds():
    stroke = downstream._stroke()
    assert len(stroke) == 20_000 and stroke.min() == 1.0 and stroke.max() == pytest.approx(35.0) and stroke[5000] == pytest.approx(35.0)
    assert stroke[2500] == pytest.approx(18.0)


@pytest.mark.parametrize(("slope", "line"), [(0.025, True), (0.015, False)])
def test_a_line_is_steeper_than_a_fiftieth(slope, line):
    plant = Plant(lambda t_in, dt: slope * t_in)
    if line:
        assert downstream.lines_of(plant).gamma_p == pytest.approx(slope)
        return
    with pytest.raises(SstlError, match="E920"):
        downstream.lines_of(plant)


def test_sliding_is_what_has_most_of_the_steepest_slope():
    t_in = downstream._stroke()
    rising = np.gradient(t_in) > 0.0
    # a pull that answers by 0.8 of its slope up to 20 N is rounding into its line; one that answers by 0.9 is on it
    for share, gamma in ((0.8, 1.0), (0.9, None)):
        out = np.where(rising, np.where(t_in < 20.0, 20.0 - share * (20.0 - t_in), t_in), 2.0 * t_in)
        found = downstream._lines(t_in, out).gamma_p
        assert (abs(found - 1.0) < 1e-3) if gamma else (0.9 < found < 0.99)


def test_lags_of_a_loop_are_looked_for_up_to_two_seconds():
    dt = 0.01
    command = np.where(np.arange(600) < 100, 0.0, 1.0)
    # of a grid of a tenth of a second, refined twice: a slower one ends a step beyond, and a tenth of one
    for tau, found in ((0.5, 0.5), (9.0, 2.11)):
        late = 1.0 - np.exp(-np.maximum(np.arange(600) - 99, 0) * dt / tau)
        assert stages._loop_lag(SimpleNamespace(command_n=command, input_n=late), dt) == pytest.approx(found, abs=0.004)


def test_what_stands_beside_the_catalogue_is_looked_for_where_rigs_are():
    load = LINE.parameters[0]
    assert load.neutral == 1.0 / Scenario().rig.load_n_per_mm == 0.125 and load.low == 0.02 and load.high == 1.0
    assert RUNS.parameters[0].high == 0.3 and [p.high for p in RUNS.parameters[1:]] == [1.0, 1.0]
    assert (LOOP.parameters[0].low, LOOP.parameters[0].high) == (-0.2, 0.2)
    assert (LOOP.parameters[0].least, LOOP.parameters[0].most) == (-0.9, 9.0)


def test_starts_are_weak_and_strong_factors_far_and_near():
    gain = next(h for h in variants("gain_error", ("act",)) if [f.parameter.name for f in h.free] == ["g_act"])
    assert sorted(float(v[0]) for v in starts.grid(gain.free)) == pytest.approx([0.3, 1.0, 3.0])
    friction = variants("const_friction", ("act",))[0]
    reach = friction.free[0].parameter.high - friction.free[0].parameter.neutral
    assert [float(v[0]) for v in starts.grid(friction.free)] == pytest.approx([0.08 * reach])
    creep = full("viscoelastic_creep", ("act",))
    at = [i for i, f in enumerate(creep.free) if f.parameter.shape and f.parameter.start is None and f.effect is not LINE]
    for i in at:
        p = creep.free[i].parameter
        grid = [p.low * (p.high / p.low) ** g if p.high / p.low > 20.0 else p.low + g * (p.high - p.low) for g in (0.15, 0.5, 0.85)]
        assert sorted({float(v[i]) for v in starts.grid(creep.free)}) == pytest.approx(grid)
    assert at
    slip = next(h for h in variants("presliding", ("act",)) if h.free[0].parameter.name == "breakaway_mm")
    own = slip.free[0].parameter
    assert sorted({float(v[0]) for v in starts.grid(slip.free)}) == pytest.approx(
        [k * (own.high - own.neutral) + own.neutral for k in (0.01, 0.08)]
    )


def test_noise_that_could_not_be_seen_is_a_tenth_and_the_least_a_search_begins_from_a_fiftieth():
    assert _without(1.0, 1.0) == pytest.approx(0.1) and _without(5.0, 3.0) == pytest.approx(4.0)
    centre, spread = noise._prior(Sensor(0.3, 0.0, 0.1), Sensor(0.2, 0.0, 0.1), (0.05, 0.3))
    assert np.exp(centre) == pytest.approx([0.2, 0.004, 0.004, 1.0]) and spread.tolist() == [0.05, 0.3, 0.35, 0.2]
    assert np.exp(noise._prior(Sensor(0.3, 0.01, 0.1), Sensor(0.2, 0.03, 0.1), (0.05, 0.3))[0]) == pytest.approx([0.2, 0.03, 0.01, 1.0])
    record = SimpleNamespace(faults_out=Faults(NONE, NONE, NONE, np.inf, 0.0, 0.0), raw=pulled(np.zeros(2), [0.0, 8.0]))
    assert white.least_white(record, "tension_out_n") == pytest.approx(8e-4)


def test_where_too_few_holds_tell_slow_noise_is_a_quarter_of_the_white_one():
    found, own = holds.held_noise(
        [SimpleNamespace(dt_s=0.02, factor=1, weight=np.ones(50), y=np.zeros(50), louder=1.0, slower=1.0)], [np.ones(50)], 0.4, np.ones(1)
    )
    assert (found.coloured_n, found.correlation_s, found.spread, own) == pytest.approx((0.1, 0.1, 1.0, 0.4))
    coarse = Faults(NONE, NONE, NONE, np.inf, 0.3, 0.0)
    rested = with_rounding(Sensor(0.1, 0.0, 0.05), [coarse])
    assert rested.coloured_n == pytest.approx(0.3 / sqrt(12.0)) and rested.correlation_s == 0.4


@pytest.mark.parametrize(("back", "turned"), [(0.45, False), (0.55, True)])
def test_a_reversal_counts_from_a_twentieth_of_the_span_on(back, turned):
    u = np.concatenate((np.linspace(0.0, 10.0, 101), 10.0 - np.linspace(0.0, back, 20)))
    way, _ = state.turning(u)
    assert bool(way[-1] == -1.0) is turned


def test_places_of_a_map_are_alike_over_three_knots_of_the_input_and_two_of_the_other():
    one = state.alike(2, 2)
    assert one[0] == pytest.approx(
        [1.0, exp(-1.0 / 2.0), exp(-1.0 / 3.0), exp(-5.0 / 6.0), 0.5, 0.5 * exp(-0.5), 0.5 * exp(-1.0 / 3.0), 0.5 * exp(-5.0 / 6.0)]
    )
    assert one == pytest.approx(one.T)
    assert state.knots(np.linspace(0.0, 100.0, 101), 3) == pytest.approx([1.0, 50.0, 99.0])


@pytest.mark.parametrize(("tail", "variance"), [(2.0, 3.0), (3.0, 3.0), (4.0, 2.0), (np.inf, 1.0)])
def test_tails_heavier_than_of_three_degrees_count_as_those(tail, variance):
    assert tails.variance(tail) == pytest.approx(variance)


def test_seven_trajectories_share_six_folds_and_blocks_last_five_seconds():
    many = windows(*((np.zeros(4), {"trajectory": f"t{i}"}) for i in range(7)))
    assert make_folds(many).count == 6
    assert np.bincount(blocks(windows((np.zeros(120), {"dt_s": 0.1})))).tolist() == [50, 50, 20]


def test_sizes_of_a_map_and_variances_that_are_tried_span_what_there_may_be():
    assert constants.MAP_SIZES[0] == 0.0 and len(constants.MAP_SIZES) == 17
    # steps of half as much again, and of a quarter: nothing falls between two
    assert np.ptp(np.diff(np.log(constants.MAP_SIZES[1:]))) < 1e-9 and constants.MAP_SIZES[2] / constants.MAP_SIZES[1] < 1.5
    assert constants.MAP_SIZES[-1] == pytest.approx(10.0) and constants.MAP_SIZES[1] == pytest.approx(0.03)
    assert np.diff(np.log10(constants.VARIANCES)) == pytest.approx([0.1] * 70) and log10(constants.VARIANCES[0]) == pytest.approx(-1.0)
    assert np.diff(np.log(constants.CORRELATIONS_S)) == pytest.approx([log(2.0)] * 7) and constants.CORRELATIONS_S[0] == 0.05
    assert np.diff(np.log(constants.MIXTURE_WIDTHS)) == pytest.approx([0.5 * log(2.0)] * 13) and constants.MIXTURE_WIDTHS[0] == 1.0
    assert constants.LOUDER[0] == 1.0 and constants.LOUDER[-1] == pytest.approx(4.0) and len(constants.LOUDER) == 13
    assert constants.LEVELS[0] == pytest.approx(0.03) and constants.LEVELS[-1] == pytest.approx(4.0) and len(constants.LEVELS) == 15
    assert constants.NEAR == (1.0, 0.5, 2.0) and constants.WIDE == (1.0, 0.5, 2.0, 0.1, 10.0)


@pytest.mark.parametrize(("count", "looked"), [(15, False), (16, True)])
def test_a_signal_of_sixteen_readings_is_the_shortest_that_is_looked_at(count, looked):
    y = np.random.default_rng(0).standard_normal(count)
    assert (recorder.scan(y).noise_n > 0.0) is looked
