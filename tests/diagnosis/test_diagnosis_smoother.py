"""Kernels of the latent input against dense linear algebra of all states at once."""

from __future__ import annotations

import numpy as np
import pytest
from made_chain import posterior

from sstl_cli.diagnosis.smoother import DIFFUSE, chain, cost, error_of_means, follow

N, R = 40, 0.01
RNG = np.random.default_rng(0)
CORNERS, BENDS = 10.0 ** RNG.uniform(-6.0, -2.0, N), 10.0 ** RNG.uniform(-6.0, -3.0, N)
KNOWN, Y = RNG.random(N) > 0.1, RNG.standard_normal(N)


def covariance(law):
    """Covariance of the values of a chain, from its transitions."""
    n = len(law)
    found, now, ahead = np.zeros((n, n)), np.zeros((3, 3)), np.zeros((n, 3))
    for k in range(n):
        move, v = law[k, :9].reshape(3, 3), law[k, 9:]
        now = move @ now @ move.T + np.array([[v[0], v[1], v[2]], [v[1], v[3], v[4]], [v[2], v[4], v[5]]])
        ahead[:k], ahead[k] = ahead[:k] @ move.T, now[0]
        found[k, : k + 1] = found[: k + 1, k] = ahead[: k + 1, 0]
    return found


def test_the_chain_is_the_posterior_of_all_states():
    law, drive = chain(Y, KNOWN, R, CORNERS, BENDS)
    mean, variance, _ = follow(law, drive)
    dense_mean, dense = posterior(KNOWN, R, CORNERS, BENDS, Y)
    assert mean[:, 0] == pytest.approx(dense_mean, abs=1e-9)
    assert variance == pytest.approx(np.diag(dense), rel=1e-9)
    assert covariance(law) == pytest.approx(dense, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("factor", [1, 4, 7])
def test_the_error_of_means_is_that_of_averaged_states(factor):
    law, _ = chain(Y, KNOWN, R, CORNERS, BENDS)
    blocks = N // factor
    means = np.kron(np.eye(blocks), np.full((1, factor), 1.0 / factor))
    dense = means @ posterior(KNOWN, R, CORNERS, BENDS)[1][: blocks * factor, : blocks * factor] @ means.T
    moves, sd = error_of_means(law, factor)
    assert sd**2 == pytest.approx(np.diag(dense), rel=1e-9)
    # covariance of a mean with the next one: through the state between them
    state, first = np.zeros((3, 3)), None
    for k, row in enumerate(moves[:2]):
        move, c, v = row[:9].reshape(3, 3), row[9:12], row[12:18]
        if k == 1:
            assert c @ first == pytest.approx(dense[0, 1], rel=1e-8)
        first = move @ state @ c + row[18:21]
        state = move @ state @ move.T + np.array([[v[0], v[1], v[2]], [v[1], v[3], v[4]], [v[2], v[4], v[5]]])


def test_the_cost_is_the_dense_likelihood_of_the_readings():
    few = slice(0, 8)
    known = np.ones(8, bool)

    def dense(r):
        # covariance of the readings: that of the states without them, and noise
        prior = posterior(~known, r, CORNERS[few], BENDS[few])[1] + r * np.eye(8)
        return 0.5 * Y[few] @ np.linalg.solve(prior, Y[few]) + 0.5 * np.linalg.slogdet(prior)[1]

    # a prior a million times as wide as a reading costs the dense matrix some digits
    for r in (0.01, 0.03):
        assert cost(Y[few], known, r, CORNERS[few], BENDS[few]) == pytest.approx(dense(r), abs=1e-2)
    assert cost(Y[:1], np.ones(1, bool), R, CORNERS, BENDS) == pytest.approx(
        0.5 * Y[0] ** 2 / (R * (1.0 + DIFFUSE)) + 0.5 * np.log(R * (1.0 + DIFFUSE))
    )


def test_a_straight_line_has_no_steps_and_a_corner_one():
    y = np.abs(np.arange(21.0) - 10.0)
    flat = np.full(21, 1e-12)
    corners = flat.copy()
    corners[11] = 4.0
    law, drive = chain(y - y[0], np.ones(21, bool), 1e-6, corners, flat)
    mean, _, steps = follow(law, drive)
    assert mean[:, 0] + y[0] == pytest.approx(y, abs=1e-2)
    assert steps[11, 0] == pytest.approx(4.0, rel=0.05) and np.delete(steps[:, 0], 11).max() < 1e-3
