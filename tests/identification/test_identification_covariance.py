"""Lines and their errors against dense matrices: the same model of the noise, written out sample by sample."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.identification.covariance import CORRELATION_S, SLOW_SHARE, Line, fit_lines

DT = 0.002
TIMES = (0.03, 0.06, 0.12, 0.18, 0.25, 0.33, 0.45, 0.65, 1.0, 2.0)
SHARES = (0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0)


def blocks(length, starts, line, seed, sd=0.05, dt=DT):
    """Block means of ``length`` samples that begin at the given samples; noise white and with a memory of 0.2 s."""
    rng = np.random.default_rng(seed)
    at = np.array(starts)[:, None] + np.arange(length)
    t = (at * dt).mean(axis=1)
    x = 8.0 + 6.0 * np.sin(30.0 * t + seed)
    slow = np.exp(-np.abs(t[:, None] - t) / 0.2)
    noise = np.linalg.cholesky(slow + 0.2 * np.eye(len(t))) @ rng.standard_normal(len(t))
    return t, x, line[0] * x + line[1] + sd * noise, length


def omega(starts, length, tau, share, dt):
    """Covariance of the block means, over that of a white block: sample by sample, then averaged."""
    at = np.array(starts)[:, None] + np.arange(length)
    every = at.ravel()
    fine = np.exp(-np.abs(every[:, None] - every) * dt / tau)
    n = len(starts)
    slow = fine.reshape(n, length, n, length).mean(axis=(1, 3))
    if length * dt > 8.0 * tau:
        slow = np.diag(np.diag(slow))
    return (1.0 - share) * np.eye(n) + share * slow


def dense(points, starts, sd_in, sd_out, dt):
    """Textbook least squares, restricted likelihood of every noise model, and averages with its weights."""
    rate = np.gradient(-1.0 / np.array(TIMES))
    prior = [0.8] + [0.2 * r / (len(SHARES) * rate.sum()) for r in rate for _ in SHARES]
    models = [(1.0, 0.0), *((tau, share) for tau in TIMES for share in SHARES)]
    scores, fits = np.zeros(len(models)), []
    for (_, x, y, length), s in zip(points, starts, strict=True):
        a = np.c_[np.ones(len(x)), x]
        inverse = np.linalg.inv(a.T @ a)
        beta, gamma = inverse @ a.T @ y
        rows = []
        for i, (tau, share) in enumerate(models):
            o = omega(s, length, tau, share, dt)
            w = np.linalg.inv(o)
            normal = a.T @ w @ a
            # restricted likelihood in centred input: its determinant is that of the plain one
            b = np.linalg.solve(normal, a.T @ w @ y)
            r = y - a @ b
            variance = float(r @ w @ r) / (len(x) - 2)
            scores[i] -= 0.5 * (np.linalg.slogdet(o)[1] + np.linalg.slogdet(normal)[1] + (len(x) - 2) * np.log(variance))
            rows.append((variance, variance * inverse @ a.T @ o @ a @ inverse))
        fits.append((gamma, beta, x, rows))
    weight = np.exp(scores - scores.max()) * prior
    weight /= weight.sum()
    lines = []
    for gamma, beta, x, rows in fits:
        n = len(x)
        variance = sum(w * v for w, (v, _) in zip(weight, rows, strict=True))
        cov = sum(w * c for w, (_, c) in zip(weight, rows, strict=True))
        noise = min(variance * sd_in**2 / ((gamma * sd_in) ** 2 + sd_out**2), 1.5 * sd_in**2 / (1.0 - np.exp(-dt / 0.5)))
        slope = gamma / (1.0 - noise / np.var(x))
        wider = 1.0 + (1.96**2 + 1.0) / (4.0 * (n - 2))
        mean_y = beta + gamma * x.mean()
        lines.append((slope, mean_y - slope * x.mean(), wider * np.sqrt(cov[1, 1]), wider * np.sqrt(cov[0, 0])))
    return lines


def values(line):
    assert isinstance(line, Line)
    return line.gamma, line.beta, line.gamma_se, line.beta_se


CASES = {
    # samples in a block, first samples of the blocks of both directions (with a gap in the second), noise of input and
    # output, sampling period
    "short blocks": (3, range(0, 180, 3), [*range(300, 390, 3), *range(600, 700, 4)], 0.02, 0.03, 0.002),
    "blocks longer than the correlation": (30, range(0, 30 * 20, 30), range(900, 900 + 30 * 14, 30), 0.02, 0.02, 0.01),
    "single samples, far noisier than the sensors": (1, range(60), range(200, 260), 0.003, 0.0005, 0.002),
}


@pytest.mark.parametrize("case", CASES)
def test_lines_and_errors_are_those_of_dense_matrices(case):
    length, first, second, sd_in, sd_out, dt = CASES[case]
    points = [blocks(length, first, (0.6, -1.4), 1, dt=dt), blocks(length, second, (1.7, -1.0), 2, dt=dt)]
    found = fit_lines(points, dt, sd_in, sd_out)
    for line, expected in zip(found, dense(points, [first, second], sd_in, sd_out, dt), strict=True):
        assert values(line) == pytest.approx(expected, rel=1e-7)


def test_the_grid_of_noise_models():
    assert CORRELATION_S.tolist() == list(TIMES) and SLOW_SHARE.tolist() == list(SHARES)


def test_a_direction_with_fewer_than_four_blocks_has_no_line_and_leaves_the_other_alone():
    whole = blocks(2, range(0, 80, 2), (0.6, 0.0), 3)
    for n in (3, 4):
        few = (*(v[:n] for v in blocks(2, range(0, 80, 2), (1.7, 0.0), 4)[:3]), 2)
        found = fit_lines([few, whole], DT, 0.0, 0.05)
        assert (found[0] is None) == (n < 4) and found[1] is not None
    alone = fit_lines([whole], DT, 0.0, 0.05)[0]
    few = (*(v[:3] for v in whole[:3]), 2)
    assert fit_lines([few, whole], DT, 0.0, 0.05)[1] == alone
    assert fit_lines([few, few], DT, 0.0, 0.05) == [None, None]
    same_x = (whole[0], np.full(40, 3.0), whole[2], 2)
    assert fit_lines([same_x, whole], DT, 0.0, 0.05) == [None, alone]


def test_a_slope_that_input_noise_flattens_by_more_than_15_percent_is_not_reported():
    # all noise at the input, range of variance 1: the slope falls to k = 1 / (1 + sd^2); the residual, 1 - k, takes a share
    # sd^2 of the slope back, so that k / (1 - sd^2) is left
    rng = np.random.default_rng(5)
    n = 4000
    t, x = np.arange(n) * 0.5, rng.permutation(np.repeat([0.0, 2.0], n // 2))
    for sd in (0.25, 0.37):
        line = fit_lines([(t, x + sd * rng.standard_normal(n), x, 1)], 0.5, sd, 0.0)[0]
        assert values(line)[0] == pytest.approx(1.0 / (1.0 + sd**2) / (1.0 - sd**2), abs=0.02)
    assert fit_lines([(t, x + 0.41 * rng.standard_normal(n), x, 1)], 0.5, 0.41, 0.0) == [None]


def test_a_record_without_noise_has_an_exact_line_and_a_tiny_error():
    t = np.arange(30) * DT
    x = np.linspace(2.0, 20.0, 30)
    gamma, beta, gamma_se, beta_se = values(fit_lines([(t, x, 0.6 * x - 1.0, 1)], DT, 0.0, 0.0)[0])
    assert (gamma, beta) == pytest.approx((0.6, -1.0), abs=1e-12)
    assert 0.0 < gamma_se < 1e-10 and 0.0 < beta_se < 1e-9
