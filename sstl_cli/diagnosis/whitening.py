"""Where the noise enters: a Kalman filter that follows the play, and turns residuals into independent unit normals.

The model is driven by the smoothed input, which differs from the true one by an error e. While the line slides the output
error is the gain times e; while it holds, the error is the one of the extreme that was reached, one number until the next
slide. The output sensor adds white and first-order coloured noise. Given the phases all of this is linear and Gaussian::

    e1'  = error of the smoothed input, by the law that the smoother states (three numbers), averaged over the step
    e2'  = first-order coloured noise of the input sensor
    h'   = (1 - slide) h + slide gain (e1' + e2')
    c'   = first-order coloured noise of the output sensor
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
# error of the input (3), coloured noise of its sensor, what the line holds of them, coloured noise of the output's sensor
STATES = 6


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

    error_law: Array
    decay: Array
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
        out = _filter(x, self.error_law, self.decay, self.weights, self.scale, self.slide, self.gain, self.first)
        return out[:, 0] if flat else out


def white(scale_n: float, keep: Array, starts: Sequence[int]) -> Whitener:
    """Return the whitener of independent noise of one standard deviation (N)."""
    n = len(keep)
    scale = np.where(keep > 0, 1.0 / scale_n, 0.0)
    first = np.zeros(n, np.bool_)
    first[list(starts)] = True
    zero = np.zeros(n)
    return Whitener(np.zeros((n, 12)), np.zeros((n, 2)), np.zeros((n, 6)), scale, zero, zero, first, 2.0 * float(np.sum(keep > 0)) * float(np.log(scale_n)))


@dataclass(frozen=True)
class Constants:
    """What the noise is whatever the model does, per sample: decays and fresh variances of both sensors' coloured noise
    (n, 2), white noise (N), law of the input's error (n, 22), variance of the output before a record, whether the sample
    counts, and whether a record begins.
    """

    decay: Array
    fresh: Array
    white_n: Array
    error_law: Array
    start: Array
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
    weights, scale, log_det = _gains(
        phases.slide, phases.gain, c.error_law, c.decay, c.fresh, white_n, c.keep, c.first, c.start
    )
    moves = np.ascontiguousarray(c.error_law[:, :12])
    return Whitener(moves, c.decay, weights, scale, phases.slide, phases.gain, c.first, log_det)


def constants(records: Sequence[Record], noise: Noise) -> Constants:
    """Return what the noise of records is whatever the model does."""
    count = [len(r) for r in records]
    begin = np.concatenate(([0], np.cumsum(count)[:-1]))
    first = np.zeros(sum(count), np.bool_)
    first[begin] = True
    sensors = [(noise.input[r.system], noise.output[r.system]) for r in records]
    step = np.array([r.dt_s * r.factor for r in records])
    memory = np.exp(-step[:, None] / np.array([[s.correlation_s for s in pair] for pair in sensors]))
    variance = np.array([[s.coloured_n**2 for s in pair] for pair in sensors])
    decay, fresh = np.repeat(memory, count, axis=0), np.repeat(variance * (1.0 - memory**2), count, axis=0)
    decay[begin], fresh[begin] = 0.0, variance
    start = np.zeros(len(first))
    start[begin] = np.array([r.start_error_n for r in records]) ** 2 + variance[:, 1]
    law = np.concatenate([r.error_law for r in records])
    law[:, 12:] *= np.repeat([noise.smoother[r.system] ** 2 for r in records], count)[:, None]
    white_n = np.repeat([max(s.white_n / np.sqrt(r.factor), 1e-9) for (_, s), r in zip(sensors, records, strict=True)], count)
    return Constants(decay, fresh, white_n, law, start, np.concatenate([r.weight for r in records]) > 0, first)


@njit(cache=True, nogil=True, error_model="numpy")
def _gains(
    slide: Array, gain: Array, law: Array, decay: Array, fresh: Array, white_n: Array, keep: Mask, first: Mask, start: Array
) -> tuple[Array, Array, float]:
    """Return the gains on unit innovations (n, 6), one over the innovations' standard deviations (0 where masked), and log det."""
    n = slide.size
    k_out, scale, log_det = np.zeros((n, STATES)), np.zeros(n), 0.0
    p, q, m, z = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros(STATES)
    for t in range(n):
        if first[t]:
            p[:, :] = 0.0
            # the output before the first sample is what was read there
            p[4, 4] = start[t]
        hold, f, b, c = 1.0 - slide[t], slide[t] * gain[t], decay[t, 0], decay[t, 1]
        # m = F p, then q = m F' and what is new
        _pass(p, law[t], hold, f, b, c, m)
        _pass(m.T, law[t], hold, f, b, c, q.T)
        _renew(q, law[t], fresh[t], f)
        if keep[t]:
            for i in range(STATES):
                z[i] = q[i, 4] + q[i, 5]
            var = z[4] + z[5] + white_n[t] ** 2
            scale[t] = 1.0 / np.sqrt(var)
            log_det += np.log(var)
            for i in range(STATES):
                k_out[t, i] = z[i] * scale[t]
                for j in range(STATES):
                    p[i, j] = q[i, j] - z[i] * z[j] / var
        else:
            p[:, :] = q
    return k_out, scale, log_det


@njit(cache=True, nogil=True)
def _pass(x: Array, law: Array, hold: float, f: float, b: float, c: float, out: Array) -> None:
    """Write the transition of the state times a matrix."""
    for j in range(STATES):
        x0, x1, x2 = x[0, j], x[1, j], x[2, j]
        out[0, j] = law[0] * x0 + law[1] * x1 + law[2] * x2
        out[1, j] = law[3] * x0 + law[4] * x1 + law[5] * x2
        out[2, j] = law[6] * x0 + law[7] * x1 + law[8] * x2
        out[3, j] = b * x[3, j]
        out[4, j] = f * (law[9] * x0 + law[10] * x1 + law[11] * x2 + out[3, j]) + hold * x[4, j]
        out[5, j] = c * x[5, j]


@njit(cache=True, nogil=True)
def _renew(q: Array, law: Array, fresh: Array, f: float) -> None:
    """Add the covariance of what is new to that of the state, and make it symmetric."""
    q[0, 0] += law[12]
    q[1, 0] += law[13]
    q[2, 0] += law[14]
    q[1, 1] += law[15]
    q[2, 1] += law[16]
    q[2, 2] += law[17]
    for i in range(3):
        q[4, i] += f * law[18 + i]
    q[3, 3] += fresh[0]
    q[4, 3] += f * fresh[0]
    q[4, 4] += f * f * (law[21] + fresh[0])
    q[5, 5] += fresh[1]
    for i in range(STATES):
        for j in range(i):
            q[j, i] = q[i, j]


@njit(cache=True, nogil=True)
def _filter(
    x: Array, law: Array, decay: Array, weights: Array, scale: Array, slide: Array, gain: Array, first: Mask
) -> Array:
    """Return innovations over their standard deviations of every column, shape (n, k)."""
    n, k = x.shape
    out = np.zeros((n, k))
    state = np.zeros((STATES, k))
    for t in range(n):
        if first[t]:
            state[:, :] = 0.0
        t00, t01, t02, t10, t11, t12 = law[t, 0], law[t, 1], law[t, 2], law[t, 3], law[t, 4], law[t, 5]
        t20, t21, t22, f0, f1, f2 = law[t, 6], law[t, 7], law[t, 8], law[t, 9], law[t, 10], law[t, 11]
        hold, f, b, c, s = 1.0 - slide[t], slide[t] * gain[t], decay[t, 0], decay[t, 1], scale[t]
        u0, u1, u2, u3, u4, u5 = weights[t, 0], weights[t, 1], weights[t, 2], weights[t, 3], weights[t, 4], weights[t, 5]
        for j in range(k):
            a0, a1, a2 = state[0, j], state[1, j], state[2, j]
            e0, e1, e2 = t00 * a0 + t01 * a1 + t02 * a2, t10 * a0 + t11 * a1 + t12 * a2, t20 * a0 + t21 * a1 + t22 * a2
            e3, e5 = b * state[3, j], c * state[5, j]
            e4 = f * (f0 * a0 + f1 * a1 + f2 * a2 + e3) + hold * state[4, j]
            # 0 where masked: the state is only moved on
            v = s * (x[t, j] - e4 - e5) if s > 0.0 else 0.0
            out[t, j] = v
            state[0, j], state[1, j], state[2, j] = e0 + u0 * v, e1 + u1 * v, e2 + u2 * v
            state[3, j], state[4, j], state[5, j] = e3 + u3 * v, e4 + u4 * v, e5 + u5 * v
    return out
