"""Kernels of the latent input against dense linear algebra of all states at once."""

from __future__ import annotations

import numpy as np
import pytest
from made_chain import pairs, posterior, states
from scipy.signal import lfilter

from sstl_cli.diagnosis.smoother import DIFFUSE, MOVES, PAIRS, STATES, Reading, chain, costs, error_of_means, follow
from sstl_cli.diagnosis.tries import TOGETHER, costs_of

N, R = 40, 0.01
RNG = np.random.default_rng(0)
CORNERS, BENDS = 10.0 ** RNG.uniform(-6.0, -2.0, N), 10.0 ** RNG.uniform(-6.0, -3.0, N)
KNOWN, Y = RNG.random(N) > 0.1, RNG.standard_normal(N)


NOISES = pytest.mark.parametrize("noise", [Reading(R), Reading(R, 0.02, 0.9), Reading(R, 1e-4, 0.3)], ids=["white", "slow", "faint"])


def covariance(law):
    """Covariance of the values of a chain, from its transitions."""
    n, m = len(law), STATES
    found, now, ahead = np.zeros((n, n)), np.zeros((m, m)), np.zeros((n, m))
    for k in range(n):
        move = law[k, : m * m].reshape(m, m)
        now = move @ now @ move.T + pairs(law[k, m * m :])
        ahead[:k], ahead[k] = ahead[:k] @ move.T, now[0]
        found[k, : k + 1] = found[: k + 1, k] = ahead[: k + 1, 0]
    return found


@NOISES
def test_the_chain_is_the_posterior_of_all_states(noise):
    law, drive = chain(Y, KNOWN, noise, CORNERS, BENDS)
    mean, variance, _ = follow(law, drive)
    dense_mean, dense = posterior(KNOWN, noise, CORNERS, BENDS, Y)
    assert mean[:, 0] == pytest.approx(dense_mean, abs=1e-8)
    assert variance == pytest.approx(np.diag(dense), rel=1e-8)
    assert covariance(law) == pytest.approx(dense, rel=1e-7, abs=1e-11)


@NOISES
def test_states_and_squared_steps_are_those_of_the_posterior(noise):
    mean, _, steps = follow(*chain(Y, KNOWN, noise, CORNERS, BENDS))
    dense, whole, m = states(KNOWN, noise, CORNERS, BENDS, Y)
    assert mean[:, :m] == pytest.approx(dense.reshape(N, m), abs=1e-8)
    for k in range(1, N):
        # of the increment beyond the change before, and of that change
        turn, bend = np.zeros(m * N), np.zeros(m * N)
        turn[m * k + 1], turn[m * k - m + 1], turn[m * k - m + 2] = 1.0, -1.0, -1.0
        bend[m * k + 2], bend[m * k - m + 2] = 1.0, -1.0
        for i, step in enumerate((turn, bend)):
            assert steps[k, 2 * i] == pytest.approx((step @ dense) ** 2, rel=1e-4, abs=1e-12)
            assert steps[k, 2 * i + 1] == pytest.approx(step @ whole @ step, rel=1e-4, abs=1e-12)
    assert np.array_equal(steps[0], steps[1])


@NOISES
@pytest.mark.parametrize("factor", [1, 4, 7])
def test_the_error_of_means_is_that_of_averaged_states(factor, noise):
    law, _ = chain(Y, KNOWN, noise, CORNERS, BENDS)
    blocks = N // factor
    means = np.kron(np.eye(blocks), np.full((1, factor), 1.0 / factor))
    dense = means @ posterior(KNOWN, noise, CORNERS, BENDS)[1][: blocks * factor, : blocks * factor] @ means.T
    moves, sd = error_of_means(law, factor)
    assert sd**2 == pytest.approx(np.diag(dense), rel=1e-8)
    # the end of a block less its mean
    apart = np.kron(np.eye(blocks), np.eye(factor)[-1:]) - means
    differ = apart @ posterior(KNOWN, noise, CORNERS, BENDS)[1][: blocks * factor, : blocks * factor] @ apart.T
    assert moves[:, -1] == pytest.approx(np.diag(differ), rel=1e-6, abs=1e-12)
    # covariance of a mean with the next one: through the state between them
    m = STATES
    state, first = np.zeros((m, m)), None
    for k, row in enumerate(moves[:2]):
        move, c, new = row[: m * m].reshape(m, m), row[m * m : MOVES], pairs(row[MOVES : MOVES + PAIRS])
        if k == 1:
            assert c @ first == pytest.approx(dense[0, 1], rel=1e-8)
        first = move @ state @ c + row[MOVES + PAIRS : -2]
        state = move @ state @ move.T + new


@pytest.mark.parametrize("sd", [0.0, 0.15])
def test_slow_noise_is_told_from_the_signal(sd):
    rng = np.random.default_rng(3)
    n, memory, white = 3000, 0.99, 0.05
    x = 0.002 * np.abs(np.arange(n) % 1000 - 500.0)
    c = lfilter([1.0], [1.0, -memory], sd * np.sqrt(1.0 - memory**2) * rng.standard_normal(n))
    y, steps = x + c + white * rng.standard_normal(n), (np.full(n, 1e-16), np.full(n, 1e-18))
    steps[0][500::500] = 1e-5
    use, told = np.ones(n, bool), Reading(white**2, sd**2, memory)
    mean, variance, _ = follow(*chain(y - y[0], use, told, *steps))
    off = mean[:, 0] + y[0] - x
    assert np.sqrt(np.mean(off**2)) < 0.6 * np.hypot(sd, white)
    # the error is as large as it is said to be, which it is not for a smoother that takes all noise for white
    assert 0.5 < np.mean(off**2 / variance) < 2.0
    if sd:
        other, claimed, _ = follow(*chain(y - y[0], use, Reading(white**2), *steps))
        assert np.mean((other[:, 0] + y[0] - x) ** 2 / claimed) > 10.0


@NOISES
def test_what_stands_still_is_known_to_make_no_step(noise):
    rest = np.zeros(N, bool)
    rest[12:25] = True
    law, drive = chain(Y, KNOWN, noise, CORNERS, BENDS, rest)
    mean, variance, _ = follow(law, drive)
    dense_mean, dense = posterior(KNOWN, noise, CORNERS, BENDS, Y, rest)
    assert mean[:, 0] == pytest.approx(dense_mean, abs=1e-6)
    assert variance == pytest.approx(np.diag(dense), rel=1e-5)
    assert np.abs(mean[rest, 1]).max() < 2e-3 * np.sqrt(noise.white)
    # the cost is that of the readings alone: about that of a level (how it began to curve is open for one sample)
    few, none = slice(12, 24), np.zeros(12)
    got = costs(Y[few], KNOWN[few], noise, none, none, rest[few])
    y, at = Y[few][KNOWN[few]], np.flatnonzero(KNOWN[few])
    level = DIFFUSE * noise.white * np.ones((len(y), len(y))) + noise.white * np.eye(len(y))
    level += noise.slow * noise.memory ** np.abs(np.subtract.outer(at, at))
    assert got.sum() == pytest.approx(0.5 * y @ np.linalg.solve(level, y) + 0.5 * np.linalg.slogdet(level)[1], abs=0.2)


def test_the_cost_is_the_dense_likelihood_of_the_readings():
    few = slice(0, 8)
    known = np.ones(8, bool)

    def dense(r):
        # covariance of the readings: that of the states without them, and noise
        lag = np.abs(np.subtract.outer(np.arange(8), np.arange(8)))
        prior = posterior(~known, r._replace(slow=0.0), CORNERS[few], BENDS[few])[1] + r.white * np.eye(8) + r.slow * r.memory**lag
        return 0.5 * Y[few] @ np.linalg.solve(prior, Y[few]) + 0.5 * np.linalg.slogdet(prior)[1]

    # a prior a million times as wide as a reading costs the dense matrix some digits
    for r in (Reading(0.01), Reading(0.03), Reading(0.01, 0.02, 0.8)):
        assert costs(Y[few], known, r, CORNERS[few], BENDS[few]).sum() == pytest.approx(dense(r), abs=1e-2)
    assert costs(Y[:1], np.ones(1, bool), Reading(R), CORNERS, BENDS).sum() == pytest.approx(
        0.5 * Y[0] ** 2 / (R * (1.0 + DIFFUSE)) + 0.5 * np.log(R * (1.0 + DIFFUSE))
    )


@pytest.mark.parametrize("n", [1, TOGETHER, TOGETHER + 1, 500])
@pytest.mark.parametrize("noise", [Reading(R), Reading(1e-10, 2e-10, 0.9)], ids=["white", "slow, and very small"])
def test_costs_side_by_side_are_those_one_after_the_other(n, noise):
    rng = np.random.default_rng(n)
    y, use = np.cumsum(rng.standard_normal(n)) * 1e-3, rng.random(n) > 0.2
    one, others = rng.random(n) * 1e-6, [10.0**k * rng.random(n) for k in range(-9, -4)]

    def single(corners, bends):
        return costs(y, use, noise, corners, bends).sum()

    np.testing.assert_allclose(costs_of(y, use, noise, others, [one]), [single(o, one) for o in others], rtol=1e-9)
    np.testing.assert_allclose(costs_of(y, use, noise, [one], others[:2]), [single(one, o) for o in others[:2]], rtol=1e-9)


def test_a_straight_line_has_no_steps_and_a_corner_one():
    y = np.abs(np.arange(21.0) - 10.0)
    flat = np.full(21, 1e-12)
    corners = flat.copy()
    corners[11] = 4.0
    law, drive = chain(y - y[0], np.ones(21, bool), Reading(1e-6), corners, flat)
    mean, _, steps = follow(law, drive)
    assert mean[:, 0] + y[0] == pytest.approx(y, abs=1e-2)
    assert steps[11, 0] == pytest.approx(4.0, rel=0.05) and np.delete(steps[:, 0], 11).max() < 1e-3
