"""Which samples are readings: limits that a sensor stands at, limits that only one run seems to have."""

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.readings import agreed, known, renewed
from sstl_cli.diagnosis.recorder import scan
from sstl_cli.diagnosis.records import prepare

T = np.arange(0.0, 20.0, 0.01)
NOISE = np.random.default_rng(4).standard_normal((4, len(T)))


def made(limit=np.inf, top=20.0, run_id="a"):
    u = 2.0 + 0.5 * (top - 2.0) * (1.0 - np.cos(2.0 * np.pi * 0.2 * T)) + 0.02 * NOISE[0]
    y = 1.0 + 0.2 * (top - 2.0) * (1.0 - np.cos(2.0 * np.pi * 0.2 * T)) + 0.02 * NOISE[1]
    return Run(run_id, "act", T, u, np.minimum(y, limit))


def test_what_stands_at_a_limit_for_half_of_the_time_was_read_and_is_no_slow_sensor():
    run = made(4.0)
    assert np.mean(run.tension_out_n == 4.0) > 0.4
    assert known(renewed(run, np.ones(len(T), bool)), "tension_out_n").all()
    (record,) = prepare([run]).records
    assert record.faults_out.clip_level_n == 4.0 and record.weight.mean() == pytest.approx(np.mean(run.tension_out_n < 4.0), abs=0.03)


def test_a_limit_that_another_run_of_the_sensor_passes_is_none():
    low, high = made(4.0), made(run_id="b")
    pair = agreed([(r, scan(r.tension_in_n), scan(r.tension_out_n)) for r in (low, high)])
    assert not pair[0][2].clipped.any() and pair[0][2].clip_level_n == np.inf
    alone = agreed([(low, scan(low.tension_in_n), scan(low.tension_out_n))])
    assert alone[0][2].clipped.any()


def test_behind_a_clipped_input_the_model_begins_anew():
    run = made()
    cut = Run("a", "act", T, np.minimum(run.tension_in_n, 15.0), run.tension_out_n)
    (record,) = prepare([cut]).records
    ends = [T[i] for i in np.flatnonzero(np.diff((run.tension_in_n < 15.0).astype(int)) == 1)]
    starts = np.array([s.at * record.dt_s for s in record.again])
    assert all(np.abs(starts - last).min() < 0.1 for last in ends[-1:]) and len(starts) >= 4


def test_a_slow_sensor_that_stands_still_at_its_highest_reading_is_at_no_limit():
    fresh = np.arange(len(T)) % 10 == 0
    y = made().tension_out_n[np.maximum.accumulate(np.where(fresh, np.arange(len(T)), 0))].copy()
    at = int(np.argmax(y))
    # four renewals are missed there
    y[at : at + 50] = y[at]
    run = Run("a", "act", T, made().tension_in_n, y)
    (record,) = prepare([run]).records
    assert not record.faults_out.clipped.any() and known(record.raw, "tension_out_n").sum() == pytest.approx(len(T) / 10, abs=8)


def test_a_limit_that_noise_leaves_all_the_time_makes_no_slow_sensor():
    y = np.minimum(np.clip(8.0 * np.sin(2.0 * np.pi * 0.2 * T), -2.0, 4.0) + 0.02 * NOISE[2], 4.0)
    run = Run("a", "act", T, made().tension_in_n, 6.0 + y)
    assert known(renewed(run, np.ones(len(T), bool)), "tension_out_n").all()


@pytest.mark.parametrize("step", [0.05, 0.2])
def test_a_rounded_output_that_goes_to_and_fro_at_rest_is_no_slow_sensor(step):
    rest = np.clip(np.abs((T % 6.0) - 3.0), 1.0, 2.0)
    y = np.round((10.0 + 0.5 * rest + 0.1 * step * NOISE[3]) / step) * step
    assert np.mean(np.diff(y) == 0.0) > 0.7
    found = renewed(Run("a", "act", T, made().tension_in_n, y), np.ones(len(T), bool))
    assert known(found, "tension_out_n").all() and np.array_equal(found.tension_out_n, y)


def test_what_a_sensor_renewed_every_other_sample_or_so_says_first_behind_a_gap_is_no_reading():
    """It may be a copy of what was not recorded: a null had 46 sigma there."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 40.0, 0.02)
    held = 0.03 * np.floor(time / 0.03)
    there = (time < 20.01) | (time > 20.29)
    read, noise = 12.0 + 8.0 * np.sin(held), 0.02 * rng.standard_normal(int(held[-1] / 0.03) + 2)
    out = read + noise[np.rint(held / 0.03).astype(int)]
    given = 14.0 + 9.0 * np.sin(time) + 0.02 * rng.standard_normal(len(time))
    run = Run("a", "act", time[there], given[there], out[there])
    marked = known(renewed(run, np.ones(len(run), bool)), "tension_out_n")
    first = int(np.searchsorted(run.time_s, 20.1))
    assert not marked.all() and not marked[first] and 0.6 < marked.mean() < 0.7
