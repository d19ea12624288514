"""Noise that differs from run to run: by how much, how surely, and what of it differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import simulator
from rig_logs import SHORT, record

from sstl_cli.diagnosis import louder
from sstl_cli.diagnosis.constants import MIN_READINGS, WHITE
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.louder import _shrunk, unalike
from sstl_cli.diagnosis.noise import measured, variance
from sstl_cli.diagnosis.recorder import THIRDS_ERROR
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


def test_values_that_are_known_alike_are_drawn_to_their_middle_by_what_they_differ_beyond_their_error():
    values = np.array([0.1, 0.5, -0.3, 0.9, 0.2])
    # with equal errors the variance between them is that of the values less that of an error
    error = 0.2
    between = np.var(values, ddof=1) - error**2
    found = louder._shrunk(values, np.full(5, error))
    assert found == pytest.approx(between / (between + error**2) * (values - 0.2))
    # less than one error apart they do not differ, and one alone has nothing to differ from
    assert not louder._shrunk(values, np.full(5, 0.6)).any() and louder._shrunk(values[:1], np.array([0.1])).tolist() == [0.0]
    assert louder._shrunk(values[:2], np.array([0.01, 0.01])) == pytest.approx([-0.2, 0.2], rel=0.01)


def test_values_that_are_known_less_well_are_drawn_further():
    values, errors = np.array([1.0, -1.0, 0.0, 0.0]), np.array([0.1, 0.1, 0.1, 2.0])
    weight = 1.0 / errors**2
    mean = np.average(values, weights=weight)
    # DerSimonian and Laird: the excess of the weighted scatter over its degrees of freedom, in units of the weights
    scatter = np.sum(weight * (values - mean) ** 2) - 3.0
    between = scatter / (np.sum(weight) - np.sum(weight**2) / np.sum(weight))
    found = louder._shrunk(values, errors)
    assert found == pytest.approx(between / (between + errors**2) * values)
    assert found[0] > 0.9 and louder._shrunk(np.array([1.0, -1.0, 0.0, 3.0]), errors)[3] < 1.0


@pytest.mark.parametrize("readings", [1.0, 4.0])
def test_the_noise_of_a_run_is_seen_where_it_holds_and_known_as_well_as_its_samples_say(readings):
    r = simulator().problem.records[0]
    rng = np.random.default_rng(21)
    held = np.arange(2000) < 1200
    left = np.where(held, 0.03, 0.5) * rng.standard_normal(2000)
    still = replace(r, y=r.y_smooth[:2000] + left, readings=np.full(2000, readings))
    slide = np.where(held, 0.0, 1.0)
    log_n, error = louder._seen(still, r.y_smooth[:2000], slide, 0.0)
    # a sample is the mean of so many readings
    assert np.exp(log_n) == pytest.approx(0.03 * np.sqrt(readings), rel=0.1)
    assert error == pytest.approx(np.hypot(WHITE, THIRDS_ERROR / np.sqrt(1197)))
    # no less than what the converter and the grid make; and too few samples tell nothing
    assert louder._seen(still, r.y_smooth[:2000], slide, 0.7)[0] == pytest.approx(np.log(0.7))
    for count, told in ((MIN_READINGS + 3, True), (MIN_READINGS + 2, False)):
        few = np.where(np.arange(2000) < count, 0.0, 1.0)
        assert np.isfinite(louder._seen(still, r.y_smooth[:2000], few, 0.0)[1]) == told
    blind = replace(still, weight=np.zeros(2000))
    assert louder._seen(blind, r.y_smooth[:2000], slide, 0.0) == (0.0, float("inf"))
