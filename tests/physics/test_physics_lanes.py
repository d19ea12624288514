"""Vectors of compiled code against the same arithmetic of numpy, lane by lane."""

import numpy as np
import pytest
from numba import njit

from sstl_cli.physics.transmission import lanes
from sstl_cli.physics.transmission.lanes import WIDTH, larger, put, root, row, rows, select, size, some, wide

EPS = np.finfo(float).eps


@njit(error_model="numpy")
def _operate(a, out, any_of):
    x, y = row(a, 0), row(a, 1)
    put(out, 0, x + y)
    put(out, 1, x - 2.0)
    put(out, 2, 3.0 * y)
    put(out, 3, x / y)
    put(out, 4, -x)
    put(out, 5, select(x < y, x, 7.0))
    put(out, 6, select((x >= 0.0) & ~(y > 1.0) | (x == y), wide(1.0), 0.0))
    put(out, 7, select((x <= y) & (x != 0.5), 1.0, y))
    put(out, 8, larger(x, y))
    put(out, 9, size(x))
    put(out, 10, root(size(y)))
    any_of[0], any_of[1] = some(x > 1e3), some(x == y)


@njit(error_model="numpy")
def _exp(a, out):
    for i in range(a.shape[0]):
        put(out, i, lanes.exp(row(a, i)))


@njit(error_model="numpy")
def _log(a, out):
    for i in range(a.shape[0]):
        put(out, i, lanes.log(row(a, i)))


def test_operators_are_those_of_numbers():
    a, out, any_of = rows(2), rows(11), np.zeros(2, np.bool_)
    x = a[0, :] = np.linspace(-2.0, 1.5, WIDTH)
    y = a[1, :] = np.where(np.arange(WIDTH) == 3, x, np.linspace(2.0, -0.7, WIDTH))
    _operate(a, out, any_of)
    expected = [
        x + y, x - 2.0, 3.0 * y, x / y, -x, np.where(x < y, x, 7.0), ((x >= 0.0) & ~(y > 1.0)) | (x == y),
        np.where((x <= y) & (x != 0.5), 1.0, y), np.maximum(x, y), np.abs(x), np.sqrt(np.abs(y)),
    ]  # fmt: skip
    assert (out == np.array(expected)).all() and any_of.tolist() == [False, True]


def test_what_is_no_number_stays_none():
    a, out, any_of = rows(2), rows(11), np.zeros(2, np.bool_)
    a[:] = np.nan
    _operate(a, out, any_of)
    assert np.isnan(out[[0, 1, 2, 3, 4, 8, 9, 10]]).all() and not any_of.any()
    _exp(a, out[:2])
    assert np.isnan(out[:2]).all()


def test_rows_lie_in_one_line_of_the_cache_and_are_empty():
    for count in (1, 3, 128):
        found = rows(count)
        assert found.shape == (count, WIDTH) and not found.any() and found.ctypes.data % (8 * WIDTH) == 0


def test_exp_is_right_to_the_last_places():
    rng = np.random.default_rng(1)
    x = -(10.0 ** rng.uniform(-18.0, 2.83, (2000, WIDTH)))
    x[0], out = 0.0, np.empty_like(x)
    _exp(x, out)
    assert out == pytest.approx(np.exp(x), rel=2.0 * EPS, abs=0.0) and (out[0] == 1.0).all()
    x[:2] = np.array([[-1e6], [-np.inf]])
    _exp(x, out)
    assert (out[:2] < 1e-300).all()


def test_log_is_right_to_the_last_places():
    rng = np.random.default_rng(2)
    x = 10.0 ** rng.uniform(-8.0, 8.0, (2000, WIDTH))
    x[:2], out = np.array([[1.0], [1.0 + 1e-12]]), np.empty_like(x)
    _log(x, out)
    assert (np.abs(out - np.log(x)) <= 2.0 * EPS * np.maximum(np.abs(np.log(x)), 1.0)).all() and (out[0] == 0.0).all()
