"""Where a model may have slid, and intervals of several numbers, against plain numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.floor import fine_n
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.hypotheses import full
from sstl_cli.diagnosis.noise import variance
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.shrink import parameter_intervals
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.white import white_of_output
from sstl_cli.diagnosis.whitening import Noise, Phases, Sensor, step_of
from sstl_cli.physics.scenario import Scenario

SIM = simulator()


def shifted(by):
    """Return what the model makes of inputs that are off by so much (N, shape (samples,))."""
    records = tuple(replace(r, u=r.u + by[s]) for r, s in zip(SIM.problem.records, SIM.slices(), strict=True))
    return replace(SIM, problem=replace(SIM.problem, records=records)).predict(THETA, {})


def test_what_may_have_slid_is_the_bend_of_the_answer_over_the_error_of_the_input():
    error = np.concatenate([r.error_n for r in SIM.problem.records])
    here, high, low = SIM.predict(THETA, {}), shifted(np.sqrt(3.0) * error), shifted(-np.sqrt(3.0) * error)
    bent = np.abs(0.5 * (high + low - 2.0 * here)) / np.sqrt(3.0)
    found = SIM.phases(THETA, {}).doubt_n
    assert found == pytest.approx(np.minimum(bent, 50.0 * error.max()), abs=1e-12) and found.max() > 1e-4


def test_intervals_of_two_numbers_are_the_sandwich_over_blocks_or_that_of_the_noise():
    h = full("zero_offset", ("act",))
    f = made(noise(1) + 0.05 * np.sin(np.arange(len(SIM.y)) / 90.0), h, (0.1, 0.2))
    j = np.zeros((len(SIM.y), 4))
    j[np.arange(len(SIM.y)), SIM.config] = f.jacobian[:, 0]
    j[:, 2:] = f.jacobian[:, 1:]
    a, r = f.whiten(j), f.whiten(f.residual)
    index = blocks(SIM)
    score = np.array([a[index == b].T @ r[index == b] for b in range(index.max() + 1)])
    inverse = np.linalg.inv(a.T @ a)
    wide = np.diag(inverse @ score.T @ score @ inverse) * len(score) / (len(score) - 4)
    reach = 1.96 * np.sqrt(np.maximum(wide, np.diag(inverse)))[2:]
    found = parameter_intervals(SIM, f)
    assert [x.estimate for x in found] == [0.1, 0.2] and wide[3] > np.diag(inverse)[3]
    for x, by in zip(found, reach, strict=True):
        assert (x.high - x.estimate, x.estimate - x.low) == pytest.approx((by, by), rel=1e-3)


def test_noise_above_the_rate_of_the_analysis_is_what_a_mean_of_readings_does_not_hold():
    noise_of = Noise({}, {"act": Sensor(NOISE_N, 0.0, 0.1)}, {})

    def of(*records):
        problem = replace(SIM.problem, records=records)
        return fine_n(type("G", (), {"problem": problem})(), noise_of)

    r = replace(SIM.problem.records[0], readings=np.full(2000, 4.0))
    assert of(r) == pytest.approx(NOISE_N * np.sqrt(0.75)) and of(replace(r, louder=2.0)) == pytest.approx(2.0 * NOISE_N * np.sqrt(0.75))
    # of half of the samples one reading each, of a record of which nothing counts none is above
    half = replace(r, readings=np.where(np.arange(2000) < 1000, 1.0, 4.0))
    assert of(half) == pytest.approx(NOISE_N * np.sqrt(1.0 - 0.625)) and of(replace(r, weight=np.zeros(2000))) == 0.0
    assert of(r, replace(r, readings=np.ones(2000))) == pytest.approx(NOISE_N * np.sqrt(0.375))
    assert of(replace(r, readings=np.full(2000, 0.5))) == 0.0


def twice_as_fast():
    """Return two runs of 20 s at 100 Hz: a sample of the analysis is the mean of two steps of the simulation."""
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(3)
    runs = []
    for i, period in enumerate((7.0, 9.0)):
        u = 12.0 + 9.0 * np.sin(2.0 * np.pi * t / period + i) + 0.01 * rng.standard_normal(len(t))
        runs.append(Run(f"run{i}", "act", t, u, 0.6 * u + 0.01 * rng.standard_normal(len(t)), config_id="ab"[i]))
    return Simulator(prepare(runs), Scenario().rig.mechanics())


def pairs(fine):
    return np.asarray(fine).reshape(-1, 2).mean(axis=1)


def test_samples_are_means_over_steps_of_what_is_simulated():
    fast = twice_as_fast()
    assert [r.factor for r in fast.problem.records] == [2, 2] and len(fast.y) == 2000
    here = np.concatenate(fast.predict_fine(THETA, {}))
    assert fast.predict(THETA, {}) == pytest.approx(pairs(here))

    def fine(by):
        records = tuple(replace(r, u=r.u + by * np.repeat(r.error_n, 2)) for r in fast.problem.records)
        return np.concatenate(replace(fast, problem=replace(fast.problem, records=records)).predict_fine(THETA, {}))

    bent = np.abs(0.5 * (fine(np.sqrt(3.0)) + fine(-np.sqrt(3.0)) - 2.0 * here))
    error = np.concatenate([r.error_n for r in fast.problem.records])
    # a drive that is made anew has its knots elsewhere, by next to nothing
    assert fast.phases(THETA, {}).doubt_n == pytest.approx(np.minimum(pairs(bent) / np.sqrt(3.0), 50.0 * error.max()), rel=0.02, abs=1e-9)


def test_noise_of_such_samples_is_that_of_means_and_lasts_by_their_time():
    records = twice_as_fast().problem.records
    still = Phases(*(np.zeros(2000) for _ in range(4)))
    noise_of = Noise({"act": Sensor(0.01, 0.0, 0.1)}, {"act": Sensor(0.04, 0.03, 0.05)}, {"act": 1.0})
    # 20 ms of noise that lasts 50 ms, of two readings
    assert variance(records, still, noise_of) == pytest.approx(step_of(2.0, 0.02 / 0.05).variance * 0.03**2 + 0.04**2 / 2.0)
    # a rest of samples is one of all their readings
    rests = [np.where(np.arange(1000) < 500, 0.0, 1.0)] * 2
    loud = [
        replace(r, y_fine=np.where(np.arange(2000) < 1000, 5.0, 9.0) + 0.02 * np.random.default_rng(5).standard_normal(2000))
        for r in records
    ]
    rough = [
        replace(r, y_fine=r.y_fine + np.where(np.arange(2000) < 1000, 0.0, 1.0) * np.random.default_rng(6).standard_normal(2000))
        for r in loud
    ]
    assert white_of_output(list(zip(rough, rests, strict=True)))[0] == pytest.approx(0.02, rel=0.1)
