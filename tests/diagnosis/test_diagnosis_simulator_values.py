"""Where a model may have slid, and intervals of several numbers, against plain numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator

from sstl_cli.diagnosis.floor import fine_n
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.hypotheses import full
from sstl_cli.diagnosis.shrink import parameter_intervals
from sstl_cli.diagnosis.whitening import Noise, Sensor

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
