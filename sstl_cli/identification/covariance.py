"""Lines and honest standard errors under correlated noise.

Residuals of recorded tensions are white noise plus slow, correlated noise, so that the textbook error of
a least-squares line is far too small. The line stays the least-squares one (a slow misfit of a real loop
must not turn it); its covariance is X+ Omega X+' with Omega white noise plus an exponential
autocorrelation. White share and correlation time are averaged over a grid with the weights of their
restricted likelihood [1]_, pooled over both directions, so that short runs, which hardly show the
correlation, get wider errors.

.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320-338.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
CORRELATION_S = np.array([0.03, 0.06, 0.12, 0.18, 0.25, 0.33, 0.45, 0.65, 1.0, 2.0])
SLOW_SHARE = np.array([0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0])
# correlation times and shares that march together, up to a multiple of what a vector register holds
LANES = 96
WHITE_BEFOREHAND = 0.8
# a line whose slope the noise of the input flattens by more than this is not reported
LARGEST_CORRECTION = 0.15
SLOWEST_NOISE_S = 0.5


@dataclass(frozen=True)
class Line:
    """A propagation line with the standard errors of slope and bias (N)."""

    gamma: float
    beta: float
    gamma_se: float
    beta_se: float


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def _step(w: Array, x: float, y: float) -> None:
    """Take the filters of all correlation times and shares over one more point."""
    for j in range(LANES):
        rho = w[12 * LANES + j]
        prior = rho * rho * w[j] + w[13 * LANES + j]
        s = prior + w[14 * LANES + j]
        inverse = 1.0 / s
        gain = prior * inverse
        w[j] = prior - gain * prior
        b0, b1, b2 = rho * w[LANES + j], rho * w[2 * LANES + j], rho * w[3 * LANES + j]
        e0, e1, e2 = 1.0 - b0, x - b1, y - b2
        w[LANES + j] = b0 + gain * e0
        w[2 * LANES + j] = b1 + gain * e1
        w[3 * LANES + j] = b2 + gain * e2
        w[11 * LANES + j] *= s
        f0, f1 = e0 * inverse, e1 * inverse
        w[4 * LANES + j] += e0 * f0
        w[5 * LANES + j] += e1 * f0
        w[6 * LANES + j] += e1 * f1
        w[7 * LANES + j] += e2 * f0
        w[8 * LANES + j] += e2 * f1
        w[9 * LANES + j] += e2 * e2 * inverse


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def _grid(t: Array, x: Array, y: Array, taus: Array, slow: Array, white: Array) -> Array:
    """Return the log-determinant and the cross products of (1, x, y) after whitening by a Kalman filter.

    Row 0 is white noise, then come every correlation time and share. ``slow`` is the variance of the slow part,
    ``white`` that of the rest. All filters march together: their state lies in one array with fixed strides, so that the
    compiler takes several of them in one instruction, and none waits for its own last point.
    """
    times, shares = slow.shape
    out = np.zeros((1 + times * shares, 7))
    for k in range(t.size):
        out[0, 1] += 1.0
        out[0, 2] += x[k]
        out[0, 3] += x[k] * x[k]
        out[0, 4] += y[k]
        out[0, 5] += x[k] * y[k]
        out[0, 6] += y[k] * y[k]
    # variance, three states, six sums, the log-determinant and what of it is still a product; correlation over one
    # step, what the step adds to the variance, the white variance
    w = np.zeros(15 * LANES)
    for j in range(LANES):
        w[11 * LANES + j] = w[14 * LANES + j] = 1.0
    for i in range(times):
        for j in range(shares):
            lane = i * shares + j
            w[lane] = w[13 * LANES + lane] = slow[i, j]
            w[14 * LANES + lane] = white[i, j]
    step = -1.0
    for k in range(t.size):
        dt = t[k] - t[k - 1] if k > 0 else 0.0
        if k > 0 and abs(dt - step) > 1e-6 * dt:
            step = dt
            for i in range(times):
                rho = math.exp(-dt / taus[i])
                for j in range(shares):
                    w[12 * LANES + i * shares + j] = rho
                    w[13 * LANES + i * shares + j] = slow[i, j] * (1.0 - rho * rho)
        _step(w, x[k], y[k])
        if k % 32 == 31 or k == t.size - 1:
            for j in range(times * shares):
                w[10 * LANES + j] += math.log(w[11 * LANES + j])
                w[11 * LANES + j] = 1.0
    for j in range(times * shares):
        out[1 + j, 0] = w[10 * LANES + j]
        for c in range(6):
            out[1 + j, 1 + c] = w[(4 + c) * LANES + j]
    return out


@lru_cache(64)
def _parts(length: int, dt_s: float) -> tuple[Array, Array]:
    """Return slow and white variances of block means per correlation time and share.

    Means of ``length`` samples of an exponentially correlated noise keep its correlation from block to
    block, but have less variance than that suggests: the white part takes the (negative) difference.
    """
    r = np.exp(-dt_s / CORRELATION_S)
    lag = np.arange(1, length)
    amplitude = ((1.0 - r**length) / (length * (1.0 - r))) ** 2 * r ** (1.0 - length)
    variance = (length + 2.0 * (r[:, None] ** lag) @ (length - lag)) / length**2
    # blocks far longer than the correlation are white
    amplitude = np.where(length * dt_s > 8.0 * CORRELATION_S, 0.0, amplitude)
    share = SLOW_SHARE[None, :]
    return share * amplitude[:, None], 1.0 - share + share * (variance - amplitude)[:, None]


def fit_lines(points: list[tuple[Array, Array, Array, int]], dt_s: float, sd_in: float, sd_out: float) -> list[Line | None]:
    """Return the line of each direction, or None where the points do not define one.

    Parameters
    ----------
    points : list of (time, input, output, length)
        Inlier block means of each direction in time order (s, N, N), and the samples in a block; fewer
        than 4 blocks give None.
    dt_s : float
        Sampling period in s.
    sd_in, sd_out : float
        White noise of a sample of input and output (N).
    """
    parts = [_solve(*p, dt_s) if len(p[0]) >= 4 else None for p in points]
    known = [p for p in parts if p is not None]
    if not known:
        return [None] * len(points)
    score = np.sum([p.score for p in known], axis=0)
    weight = np.exp(score - np.max(score))
    weight *= _prior()
    weight /= weight.sum()
    return [None if p is None else p.average(weight, sd_in, sd_out, dt_s) for p in parts]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _correlated(t: Array, x: Array, taus: Array) -> Array:
    """Return the quadratic forms of (1, 1), (1, x), (x, x) with the correlation matrix of each time."""
    out = np.zeros((taus.size, 3))
    for i in range(taus.size):
        s0, s1, step, rho = 0.0, 0.0, -1.0, 0.0
        c00, c01, c11 = 0.0, 0.0, 0.0
        for k in range(t.size):
            if k > 0:
                dt = t[k] - t[k - 1]
                if abs(dt - step) > 1e-6 * dt:
                    step = dt
                    rho = math.exp(-dt / taus[i])
                s0 = rho * (s0 + 1.0)
                s1 = rho * (s1 + x[k - 1])
            c00 += 1.0 + 2.0 * s0
            c01 += x[k] + s1 + x[k] * s0
            c11 += x[k] * (x[k] + 2.0 * s1)
        out[i, 0], out[i, 1], out[i, 2] = c00, c01, c11
    return out


@lru_cache(1)
def _prior() -> Array:
    """Return the weights before seeing residuals: white unless shown otherwise, then uniform in rate 1 / tau."""
    times = np.repeat(np.gradient(-1.0 / CORRELATION_S), len(SLOW_SHARE))
    return np.concatenate(([WHITE_BEFOREHAND], (1.0 - WHITE_BEFOREHAND) * times / times.sum()))


@dataclass(frozen=True)
class _Fit:
    """Least squares of one direction, and per grid point its variances and restricted likelihood."""

    n: int
    centre: float
    level: float
    gamma: float
    sxx: float
    variance: Array
    var_level: Array
    cov: Array
    var_gamma: Array
    score: Array

    def average(self, weight: Array, sd_in: float, sd_out: float, dt_s: float) -> Line | None:
        """Return the line with standard errors averaged over the grid."""
        # errors in the input flatten the slope: its noise is its share of the residual, as large as white noise
        # of the sensors lets expect, but no more than a correlation of half a second can hide from fast differences
        noise = float(weight @ self.variance) * sd_in**2 / max((self.gamma * sd_in) ** 2 + sd_out**2, 1e-300)
        noise = min(noise, 1.5 * sd_in**2 / -math.expm1(-dt_s / SLOWEST_NOISE_S))
        shift = self.n * noise / self.sxx
        if shift > LARGEST_CORRECTION:
            return None
        slope = self.gamma / (1.0 - shift)
        c = self.centre
        sd_slope = math.sqrt(float(weight @ self.var_gamma))
        var_beta = np.maximum(self.var_level - 2.0 * c * self.cov + c * c * self.var_gamma, 0.0)
        sd_bias = math.sqrt(float(weight @ var_beta))
        if not (math.isfinite(sd_slope) and math.isfinite(sd_bias)):
            return None
        # two-sided 95 % limits are drawn at 1.96 standard errors: widen by Student's t over the normal
        wider = 1.0 + (1.96**2 + 1.0) / (4.0 * max(self.n - 2, 1))
        return Line(slope, self.level - slope * c, wider * sd_slope, wider * sd_bias)


@njit(cache=True, nogil=True, error_model="numpy")
def _moments(sums: Array, forms: Array, slow: Array, white: Array, n: int, sxx: float, tiny: float) -> Array:
    """Return variances of level, both and slope, the variance, and the determinant: a row for white noise, then for every correlation time and share.

    ``sums`` are those of :func:`_grid`, ``forms`` those of :func:`_correlated`. In numpy it is forty operations on ninety numbers each.
    """
    times, shares = slow.shape
    out = np.empty((1 + times * shares, 5))
    for k in range(1 + times * shares):
        s = sums[k]
        det = s[1] * s[3] - s[2] * s[2]
        g = (s[1] * s[5] - s[2] * s[4]) / det
        b = (s[3] * s[4] - s[2] * s[5]) / det
        # a noise-free record leaves rounding errors only
        variance = max(s[6] - g * s[5] - b * s[4], tiny) / (n - 2)
        ones, mixed, squares = float(n), 0.0, sxx
        if k:
            i, j = (k - 1) // shares, (k - 1) % shares
            ones = white[i, j] * n + slow[i, j] * forms[i, 0]
            mixed = slow[i, j] * forms[i, 1]
            squares = white[i, j] * sxx + slow[i, j] * forms[i, 2]
        out[k, 0], out[k, 1], out[k, 2] = variance * ones / (n * n), variance * mixed / (n * sxx), variance * squares / (sxx * sxx)
        out[k, 3], out[k, 4] = variance, det
    return out


def _solve(t: Array, x: Array, y: Array, length: int, dt_s: float) -> _Fit | None:
    n = len(x)
    centre, level = float(x.sum()) / n, float(y.sum()) / n
    u, v = x - centre, y - level
    sxx = float(u @ u)
    if sxx <= 0.0:
        return None
    gamma = float(u @ v) / sxx
    # the residual instead of y: same likelihood, no loss of digits
    slow, rest = _parts(length, dt_s)
    m = _grid(t, u, v - gamma * u, CORRELATION_S, slow, rest)
    tiny = 1e-24 * max((float(y.max()) - float(y.min())) ** 2, 1e-30)
    var_level, cov, var_gamma, variance, det = _moments(m, _correlated(t, u, CORRELATION_S), slow, rest, n, sxx, tiny).T
    if not np.all(det > 0.0):
        return None
    score = -0.5 * (m[:, 0] + np.log(det) + (n - 2) * np.log(variance))
    # apart from the other columns: the product with the weights sums numbers that stand side by side in another order
    return _Fit(n, centre, level, gamma, sxx, variance.copy(), var_level, cov, var_gamma, score)
