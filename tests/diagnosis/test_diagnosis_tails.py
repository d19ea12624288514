"""Heavy tails against the density of SciPy, and the bound that makes a fit with them a chain of linear ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, t

from sstl_cli.diagnosis import tails
from sstl_cli.diagnosis.whitening import white

Z = np.linspace(-9.0, 9.0, 37)


@pytest.mark.parametrize("tail", [0.8, 3.0, 40.0])
def test_nats_are_those_of_student_s_density_beside_a_gaussian_s(tail):
    assert tails.nats(Z, tail) == pytest.approx(-t.logpdf(Z, tail) + norm.logpdf(0.0))


def test_a_tail_of_many_degrees_of_freedom_is_gaussian():
    assert tails.nats(Z, 1e7) == pytest.approx(0.5 * Z**2, abs=1e-3) and tails.trust(Z, 1e7) == pytest.approx(np.ones(37), abs=1e-4)


def test_the_cost_given_precisions_touches_the_true_one_and_is_nowhere_less():
    plain = white(0.5, np.where(np.arange(37) == 5, 0.0, 1.0), [0])
    tail = np.full(37, 3.0)
    residual = 0.5 * Z
    heavy = plain.trusting(residual, tail)

    def by(whiten, r):
        return 0.5 * float(np.sum(whiten(r) ** 2)) + 0.5 * whiten.log_det

    def true(r):
        return float(np.sum(np.delete(tails.nats(plain(r), 3.0), 5))) + 0.5 * plain.log_det

    assert by(heavy, residual) == pytest.approx(true(residual))
    rng = np.random.default_rng(1)
    for r in residual + rng.standard_normal((20, 37)):
        assert by(heavy, r) >= true(r) - 1e-9
    # what is Gaussian stays as it is
    sure = plain.trusting(residual, np.full(37, np.inf))
    assert by(sure, residual) == pytest.approx(by(plain, residual)) and np.all(sure.trust == 1.0)


def test_the_variance_is_that_of_student_s_distribution_and_finite_for_any():
    for tail in (3.0, 5.5, 40.0):
        assert tails.variance(tail) == pytest.approx(t.var(tail))
    assert tails.variance(float("inf")) == 1.0 and tails.variance(0.8) == tails.variance(3.0)
