"""Pieces of what a model is known to leave: the map, its scatter and how likely they are, by dense linear algebra."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import simulator
from scipy.stats import multivariate_normal

from sstl_cli.diagnosis import discrepancy
from sstl_cli.diagnosis.constants import MAP_SIZES, QUIETEST, SPREAD, UNSEEN_SHARE
from sstl_cli.diagnosis.whitening import Phases, white

N, NOISE_N = 120, 0.1
RNG = np.random.default_rng(40)
DESIGN = RNG.standard_normal((N, 4))
PRIOR = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.8, 0.0, 0.0], [0.0, 0.3, 0.9, 0.0], [0.1, 0.0, 0.2, 0.9]])
KEEP = np.arange(N) % 10 > 0
STILL = Phases(*(np.zeros(N) for _ in range(4)))


def mapped(residual, keep=KEEP, design=DESIGN, expected=NOISE_N**2, records=()):
    return discrepancy._Map(records, design, keep, residual, np.broadcast_to(expected, len(residual)), STILL, None, PRIOR)


def test_a_map_is_as_likely_as_its_dense_covariance_says_and_its_size_the_likeliest_one():
    columns = DESIGN @ PRIOR
    residual = columns @ [0.3, -0.2, 0.1, 0.25] + NOISE_N * RNG.standard_normal(N)
    m, whiten = mapped(residual), white(NOISE_N, KEEP.astype(float), [0])
    # a tail of as good as none is the normal
    found = discrepancy._posterior(m, whiten, columns, 1e9)
    c, r = columns[KEEP], residual[KEEP]
    sizes = MAP_SIZES * np.sqrt(np.mean(r**2))

    def cost(size):
        cov = NOISE_N**2 * np.eye(len(r)) + size**2 * c @ c.T
        return -multivariate_normal(np.zeros(len(r)), cov).logpdf(r) - 0.5 * len(r) * np.log(2.0 * np.pi)

    costs = [cost(s) for s in sizes]
    assert found.size_n == pytest.approx(sizes[int(np.argmin(costs))]) and found.cost == pytest.approx(min(costs), rel=1e-4)
    inverse = np.linalg.inv(NOISE_N**2 * np.eye(len(r)) + found.size_n**2 * c @ c.T)
    assert found.mean == pytest.approx(found.size_n**2 * c.T @ inverse @ r, rel=1e-4)
    known = found.size_n**2 * (np.eye(4) - found.size_n**2 * c.T @ inverse @ c)
    assert found.factor @ found.factor.T == pytest.approx(known, rel=1e-4, abs=1e-9)
    # of noise alone nothing is mapped
    none = discrepancy._posterior(mapped(NOISE_N * RNG.standard_normal(N)), whiten, columns, 1e9)
    assert none.size_n < 0.05 and np.abs(none.mean).max() < 0.05


def test_a_heavy_tail_takes_jerks_for_jerks_and_not_for_the_map():
    columns = DESIGN @ PRIOR
    jerk = np.where(np.arange(N) % 30 == 7, 40.0 * NOISE_N, 0.0)
    truth = np.array([0.3, -0.2, 0.1, 0.25])
    m, whiten = mapped(columns @ truth + NOISE_N * RNG.standard_normal(N) + jerk), white(NOISE_N, KEEP.astype(float), [0])
    normal, heavy = (discrepancy._posterior(m, whiten, columns, tail) for tail in (1e9, 3.0))
    assert np.abs(heavy.mean - truth).max() < 0.05 < np.abs(normal.mean - truth).max() and heavy.cost < normal.cost - 100.0


def test_a_first_map_is_the_ridge_of_unit_noise():
    residual = RNG.standard_normal(N)
    columns = DESIGN @ PRIOR
    c, r = columns[KEEP], residual[KEEP]
    expected = columns @ np.linalg.solve(c.T @ c + np.eye(4), c.T @ r)
    assert discrepancy._rough(mapped(residual)) == pytest.approx(expected)


def test_the_scatter_begins_as_what_there_is_beyond_noise():
    squares = np.where(KEEP, 0.25, 99.0)
    assert discrepancy._usual(mapped(np.zeros(N), expected=0.09), squares) == pytest.approx(0.4)
    # less than the noise is not known to be nothing
    assert discrepancy._usual(mapped(np.zeros(N), expected=0.36), squares) == pytest.approx(np.sqrt(UNSEEN_SHARE * 0.36))


@pytest.mark.parametrize("memory", [0.2, 1.0, 3.0])
def test_places_are_as_loud_as_their_samples_and_drawn_to_the_usual_by_few_of_them(memory):
    design = np.eye(2)[np.arange(N) % 2]
    loud, quiet = (np.count_nonzero(KEEP & (np.arange(N) % 2 == i)) for i in (0, 1))
    beyond = np.where(np.arange(N) % 2 == 0, 3.0, 1.0)
    usual = (3.0 * loud + quiet) / (loud + quiet)
    found = discrepancy._places(mapped(np.zeros(N), design=design), beyond, memory)
    # independent samples count against so many that are usual; those alike over several count once
    own = SPREAD * max(memory, 1.0)
    expected = [1.0 + n * (v / usual - 1.0) / (n + own) for n, v in ((loud, 3.0), (quiet, 1.0))]
    assert found == pytest.approx(np.sqrt(expected)) and found[0] > 1.0 > found[1]


def test_a_place_is_never_quite_still_and_without_scatter_all_are_alike():
    design = np.eye(2)[np.arange(N) % 2]
    beyond = np.where(np.arange(N) % 2 == 0, 30.0, -29.0)
    assert discrepancy._places(mapped(np.zeros(N), np.ones(N, bool), design), beyond, 1.0)[1] == pytest.approx(np.sqrt(QUIETEST))
    assert discrepancy._places(mapped(np.zeros(N), design=design), np.full(N, -1.0), 1.0).tolist() == [1.0, 1.0]
    assert discrepancy._places(mapped(np.zeros(N), design=design), np.zeros(N), 1.0).tolist() == [1.0, 1.0]


def test_knots_are_as_far_apart_as_they_are_and_one_is_a_unit():
    assert discrepancy._knots_apart(np.array([2.0, 5.0, 8.0])) == 3.0 and discrepancy._knots_apart(np.array([2.0])) == 1.0


def test_the_fastest_rate_of_either_way_is_that_of_means_over_a_sample():
    records = [SimpleNamespace(rate=np.array(v), factor=2) for v in ([1.0, 3.0, -8.0, -2.0], [5.0, -9.0, 0.0, 0.0])]
    # what goes the other way counts as none
    assert discrepancy._fastest(records, 1.0) == 2.5 and discrepancy._fastest(records, -1.0) == 5.0


def test_few_columns_say_all_but_a_hundredth_of_a_covariance():
    # singular values whose squares are 90, 9.1 and 0.9: two say 99.1 %
    axes = np.linalg.qr(RNG.standard_normal((6, 3)))[0]
    factor = axes * np.sqrt([90.0, 9.1, 0.9])
    assert discrepancy._short(factor).shape == (6, 2) and discrepancy._short(axes * np.sqrt([90.0, 8.9, 1.1])).shape == (6, 3)
    short = discrepancy._short(factor)
    assert short @ short.T == pytest.approx(factor[:, :2] @ factor[:, :2].T, abs=1e-9)


def test_a_residual_is_like_itself_within_its_own_runs():
    # every run alternates by its own sign: what is alike across the border between two is no memory
    records = [replace(r, y=r.y[:40]) for r in simulator().problem.records[:2]]
    m = mapped(np.zeros(80), np.ones(80, bool), records=records)
    # triangles of correlation: blocks of four are alike by 3/4, 2/4, 1/4
    block = np.tile(np.repeat([1.0, -1.0], 4), 10)
    lags = [float(np.sum([x[k:] @ x[:-k] for x in np.split(block, 2)])) / 80.0 for k in range(1, 11)]
    expected = next(k for k, c in enumerate(lags, 1) if c <= np.exp(-1.0))
    assert discrepancy._memory(m, block) == expected == 2
    # no more than a quarter of the longest run, and what is masked does not count
    assert (
        discrepancy._memory(m, np.ones(80)) == 10.0
        and discrepancy._memory(mapped(block, np.zeros(80, bool), records=records), block) == 1.0
    )
