"""Slow noise of the input's sensor: found in the input's own readings, and never made of what moves the line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.residuals import leftover
from sstl_cli.steps.diagnose import DiagnoseOptions, run

DT = 0.01
TIME = np.arange(0.0, 48.0, DT)
TURNS = np.cumsum(np.concatenate(([0.0], np.tile([3.0, 1.5, 2.0, 1.0], 8))))
WHITE, SLOW, SLOW_S = 0.008, 0.025, 0.1
ONE = DiagnoseOptions(effects=("viscous",), max_effects=1)


def wander(rng, sd, slow_s=SLOW_S):
    memory = np.exp(-DT / slow_s)
    start = rng.standard_normal()
    return sd * lfilter([1.0], [1.0, -memory], np.sqrt(1.0 - memory**2) * rng.standard_normal(len(TIME)), zi=[memory * start])[0]


def played(u, wrap):
    y = np.empty_like(u)
    last = u[0]
    for k, v in enumerate(u):
        last = y[k] = max(np.exp(-wrap) * v, min(last, np.exp(wrap) * v))
    return y


def recorded(seed, of_sensor, of_line):
    """Return a run of a play; slow noise of the input's sensor, or as much wander of the line's true input."""
    rng = np.random.default_rng(seed)
    levels = rng.uniform(3.0, 25.0, len(TURNS))
    levels[1::2] = levels[0::2][: len(levels[1::2])]
    u = np.interp(TIME, TURNS, levels) + of_line * wander(rng, SLOW)
    y = played(u, 0.5)
    seen = (u + of_sensor * wander(rng, SLOW), y + wander(rng, SLOW))
    return Run(f"r{seed}", "act", TIME, *(x + WHITE * rng.standard_normal(len(TIME)) for x in seen), config_id="a", trajectory=f"m{seed}")


def test_noise_of_the_sensor_is_found_and_leaves_a_white_residual():
    found = gather([recorded(1, 1.0, 0.0), recorded(2, 1.0, 0.0)], ONE)
    for r in found.problem.records:
        assert r.told_n == pytest.approx(SLOW, rel=0.3) and r.told_s == pytest.approx(SLOW_S, rel=0.5)
    base = found.search.base
    left = leftover(found.search.sim, base)
    assert abs(left.chi2 - 1.0) < 0.08 and left.worst().z < 6.0 and abs(left.lag_one) < 0.05
    # and the latent input is the nearer to the true one for it
    clean = recorded(1, 0.0, 0.0)
    truth = clean.tension_in_n  # white noise beside
    plain = prepare(found.runs).records[0]
    near, far = (np.sqrt(np.mean((r.u - truth[: len(r.u)]) ** 2 - WHITE**2)) for r in (found.problem.records[0], plain))
    assert near < 0.9 * far


def swung(seed, slow_s):
    """Return a run of a play whose input swings: nowhere straight, so that its readings alone tell little of slow noise."""
    rng = np.random.default_rng(seed)
    swings = rng.uniform((0.1, 0.0, 1.0), (1.2, 2.0 * np.pi, 3.0), (5, 3))
    u = 14.0 + sum(size * np.sin(2.0 * np.pi * hz * TIME + phase) for hz, phase, size in swings)
    seen = (x + wander(rng, SLOW, slow_s) + WHITE * rng.standard_normal(len(TIME)) for x in (u, played(u, 0.3)))
    return Run(f"r{seed}", "act", TIME, *seen, config_id="a", trajectory=f"m{seed}")


@pytest.mark.parametrize("seed", asked((1, 3), 1))
def test_noise_that_the_readings_take_for_movement_is_found_by_what_it_does_to_the_output(seed):
    found = gather([swung(seed, 0.4), swung(seed + 1, 0.4)], ONE)
    for r in found.problem.records:
        assert r.told_n == pytest.approx(SLOW, rel=0.15) and r.told_s == pytest.approx(0.4, rel=0.3)


@pytest.mark.slow
def test_what_moves_the_line_is_no_noise():
    found = gather([recorded(3, 0.0, 1.0), recorded(4, 0.0, 1.0)], ONE)
    assert all(r.told_n == 0.0 for r in found.problem.records)


def test_a_smooth_input_with_white_noise_is_left_as_it_is():
    found = gather([recorded(5, 0.0, 0.0), recorded(6, 0.0, 0.0)], ONE)
    assert all(r.told_n < 0.3 * SLOW for r in found.problem.records)


def unlike(seed, fastest_hz, slow_s):
    """Return a run of a play whose input swings; the sensor of its output has no slow noise."""
    rng = np.random.default_rng(seed)
    swings = rng.uniform((0.02, 0.0, 1.0), (fastest_hz, 2.0 * np.pi, 3.5), (4, 3))
    u = 14.0 + sum(size * np.sin(2.0 * np.pi * hz * TIME + phase) for hz, phase, size in swings)
    seen = (x + WHITE * rng.standard_normal(len(TIME)) for x in (u + wander(rng, SLOW, slow_s), played(u, 0.5)))
    return Run(f"r{seed}", "act", TIME, *seen, config_id="a", trajectory=f"m{seed}")


# of slow movement the readings tell what is noise, of fast movement the output does
@pytest.mark.parametrize(("seed", "fastest_hz", "slow_s"), asked(((11, 0.4, 0.3), (25, 1.2, 0.4)), (11, 0.4, 0.3), several=True))
def test_noise_of_an_input_whose_output_has_none_is_found_and_nothing_is_missing(seed, fastest_hz, slow_s):
    runs = [unlike(seed, fastest_hz, slow_s), unlike(seed + 1, fastest_hz, slow_s)]
    found = run(runs, DiagnoseOptions(max_effects=1, effects=("viscous", "const_friction", "stribeck")))
    assert found.verdict.status == "none"
    assert all(0.4 * SLOW < r.told_n < 1.5 * SLOW for r in found.evidence.problem.records)
    assert found.evidence.search.noise.output["act"].coloured_n < 0.5 * WHITE


@pytest.mark.slow
def test_a_model_of_such_a_record_says_none_of_it_and_of_its_like():
    runs = [recorded(k, 1.0, 0.0) for k in (7, 8, 9)]
    options = DiagnoseOptions(max_effects=1, effects=("viscous", "const_friction", "channel_lowpass"))
    model = run(runs[:2], options).model()
    for later in (runs[:2], runs[2:]):
        assert run(later, replace(options, sim=model)).verdict.status == "none"
