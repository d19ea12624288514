"""What a model leaves: white noise passes all tests, whatever else is left fails the one that is made for it."""

from __future__ import annotations

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator

from sstl_cli.diagnosis.residuals import leftover
from sstl_cli.diagnosis.where import phases

# standard deviations of the worst of 15 tests that chance alone reaches now and then
CHANCE = 6.0


def left(residual):
    return leftover(simulator(), made(residual))


def z_of(found):
    return {t.name: t.z for t in found.tests}


@pytest.mark.parametrize("seed", range(5))
def test_white_noise_fails_nothing(seed):
    found = left(noise(seed))
    assert found.worst().z < CHANCE
    assert found.chi2 == pytest.approx(1.0, abs=0.05) and found.excess < 0.25
    assert abs(found.lag_one) < 0.05 and abs(found.kurtosis) < 0.3 and abs(found.skewness) < 0.2


def test_noise_that_is_larger_than_stated_shows_in_chi2_and_in_spreads():
    found = left(1.5 * noise())
    assert found.chi2 == pytest.approx(2.25, rel=0.05) and found.excess == pytest.approx(np.sqrt(1.25), rel=0.1)
    assert all(z > CHANCE for name, z in z_of(found).items() if name.startswith("spread"))


def test_a_tone_is_found_at_its_frequency():
    sim = simulator()
    time = np.concatenate([r.time_s for r in sim.problem.records])
    # a fifth of the noise: hidden in every sample, not in the spectrum
    found = left(noise() + 0.4 * NOISE_N * np.sin(2.0 * np.pi * 3.0 * time))
    line = next(t for t in found.tests if t.name == "one line of the spectrum")
    assert line.z > 2.0 * CHANCE and line.peak.startswith("3")
    assert z_of(found)["one sample"] < CHANCE


def test_a_step_inside_one_run_is_told_from_one_between_runs():
    sim = simulator()
    within, between = noise(), noise()
    second = sim.slices()[1]
    within[(second.start + second.stop) // 2 : second.stop] += NOISE_N
    within[second.start : (second.start + second.stop) // 2] -= NOISE_N
    between[second] += NOISE_N
    a, b = z_of(left(within)), z_of(left(between))
    assert "run1, quarter" in next(t.peak for t in left(within).tests if t.name == "mean by run and time in the run")
    assert next(t.peak for t in left(between).tests if t.name == "mean by run") == "run run1"
    assert a["mean by run and time in the run"] > 2.0 * CHANCE > CHANCE > a["mean by run"]
    assert b["mean by run"] > 2.0 * CHANCE


def test_pulses_raise_the_fourth_moment_and_the_largest_is_told():
    r = noise()
    r[200::400] += 12.0 * NOISE_N
    r[1000] += 6.0 * NOISE_N
    found = left(r)
    single = next(t for t in found.tests if t.name == "one sample")
    run = simulator().problem.records[int(simulator().run[1000])]
    assert found.kurtosis > 5.0 and single.z > 2.0 * CHANCE
    assert single.peak.endswith(run.run_id)


def test_a_tail_to_one_side_along_the_movement_is_skew():
    sim = simulator()
    rng = np.random.default_rng(3)
    one_sided = NOISE_N * (rng.exponential(1.0, len(sim.y)) - 1.0)
    pulling = np.concatenate([np.gradient(r.u.reshape(-1, r.factor).mean(axis=1)) > 0 for r in sim.problem.records])
    # the same tail against the movement in both directions
    assert left(np.where(pulling, -one_sided, one_sided)).skewness < -1.0


def test_a_model_that_leaves_nothing_is_no_error():
    found = left(0.0)
    assert found.chi2 < 1e-50 and found.excess == 0.0 and found.skewness == 0.0


def test_masked_samples_count_for_nothing():
    sim = simulator()
    used = sim.weight > 0
    spoilt = np.where(used, noise(), 1e6)
    assert left(spoilt) == left(noise())


def test_where_a_test_fails_is_said_in_words():
    sim = simulator()
    fit = made()
    pulling = (phases(sim, fit.prediction) == 1) & (sim.config == 1)
    found = {t.name: t.peak for t in leftover(sim, made(noise() + np.where(pulling, 2.0 * NOISE_N, 0.0))).tests}
    assert found["mean by configuration and phase"] == "b, act PP"
    assert found["mean by phase and tension"].startswith("act PP, quarter ")
    assert found["mean by phase and time since reversal"].endswith("after a reversal")
