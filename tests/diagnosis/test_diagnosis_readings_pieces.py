"""What makes a sample a copy, a renewal that changed nothing, or a limit, at its thresholds."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import readings
from sstl_cli.diagnosis.constants import CLIPPED_SIGMA, MOST_ALIKE
from sstl_cli.diagnosis.readings import agreed, gaps, known, scanned
from sstl_cli.diagnosis.recorder import Faults, scan


def flags(text):
    return np.array([c == "x" for c in text])


def test_a_limit_is_held_for_longer_than_a_few_renewals():
    # three are a few, four are more
    assert readings._standing(flags("xxx.xxxx."), 3.0).tolist() == flags("....xxxx.").tolist()


@pytest.mark.parametrize("missed", range(1, MOST_ALIKE + 2))
def test_renewals_that_changed_nothing_are_put_at_their_places(missed):
    fresh = np.zeros(40, bool)
    fresh[[0, 5, 5 + 5 * missed]] = True
    expected = [5 + 5 * k for k in range(1, missed)] if missed <= MOST_ALIKE else []
    assert np.flatnonzero(readings._alike(fresh, np.arange(40.0), 5.0)).tolist() == expected


@pytest.mark.parametrize(
    ("held", "noise", "step", "repeated", "copies"),
    [
        (True, 0.0, 0.0, 0.0, True),
        # less noise than half a step repeats by itself, next to none as well
        (False, 0.05, 0.1, 0.9, False), (False, 0.051, 0.1, 0.9, False), (False, 1e-5, 0.0, 0.9, False),
        (False, 0.1, 0.0, 0.11, True), (False, 0.1, 0.0, 0.1, False),
        # a step as large as the noise repeats 0.28 of them by chance: three times that
        (False, 0.1, 0.1, 0.86, True), (False, 0.1, 0.1, 0.83, False),
    ],
)  # fmt: skip
def test_samples_that_repeat_are_copies_beyond_what_rounding_makes(held, noise, step, repeated, copies):
    assert readings._copies(SimpleNamespace(held=held, noise_n=noise, step_n=step), repeated) is copies


def test_what_is_not_marked_is_a_reading_and_was_recorded():
    run = Run("r", "act", np.arange(3.0), np.ones(3), np.ones(3), extra={"known_tension_out_n": np.array([1.0, 0.0, 1.0])})
    assert known(run, "tension_in_n").all() and known(run, "tension_out_n").tolist() == [True, False, True]
    assert gaps(run).tolist() == [0.0] * 3


def test_what_a_slow_sensor_says_first_and_behind_a_gap_may_be_older_than_it_seems():
    rng = np.random.default_rng(4)
    t = 0.005 * np.arange(2000)
    u = 10.0 + 5.0 * np.sin(t)
    out = u * np.exp(-0.4) + 0.01 * rng.standard_normal(2000)
    # renewed every ninth sample; the gap begins and ends between two renewals
    held = out[np.maximum((np.arange(2000) + 4) // 9 * 9 - 4, 0)]
    kept = np.delete(np.arange(2000), np.arange(803, 826))
    run = Run("r", "act", t[kept], (u + 0.01 * rng.standard_normal(2000))[kept], held[kept])
    told = known(readings.renewed(run, np.ones(len(kept), bool)), "tension_out_n")
    at = kept[told]
    assert not told[0] and 826 not in at and set((at + 4) % 9) == {0} and len(at) > 200
    # a sensor of which every sample is a reading has them all
    assert known(readings.renewed(replace(run, tension_out_n=out[kept]), np.ones(len(kept), bool)), "tension_out_n").all()


def test_faults_of_a_slow_sensor_are_those_of_its_readings_at_their_places():
    rng = np.random.default_rng(1)
    values = np.sin(0.05 * np.arange(400)) + 0.01 * rng.standard_normal(400)
    values[[100, 201]] += 5.0
    fresh = np.arange(400) % 2 == 0
    run = Run("r", "act", 0.1 * np.arange(400), values, values, extra={"known_tension_out_n": fresh.astype(float)})
    found, alone = scanned(run, "tension_out_n"), scan(values[fresh])
    # the second spike is no reading
    assert np.flatnonzero(found.spike).tolist() == [100] and found.noise_n == alone.noise_n
    assert np.array_equal(found.frozen[fresh], alone.frozen) and not found.frozen[~fresh].any() and len(found.clipped) == 400
    assert np.flatnonzero(scanned(run, "tension_in_n").spike).tolist() == [100, 201]


@pytest.mark.parametrize(("beyond", "stays"), [(0.9, True), (1.1, False)])
def test_a_limit_is_none_where_another_run_of_the_same_sensor_is_beyond_it_by_more_than_noise(beyond, stays):
    no, hit = np.zeros(3, bool), np.array([False, True, True])
    limited = Faults(no, no, hit, 5.0, 0.2, 0.1)
    free = Faults(no, no, no, float("inf"), 0.2, 0.1)

    def run(name, top, system="act"):
        return Run(name, system, np.arange(3.0), np.array([0.0, 1.0, top]), np.array([0.0, 1.0, 5.0]))

    other = run("b", 5.0 + beyond * CLIPPED_SIGMA * 0.2)
    found = agreed([(run("a", 5.0), limited, limited), (other, free, free)])
    assert bool(found[0][1].clipped.any()) is stays and (found[0][1].clip_level_n == 5.0) is stays
    # the output of neither run is beyond its level, and another system has another sensor
    assert found[0][2].clipped.any() and found[1][1] is free
    apart = agreed([(run("a", 5.0), limited, limited), (run("c", 99.0, "sstl"), free, free)])
    assert apart[0][1].clipped.any()
