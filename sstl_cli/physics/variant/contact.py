"""Friction of a station: how it follows tension, direction, speed, displacement, rest and use."""

from __future__ import annotations

from math import exp, expm1

import numpy as np
from numba import njit

from sstl_cli.physics.variant.line import BESIDE, CLOCK, FACTOR, REFERENCE_N, WARMTH, Line, Rate, Rub, Trial

LEAST_N = 0.05


@njit(cache=True)
def load_factor(law: Rub, tension: float) -> float:
    """Return how the local tension changes the friction coefficient and the wrap angle."""
    factor = 1.0
    t = max(tension, LEAST_N)
    if law.load != 0.0:
        if law.load_code == 0:
            factor = max(1.0 - 3.0 * law.load + 3.0 * law.load * (t / REFERENCE_N) ** (-1.0 / 3.0), 0.05)
        else:
            factor = 1.0 + 0.69 * law.load * np.tanh((law.load_shape - t) / 1.5)
    if law.sheath != 0.0:
        if law.sheath_code == 0:
            factor /= 1.0 - min(law.sheath * t, 0.6)
        else:
            factor *= 1.0 - law.sheath * law.sheath_shape * expm1(-t / law.sheath_shape)
    return factor


@njit(cache=True)
def lean_factor(law: Rub, tension: float, sign: float) -> float:
    """Return the factor of pulling (1) or releasing (-1) on the friction coefficient."""
    if law.lean == 0.0:
        return 1.0
    if law.lean_code == 0:
        return 1.0 + 2.0 * law.lean if sign > 0.0 else 1.0
    grown: float = min((max(tension, LEAST_N) / REFERENCE_N) ** law.lean_shape, 2.0)
    return 1.0 + sign * law.lean * grown


@njit(cache=True)
def behind_pulley(law: Rub, t: float, speed: float, sign: float) -> float:
    """Return the tension behind the pulley that turns towards the drive (1) or away from it (-1)."""
    lift = (max(t, LEAST_N) / REFERENCE_N) ** law.pulley_power
    constant = law.pulley_n
    if law.pulley_code == 0:
        constant *= -expm1(-max(t, 0.0) / 2.0)
    else:
        constant *= max(1.0, speed) ** (2.0 / 3.0)
    if sign > 0.0:
        return max(t * exp(-law.pulley_pull * lift) - constant, 0.0)
    return t * exp(law.pulley_release * lift) + constant


@njit(cache=True)
def behind(law: Rub, pulley: int, t: float, angle: float, weight: float, speed: float, sign: float) -> float:
    """Return the tension behind a station that slides towards the drive (1) or away from it (-1), without drag.

    The capstan equation with constant friction, dT/ds = -zeta (mu kappa T + w), solved exactly over the cell; a
    coefficient that depends on tension is taken at the middle of the cell (one corrector step).
    """
    if pulley == 1:
        return behind_pulley(law, t, speed, sign)
    bent = law.load != 0.0 or law.sheath != 0.0 or law.lean != 0.0
    phi = -sign * angle
    if bent:
        phi = -sign * angle * load_factor(law, t) * lean_factor(law, t, sign)
    x = _cell(t, phi, sign * weight)
    if bent:
        middle = 0.5 * (t + max(x, 0.0))
        phi = -sign * angle * load_factor(law, middle) * lean_factor(law, middle, sign)
        x = _cell(t, phi, sign * weight)
    return max(x, 0.0)


@njit(cache=True)
def _cell(t: float, phi: float, weight: float) -> float:
    if abs(phi) < 1e-12:
        return t - weight
    if weight == 0.0:
        return t * exp(phi)
    return t * exp(phi) - weight * expm1(phi) / phi


@njit(cache=True)
def strengths(line: Line, law: Rate, trial: Trial, dt: float) -> None:
    """Write the friction of each station for a step of dt (s)."""
    common = line.slow[FACTOR]
    trial.weight[:] = line.weight
    if law.beside != 0.0 and law.beside_code == 0:
        trial.weight[:] += line.angle * (law.beside * line.slow[BESIDE] * REFERENCE_N)
    if law.beside != 0.0 and law.beside_code == 1:
        bend = law.beside * line.slow[BESIDE]
        common *= max(1.0 + bend / (1.0 + abs(bend)), 0.05)
    if law.drift != 0.0:
        if law.drift_code == 0:
            common *= 1.0 + law.drift * exp(-line.slow[CLOCK] * law.drift_shape / law.drift_path)
        elif law.drift_code == 1:
            common *= 1.0 + law.drift * (1.0 - line.slow[WARMTH])
    trial.angle[:] = line.angle * common
    if law.speed == 0.0 and law.heal == 0.0 and law.dwell == 0.0 and (law.drift == 0.0 or law.drift_code != 2):
        return
    for j in range(trial.angle.size):
        s = common
        if law.drift != 0.0 and law.drift_code == 2:
            s *= 1.0 + law.drift * exp(-line.wear[j])
        if law.speed != 0.0:
            v = line.speed[j] / law.speed_mm_s
            if law.speed_code == 0:
                s *= 1.0 + law.speed / (1.0 + v * v)
            else:
                s *= 1.0 + law.speed * exp(-(v**law.speed_shape))
        if law.heal != 0.0 or law.dwell != 0.0:
            s *= 1.0 + trial.share[j] * aged(law, line.rest[j] + dt)
        trial.angle[j] = line.angle[j] * s


@njit(cache=True)
def aged(law: Rate, rest: float) -> float:
    """Return the static excess of a contact that has rested (s)."""
    excess = 0.0
    if law.heal != 0.0:
        x = rest / law.heal_s
        excess += law.heal * (1.0 - exp(-(x**law.heal_shape)) if law.heal_code == 0 else x / (x + 1.0))
    if law.dwell != 0.0:
        x = rest / law.dwell_s
        if law.dwell_code == 0:
            excess += law.dwell * ((1.0 + x) ** law.dwell_shape - 1.0) / law.dwell_shape
        else:
            excess += 3.0 * law.dwell * (1.0 - exp(-(x**law.dwell_shape) / 3.0))
    return excess


@njit(cache=True)
def drag_force(law: Rate, c: float, v: float) -> tuple[float, float]:
    """Return the drag (N) of a station with the coefficient c (N s/mm) at a speed (mm/s), and its slope (N s/mm)."""
    if c == 0.0:
        return 0.0, 0.0
    if law.drag_code == 0:
        return c * v, c
    if law.drag_code == 1:
        # shear thinning below 0.01 mm/s is Newtonian again, so that the slope stays finite
        a = max(abs(v) / 2.0, 0.005)
        slope = a ** (law.drag_shape - 1.0)
        return (c * v * slope, c * slope * (law.drag_shape if abs(v) > 0.01 else 1.0))
    s = v / law.drag_shape
    root = np.sqrt(1.0 + s * s)
    return c * law.drag_shape * np.arcsinh(s), c / root


@njit(cache=True)
def grip(law: Rate, old: float, pull: float, release: float, z: float, move: float) -> tuple[float, float]:
    """Return presliding friction (N) after a move (mm) from `old`, between -release and pull, and its slope."""
    start = min(max(old, -release), pull)
    limit, at = (pull, start) if move >= 0.0 else (release, -start)
    d = abs(move)
    rise = 1.0
    if law.soft_code == 1 and at < 0.0:
        # Bouc-Wen lets go along a straight line
        stiff = (release if move >= 0.0 else pull) / z
        reach = -at / stiff if stiff > 0.0 else 0.0
        if d < reach:
            f = at + stiff * d
            return (f if move >= 0.0 else -f), stiff
        d, at = d - reach, 0.0
    rise = exp(-d / z)
    f = limit - (limit - at) * rise
    return (f if move >= 0.0 else -f), (limit - at) * rise / z
