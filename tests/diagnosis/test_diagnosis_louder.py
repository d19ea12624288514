"""Noise that differs from run to run: by how much, how surely, and what of it differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import SHORT, record

from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.louder import _shrunk, unalike
from sstl_cli.diagnosis.noise import measured, variance
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.whitening import Noise, Phases, Sensor
from tests.diagnosis.made_windows import coloured


@pytest.fixture(scope="module")
def resting():
    """Records that hold all the time: noise alone, white and slow, as loud in all of them."""
    rng = np.random.default_rng(12)
    found = []
    for r in prepare(record({}, moves=SHORT, configs=3), 1.0).records:
        slow = coloured(rng, len(r), r.dt_s * r.factor, 0.02, 0.4)
        found.append(replace(r, y=0.02 / np.sqrt(r.factor) * rng.standard_normal(len(r)) + slow, weight=np.ones(len(r))))
    return found


def _asked(records):
    return unalike(records, [np.zeros(len(r) * r.factor) for r in records], [np.zeros(len(r)) for r in records])


def test_runs_as_loud_as_one_another_are_equally_loud(resting):
    assert all(r.louder == pytest.approx(1.0, abs=0.05) for r in _asked(resting))


def test_louder_runs_are_found_with_their_slow_noise_or_without(resting):
    loud = [3.0 if i % 3 == 0 else 1.0 for i in range(len(resting))]
    rng = np.random.default_rng(13)
    both = _asked([replace(r, y=k * r.y) for r, k in zip(resting, loud, strict=True)])
    more = [np.sqrt((k**2 - 1.0) / r.factor) * 0.02 for r, k in zip(resting, loud, strict=True)]
    white = _asked([replace(r, y=r.y + s * rng.standard_normal(len(r))) for r, s in zip(resting, more, strict=True)])
    for found in (both, white):
        assert [r.louder for r in found] == pytest.approx(loud, rel=0.15)
    assert [r.slower for r in both] == [r.louder for r in both] and all(r.slower == 1.0 for r in white)


def test_a_run_that_does_not_hold_is_as_loud_as_the_rest(resting):
    records = [replace(resting[0], y=5.0 * resting[0].y), *resting[1:]]
    slides = [np.full(len(r), float(i == 0)) for i, r in enumerate(records)]
    found = unalike(records, [np.zeros(len(r) * r.factor) for r in records], slides)
    assert found[0].louder == found[0].slower == 1.0


def test_what_arithmetic_leaves_of_records_without_noise_tells_nothing(resting):
    """One of two outputs that never change was louder than the other by a factor of 1e295."""
    still = [replace(r, raw=replace(r.raw, tension_out_n=np.full(len(r.raw), 5.0))) for r in resting]
    quiet = [
        replace(r, y=np.zeros(len(r)) if i else 1e-13 * r.y, faults_out=replace(r.faults_out, step_n=0.0)) for i, r in enumerate(still)
    ]
    assert [r.louder for r in _asked(quiet)] == [1.0] * len(quiet)


def test_what_differs_by_no_more_than_its_error_does_not_differ():
    values = np.array([0.05, -0.03, 0.01, -0.02])
    assert _shrunk(values, np.full(4, 0.05)).tolist() == [0.0] * 4 and _shrunk(values[:1], np.array([0.05])).tolist() == [0.0]
    # 0.5 apart and known to 0.05: the variance between is that of the values less that of their errors (by hand)
    far = np.array([0.0, 0.5])
    between = (0.25 / 2.0 / 0.05**2 - 1.0) / (2.0 / 0.05**2 - 1.0 / 0.05**2)
    assert _shrunk(far, np.full(2, 0.05)) == pytest.approx(between / (between + 0.05**2) * (far - 0.25))


def test_a_louder_run_has_more_noise_in_its_likelihood(resting):
    r = resting[0]
    noise = Noise({r.system: Sensor(0.02, 0.01, 0.4)}, {r.system: Sensor(0.03, 0.02, 0.4)}, {r.system: 1.0})
    loud = replace(r, louder=2.0, slower=3.0)
    plain, more = (constants([x], noise) for x in (r, loud))
    assert more.white_n == pytest.approx(2.0 * plain.white_n)
    assert more.own.columns[:, [1, 3, 4]] == pytest.approx(9.0 * plain.own.columns[:, [1, 3, 4]])
    assert more.own.columns[:, [0, 2]] == pytest.approx(plain.own.columns[:, [0, 2]])
    held = Phases(*np.zeros((4, len(r))))
    white, slow = (
        variance([replace(r, louder=a, slower=b)], held, noise) - variance([r], held, noise) for a, b in ((2.0, 1.0), (1.0, 2.0))
    )
    assert variance([loud], held, noise) - variance([r], held, noise) == pytest.approx(white + 8.0 / 3.0 * slow)
    assert measured([loud], np.zeros(len(r))).output[r.system].white_n < measured([r], np.zeros(len(r))).output[r.system].white_n
