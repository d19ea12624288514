"""Second-order lag and sliding mean of a signal that runs straight between its samples, exact for any step."""

from __future__ import annotations

from math import cos, exp, sin, sqrt

import numpy as np
from numba import njit

from sstl_cli.physics.variant.line import Array


@njit(cache=True)
def lag_step(y: float, rate: float, start: float, end: float, dt: float, omega: float, damping: float) -> tuple[float, float]:
    """Return value and rate after a step of y'' = omega^2 (u - y) - 2 damping omega y', u straight from start to end."""
    slope = (end - start) / dt
    behind = 2.0 * damping / omega * slope
    # distance from the steady lag behind a ramp, a damped turn (damping below 1)
    e, de = y - start + behind, rate - slope
    decay, turn = damping * omega, omega * sqrt(1.0 - damping * damping)
    fade, c, s = exp(-decay * dt), cos(turn * dt), sin(turn * dt)
    later = fade * (e * (c + decay / turn * s) + de / turn * s)
    change = fade * (de * (c - decay / turn * s) - e * omega * omega / turn * s)
    return end - behind + later, slope + change


@njit(cache=True)
def limited(step: float, dt: float, inverse_slew: float) -> float:
    """Return a change that a drive makes of one that is asked for in dt; it saturates as a hyperbolic tangent."""
    return dt / inverse_slew * np.tanh(step * inverse_slew / dt) if inverse_slew > 0.0 else step


@njit(cache=True)
def second_order(time: Array, signal: Array, tau_s: float, damping: float, inverse_slew: float) -> Array:
    """Return a signal behind a second-order lag whose delay on ramps is tau_s, and a limit of its slope."""
    out = signal.copy()
    rate = 0.0
    for n in range(1, signal.size):
        dt = time[n] - time[n - 1]
        new = signal[n]
        if tau_s > 0.0:
            new, rate = lag_step(out[n - 1], rate, signal[n - 1], signal[n], dt, 2.0 * damping / tau_s, damping)
        step = limited(new - out[n - 1], dt, inverse_slew)
        if inverse_slew > 0.0:
            rate = min(max(rate, -1.0 / inverse_slew), 1.0 / inverse_slew)
        out[n] = out[n - 1] + step
    return out


@njit(cache=True)
def first_order(time: Array, signal: Array, tau_s: float, inverse_slew: float) -> Array:
    """Return a signal behind a first-order lag, with a limit of its slope."""
    out = signal.copy()
    for n in range(1, signal.size):
        dt = time[n] - time[n - 1]
        new = signal[n]
        if tau_s > 0.0:
            behind = tau_s * (signal[n] - signal[n - 1]) / dt
            new = signal[n] - behind + (out[n - 1] - signal[n - 1] + behind) * exp(-dt / tau_s)
        out[n] = out[n - 1] + limited(new - out[n - 1], dt, inverse_slew)
    return out


def sliding_mean(time: Array, signal: Array, width_s: float) -> Array:
    """Return the mean over the last width_s; before the first sample the signal stood still."""
    area = np.concatenate(([0.0], np.cumsum(0.5 * (signal[1:] + signal[:-1]) * np.diff(time))))
    back = time - width_s
    k = np.clip(np.searchsorted(time, back, "right") - 1, 0, time.size - 2)
    on = back - time[k]
    slope = (signal[k + 1] - signal[k]) / (time[k + 1] - time[k])
    before = np.where(back < time[0], on * signal[0], area[k] + on * (signal[k] + 0.5 * slope * on))
    return np.asarray((area - before) / width_s)
