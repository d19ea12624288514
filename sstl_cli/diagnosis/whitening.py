"""Where the noise enters: a Kalman filter that follows the play, and turns residuals into independent unit normals.

The model is driven by the smoothed input, which differs from the true one by an error e. While the line slides the output
error is the gain times e; while it holds, the error is the one of the extreme that was reached, one number until the next
slide. The output sensor adds white and first-order coloured noise. Given the phases all of this is linear and Gaussian::

    e1' = autoregression with the smoother's variance,   e2' = first-order coloured noise of the input sensor,
    h'  = (1 - slide) h + slide gain (e1 + e2),          c'  = first-order coloured noise of the output sensor,
    residual = h + c + white noise

so the innovations of the filter, over their standard deviations, are the whitened residual, and the sum of the logarithms
is its log-determinant (Harvey 1989, section 3.4). The filter depends on phases and noise only: a residual and all columns
of a Jacobian pass through it in one go.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.records import Record

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Sensor:
    """Noise of one tension sensor: white and coloured standard deviations (N) and correlation time (s)."""

    white_n: float
    coloured_n: float
    correlation_s: float


@dataclass(frozen=True)
class Noise:
    """Noise of the two sensors of each system; ``smoother`` is the true error of the smoothed input over the stated one.

    ``spread`` has the standard errors of the logarithms, by system and by ``input.coloured_n`` and the like.
    """

    input: Mapping[str, Sensor]
    output: Mapping[str, Sensor]
    smoother: Mapping[str, float]
    spread: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Phases:
    """How the model's output follows its input, shape (samples,): share of a step spent sliding, and gain."""

    slide: Array
    gain: Array


@dataclass(frozen=True)
class Whitener:
    """Innovations filter of a problem; ``log_det`` is the log-determinant of the covariance over kept samples."""

    transition: Array
    weights: Array
    scale: Array
    slide: Array
    gain: Array
    first: Mask
    log_det: float

    def __call__(self, columns: Array) -> Array:
        """Return whitened residuals or Jacobian columns, shape (samples,) or (samples, k); 0 where nothing is known."""
        flat = columns.ndim == 1
        x = np.ascontiguousarray(columns[:, None] if flat else columns, np.float64)
        out = _filter(x, self.transition, self.weights, self.scale, self.slide, self.gain, self.first)
        return out[:, 0] if flat else out


def white(scale_n: float, keep: Array, starts: Sequence[int]) -> Whitener:
    """Return the whitener of independent noise of one standard deviation (N)."""
    n = len(keep)
    scale = np.where(keep > 0, 1.0 / scale_n, 0.0)
    first = np.zeros(n, np.bool_)
    first[list(starts)] = True
    zero = np.zeros(n)
    return Whitener(np.zeros((n, 3)), np.zeros((n, 4)), scale, zero, zero, first, 2.0 * float(np.sum(keep > 0)) * float(np.log(scale_n)))


@dataclass(frozen=True)
class Constants:
    """What the noise is whatever the model does, per sample: decays and fresh variances of the three autoregressions
    (n, 3), white noise (N), whether the sample counts, and whether a record begins.
    """

    decay: Array
    fresh: Array
    white_n: Array
    keep: Mask
    first: Mask


def whitener(
    records: Sequence[Record],
    phases: Phases,
    noise: Noise,
    discrepancy_n: Array | None = None,
    known: Constants | None = None,
) -> Whitener:
    """Return the innovations filter of records whose model slides and holds as ``phases`` say.

    Parameters
    ----------
    records : sequence of Record
        Laid end to end; ``phases`` has one entry for each of their samples.
    discrepancy_n : ndarray, shape (samples,), optional
        Standard deviation of what the model's law may be off (N).
    known : Constants, optional
        Those of the records and the noise, where several whiteners share them.
    """
    c = known or constants(records, noise)
    white_n = c.white_n if discrepancy_n is None else np.hypot(c.white_n, discrepancy_n)
    weights, scale, log_det = _gains(phases.slide, phases.gain, c.decay, c.fresh, white_n, c.keep, c.first)
    return Whitener(c.decay, weights, scale, phases.slide, phases.gain, c.first, log_det)


def constants(records: Sequence[Record], noise: Noise) -> Constants:
    """Return what the noise of records is whatever the model does."""
    count = [len(r) for r in records]
    edges = np.concatenate(([0], np.cumsum(count)))
    into, out = [noise.input[r.system] for r in records], [noise.output[r.system] for r in records]
    step = np.array([r.dt_s * r.factor for r in records])
    decay, fresh = _autoregressions(
        edges,
        np.concatenate([r.error_n for r in records]),
        np.concatenate([r.averaged for r in records]),
        np.array([float(r.factor) for r in records]),
        np.array([noise.smoother[r.system] for r in records]),
        np.exp(-step / np.array([s.correlation_s for s in into])),
        np.array([s.coloured_n for s in into]),
        np.exp(-step / np.array([s.correlation_s for s in out])),
        np.array([s.coloured_n for s in out]),
    )
    first = np.zeros(edges[-1], np.bool_)
    first[edges[:-1]] = True
    white_n = np.repeat([max(s.white_n / np.sqrt(r.factor), 1e-9) for s, r in zip(out, records, strict=True)], count)
    return Constants(decay, fresh, white_n, np.concatenate([r.weight for r in records]) > 0, first)


@njit(cache=True, nogil=True, error_model="numpy")
def _autoregressions(
    edges: Counts,
    error_n: Array,
    averaged: Array,
    factor: Array,
    smoother: Array,
    memory_in: Array,
    coloured_in: Array,
    memory_out: Array,
    coloured_out: Array,
) -> tuple[Array, Array]:
    """Return decays and fresh variances (n, 3) of the smoother's error and of both sensors' coloured noise."""
    decay, fresh = np.zeros((error_n.size, 3)), np.empty((error_n.size, 3))
    for i in range(factor.size):
        a = edges[i]
        before = smoother[i] * error_n[a]
        for t in range(a, edges[i + 1]):
            spread = smoother[i] * error_n[t]
            # an average over m samples and its neighbour share what they have in common
            memory = math.exp(-2.0 * factor[i] / max(averaged[t], 1.0))
            decay[t, 0] = memory * spread / before if before > 0.0 else 0.0
            fresh[t, 0] = spread**2 * (1.0 - memory**2)
            decay[t, 1] = memory_in[i] if coloured_in[i] > 0.0 else 0.0
            fresh[t, 1] = coloured_in[i] ** 2 * (1.0 - memory_in[i] ** 2)
            decay[t, 2] = memory_out[i] if coloured_out[i] > 0.0 else 0.0
            fresh[t, 2] = coloured_out[i] ** 2 * (1.0 - memory_out[i] ** 2)
            before = spread
        decay[a] = 0.0
        fresh[a, 0], fresh[a, 1], fresh[a, 2] = (smoother[i] * error_n[a]) ** 2, coloured_in[i] ** 2, coloured_out[i] ** 2
    return decay, fresh


@njit(cache=True, nogil=True, error_model="numpy")
def _gains(
    slide: Array, gain: Array, decay: Array, fresh: Array, white_n: Array, keep: Mask, first: Mask
) -> tuple[Array, Array, float]:
    """Return the Kalman gains (n, 4), one over the innovations' standard deviations (0 where masked), and log det."""
    n = slide.size
    k_out, scale, log_det, product = np.zeros((n, 4)), np.zeros(n), 0.0, 1.0
    p00 = p01 = p02 = p03 = p11 = p12 = p13 = p22 = p23 = p33 = 0.0
    for t in range(n):
        d0, d1, d3 = decay[t, 0], decay[t, 1], decay[t, 2]
        d2, f = 1.0 - slide[t], slide[t] * gain[t]
        white2 = white_n[t] ** 2
        if first[t]:
            p00 = p01 = p02 = p03 = p11 = p12 = p13 = p23 = p33 = 0.0
            # the output before the first sample is the reading itself
            p22 = white2 + fresh[t, 2]
        # x0' = a x0 + w0, x1' = b x1 + w1, x2' = (1 - s) x2 + s g (x0' + x1'), x3' = c x3 + w3
        q00 = d0 * d0 * p00 + fresh[t, 0]
        q01 = d0 * d1 * p01
        q11 = d1 * d1 * p11 + fresh[t, 1]
        m0, m1 = d0 * d2 * p02, d1 * d2 * p12
        q02 = m0 + f * (q00 + q01)
        q12 = m1 + f * (q01 + q11)
        q22 = d2 * d2 * p22 + 2.0 * f * (m0 + m1) + f * f * (q00 + 2.0 * q01 + q11)
        q03 = d0 * d3 * p03
        q13 = d1 * d3 * p13
        q23 = d2 * d3 * p23 + f * (q03 + q13)
        q33 = d3 * d3 * p33 + fresh[t, 2]
        if not keep[t]:
            p00, p01, p02, p03, p11, p12, p13, p22, p23, p33 = q00, q01, q02, q03, q11, q12, q13, q22, q23, q33
            continue
        z0, z1, z2, z3 = q02 + q03, q12 + q13, q22 + q23, q23 + q33
        var = z2 + z3 + white2
        inverse = 1.0 / var
        k0, k1, k2, k3 = z0 * inverse, z1 * inverse, z2 * inverse, z3 * inverse
        k_out[t, 0], k_out[t, 1], k_out[t, 2], k_out[t, 3] = k0, k1, k2, k3
        scale[t] = math.sqrt(inverse)
        # a logarithm of a product instead of one a sample
        product *= var
        if not 1e-100 < product < 1e100:
            log_det += math.log(product)
            product = 1.0
        p00, p01, p02, p03 = q00 - z0 * k0, q01 - z0 * k1, q02 - z0 * k2, q03 - z0 * k3
        p11, p12, p13 = q11 - z1 * k1, q12 - z1 * k2, q13 - z1 * k3
        p22, p23, p33 = q22 - z2 * k2, q23 - z2 * k3, q33 - z3 * k3
    return k_out, scale, log_det + math.log(product)


@njit(cache=True, nogil=True)
def _filter(
    x: Array, decay: Array, weights: Array, scale: Array, slide: Array, gain: Array, first: Mask
) -> Array:
    """Return innovations over their standard deviations of every column, shape (n, k)."""
    n, k = x.shape
    out = np.zeros((n, k))
    state = np.zeros((4, k))
    for t in range(n):
        if first[t]:
            state[:, :] = 0.0
        a, b, c = decay[t, 0], decay[t, 1], decay[t, 2]
        hold, f = 1.0 - slide[t], slide[t] * gain[t]
        u0, u1, u2, u3, s = weights[t, 0], weights[t, 1], weights[t, 2], weights[t, 3], scale[t]
        for j in range(k):
            e0, e1, e3 = a * state[0, j], b * state[1, j], c * state[3, j]
            e2 = hold * state[2, j] + f * (e0 + e1)
            if s > 0.0:
                v = x[t, j] - e2 - e3
                out[t, j] = v * s
                e0 += u0 * v
                e1 += u1 * v
                e2 += u2 * v
                e3 += u3 * v
            state[0, j], state[1, j], state[2, j], state[3, j] = e0, e1, e2, e3
    return out
