"""Pieces of the search for limits behind noise, and scales of outputs that are no force, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import clipping
from sstl_cli.diagnosis.clipping import Limit, Pair, limit_of
from sstl_cli.diagnosis.scale import Scale, given, in_newtons, scale_of
from sstl_cli.physics.scenario import OutputScale


def flags(text):
    return np.array([c == "x" for c in text])


def test_a_limit_gains_by_how_far_the_line_goes_beyond_over_what_it_is_off_and_what_is_usual():
    limit = Limit(10.0, (), 0.5, 0.3)
    assert limit.share == pytest.approx(0.04) and limit.nats() == pytest.approx(0.5 * (0.5 / 0.3) ** 2)
    assert limit.nats(0.04) == pytest.approx(0.5) and Limit(10.0, (), 0.0, 0.3).nats() == 0.0 == Limit(10.0, (), 0.3, 0.3).share
    # a level near nothing counts as what the line is off
    assert Limit(0.1, (), 0.5, 0.3).share == pytest.approx(0.4 / 0.3) and Limit(-10.0, (), 0.5, 0.3).share == pytest.approx(0.04)


def test_what_a_reading_is_short_of_is_the_line_or_the_output_beyond_it():
    into, out, line = np.array([1.0, 2.0]), np.array([3.0, 5.0]), np.array([4.0, 4.0])
    assert Pair(into, out, 0.1, True).short(line).tolist() == [1.0, -1.0] and Pair(into, out, 0.1, False).short(line).tolist() == [
        -1.0,
        1.0,
    ]
    assert Pair(into, out, 0.1, True).value is out and Pair(into, out, 0.1, False).value is into


def test_what_a_line_was_off_on_its_way_is_taken_off_where_it_rests():
    short = np.array([0.2, 0.4, 5.0, 5.0, 9.0, -3.0, 7.0, 7.0, 7.0])
    # two readings there, 0.3 on average in the two before; one there, after -3: nothing is added
    assert clipping._since_entering(short, flags("..xx..x..")).tolist() == pytest.approx([4.7, 4.7, 7.0])
    # from the beginning there is nothing before, and a long rest looks back as far as there is
    assert clipping._since_entering(short, flags("xx.......")).tolist() == pytest.approx([0.2, 0.4])
    assert clipping._since_entering(short, flags("..xxxx...")).tolist() == pytest.approx([4.7, 4.7, 8.7, -3.3])


@pytest.mark.parametrize(("down", "both"), [(0.61, True), (0.59, False)])
def test_a_line_goes_both_ways_by_six_noises(down, both):
    line = np.concatenate((np.linspace(0.0, 5.0, 11), 5.0 - np.linspace(0.0, down, 5), 5.0 - down + np.linspace(0.0, 3.0, 5)))
    none = np.zeros(len(line), bool)
    assert clipping._both_ways(line, none, 0.1) is both and clipping._both_ways(-line, none, 0.1) is both
    # what moves at the limit says nothing
    assert not clipping._both_ways(line, (np.arange(len(line)) >= 10) & (np.arange(len(line)) < 17), 0.1)


def test_the_level_is_the_highest_about_which_most_readings_lie_within_noise():
    values = np.array([0.0, 9.0, 9.08, 9.16, 9.52, 9.6, 9.68, 9.9])
    # three lie within a tenth of 9.08 and of 9.6: the higher one counts
    assert clipping._piled(values, 0.1) == 9.6
    # twelve noises below the highest nobody counts
    assert clipping._piled(np.concatenate((np.full(50, 8.69), values)), 0.1) == 9.6
    assert clipping._piled(np.concatenate((np.full(50, 8.71), values)), 0.1) == 8.71


def test_a_rest_goes_from_the_first_to_the_last_reading_above_and_three_of_them_make_one():
    value = np.array([0.0, 9.5, 10.0, 9.8, 10.1, 10.0, 9.5, 0.0, 10.0, 10.0, 9.7, 0.0, 0.0, 0.0])
    # readings within six noises of 10 N: the first part has three at 10 N or above, the second two
    assert clipping._resting(value, 10.0, 0.1).tolist() == flags("..xxxx........").tolist()
    assert clipping._resting(value, 10.0, 0.1, 5.0).tolist() == flags(".xxxxxx.......").tolist()
    # no run is there for nine tenths of it
    most = np.concatenate(([0.0], np.full(9, 10.0)))
    assert not clipping._resting(most, 10.0, 0.1).any() and clipping._resting(np.append(most, 0.0), 10.0, 0.1).sum() == 9


def test_without_noise_and_where_a_reading_is_beyond_nothing_is_a_limit():
    u = np.concatenate((np.linspace(0.0, 9.0, 100), np.full(30, 9.0), np.linspace(9.0, 0.0, 100)))
    flat = limit_of([Pair(u, 0.5 * u, 0.0, False)])
    assert flat.level_n == np.inf and not flat.there[0].any() and (flat.beyond_n, flat.off_n) == (0.0, 0.0)
    beyond = limit_of([Pair(np.append(u, 9.7), np.append(0.5 * u, 4.0), 0.1, False)])
    assert beyond.level_n == pytest.approx(9.0, abs=0.1) and not beyond.there[0].any() and beyond.beyond_n == 0.0


def run(system, out, unit="V"):
    t = np.arange(4.0)
    return Run("r", system, t, np.array([0.0, 4.0, 8.0, 4.0]), np.asarray(out, float), unit_out=unit)


def test_the_scale_of_a_model_is_that_of_outputs_in_its_unit_and_of_its_systems():
    had = OutputScale(unit="V", per_n={"act": 0.5, "sstl": 0.25}, origin={"act": 1.0, "sstl": 2.0})
    assert given([run("act", [1.0] * 4)], had) == Scale("V", {"act": 0.5, "sstl": 0.25}, {"act": 1.0, "sstl": 2.0})
    assert given([run("act", [1.0] * 4)], None) is None and given([run("act", [1.0] * 4, "mA")], had) is None
    one = OutputScale(unit="V", per_n={"act": 0.5}, origin={"act": 1.0})
    assert given([run("act", [1.0] * 4), run("sstl", [1.0] * 4)], one) is None
    (r, s) = in_newtons([run("act", [1.0, 2.0, 3.0, 2.0]), run("sstl", [2.0, 2.5, 3.0, 2.0])], given([run("act", [1.0] * 4)], had))
    assert r.tension_out_n.tolist() == [0.0, 2.0, 4.0, 2.0] and s.tension_out_n.tolist() == [0.0, 2.0, 4.0, 0.0]
    assert given([run("act", [1.0] * 4)], had).typical == 0.375 and scale_of([run("act", [1.0] * 4, "N")]) is None
