"""Cases recorded as labs record: what is dealt, what the recorder leaves alone, and what reaches the log."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.blind import bench as benches
from sstl_cli.blind.cases import draw
from sstl_cli.blind.record import DAY_SHARE, FINE_SHARE, Source
from sstl_cli.blind.retune import gap_n
from sstl_cli.blind.schedule import Entry, jobs
from sstl_cli.physics.recording import Recording

FRICTION = Entry("single", ("const_friction",), 1.2)


def source(lab=None, seed=4):
    return Source(benches.draw(np.random.default_rng(seed), True, lab=lab), seed)


def test_half_of_each_kind_and_of_each_simulator_is_recorded_as_labs_do():
    dealt = Counter((j.entry.kind, j.simulator, j.as_labs) for j in jobs(600, 3, "mixed"))
    for kind in ("single", "none", "pair"):
        for simulator in ("rig", "bristle", "variant"):
            assert abs(dealt[kind, simulator, True] - dealt[kind, simulator, False]) <= 1
    more = Counter((j.entry.kind, j.simulator) for j in jobs(600, 3, "mixed", nulls=30))
    assert {k: more[k] - sum(dealt[(*k, lab)] for lab in (False, True)) for k in more} == {
        k: 10 * (k[0] == "none") for k in more
    }  # further nulls of every simulator, and all else as before
    assert not any(j.as_labs for j in jobs(40, 3, "mixed", recordings="plain"))
    assert all(j.as_labs for j in jobs(40, 3, "rig", recordings="lab"))


def test_plain_cases_are_those_of_before():
    plain = draw(FRICTION, 5, True)
    assert plain.truth.recording is None
    assert all(np.allclose(np.diff(r.time_s), 0.01) for r in plain.runs) and {r.system for r in plain.runs} == {"act", "sstl"}


def test_a_recorder_that_changes_nothing_gives_the_plain_log():
    plain = source()
    same = replace(plain, bench=replace(plain.bench, lab=Recording(rate_hz=100.0), position=True, reference=True))
    plain = replace(plain, bench=replace(plain.bench, position=True, reference=True))
    for a, b in zip(plain.record(plain.bench.runs, {}), same.record(same.bench.runs, {}), strict=True):
        for name in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n"):
            assert np.allclose(getattr(a, name), getattr(b, name), atol=1e-9), name


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_the_log_has_the_rate_and_the_systems_of_the_lab(rate):
    lab = Recording(rate_hz=rate, systems=("sstl",), one_configuration=True, gaps=((0.3, 0.05),))
    found = source(lab)
    runs = found.record(found.bench.runs, {})
    assert {r.system for r in runs} == {"sstl"} and {r.config_id for r in runs} == {"C1"}
    for r in runs:
        steps = np.diff(r.time_s)
        assert np.median(steps) == pytest.approx(1.0 / rate)
        assert steps.max() > 0.04 * np.ptp(r.time_s)
    # sensors see the mechanics of the simulated clock, not those of the recorder's
    planned = found.bench.runs[0]
    truth = found.truth(planned, {})[0]
    assert np.abs(runs[0].tension_in_n - np.interp(runs[0].time_s, planned.time_s, truth)).max() < 6 * 0.05


def test_zeros_of_days_and_resolution_stay_below_the_noise():
    far = Recording(rate_hz=100.0, step_in_n=0.5, step_out_n=0.5, day_zero_n=((0.0,) * 4, (0.5, -0.8, 0.4, 0.9)))
    found = source(far).as_recorded()
    lab = found.bench.lab
    assert lab.step_out_n == FINE_SHARE * found.noise_n
    quiet = replace(found, bench=replace(found.bench, lab=None))
    # independent of how it was scaled: play both sessions and re-tune
    before, _ = quiet.gap({})
    moved = [found._moved(lab, p, i) for i, p in enumerate(quiet.pairs({}))]
    after, _ = gap_n(moved, found.bench.theta)
    assert np.sqrt(after**2 - before**2) == pytest.approx(DAY_SHARE * found.noise_n, rel=0.1)
    early, late = lab.day_zero_n
    assert early == (0.0,) * 4 and late[1] < 0.0 < late[0]


def test_a_case_says_how_it_was_recorded_and_is_drawn_again_alike():
    one, two = (draw(FRICTION, 17, True, as_labs=True) for _ in range(2))
    assert one.truth == two.truth and "Hz" in one.truth.recording
    assert all(np.array_equal(a.tension_out_n, b.tension_out_n) for a, b in zip(one.runs, two.runs, strict=True))
    assert one.truth.strength == pytest.approx(1.2, rel=0.25)


def test_an_effect_of_a_sensor_that_is_not_recorded_is_not_withheld():
    # gains are drawn for one system or both: whatever lab is drawn, it must show
    for seed in range(12):
        case = draw(Entry("single", ("gain_error",), 1.2), seed, True, as_labs=True)
        assert case.truth.strength > 0.1


def test_where_nothing_is_missing_the_base_leaves_nothing() -> None:
    # a bristle line in cycles of two seconds has a lag of its own, 0.19 times the noise of the first bench of this seed
    truth = draw(Entry("none"), 48000355, quick=True, hardware="bristle", as_labs=True).truth
    assert truth.attempt > 0 and truth.gap_null_n <= 0.1 * truth.noise_n
