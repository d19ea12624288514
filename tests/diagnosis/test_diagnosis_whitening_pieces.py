"""What the noise of records is whatever the model does: scatter of an accepted model, readings of a step, starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import simulator
from scipy.linalg import toeplitz

from sstl_cli.diagnosis.laid import coloured, constants
from sstl_cli.diagnosis.records import Start
from sstl_cli.diagnosis.smoother import MOVES
from sstl_cli.diagnosis.whitening import Noise, Sensor, step_of, white

RECORDS = simulator().problem.records[:2]
OUT = Sensor(0.02, 0.03, 0.1)
NOISE = Noise({"act": Sensor(0.01, 0.004, 0.2)}, {"act": OUT}, {"act": 2.0})
SPREAD = 0.3 + 0.2 * np.sin(np.arange(2000) / 50.0)


def scattered(r, **more):
    return replace(r, misfit_n=SPREAD, misfit_s=1.5, **more)


@pytest.mark.parametrize(("readings", "length"), [(1, 0.2), (5, 0.4), (40, 3.0)])
def test_the_mean_of_a_step_is_that_of_its_readings(readings, length):
    step = step_of(readings, length)
    one = np.exp(-length / readings)
    cov = toeplitz(one ** np.arange(2 * readings))
    first, second = np.repeat([1.0, 0.0], readings) / readings, np.repeat([0.0, 1.0], readings) / readings
    assert step.kept == pytest.approx(np.exp(-length)) and step.variance == pytest.approx(second @ cov @ second)
    assert step.lasting == pytest.approx(first @ cov @ second)


def test_scatter_and_slow_noise_are_one_state_as_slow_as_they_are_together():
    slow, total = coloured(scattered(RECORDS[0]), OUT)
    share = SPREAD**2 / (SPREAD**2 + 0.03**2)
    assert total == pytest.approx(np.hypot(SPREAD, 0.03)) and slow == pytest.approx(1.5**share * 0.1 ** (1.0 - share))
    plain = coloured(RECORDS[0], OUT)
    assert set(plain[0]) == {0.1} and set(plain[1]) == {0.03}


def test_the_scatter_is_as_large_at_every_sample_as_it_is_known_to_be():
    r = scattered(RECORDS[0], again=(Start(700, 9.0, 0.1),))
    c = constants([r, RECORDS[1]], NOISE)
    slow, total = coloured(r, OUT)
    power = 0.0
    for k in range(700):
        power = c.own.decay[k] ** 2 * power + c.own.fresh[k]
        assert power == pytest.approx(total[k] ** 2)
    inner = np.delete(np.arange(1, 2000), 699)
    assert c.own.decay[inner] == pytest.approx(np.exp(-0.02 / slow[inner]) * total[inner] / total[inner - 1])
    for at, error in ((0, r.start_error_n), (700, 0.1)):
        begin = 0.03**2 + SPREAD[at] ** 2
        assert c.own.decay[at] == 0.0 and c.own.fresh[at] == pytest.approx(begin) and c.start[at] == pytest.approx(error**2 + begin)
    # a record without scatter begins with the slow noise alone
    assert c.start[2000] == pytest.approx(RECORDS[1].start_error_n ** 2 + 0.03**2) and np.flatnonzero(c.first).tolist() == [0, 700, 2000]
    assert np.count_nonzero(c.start) == 3 and c.own.fresh[2000] == pytest.approx(0.03**2) and c.own.mean[2000] == pytest.approx(0.03**2)


def test_white_noise_is_that_of_a_mean_and_what_the_input_is_off_by_as_stated_times_the_smoother_s():
    several = replace(RECORDS[0], readings=np.repeat([1.0, 4.0], 1000))
    c = constants([several], NOISE)
    assert set(np.round(c.white_n, 9)) == {0.02, 0.01} and c.keep.all() and c.wander is None
    assert np.array_equal(c.moves, c.error_law[:, :MOVES])
    told = constants([replace(several, told_n=0.1)], NOISE)
    assert told.error_law[:, MOVES:] == pytest.approx(4.0 * several.error_law[:, MOVES:]) and np.array_equal(
        told.error_law[:, :MOVES], several.error_law[:, :MOVES]
    )
    # not told of it, the slow noise of the input's sensor is the last of the error's numbers: one reading a step
    kept = np.exp(-0.02 / 0.2)
    assert c.error_law[1:, 15] == pytest.approx(kept) and c.error_law[1:, 19] == pytest.approx(kept) and c.error_law[0, 15] == 0.0
    fresh = 0.004**2 * (1.0 - kept**2)
    assert (
        c.error_law[1:, 29] == pytest.approx(fresh)
        and c.error_law[1:, 33] == pytest.approx(fresh)
        and c.error_law[0, 29] == pytest.approx(0.004**2)
    )
    assert c.error_law[1:, 34] - told.error_law[1:, 34] == pytest.approx(fresh)


def test_independent_noise_of_one_size_is_divided_by_it_where_something_is_known():
    keep = np.array([1.0, 0.0, 1.0, 1.0])
    w = white(0.5, keep, [0, 2])
    assert w(np.array([1.0, 2.0, 3.0, 4.0])).tolist() == [2.0, 0.0, 6.0, 8.0] and w.first.tolist() == [True, False, True, False]
    assert w(np.ones((4, 2))).tolist() == [[2.0, 2.0], [0.0, 0.0], [2.0, 2.0], [2.0, 2.0]] and w.log_det == pytest.approx(6.0 * np.log(0.5))
