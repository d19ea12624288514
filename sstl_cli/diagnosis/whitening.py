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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.records import Record

Array = NDArray[np.float64]
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


def whitener(records: Sequence[Record], phases: Phases, noise: Noise, discrepancy_n: Array | None = None) -> Whitener:
    """Return the innovations filter of records whose model slides and holds as ``phases`` say.

    Parameters
    ----------
    records : sequence of Record
        Laid end to end; ``phases`` has one entry for each of their samples.
    discrepancy_n : ndarray, shape (samples,), optional
        Standard deviation of what the model's law may be off (N).
    """
    parts = [_constants(r, noise) for r in records]
    decay, fresh, white_n = (np.concatenate([p[i] for p in parts]) for i in range(3))
    if discrepancy_n is not None:
        white_n = np.hypot(white_n, discrepancy_n)
    keep = np.concatenate([r.weight for r in records]) > 0
    first = np.zeros(len(keep), np.bool_)
    first[np.cumsum([0, *(len(r) for r in records[:-1])])] = True
    weights, scale, log_det = _gains(phases.slide, phases.gain, decay, fresh, white_n, keep, first)
    return Whitener(decay, weights, scale, phases.slide, phases.gain, first, log_det)


def _constants(r: Record, noise: Noise) -> tuple[Array, Array, Array]:
    """Return per sample: decays and fresh variances of the three autoregressions (n, 3), and the white noise (N)."""
    n, dt = len(r), r.dt_s * r.factor
    into, out = noise.input[r.system], noise.output[r.system]
    # an average over m samples and its neighbour share what they have in common
    smoother = np.exp(-2.0 * r.factor / np.maximum(r.averaged, 1.0))
    decay, fresh = np.empty((n, 3)), np.empty((n, 3))
    for i, (memory, spread) in enumerate(
        (
            (smoother, noise.smoother[r.system] * r.error_n),
            (np.full(n, np.exp(-dt / into.correlation_s)), np.full(n, into.coloured_n)),
            (np.full(n, np.exp(-dt / out.correlation_s)), np.full(n, out.coloured_n)),
        )
    ):
        before = np.concatenate((spread[:1], spread[:-1]))
        decay[:, i] = memory * np.where(before > 0.0, spread / np.maximum(before, 1e-300), 0.0)
        fresh[:, i] = spread**2 * (1.0 - memory**2)
        decay[0, i], fresh[0, i] = 0.0, spread[0] ** 2
    return decay, fresh, np.full(n, max(out.white_n / np.sqrt(r.factor), 1e-9))


@njit(cache=True, nogil=True, error_model="numpy")
def _gains(
    slide: Array, gain: Array, decay: Array, fresh: Array, white_n: Array, keep: Mask, first: Mask
) -> tuple[Array, Array, float]:
    """Return the Kalman gains (n, 4), one over the innovations' standard deviations (0 where masked), and log det."""
    n = slide.size
    k_out, scale, log_det = np.zeros((n, 4)), np.zeros(n), 0.0
    p, q = np.zeros((4, 4)), np.zeros((4, 4))
    for t in range(n):
        a, b, c = decay[t, 0], decay[t, 1], decay[t, 2]
        v0, v1, v3 = fresh[t, 0], fresh[t, 1], fresh[t, 2]
        s, g = slide[t], gain[t]
        if first[t]:
            p[:, :] = 0.0
            # the output before the first sample is the reading itself
            p[2, 2] = white_n[t] ** 2 + v3
        # x0' = a x0 + w0, x1' = b x1 + w1, x2' = (1 - s) x2 + s g (x0' + x1'), x3' = c x3 + w3
        d0, d1, d2, d3 = a, b, 1.0 - s, c
        f = s * g
        q[0, 0] = d0 * d0 * p[0, 0] + v0
        q[0, 1] = d0 * d1 * p[0, 1]
        q[1, 1] = d1 * d1 * p[1, 1] + v1
        m0, m1 = d0 * d2 * p[0, 2], d1 * d2 * p[1, 2]
        q[0, 2] = m0 + f * (q[0, 0] + q[0, 1])
        q[1, 2] = m1 + f * (q[0, 1] + q[1, 1])
        q[2, 2] = d2 * d2 * p[2, 2] + 2.0 * f * (m0 + m1) + f * f * (q[0, 0] + 2.0 * q[0, 1] + q[1, 1])
        q[0, 3] = d0 * d3 * p[0, 3]
        q[1, 3] = d1 * d3 * p[1, 3]
        q[2, 3] = d2 * d3 * p[2, 3] + f * (q[0, 3] + q[1, 3])
        q[3, 3] = d3 * d3 * p[3, 3] + v3
        if keep[t]:
            z0, z1, z2, z3 = q[0, 2] + q[0, 3], q[1, 2] + q[1, 3], q[2, 2] + q[2, 3], q[2, 3] + q[3, 3]
            var = z2 + z3 + white_n[t] ** 2
            k_out[t, 0], k_out[t, 1], k_out[t, 2], k_out[t, 3] = z0 / var, z1 / var, z2 / var, z3 / var
            scale[t] = 1.0 / np.sqrt(var)
            log_det += np.log(var)
            p[0, 0] = q[0, 0] - z0 * z0 / var
            p[0, 1] = q[0, 1] - z0 * z1 / var
            p[0, 2] = q[0, 2] - z0 * z2 / var
            p[0, 3] = q[0, 3] - z0 * z3 / var
            p[1, 1] = q[1, 1] - z1 * z1 / var
            p[1, 2] = q[1, 2] - z1 * z2 / var
            p[1, 3] = q[1, 3] - z1 * z3 / var
            p[2, 2] = q[2, 2] - z2 * z2 / var
            p[2, 3] = q[2, 3] - z2 * z3 / var
            p[3, 3] = q[3, 3] - z3 * z3 / var
        else:
            p[:, :] = q
    return k_out, scale, log_det


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
