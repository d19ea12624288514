"""Channels that overflow and readings about a limit that only several runs tell, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from rig_logs import sound

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import readings
from sstl_cli.diagnosis.clipping import Limit
from sstl_cli.diagnosis.constants import CLIPPED_SIGMA, DOUBT_NATS
from sstl_cli.diagnosis.readings import folded, renewed, scanned, unfolded

T = 0.01 * np.arange(4000)
PULL = 12.0 + 10.0 * np.sin(2.0 * np.pi * T / 8.0)
EVERY = np.ones(len(T), bool)
NOISE = 0.02 * np.random.default_rng(2).standard_normal((2, len(T)))


def overflowing(size=15.0):
    """Return a run whose output reads on from 0 N beyond its range, and what it would have read."""
    out = 0.9 * PULL + NOISE[0]
    return Run("r", "act", T, PULL + NOISE[1], out % size), out


def test_a_channel_that_overflows_goes_on_beyond_its_range_and_reads_as_it_did_again():
    run, out = overflowing()
    whole, ranges = unfolded(run, EVERY)
    assert list(ranges) == ["tension_out_n"] and whole.tension_in_n is run.tension_in_n
    size, top = ranges["tension_out_n"]
    assert size == pytest.approx(15.0, abs=0.05) and whole.tension_out_n == pytest.approx(out, abs=0.05)
    # the range spans its readings: its end is the highest of them
    assert top == run.tension_out_n.max()
    again = folded(whole, ranges)
    # the range is known to noise: a reading as near to its end may be told on either side
    clear = np.abs(out - 15.0) > 0.05
    assert again.tension_out_n[clear] == pytest.approx(run.tension_out_n[clear])
    # by how much the readings are beyond is a whole range, where the pull is above it
    assert again.extra["beyond_tension_out_n"][clear] == pytest.approx(np.where(out >= 15.0, size, 0.0)[clear])
    assert run.extra == {} and "beyond_tension_in_n" not in again.extra


def test_the_end_of_a_range_that_was_read_past_is_where_readings_jump():
    run, _ = overflowing()
    # a recorder has interpolated between the two ends
    run.tension_out_n[100], run.tension_out_n[200] = 17.5, -2.5
    size, top = unfolded(run, EVERY)[1]["tension_out_n"]
    assert size == pytest.approx(15.0, abs=0.1) and top == pytest.approx(15.0, abs=0.1) and top < run.tension_out_n.max()


def test_samples_that_do_not_count_are_left_as_they_are():
    run, out = overflowing()
    finite = EVERY.copy()
    finite[1234] = False
    run.tension_out_n[1234] = np.nan
    whole, _ = unfolded(run, finite)
    assert np.isnan(whole.tension_out_n[1234]) and whole.tension_out_n[finite] == pytest.approx(out[finite], abs=0.05)
    quiet, none = unfolded(Run("q", "act", T, PULL, 0.5 * PULL), EVERY)
    assert none == {} and np.array_equal(quiet.tension_out_n, 0.5 * PULL)


@pytest.mark.parametrize(("value", "over"), [(14.9, 0.0), (15.0, 0.0), (15.1, 15.0), (30.1, 30.0), (-40.0, 0.0)])
def test_a_value_is_beyond_its_range_by_whole_ranges(value, over):
    run = Run("r", "act", T[:2], np.zeros(2), np.array([1.0, value]))
    found = folded(run, {"tension_out_n": (15.0, 15.0)})
    assert found.extra["beyond_tension_out_n"].tolist() == [0.0, over] and found.tension_out_n[1] == pytest.approx(value - over)


def test_what_overflows_is_beyond_the_limit_and_no_spike():
    run, out = overflowing()
    found = scanned(folded(*unfolded(run, EVERY)), "tension_out_n")
    clear = np.abs(out - 15.0) > 0.05
    assert np.array_equal(found.clipped[clear], out[clear] >= 15.0) and not found.spike.any() and not found.frozen.any()
    assert found.clip_level_n == pytest.approx(15.0, abs=0.05) and found.noise_n == pytest.approx(0.02, rel=0.1)
    # a channel that does not overflow has a limit only where readings pile up
    assert not scanned(run, "tension_in_n").clipped.any()


def test_samples_to_and_fro_between_two_levels_of_a_converter_are_no_renewals():
    def sensor(noise=0.1, step=0.1, held=False):
        return SimpleNamespace(held=held, noise_n=noise, step_n=step)

    # independent readings with a noise of 0.1 N differ by 0.113 N on average
    to_and_fro, apart = np.tile([0.0, 0.1], 20), np.tile([0.0, 0.12], 20)
    assert readings._flickers(sensor(), to_and_fro) and not readings._flickers(sensor(), apart)
    assert readings._flickers(sensor(), -to_and_fro) and not readings._flickers(sensor(held=True), to_and_fro)
    # without a step there are no levels, and one reading differs from none
    assert not readings._flickers(sensor(step=0.0), to_and_fro) and not readings._flickers(sensor(), to_and_fro[:1])
    assert readings._flickers(sensor(), to_and_fro[:2])


def test_a_sensor_that_repeats_itself_follows_straight_lines_between_its_readings():
    held = PULL[np.arange(len(T)) // 10 * 10]
    run = renewed(Run("r", "act", T, PULL + NOISE[0], held), EVERY)
    marked = np.flatnonzero(run.extra["known_tension_out_n"])
    # the first may be a copy; a tenth of the others are readings, each at its own place
    assert set(np.diff(marked)) == {10} and marked[0] == 10 and np.array_equal(run.tension_out_n[marked], held[marked])
    assert run.tension_out_n[10:3990] == pytest.approx(PULL[10:3990], abs=0.01)
    assert "known_tension_in_n" not in run.extra and np.array_equal(run.tension_in_n, PULL + NOISE[0])


def rested(level, beyond=0.6, off=0.02):
    return Limit(level, (np.array([False, True]),), beyond, off)


def test_other_sensors_tell_by_how_much_lines_are_usually_short_at_their_highest():
    share = np.sqrt(0.6**2 - 0.02**2) / 10.0
    limits = {("act", True): rested(10.0), ("sstl", True): rested(20.0), ("sstl", False): rested(5.0)}
    # of the same end of another line, at a level of its own
    assert readings._usual(("sstl", True), limits) == pytest.approx(share)
    assert readings._usual(("act", True), limits) == pytest.approx(np.sqrt(0.6**2 - 0.02**2) / 20.0)
    assert readings._usual(("sstl", False), limits) == 0.0 and readings._usual(("act", False), limits) == 0.0
    # two at one level may share a limit
    for apart, usual in ((0.99, 0.0), (1.01, pytest.approx(0.06, rel=0.02))):
        near = {("act", True): rested(10.0 + apart * CLIPPED_SIGMA * 0.02), ("sstl", True): rested(10.0)}
        assert readings._usual(("sstl", True), near) == usual


def test_a_limit_beyond_doubt_takes_the_readings_about_it_that_count():
    faults, used = [sound(4, 0.02), sound(3, 0.02)], [np.array([True, False, True, True]), np.ones(3, bool)]
    there = (np.array([False, True, True]), np.zeros(3, bool))
    # a gain of (beyond / off)^2 / 2
    for nats, taken in ((1.01 * DOUBT_NATS, True), (0.99 * DOUBT_NATS, False)):
        limit = Limit(9.0, there, 0.02 * np.sqrt(2.0 * nats), 0.02)
        first, second = readings._behind_noise(faults, used, limit, 0.0)
        assert first.clipped.tolist() == ([False, False, True, True] if taken else [False] * 4)
        assert (first.clip_level_n == 9.0) is taken and second is faults[1]
    # where every line is short by as much it is none
    sure = Limit(9.0, there, 0.02 * np.sqrt(4.0 * DOUBT_NATS), 0.02)
    assert readings._behind_noise(faults, used, sure, 0.0)[0].clipped.any()
    assert not readings._behind_noise(faults, used, sure, 0.1)[0].clipped.any()
    assert not faults[0].clipped.any()
