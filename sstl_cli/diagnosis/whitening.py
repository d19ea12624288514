"""Where the noise enters: a Kalman filter that follows the play, and turns residuals into independent unit normals.

The model is driven by the smoothed input, which differs from the true one by an error e. While the line slides the output
error is the gain times e; while it holds, the error is the one of the extreme that was reached, one number until the next
slide. The output sensor adds white and first-order coloured noise. Given the phases all of this is linear and Gaussian::

    e1'  = error of the smoothed input, by the law that the smoother states (three numbers), averaged over the step
    e2'  = first-order coloured noise of the input sensor
    h'   = (1 - slide) h + slide gain (e1' + e2') + slip
    c'   = first-order coloured noise of the output sensor
    residual = h + c + white noise

where ``slip`` stands for a hold that nearly slid: whether the true input slipped there is not known, and what it left stays.
So the innovations of the filter, over their standard deviations, are the whitened residual, and the sum of the logarithms
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

from sstl_cli.diagnosis.records import Record, starts_of

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

    ``spread`` has the standard errors of the logarithms, by system and by ``input.coloured_n`` and the like; ``open`` is by what
    (natural logarithm) the coloured noise of a system's output may be off where it has not been estimated yet.
    """

    input: Mapping[str, Sensor]
    output: Mapping[str, Sensor]
    smoother: Mapping[str, float]
    spread: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    open: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Phases:
    """How the model's output follows its input, shape (samples,): share of a step spent sliding, and gain.

    ``doubt_n`` is the standard deviation (N) of what is not linear in the input's error: of a hold that nearly slid.
    """

    slide: Array
    gain: Array
    doubt_n: Array


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
    moves: Array
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
        phases.slide, phases.gain, phases.doubt_n, c.error_law, c.decay, c.fresh, white_n, c.keep, c.first, c.start
    )
    return Whitener(c.moves, c.decay, weights, scale, phases.slide, phases.gain, c.first, log_det)


def constants(records: Sequence[Record], noise: Noise) -> Constants:
    """Return what the noise of records is whatever the model does."""
    count = [len(r) for r in records]
    edges = np.concatenate(([0], np.cumsum(count)[:-1]))
    started = [(a + s.at // r.factor, i, s) for i, (a, r) in enumerate(zip(edges, records, strict=True)) for s in starts_of(r)]
    begin = np.array([at for at, _, _ in started])
    whose = np.array([i for _, i, _ in started])
    first = np.zeros(sum(count), np.bool_)
    first[begin] = True
    sensors = [(noise.input[r.system], noise.output[r.system]) for r in records]
    step = np.array([r.dt_s * r.factor for r in records])
    memory = np.exp(-step[:, None] / np.array([[s.correlation_s for s in pair] for pair in sensors]))
    variance = np.array([[s.coloured_n**2 for s in pair] for pair in sensors])
    decay, fresh = np.repeat(memory, count, axis=0), np.repeat(variance * (1.0 - memory**2), count, axis=0)
    for a, r, (_, out) in zip(edges, records, sensors, strict=True):
        if r.misfit_n is not None:
            slow, spread = coloured(r, out)
            kept = np.exp(-r.dt_s * r.factor / slow)
            before = np.concatenate((spread[:1], spread[:-1]))
            decay[a : a + len(r), 1] = kept * spread / np.maximum(before, 1e-300)
            fresh[a : a + len(r), 1] = spread**2 * (1.0 - kept**2)
    variance[:, 1] = [out.coloured_n**2 + (0.0 if r.misfit_n is None else r.misfit_n[0] ** 2) for r, (_, out) in zip(records, sensors, strict=True)]
    decay[begin], fresh[begin] = 0.0, variance[whose]
    start = np.zeros(len(first))
    start[begin] = np.array([s.error_n for _, _, s in started]) ** 2 + variance[whose, 1]
    law = np.concatenate([r.error_law for r in records])
    law[:, 12:] *= np.repeat([noise.smoother[r.system] ** 2 for r in records], count)[:, None]
    white_n = np.concatenate([np.maximum(s.white_n / np.sqrt(r.readings), 1e-9) for (_, s), r in zip(sensors, records, strict=True)])
    moves = np.ascontiguousarray(law[:, :12])
    return Constants(decay, fresh, white_n, law, moves, start, np.concatenate([r.weight for r in records]) > 0, first)


def coloured(r: Record, out: Sensor) -> tuple[Array, Array]:
    """Return correlation time (s) and standard deviation (N) of what is added to the output, each of shape (n,).

    The scatter of an accepted model adds to the sensor's noise; one filter state carries both, as slow as they are together.
    """
    n = len(r)
    if r.misfit_n is None:
        return np.full(n, out.correlation_s), np.full(n, out.coloured_n)
    total = np.hypot(out.coloured_n, r.misfit_n)
    share = (r.misfit_n / np.maximum(total, 1e-300)) ** 2
    slow = np.exp(share * np.log(r.misfit_s) + (1.0 - share) * np.log(out.correlation_s))
    return slow, total


@njit(cache=True, nogil=True, error_model="numpy")
def _gains(
    slide: Array,
    gain: Array,
    doubt_n: Array,
    law: Array,
    decay: Array,
    fresh: Array,
    white_n: Array,
    keep: Mask,
    first: Mask,
    start: Array,
) -> tuple[Array, Array, float]:
    """Return the gains on unit innovations (n, 6), one over the innovations' standard deviations (0 where masked), and log det.

    State: error of the input (0, 1, 2), coloured noise of its sensor (u), what the line holds of them (h), coloured noise of
    the output's sensor (c); p and q are its covariances before and after a step. Written out, for this is called most.
    """
    n = slide.size
    k_out, scale, log_det, product = np.zeros((n, STATES)), np.zeros(n), 0.0, 1.0
    p00 = p01 = p02 = p0u = p0h = p0c = p11 = p12 = p1u = p1h = p1c = 0.0
    p22 = p2u = p2h = p2c = puu = puh = puc = phh = phc = pcc = 0.0
    for t in range(n):
        if first[t]:
            p00 = p01 = p02 = p0u = p0h = p0c = p11 = p12 = p1u = p1h = p1c = 0.0
            p22 = p2u = p2h = p2c = puu = puh = puc = phc = pcc = 0.0
            # the output before the first sample is what was read there, or where the input holds it
            phh = start[t] + gain[t] ** 2 * (law[t, 21] + fresh[t, 0])
        t00, t01, t02, t10, t11, t12 = law[t, 0], law[t, 1], law[t, 2], law[t, 3], law[t, 4], law[t, 5]
        t20, t21, t22, c0, c1, c2 = law[t, 6], law[t, 7], law[t, 8], law[t, 9], law[t, 10], law[t, 11]
        hold, f, b, d = 1.0 - slide[t], slide[t] * gain[t], decay[t, 0], decay[t, 1]
        # transition times the covariance of the input's error, and that of its mean over the step with the state before
        m00, m01, m02 = t00 * p00 + t01 * p01 + t02 * p02, t00 * p01 + t01 * p11 + t02 * p12, t00 * p02 + t01 * p12 + t02 * p22
        m10, m11, m12 = t10 * p00 + t11 * p01 + t12 * p02, t10 * p01 + t11 * p11 + t12 * p12, t10 * p02 + t11 * p12 + t12 * p22
        m20, m21, m22 = t20 * p00 + t21 * p01 + t22 * p02, t20 * p01 + t21 * p11 + t22 * p12, t20 * p02 + t21 * p12 + t22 * p22
        m0u, m1u, m2u = t00 * p0u + t01 * p1u + t02 * p2u, t10 * p0u + t11 * p1u + t12 * p2u, t20 * p0u + t21 * p1u + t22 * p2u
        m0h, m1h, m2h = t00 * p0h + t01 * p1h + t02 * p2h, t10 * p0h + t11 * p1h + t12 * p2h, t20 * p0h + t21 * p1h + t22 * p2h
        m0c, m1c, m2c = t00 * p0c + t01 * p1c + t02 * p2c, t10 * p0c + t11 * p1c + t12 * p2c, t20 * p0c + t21 * p1c + t22 * p2c
        e0, e1, e2, eu, eh, ec = (
            c0 * p00 + c1 * p01 + c2 * p02,
            c0 * p01 + c1 * p11 + c2 * p12,
            c0 * p02 + c1 * p12 + c2 * p22,
            c0 * p0u + c1 * p1u + c2 * p2u,
            c0 * p0h + c1 * p1h + c2 * p2h,
            c0 * p0c + c1 * p1c + c2 * p2c,
        )
        q00 = m00 * t00 + m01 * t01 + m02 * t02 + law[t, 12]
        q01 = m00 * t10 + m01 * t11 + m02 * t12 + law[t, 13]
        q02 = m00 * t20 + m01 * t21 + m02 * t22 + law[t, 14]
        q11 = m10 * t10 + m11 * t11 + m12 * t12 + law[t, 15]
        q12 = m10 * t20 + m11 * t21 + m12 * t22 + law[t, 16]
        q22 = m20 * t20 + m21 * t21 + m22 * t22 + law[t, 17]
        q0u, q1u, q2u, quu = b * m0u, b * m1u, b * m2u, b * b * puu + fresh[t, 0]
        q0c, q1c, q2c, quc, qcc = d * m0c, d * m1c, d * m2c, b * d * puc, d * d * pcc + fresh[t, 1]
        q0h = f * (m00 * c0 + m01 * c1 + m02 * c2 + law[t, 18] + q0u) + hold * m0h
        q1h = f * (m10 * c0 + m11 * c1 + m12 * c2 + law[t, 19] + q1u) + hold * m1h
        q2h = f * (m20 * c0 + m21 * c1 + m22 * c2 + law[t, 20] + q2u) + hold * m2h
        quh = f * (b * eu + quu) + hold * b * puh
        entering = c0 * e0 + c1 * e1 + c2 * e2 + law[t, 21] + 2.0 * b * eu + quu
        # what a slip that may or may not have happened leaves behind stays until the next slide
        before = 0.0 if first[t] else hold * doubt_n[t - 1]
        slip = max(doubt_n[t] ** 2 - before**2, 0.0)
        qhh = f * f * entering + 2.0 * f * hold * (eh + b * puh) + hold * hold * phh + slip
        qhc = d * (f * (ec + b * puc) + hold * phc)
        if not keep[t]:
            p00, p01, p02, p0u, p0h, p0c, p11 = q00, q01, q02, q0u, q0h, q0c, q11
            p12, p1u, p1h, p1c, p22, p2u, p2h = q12, q1u, q1h, q1c, q22, q2u, q2h
            p2c, puu, puh, puc, phh, phc, pcc = q2c, quu, quh, quc, qhh, qhc, qcc
            continue
        z0, z1, z2, zu, zh, zc = q0h + q0c, q1h + q1c, q2h + q2c, quh + quc, qhh + qhc, qhc + qcc
        var = zh + zc + white_n[t] ** 2
        scale[t] = s = 1.0 / math.sqrt(var)
        # a logarithm of a product instead of one a sample
        product *= var
        if not 1e-100 < product < 1e100:
            log_det += math.log(product)
            product = 1.0
        g0, g1, g2, gu, gh, gc = s * z0, s * z1, s * z2, s * zu, s * zh, s * zc
        k_out[t, 0], k_out[t, 1], k_out[t, 2], k_out[t, 3], k_out[t, 4], k_out[t, 5] = g0, g1, g2, gu, gh, gc
        p00, p01, p02, p0u = q00 - g0 * g0, q01 - g0 * g1, q02 - g0 * g2, q0u - g0 * gu
        p0h, p0c, p11, p12 = q0h - g0 * gh, q0c - g0 * gc, q11 - g1 * g1, q12 - g1 * g2
        p1u, p1h, p1c, p22 = q1u - g1 * gu, q1h - g1 * gh, q1c - g1 * gc, q22 - g2 * g2
        p2u, p2h, p2c, puu = q2u - g2 * gu, q2h - g2 * gh, q2c - g2 * gc, quu - gu * gu
        puh, puc, phh, phc = quh - gu * gh, quc - gu * gc, qhh - gh * gh, qhc - gh * gc
        pcc = qcc - gc * gc
    return k_out, scale, log_det + math.log(product)


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
