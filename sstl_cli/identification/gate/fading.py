"""Friction that builds up over a long path (Dahl's law on the logarithm of tension), begun in any state: what it leaves of an output.

A bundle of plays forgets where it began once all of its strands have slid; Dahl's law forgets by and by, and over a movement that is short beside its path
it never shows a line. It is no slip, and moves an output as a zero that creeps, a curve or another friction from one sample on do.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
# first guesses of n theta, of the path over which friction builds up (in parts of it) and of the state at the beginning (1: pulled, -1: released)
WRAPS, PATHS, STATES = (0.1, 0.25, 0.5, 0.9, 1.4), (2.2, 4.0, 8.0), (-0.5, 0.3, 1.0)
# parameters: n theta, logarithm of the path, state at the beginning, logarithm of the gain, zero of the output (N); within what is sound: friction that gives
# nothing back (a path of twice n theta), and sensors within 5 % and half a newton
LEAST, MOST = np.array([0.0, math.log(2.0), -1.0, -0.05, -0.5]), np.array([3.0, math.log(40.0), 1.0, 0.05, 0.5])
# points of the first guesses, how many of these are followed, steps of either descent and of the derivatives
POINTS, FOLLOWED, STEPS, DELTA = 256, 2, 30, 1e-5


def fading_of(x: Array, y: Array) -> tuple[float, float]:
    """Return n theta of Dahl's law and what it leaves (N RMS) of an output, NaN where the input is no tension.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Input and output in N.
    """
    wrap, _, rms = _faded(x, y, 0.0, LEAST, MOST)
    return wrap, rms


def scaled_fading_of(x: Array, y: Array) -> tuple[float, float, float]:
    """Return n theta, the logarithm of the gain, whatever it is, and what both leave (N RMS)."""
    middle = float(np.median(x)), float(np.median(y))
    if not min(middle) > 0.0:
        return math.nan, math.nan, math.nan
    free = np.array([0.0, 0.0, 0.0, 8.0, 0.0])
    return _faded(x, y, math.log(middle[1] / middle[0]), LEAST - free, MOST + free)


def _faded(x: Array, y: Array, gain: float, least: Array, most: Array) -> tuple[float, float, float]:
    if not float(np.min(x)) > 0.0:
        return math.nan, math.nan, math.nan
    u, v = np.log(np.ascontiguousarray(x)), np.ascontiguousarray(y)
    every = max(1, len(u) // POINTS)
    few = np.ascontiguousarray(u[::every]), np.ascontiguousarray(v[::every])
    guesses = [np.array([w, math.log(path), state, gain, 0.0]) for w in WRAPS for path in PATHS for state in STATES]
    guesses.sort(key=lambda p: _rms(*few, p))
    p, rms = min((_descend(u, v, p, least, most) for p in guesses[:FOLLOWED]), key=lambda f: f[1])
    return float(p[0]), float(p[3]), float(rms)


@njit(cache=True, nogil=True)
def _left(u: Array, y: Array, p: Array) -> Array:
    """Return what is left of an output (N); ``u`` is the logarithm of the input."""
    left, z, path, gain = np.empty(u.size), p[2], max(p[0], 1e-3) * math.exp(p[1]), math.exp(p[3])
    for k in range(u.size):
        step = u[k] - u[k - 1] if k > 0 else 0.0
        sign = 1.0 if step > 0.0 else -1.0
        z = sign - (sign - z) * math.exp(-abs(step) / path)
        left[k] = y[k] - gain * math.exp(u[k] - p[0] * z) - p[4]
    return left


@njit(cache=True, nogil=True)
def _rms(u: Array, y: Array, p: Array) -> float:
    return math.sqrt(np.mean(_left(u, y, p) ** 2))


@njit(cache=True, nogil=True)
def _descend(u: Array, y: Array, first: Array, least: Array, most: Array) -> tuple[Array, float]:
    """Levenberg-Marquardt within the bounds of the parameters."""
    p, damping, m = first.copy(), 1e-3, first.size
    left = _left(u, y, p)
    cost = np.mean(left**2)
    jacobian = np.empty((m, u.size))
    for _ in range(STEPS):
        for i in range(m):
            near = p.copy()
            near[i] += DELTA
            jacobian[i] = (left - _left(u, y, near)) / DELTA
        normal, gradient = jacobian @ jacobian.T, jacobian @ left
        done = True
        while damping < 1e6:
            damped = normal + damping * np.diag(np.diag(normal) + 1e-9)
            trial = np.minimum(np.maximum(p + np.linalg.solve(damped, gradient), least), most)
            after_left = _left(u, y, trial)
            after = np.mean(after_left**2)
            if after < cost:
                done = cost - after < 1e-4 * cost
                p, left, cost, damping = trial, after_left, after, max(0.2 * damping, 1e-9)
                break
            damping *= 8.0
        if done:
            break
    return p, math.sqrt(cost)
