"""Readings of a slow sensor, starts behind a gap and corners, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import simulator

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import driven, records
from sstl_cli.diagnosis.clock import Corners
from sstl_cli.diagnosis.constants import MIN_SAMPLES
from sstl_cli.diagnosis.kalman import MEAN_NEW, TURN
from sstl_cli.diagnosis.latent import Latent, Slow, Told, latent
from sstl_cli.diagnosis.means import white_of
from sstl_cli.diagnosis.records import Passes, Start, passing, prepare, representatives, sampled_nats, starts_of, told

PROBLEM = simulator().problem
T = np.arange(0.0, 20.0, 0.02)


def run(name="r", n=1000, span=16.0, sd=0.01, **more):
    t = T[:n]
    noise = sd * np.random.default_rng(3).standard_normal((2, n))
    u = 12.0 + 0.5 * span * np.sin(2.0 * np.pi * t / 7.0)
    return Run(name, "act", t, u + noise[0], 0.6 * u + noise[1], **more)


def test_a_model_begins_anew_at_the_next_known_output_or_nowhere():
    out = Latent(np.arange(8.0), np.zeros(8), np.arange(8.0) ** 2, np.zeros((8, 26)), 0.0, np.zeros(8), np.zeros(4))
    ready = np.array([1, 0, 0, 0, 0, 1, 1, 0], bool)
    assert records._starts([(1, 2), (5, 6), (6, 7)], ready, out, np.ones(8, bool)) == [
        (2, Start(5, 5.0, 5.0)), (6, Start(6, 6.0, 6.0)), (7, Start(8, 7.0, 7.0)),
    ]  # fmt: skip
    r = replace(PROBLEM.records[0], again=(Start(7, 1.0, 2.0),))
    assert starts_of(r) == (Start(0, r.start_n, r.start_error_n), Start(7, 1.0, 2.0))


def test_what_is_open_of_a_corner_is_shown_from_there_on_and_held_whole():
    open_n = np.array([0.0, 0.0, 0.4, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    blur, shown = driven.at_corners(open_n, 4)
    assert blur.tolist() == [0.4, 0.2, 0.0] and shown.tolist() == [0.5, 1.0, 1.0]
    r = PROBLEM.records[0]
    law = np.zeros_like(r.error_law)
    law[10, TURN], law[10, MEAN_NEW] = 0.1, 0.1
    beyond = np.zeros(len(r.u))
    beyond[10 * r.factor + r.factor // 2] = 0.3
    share = 1.0 - (r.factor // 2) / r.factor
    corner = Corners(np.zeros(len(r.u)), beyond, np.zeros(len(r.u)))
    (moved,) = passing(replace(PROBLEM, records=(replace(r, corner=corner, error_law=law),)), Passes(0.0, 0.0)).records
    less = (law - moved.error_law)[10]
    assert less[MEAN_NEW] == pytest.approx(share**2 * 0.03) and less[TURN] == pytest.approx((1.0 - share**2) * 0.03, abs=1e-15)


def test_what_is_known_of_a_corner_is_taken_off_where_it_was_put():
    """A larger doubt elsewhere in the step had its own place: what was taken off left a variance below 0, and a verdict of nan."""
    beyond, doubt = np.zeros((2, 12))
    beyond[2], doubt[1], doubt[5] = 0.4, 0.6, 0.3
    blur, shown = driven.at_corners(np.hypot(beyond / np.sqrt(3.0), doubt), 4, beyond)
    less, place = driven.at_corners(beyond, 4)
    assert shown.tolist() == [0.5, 0.75, 1.0] and place[0] == shown[0]
    assert np.all((1.0 - shown**2) * blur**2 - (1.0 - place**2) * less**2 / 3.0 >= 0.0)
    # in any order
    assert driven.at_corners(beyond + doubt, 4)[1].tolist() == [0.75, 0.75, 1.0]


def test_an_input_that_passes_its_samples_goes_on_to_its_corners():
    r = PROBLEM.records[0]
    assert r.corner is None
    back, beyond, short = np.zeros((3, len(r.u)))
    back[100], beyond[100], short[100], beyond[200], short[200] = -0.1, -0.6, 2.0, 0.6, 8.0
    law = r.error_law.copy()
    law[[100, 200], MEAN_NEW] += 0.36 / 3.0
    blurred = replace(r, corner=Corners(back, beyond, short), error_law=law, error_n=np.full(len(r), 0.4))
    moved, other = passing(replace(PROBLEM, records=(blurred, r)), Passes(0.1, 0.01)).records
    assert np.array_equal(other.u, r.u) and other.passes == moved.passes
    # behind a lag of 0.1 s the extreme stays 0.2 N before the corner; one that stays 0.8 N before it is where it was sampled
    assert moved.u[100] == pytest.approx(r.u[100] - 0.1 - 0.4) and moved.u[200] == r.u[200]
    assert np.array_equal(np.delete(moved.u, 100), np.delete(r.u, 100))
    # a third of the square is open beforehand
    less = law - moved.error_law
    assert less[100, MEAN_NEW] == pytest.approx((1.0 / 3.0 - 0.01) * 0.36) and np.count_nonzero(less) == 2
    assert moved.error_n[100] == pytest.approx(np.sqrt(0.16 - (1.0 / 3.0 - 0.01) * 0.36)) and moved.error_n[99] == 0.4
    none = passing(replace(PROBLEM, records=(replace(blurred, error_n=np.zeros(len(r))),)), Passes(0.1, 0.01))
    assert none.records[0].error_n[100] == 0.0


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (run(n=MIN_SAMPLES - 1), f"fewer than {MIN_SAMPLES} samples"),
        (replace(run(), time_s=np.where(np.arange(1000) == 500, T[499], T)), "time is not strictly increasing"),
        (run(span=0.19, sd=0.001), "the input hardly moves: by 0.19"),
        # twenty times its noise
        (run(span=1.0, sd=0.2), "the input hardly moves: by"),
    ],
)
def test_a_run_that_cannot_be_used_is_set_aside_with_its_reason(bad, reason):
    found = prepare([run("good"), replace(bad, run_id="bad")])
    assert list(found.set_aside) == ["bad"] and found.set_aside["bad"].startswith(reason) and [r.run_id for r in found.records] == ["good"]
    with pytest.raises(SstlError, match=reason):
        prepare([bad])


def test_an_output_of_two_values_has_no_slope():
    def levels(name, *edges, system="act", extra=0.0):
        read = np.digitize(run().tension_out_n, edges).astype(float)
        read[500] += extra
        return replace(run(name), system=system, tension_out_n=read)

    good = replace(run("good"), system="sstl")
    said = "the output takes two values"
    with pytest.raises(SstlError, match=said):
        prepare([levels("a", 6.0), levels("b", 8.0)])
    # a stray sample is no third level; a sound sensor beside it is used
    for logs in ([levels("a", 6.0), good], [levels("a", 6.0, extra=5.0), good]):
        found = prepare(logs)
        assert list(found.set_aside) == ["a"] and found.set_aside["a"].startswith(said) and found.systems == ("sstl",)
    # what shows a third level in any run is a coarse converter; a flag of another system says nothing of this sensor
    assert not prepare([levels("a", 6.0), levels("b", 5.0, 8.0)]).set_aside
    assert list(prepare([levels("a", 6.0), levels("b", 5.0, 8.0, system="sstl")]).set_aside) == ["a"]
    # one level is a hold
    assert not prepare([levels("a", 1e9)]).set_aside


def test_the_least_that_can_be_used_is_used():
    assert len(prepare([run(n=MIN_SAMPLES, span=40.0)]).records) == 1
    assert len(prepare([run(span=0.22, sd=0.001)]).records) == 1


def test_runs_without_a_configuration_share_no_theta_and_records_are_in_the_order_of_their_names():
    found = prepare([run("c", config_id="z"), run("b"), run("a", config_id="z"), run("d")])
    assert [r.run_id for r in found.records] == ["a", "b", "c", "d"] and found.configs == ("(run b)", "(run d)", "z")
    assert [r.config for r in found.records] == [2, 0, 2, 1] and found.systems == ("act",) and found.samples == 4000
    assert found.analysis_hz == pytest.approx(50.0) and found.unit_n == 1.0 and prepare([run()], 3.0).unit_n == 3.0


def test_spoilt_samples_have_no_weight_and_bridges_between_their_neighbours():
    spoilt = run()
    spoilt.tension_out_n[[300, 301]] += 40.0
    (r,) = prepare([spoilt]).records
    assert np.flatnonzero(r.weight == 0.0).tolist() == [300, 301] and r.y[300] < spoilt.tension_out_n[299] + 1.0
    assert r.y[300] == pytest.approx(spoilt.tension_out_n[299] + (spoilt.tension_out_n[302] - spoilt.tension_out_n[299]) / 3.0)
    assert np.array_equal(r.raw_weight, r.weight) and np.array_equal(r.weight_fine, r.weight)
    assert r.time_s == pytest.approx(T + 0.01) and r.factor == r.thin == r.averaged("tension_out_n") == 1


def test_a_fast_log_is_thinned_to_the_simulation_and_averaged_to_the_analysis():
    t = np.arange(0.0, 4.0, 0.0005)
    (r,) = prepare([Run("r", "act", t, 12.0 + 8.0 * np.sin(t * 3.0), 6.0 + 4.0 * np.sin(t * 3.0))]).records
    # 2000 Hz: two samples a step of 1000 Hz, twenty steps to 50 Hz
    assert (r.thin, r.factor, len(r), len(r.u)) == (2, 20, 200, 4000) and r.dt_s == pytest.approx(0.001)
    assert r.averaged("tension_in_n") == 2 and r.share == pytest.approx(np.full(4000, 0.05)) and r.readings.tolist() == [20.0] * 200
    assert r.time_s[:2] == pytest.approx([0.01, 0.03]) and r.y[0] == pytest.approx(np.mean(6.0 + 4.0 * np.sin(t[:40] * 3.0)))


def test_an_input_whose_sensor_has_slow_noise_is_known_less_well_and_only_that_of_its_system():
    slow = Slow(0.05, 0.2)
    heard = told(replace(PROBLEM, records=PROBLEM.records[:1]), {"act": slow}).records[0]
    assert (heard.told_n, heard.told_s) == (0.05, 0.2) and np.median(heard.error_n) > 3.0 * np.median(PROBLEM.records[0].error_n)
    assert told(PROBLEM, {"sstl": slow}).records == PROBLEM.records


def test_readings_at_a_distance_are_as_likely_as_those_of_a_latent_input_of_their_own():
    slow, r = Slow(0.05, 0.2), PROBLEM.records[0]
    signal, known = r.raw.tension_in_n, np.ones(len(r.raw), bool)
    white = white_of(signal, known, r.faults_in.rounding_n, r.raw.dt_s, slow)
    # every second reading, no more than three hundred of them, and every tenth
    for every, count in ((2, 300), (10, 200)):
        part = latent(signal[::every][:300], every * r.raw.dt_s, white, told=Told(slow))
        assert len(part.value) == count and sampled_nats(r, every, 300, slow) == part.nats != 0.0


def test_of_each_movement_one_configuration_stands_for_the_others_in_turn():
    # shorter runs first, and by their means where they are as long
    made = [run(f"{c}{m}", 600 + 20 * i, config_id=c, trajectory=m) for i, (m, c) in enumerate((m, c) for m in "mn" for c in "abc")]
    small = representatives(prepare(made))
    assert [r.run_id for r in small.records] == ["am", "bn"] and small.configs == ("a", "b") and [r.config for r in small.records] == [0, 1]
    lone = representatives(prepare([run("x", config_id="z"), run("y", config_id="a", trajectory="m")]))
    assert len(lone.records) == 2 and lone.configs == ("a", "z") and lone.set_aside == {}


def test_what_was_made_ready_is_taken_again_beside_other_runs():
    # on a grid that readings do not repeat, so that no limit is found
    first = prepare([run("a"), run("b", n=900)])
    made = {r.run_id: r for r in first.records}
    alone = prepare([run("b", n=900)], made=made).records[0]
    assert alone.u is made["b"].u and alone.config == 0 != made["b"].config
    assert np.array_equal(alone.y, prepare([run("b", n=900)]).records[0].y)
    # a limit that the sensor has beside these runs is another look at it
    limited = replace(made["b"], faults_out=replace(made["b"].faults_out, clip_level_n=3.0))
    assert prepare([run("b", n=900)], made={"b": limited}).records[0].u is not made["b"].u


def test_an_input_behind_a_drive_is_smoothed_once_and_one_beside_slow_noise_each_time(monkeypatch):
    asked = []
    real = records.input_of
    monkeypatch.setattr(records, "input_of", lambda *a: asked.append(a[-1]) or real(*a))
    problem = prepare([run()])
    asked.clear()
    one, two = records.rounded(problem, 2.0), records.rounded(problem, 2.0)
    assert one.records[0].u is two.records[0].u and [t.rounded for t in asked] == [2.0]
    records.rounded(problem, 4.0)
    told(one, {"act": Slow(0.01, 0.5)})
    told(one, {"act": Slow(0.01, 0.5)})
    assert len(asked) == 4


def test_a_record_by_itself_is_as_loud_as_its_system_and_nothing_is_known_of_it():
    (r,) = prepare([run()]).records
    assert (r.louder, r.slower, r.jitter_s, r.begun_s, r.gone_n, r.told_n, r.rounded) == (1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert (r.known, r.misfit_n, r.slip, r.wander, r.passes, r.again) == (None, None, None, None, None, ())
    # what is not known to have a tail is normal
    assert r.tail == float("inf") and not replace(PROBLEM, records=(r,)).scatters
    known = replace(r, misfit_n=np.ones(len(r)))
    assert replace(PROBLEM, records=(r, known)).scatters


def test_a_recording_in_another_unit_of_time_is_averaged_to_the_nearest_rates():
    # 120 Hz: a step of the simulation is one sample, two of them to 60 Hz; at 30 Hz each sample is one of the analysis
    for hz, factor in ((120.0, 2), (30.0, 1), (74.0, 1), (76.0, 2)):
        t = np.arange(600) / hz
        (r,) = prepare([Run("r", "act", t, 12.0 + 8.0 * np.sin(t * 3.0), 6.0 + 4.0 * np.sin(t * 3.0))]).records
        assert (r.thin, r.factor, len(r)) == (1, factor, 600 // factor) and r.dt_s == pytest.approx(1.0 / hz)


def test_runs_of_one_session_know_how_long_and_how_far_their_tendon_has_gone():
    first, second = run("a", 500), run("b", 600)
    later = replace(second, time_s=second.time_s + 30.0)
    one, two = prepare([first, later]).records
    assert (one.begun_s, one.gone_n) == (0.0, 0.0) and two.begun_s == pytest.approx(30.0)
    assert two.gone_n == pytest.approx(float(np.abs(np.diff(one.u)).sum()))
    # clocks that overlap are not one
    assert [r.begun_s for r in prepare([first, replace(second, time_s=second.time_s + 9.0)]).records] == [0.0, 0.0]
