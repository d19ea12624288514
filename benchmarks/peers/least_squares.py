"""What numpy, scipy and statsmodels have for the smaller pieces of a fit: normal equations, bounded steps, fits, and others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.optimize import least_squares, lsq_linear
from scipy.sparse import csr_array, hstack
from statsmodels.tsa.stattools import acf

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Pair = tuple[Array, Array]


def spread(config: Counts, configs: int, j: Array) -> Array:
    """Return a Jacobian with one theta column a configuration instead of one in all, shape (samples, configs + k)."""
    out = np.zeros((len(j), configs + j.shape[1] - 1))
    out[np.arange(len(j)), config] = j[:, 0]
    out[:, configs:] = j[:, 1:]
    return out


def dense(config: Counts, configs: int, j: Array, r: Array) -> Pair:
    """Return J'J and J'r by BLAS, zeros and all."""
    wide = spread(config, configs, j)
    return wide.T @ wide, wide.T @ r


def sparse(config: Counts, configs: int, j: Array, r: Array) -> Pair:
    """Return the same from a matrix that knows its zeros."""
    n = len(j)
    own = csr_array((j[:, 0], config, np.arange(n + 1)), shape=(n, configs))
    wide = hstack((own, csr_array(j[:, 1:])), format="csr")
    return (wide.T @ wide).toarray(), wide.T @ r


def blocks(config: Counts, configs: int, j: Array, r: Array) -> Pair:
    """Return the same block by block: counts of theta's own, BLAS for the rest; the quickest that numpy allows."""
    own, free = j[:, 0], j[:, 1:]
    size = configs + free.shape[1]
    a, b = np.zeros((size, size)), np.empty(size)
    a[np.arange(configs), np.arange(configs)] = np.bincount(config, own * own, configs)
    b[:configs], b[configs:] = np.bincount(config, own * r, configs), free.T @ r
    for k in range(free.shape[1]):
        a[configs + k, :configs] = a[:configs, configs + k] = np.bincount(config, own * free[:, k], configs)
    a[configs:, configs:] = free.T @ free
    return a, b


def step(a: Array, b: Array, low: Array, high: Array) -> Array:
    """Return the step between bounds that lowers a quadratic most: least squares of its Cholesky factor."""
    lower = np.linalg.cholesky(a)
    return np.asarray(lsq_linear(lower.T, np.linalg.solve(lower, b), (low, high), method="bvls").x)


def fitted(left: Callable[[Array], Array], slopes: Callable[[Array], Array], start: Array, bounds: Pair, flat: float) -> Any:
    """Return scipy's fit of what is left at parameters, by slopes of that, ended where the cost falls by less than a share ``flat``."""
    return least_squares(left, start, jac=slopes, bounds=bounds, x_scale="jac", ftol=flat, xtol=1e-12, gtol=1e-12)


def means(fine: Array, share: Array, starts: Counts, ceiling: float) -> Array:
    """Return weighted sums of blocks, without what is no number."""
    bounded = np.clip(np.nan_to_num(fine, nan=ceiling), -ceiling, ceiling)
    return np.asarray(np.add.reduceat(bounded * share, starts))


def independent(x: Array) -> float:
    """Return how many independent samples there are, by statsmodels' autocorrelation (see sstl_cli/diagnosis/channels.py)."""
    n = len(x)
    rho = acf(x, nlags=n - 1, adjusted=True, fft=True)
    pairs = rho[: n // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(pairs <= 0.0)
    total = float(pairs[: int(ends[0]) if len(ends) else len(pairs)].sum())
    return float(n / max(2.0 * total - 1.0, 1.0))


def states(y: Array, use: NDArray[np.bool_], noise: tuple[float, float, float], steps: Pair, diffuse: float) -> Array:
    """Return the smoothed states of the input, shape (n, 4), from the banded system that all of them solve at once.

    What a step adds to value and increment has the covariance (5/12, 1/2; 1/2, 1), of which (6, -3; -3, 5/2) is the inverse.
    """
    (white, slow, memory), (c, b), n = noise, steps, len(y)
    weight = np.zeros((n, 4, 4))
    weight[:, 0, 0], weight[:, 0, 1], weight[:, 1, 0], weight[:, 1, 1] = 6.0 / c, -3.0 / c, -3.0 / c, 2.5 / c
    weight[:, 2, 2], weight[:, 3, 3] = 1.0 / b, 1.0 / (slow * (1.0 - memory**2))
    weight[0] = np.diag([1.0 / (diffuse * white)] * 3 + [1.0 / slow])
    move = np.array([[1.0, 1.0, 0.5, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, memory]])
    back = -weight @ move
    here = weight.copy()
    here[:-1] -= move.T @ back[1:]
    seen = use / white
    for i in (0, 3):
        for k in (0, 3):
            here[:, i, k] += seen
    band = np.zeros((8, n, 4))
    for k in range(4):
        for i in range(k, 4):
            band[i - k, :, k] = here[:, i, k]
        for i in range(4):
            band[4 + i - k, :-1, k] = back[1:, i, k]
    right = np.zeros((n, 4))
    right[:, 0] = right[:, 3] = np.where(use, y, 0.0) / white
    return np.asarray(solveh_banded(band.reshape(8, -1), right.reshape(-1), lower=True).reshape(n, 4))
