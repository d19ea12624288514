"""A sensor whose number overflows, and one whose limit cost nothing because the line told what was beyond: both are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import record

from sstl_cli.diagnosis.readings import folded, unfolded
from sstl_cli.diagnosis.records import prepare
from sstl_cli.identification.gate.overflows import size_n, turns
from sstl_cli.steps.diagnose import DiagnoseOptions, run

SENSORS = DiagnoseOptions(
    effects=("saturation", "acquisition_faults", "sensor_nonlinearity", "gain_error", "zero_offset", "const_friction")
)
T = 0.01 * np.arange(4000)
SENT = 12.0 + 10.0 * np.sin(2.0 * np.pi * T / 8.0)
HELD = np.concatenate(([12.0], np.zeros(len(T) - 1)))
for k in range(1, len(T)):
    HELD[k] = min(max(HELD[k - 1], np.exp(-0.4) * SENT[k]), np.exp(0.4) * SENT[k])
NOISE = [0.02 * np.random.default_rng(i).standard_normal(len(T)) for i in range(2)]


@pytest.mark.parametrize("range_n", [12.0, 6.0])
def test_readings_beyond_the_range_are_counted_though_noise_crosses_it_to_and_fro(range_n):
    pull, other = HELD + NOISE[0], SENT + NOISE[1]
    count = turns(pull % range_n, other)
    np.testing.assert_array_equal(count, np.floor(pull / range_n))
    assert size_n(pull % range_n, count) == pytest.approx(range_n, abs=0.05)


def test_a_reading_interpolated_beyond_the_range_makes_it_no_wider():
    pull, other = HELD + NOISE[0], SENT + NOISE[1]
    read = pull % 12.0
    read[np.argmax(read)], read[np.argmin(read)] = 13.4, -0.9
    count = turns(read, other)
    np.testing.assert_array_equal(count, np.floor(pull / 12.0))
    assert size_n(read, count) == pytest.approx(12.0, abs=0.05)


def test_what_reads_nothing_but_noise_goes_below_the_range_and_no_whole_range_higher():
    sent = 10.0 * np.maximum(np.sin(2.0 * np.pi * T / 8.0), 0.0)
    pull = 0.7 * sent + NOISE[0]
    count = turns(pull % 5.0, sent + NOISE[1])
    np.testing.assert_array_equal(count, np.floor(pull / 5.0))
    assert count.min() == -1


def test_a_channel_that_is_beyond_its_range_while_the_other_end_is_lowest_overflows():
    # much friction holds the output up when the input is back within a tenth of its span from its lowest
    wide = np.concatenate(([5.0], np.zeros(len(T) - 1)))
    for k in range(1, len(T)):
        wide[k] = min(max(wide[k - 1], np.exp(-1.0) * SENT[k]), np.exp(1.0) * SENT[k])
    pull, other = wide + NOISE[0], SENT + NOISE[1]
    assert other[pull >= 6.0].min() < other.min() + 0.1 * np.ptp(other)
    np.testing.assert_array_equal(turns(pull % 6.0, other), np.floor(pull / 6.0))


def test_a_signed_number_goes_on_at_its_other_end():
    pull = HELD + NOISE[0]
    count = turns((pull + 11.0) % 22.0 - 11.0, SENT + NOISE[1])
    np.testing.assert_array_equal(count, pull >= 11.0)


@pytest.mark.parametrize(
    "other_values",
    [
        # lost samples, a square wave that the other end follows late, noise alone, a movement within the range
        lambda pull: np.where(np.arange(len(pull)) % 300 < 20, 0.0, pull),
        lambda pull: np.where(T % 8.0 < 4.0, 14.0, 0.02) + NOISE[0],
        lambda pull: NOISE[0],
        lambda pull: pull,
    ],
)
def test_what_drops_or_moves_does_not_overflow(other_values):
    late = np.empty(len(T))
    late[0] = 14.0
    for k in range(1, len(T)):
        late[k] = late[k - 1] + 0.02 * (np.where(T[k] % 8.0 < 4.0, 14.0, 0.02) - late[k - 1])
    for other in (SENT + NOISE[1], late + NOISE[1]):
        values = other_values(HELD + NOISE[0])
        count = turns(values, other)
        assert not count.any() and np.isnan(size_n(values, count))


def logs(column, share, beyond):
    """Return runs of one channel that ends at a share of its highest reading, what is beyond by a rule, and the level (N)."""
    clean = record({}, seed=3, hz=50.0)
    top = share * max(getattr(r, column).max() for r in clean)
    return [replace(r, **{column: beyond(getattr(r, column), top)}) for r in clean], top


@pytest.mark.parametrize("column", ["tension_in_n", "tension_out_n"])
@pytest.mark.slow
def test_an_overflow_is_a_limit_and_no_failure_of_the_log(column):
    runs, top = logs(column, 0.95, lambda v, top: np.where(v >= top, v - top, v))
    said = run(runs, replace(SENSORS, max_effects=1))
    assert said.document()["analysis"]["set_aside"] == {}
    assert said.verdict.status == "identified" and said.verdict.effects == ("saturation",)
    name = "t_max_in_n" if column == "tension_in_n" else "t_max_out_n"
    assert said.evidence.recorder[0].parameters[name] == pytest.approx(top, abs=0.2)


@pytest.mark.slow
def test_a_limit_of_the_input_is_named_though_the_model_bridges_it():
    runs, _ = logs("tension_in_n", 0.97, np.minimum)
    found = run(runs, DiagnoseOptions(max_effects=1))
    assert found.verdict.effects == ("saturation",) and found.verdict.status == "identified"
    gap = found.document()["gap"]
    # what a model that follows the readings would have been off by, against what it leaves beside them
    assert gap["rmse_retuned_n"] > 2.0 * gap["rmse_with_effect_n"]


def test_a_jittering_clock_puts_no_reading_between_the_ends_of_the_range():
    runs, top = logs("tension_out_n", 0.9, lambda v, top: np.where(v >= top, v - top, v))
    r = max(runs, key=lambda r: np.count_nonzero(np.abs(np.diff(r.tension_out_n)) > 0.5 * top))
    early = 0.1 * r.dt_s * np.random.default_rng(5).uniform(-1.0, 1.0, len(r))
    (made,) = prepare([replace(r, time_s=r.time_s + early)]).records
    over = turns(r.tension_out_n, r.tension_in_n)
    assert abs(np.count_nonzero(made.faults_out.clipped) - np.count_nonzero(over)) <= 4
    whole, ranges = unfolded(r, np.ones(len(r), bool))
    # the lowest reading is as far along as the highest of the turn before
    known = r.tension_out_n > r.tension_out_n.min()
    np.testing.assert_allclose(folded(whole, ranges).tension_out_n[known], r.tension_out_n[known], atol=1e-9)


@pytest.mark.parametrize("seed", [6, 8, 10, 12, 13, 16, 17, 18])
def test_noise_of_an_output_that_rests_and_is_held_does_not_overflow(seed):
    rng = np.random.default_rng(seed)
    n = rng.integers(100, 400)
    # renewed 100 times a second, read 250 times
    held = np.repeat(np.round(2.0 + 0.021 * rng.standard_normal(n), 2), np.tile([3, 2], n)[:n])
    pull = 10.0 + 5.0 * np.sin(0.6 * np.pi * np.arange(len(held)) / 250.0 + rng.uniform(0.0, 6.0))
    assert not turns(held, pull).any()


def test_a_few_readings_far_off_between_others_do_not_overflow():
    pull = 10.0 - 8.0 * np.cos(np.arange(1000) / 100.0)
    spoilt = 0.6 * pull
    for at in (150, 151, 420, 421, 700, 701):
        spoilt[at] += 40.0
    assert not turns(spoilt, pull).any()
