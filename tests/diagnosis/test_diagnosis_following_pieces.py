"""What a plan may ask of a rig: tensions and rates that were recorded, movements slowed down as far as that takes."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, made, simulator

from sstl_cli.diagnosis import following
from sstl_cli.diagnosis.constants import FASTEST_HZ, LONGEST_S, MENU, REPEATABLE
from sstl_cli.diagnosis.following import Experiment, Limits, planned, recorded_n, sampling_s, table, within
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.noise import of_readings
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Scenario, Trajectory
from sstl_cli.physics.trajectories import span_hz
from sstl_cli.steps.diagnose_document import promised

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
BY_NAME = {t.label: t for t in MENU}


def search(problem=SIM.problem):
    sim = replace(SIM, problem=problem)
    return Search(sim, NOISE, NOISE, made(), {}, {})


def log(*records, unit_n=1.0):
    """Return a search as far as a plan reads its records: (system, u, rate)."""
    made_records = [
        SimpleNamespace(system=s, u=np.asarray(u, float), rate=np.asarray(v, float), raw=SimpleNamespace(dt_s=0.02)) for s, u, v in records
    ]
    problem = SimpleNamespace(records=made_records, systems=tuple(sorted({s for s, _, _ in records})), unit_n=unit_n)
    return SimpleNamespace(sim=SimpleNamespace(problem=problem, mechanics=Mechanics()))


def steepest(m):
    return float(np.abs(np.diff(m.tension_n)).max() / 0.02)


def test_a_plan_stays_between_the_tensions_of_its_system_and_above_nothing():
    found = log(("act", [-2.0, 9.0], [1.0]), ("act", [3.0, 12.0], [1.0]), ("sstl", [5.0, 6.0], [1.0]))
    assert recorded_n(found.sim.problem, "act") == (0.0, 12.0) and recorded_n(found.sim.problem, "sstl") == (5.0, 6.0)


@pytest.mark.parametrize(("limits", "high"), [(Limits(), 20.0), (Limits(tension_n=15.0), 15.0), (Limits(tension_n=30.0), 30.0)])
def test_a_movement_goes_from_the_lowest_tension_to_the_limit(limits, high):
    rate = np.concatenate((np.full(999, 10.0), [500.0]))
    (m,) = within(log(("act", [2.0, 20.0], rate)), BY_NAME["slow trapezoid"], limits)
    assert (m.tension_n.min(), m.tension_n.max()) == (pytest.approx(2.0), pytest.approx(high)) and m.trajectory.systems == ("act",)
    # the largest rate but for the noisiest samples
    assert steepest(m) <= np.quantile(rate, REPEATABLE) == 10.0


def test_limits_are_in_the_unit_of_the_recording_and_a_system_without_room_is_left_out():
    found = log(("act", [2.0, 20.0], [10.0]), ("sstl", [16.0, 20.0], [10.0]), unit_n=2.0)
    movements = within(found, BY_NAME["fast trapezoid"], Limits(tension_n=30.0))
    # 30 of the recording are 15 of the records: between 16 and 20 there is nothing
    assert [m.system for m in movements] == ["act"] and movements[0].tension_n.max() == pytest.approx(15.0)
    # a rig that was recorded at rest moves at a rate that is stated, not at its own
    still = log(("act", [2.0, 20.0], [0.0]), unit_n=2.0)
    assert within(still, BY_NAME["fast trapezoid"], Limits()) == ()
    (moving,) = within(still, BY_NAME["fast trapezoid"], Limits(rate_n_per_s=8.0))
    assert 3.0 < steepest(moving) <= 4.0
    # from one level to the same there is no movement
    assert within(log(("act", [15.0, 20.0], [10.0])), BY_NAME["chirp"], Limits(tension_n=15.0)) == ()


def test_a_movement_is_slowed_to_just_below_what_is_allowed():
    own = BY_NAME["fast trapezoid"].model_copy(update={"low_n": 2.0, "high_n": 20.0, "systems": ("act",)})
    free = following._slowed(own, "act", 0.02, 1e9)
    assert free.trajectory is own
    slower = following._slowed(own, "act", 0.02, 0.5 * steepest(free))
    assert 0.9 * 0.5 * steepest(free) < steepest(slower) <= 0.5 * steepest(free)
    assert slower.time_s[-1] == pytest.approx(free.time_s[-1] * own.speed / slower.trajectory.speed, rel=0.01)
    # what would last too long is none
    longest = own.duration_s / LONGEST_S * steepest(free)
    assert following._slowed(own, "act", 0.02, 0.9 * longest) is None and following._slowed(own, "act", 0.02, 1.2 * longest) is not None


def test_a_chirp_keeps_its_slow_beginning_as_far_as_it_can():
    own = BY_NAME["chirp"].model_copy(update={"low_n": 2.0, "high_n": 20.0, "systems": ("act",)})
    free = following._slowed(own, "act", 0.02, 1e9)
    low, top = span_hz(own)
    for share in (0.6, 0.02):
        slow = following._slowed(own, "act", 0.02, share * steepest(free))
        begin, end = span_hz(slow.trajectory)
        assert steepest(slow) <= share * steepest(free) and end < top and begin == pytest.approx(min(low, begin)) and begin <= 0.51 * end
    # a movement of random frequencies is slower as a whole
    random = BY_NAME["random"].model_copy(update={"low_n": 2.0, "high_n": 20.0, "systems": ("act",)})
    at = following._slowed(random, "act", 0.02, 1e9)
    slow = following._slowed(random, "act", 0.02, 0.3 * steepest(at))
    a, b = span_hz(at.trajectory), span_hz(slow.trajectory)
    assert b[0] / a[0] == pytest.approx(b[1] / a[1]) and b[1] < 0.5 * a[1]


def test_a_plan_has_this_rig_s_noise_and_the_middle_bend():
    found = search()
    movements = within(found, BY_NAME["fast trapezoid"], Limits())
    sim = planned(found, movements)
    (r,) = sim.problem.records
    assert r.run_id == "plan-act" and sim.problem.configs == ("plan",) and len(r.u) == len(movements[0].tension_n)
    assert np.std(r.raw.tension_in_n - movements[0].tension_n) == pytest.approx(NOISE_N, rel=0.2)
    # nothing to move is no plan
    assert planned(found, ()) is None
    moved = following._moved(sim, found, made())
    assert moved.theta.tolist() == [np.median(found.base.theta)] and len(moved.prediction) == len(r)


def test_the_noise_of_a_plan_is_that_of_as_many_readings_as_it_has_in_a_step():
    found = search()
    readings = of_readings(found.sim.problem.records, NOISE).output["act"].white_n
    for thin in (1, 4):
        record = SimpleNamespace(thin=thin)
        sim = SimpleNamespace(problem=SimpleNamespace(records=[record]))
        assert following._of_steps(sim, found).output["act"].white_n == pytest.approx(readings / np.sqrt(thin))


@pytest.mark.parametrize(("hz", "planned_hz"), [(50.0, 50.0), (2000.0, FASTEST_HZ)])
def test_a_plan_is_sampled_like_the_fastest_run_and_not_beyond_what_a_line_shows(hz, planned_hz):
    runs = [SimpleNamespace(raw=SimpleNamespace(dt_s=1.0 / f)) for f in (10.0, hz)]
    assert sampling_s(SimpleNamespace(sim=SimpleNamespace(problem=SimpleNamespace(records=runs)))) == pytest.approx(1.0 / planned_hz)


def test_an_experiment_settles_from_the_decidable_distance_on():
    for d2, settles in ((following.DECIDABLE, True), (following.DECIDABLE - 0.1, False)):
        assert Experiment(("a", "b"), (), d2, 0.0).settles is settles


def test_what_is_not_sure_to_settle_says_in_how_many_recordings_it_does():
    """9 of 30 movements that "settle nothing" did: below 24 the noise decides, and how often follows from the distance."""
    for d2, times in ((12.8, 76), (6.0, 36), (24.0, 95)):
        # the log-likelihood ratio is normal with mean d2 / 2 and variance d2; settled beyond ln 49
        by_hand = 1.0 - statistics.NormalDist(d2 / 2.0, d2**0.5).cdf(math.log(49.0))
        assert Experiment(("a", "b"), (), d2, 0.0).chance == pytest.approx(by_hand) and round(100.0 * by_hand) == times
    said = promised(Experiment(("a", "b"), (), 12.8, 3.04))
    assert said == (
        "no movement of the menu is sure to settle it within these tensions and rates, the best does in 76 of 100 recordings: "
        "at most D^2 = 12.8 (24 would), here 3.0"
    )
    assert promised(Experiment(("a", "b"), (), 1.2, 0.0)).startswith("no movement of the menu settles it within these tensions")
    assert (
        promised(Experiment(("a", "b"), (), 30.0, 3.0)) == "recorded on one bend, the two would differ by D^2 = 30 (24 settles it; here 3)"
    )
    assert "24 would settle it if laws were exact; here 26" in promised(Experiment(("a", "b"), (), 30.0, 26.0))


def test_a_plan_is_written_a_row_a_sample_in_the_unit_of_the_recording():
    move = Trajectory(kind="trapezoid", label="m", duration_s=1.0, low_n=2.0, high_n=6.0, systems=("act", "sstl"))
    lines = table(Scenario(trajectories=(move,), sampling_hz=10.0), 3.0).splitlines()
    rows = [line.split(",") for line in lines[1:]]
    assert lines[0] == "system,time_s,tension_in_n" and {r[0] for r in rows} == {"act", "sstl"}
    assert [float(r[1]) for r in rows[:3]] == pytest.approx([0.0, 0.1, 0.2])
    values = [float(r[2]) for r in rows]
    assert min(values) == pytest.approx(6.0) and max(values) == pytest.approx(18.0)
