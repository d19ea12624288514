"""Both ends of the input side: the tension loop before the line, and what the recorded position holds beside stretch."""

from __future__ import annotations

import numpy as np
from numba import njit

from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array


def follow(time: Array, command: Array, tau_s: float, inverse_slew: float, law: Chosen) -> Array:
    """Return the input tension (N) that a tension loop makes of its command; the command itself at neutral values."""
    if tau_s == 0.0 and inverse_slew == 0.0:
        return command
    if law.id == "second_order":
        return _second_order(time, command, tau_s, inverse_slew, law.shape)
    late = np.interp(time - 0.5 * tau_s, time, command) if tau_s > 0.0 else command
    return _first_order(time, late, 0.5 * tau_s, inverse_slew)


@njit(cache=True)
def _limited(rate: float, inverse_slew: float) -> float:
    return np.tanh(rate * inverse_slew) / inverse_slew if inverse_slew > 0.0 else rate


@njit(cache=True)
def _first_order(time: Array, goal: Array, tau_s: float, inverse_slew: float) -> Array:
    out = goal.copy()
    for n in range(1, goal.size):
        dt = time[n] - time[n - 1]
        share = 1.0 - np.exp(-dt / tau_s) if tau_s > 0.0 else 1.0
        out[n] = out[n - 1] + dt * _limited(share * (goal[n] - out[n - 1]) / dt, inverse_slew)
    return out


@njit(cache=True)
def _second_order(time: Array, goal: Array, tau_s: float, inverse_slew: float, damping: float) -> Array:
    """Semi-implicit steps of at most a twentieth of the natural period."""
    out = goal.copy()
    speed = 0.0
    for n in range(1, goal.size):
        whole = time[n] - time[n - 1]
        omega = 2.0 * damping / max(tau_s, 0.5 * whole)
        parts = int(np.ceil(whole * omega * 4.0)) + 1
        dt = whole / parts
        y = out[n - 1]
        for i in range(parts):
            aim = goal[n - 1] + (goal[n] - goal[n - 1]) * (i + 1) / parts
            # implicit in the damping, explicit in the spring
            speed = (speed + dt * omega * omega * (aim - y - dt * speed)) / (1.0 + 2.0 * damping * omega * dt)
            y += dt * _limited(speed, inverse_slew)
        out[n] = y
    return out


def extra_travel(tension: Array, compliance: float, sheath: Chosen, gap_mm: float, slack: Chosen) -> Array:
    """Return what a shortening sheath and slack add to the position (mm)."""
    shortened = compliance * tension * (1.0 + tension / 50.0)
    if sheath.id == "stop":
        shortened = compliance * sheath.shape * -np.expm1(-tension / sheath.shape)
    if slack.id == "catenary":
        taken = tension**2 / (tension**2 + slack.shape**2)
    else:
        taken = -np.expm1(-tension / slack.shape)
    return np.asarray(shortened + gap_mm * taken)
