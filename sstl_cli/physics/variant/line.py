"""The line as the cascade sees it: stations of friction, segments of tendon between them, the load behind.

Unknowns are tensions, not displacements. Station j turns the tension t before it into x behind it; a displacement is
what the segments behind it and the load have stretched. Units mm, N, s.
"""

from __future__ import annotations

from math import exp, expm1, log1p
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
REFERENCE_N = 10.0
LEAST_N = 0.05
# counters of a run
UNCONVERGED, SUBSTEPPED, ITERATIONS, WORK, LEAST = range(5)
# slow state of the whole line: run time (s), warmth, tension of the neighbours (N)
CLOCK, WARMTH, BESIDE = range(3)


class Rub(NamedTuple):
    """Laws that follow the local tension: load, sheath, direction, pulley. Codes as in `laws.LAWS`."""

    pulley_pull: float
    pulley_release: float
    pulley_n: float
    pulley_code: int
    pulley_power: float
    load: float
    load_code: int
    load_shape: float
    sheath: float
    sheath_code: int
    sheath_shape: float
    lean: float
    lean_code: int
    lean_shape: float


class Rate(NamedTuple):
    """Laws that follow speed, displacement, rest and use."""

    drift: float
    drift_code: int
    drift_path: float
    drift_shape: float
    beside: float
    beside_code: int
    speed: float
    speed_mm_s: float
    speed_code: int
    speed_shape: float
    drag: float
    drag_code: int
    drag_shape: float
    soft: float
    soft_code: int
    heal: float
    heal_s: float
    heal_code: int
    heal_shape: float
    dwell: float
    dwell_s: float
    dwell_code: int
    dwell_shape: float
    memory_s: float
    weakening_mm: float


class Spring(NamedTuple):
    """Laws of tendon and load."""

    plain: bool
    creep: float
    load_k1: float
    fung: float
    joint_share: float
    joint_n: float
    play: float
    play_n: float
    rope: float
    rope_code: int
    rope_shape: float


class Laws(NamedTuple):
    """All laws in force."""

    rub: Rub
    rate: Rate
    spring: Spring


class Line(NamedTuple):
    """State of M stations and M + 1 segments; segment k ends at station k, the last one at the load."""

    angle: Array  # (M,) mu times bend angle
    weight: Array  # (M,) constant friction, N
    drag: Array  # (M,) N s/mm
    breakaway: Array  # (M,) mm, 0 for rigid
    pulley: Ints  # (M,) 1 at the pulley
    compliance: Array  # (M + 1,) mm/N
    tension: Array  # (M + 1,)
    crept: Array  # (M + 1, E) mm
    creep_share: Array  # (E,)
    creep_s: Array  # (E,)
    rope: Array  # (M + 1,) force between the wires, N
    joint: Array  # (2,) force of the hysteretic load (N), place in its play 0..1
    drop: Array  # (M,) friction at the last sample, N
    speed: Array  # (M,) remembered speed, mm/s
    rest: Array  # (M,) age of the contact, s
    wear: Array  # (M,) friction work over that of the run-in
    wear_n_mm: Array  # (M,)
    slow: Array  # (3,)
    tally: Array  # (5,)


class Trial(NamedTuple):
    """Work arrays of one step."""

    tension: Array  # (M + 1,)
    move: Array  # (M,) displacement in this step, mm
    angle: Array  # (M,) friction of the step: mu times bend angle
    weight: Array  # (M,) and constant friction, N
    share: Array  # (M,) what slip has left of the static excess
    offset: Array  # (M,) move = offset + tangent * tension behind
    tangent: Array  # (M,)
    force: Array  # (M,) friction and drag of the iterate
    slope: Array  # (M,) d force / d move
    gain: Array  # (M,) d force / d tension before
    moved: Array  # (M,) the move that force belongs to
    stuck: Ints  # (M,)
    flow: Array  # (M + 1,) creep of the step, mm, is give x tension - flow
    give: Array  # (M + 1,) mm/N


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
    grown = min((max(tension, LEAST_N) / REFERENCE_N) ** law.lean_shape, 2.0)
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
    common = 1.0
    trial.weight[:] = line.weight
    if law.beside != 0.0 and law.beside_code == 0:
        trial.weight[:] += line.angle * (law.beside * line.slow[BESIDE] * REFERENCE_N)
    if law.beside != 0.0 and law.beside_code == 1:
        bend = law.beside * line.slow[BESIDE]
        common = max(1.0 + bend / (1.0 + abs(bend)), 0.05)
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


@njit(cache=True)
def stretch(
    law: Spring, c: float, old: float, tension: float, rope: float, flow: float, give: float
) -> tuple[float, float]:
    """Return how far a segment of compliance c stretches in a step from one tension to another (mm), and its slope.

    In the step it creeps by `give` x tension - `flow`; `rope` is the force between its wires before.
    """
    move, slope = c * (tension - old), c
    if law.plain:
        return move, slope
    if law.rope != 0.0:
        if law.rope_code == 0:
            a = 4.0 * law.rope_shape
            move += c * a * (exp(-old / 4.0) - exp(-tension / 4.0))
            slope += c * law.rope_shape * exp(-tension / 4.0)
        else:
            z = rope + tension - old
            move -= c * law.rope_shape * (min(max(z, -2.0), 2.0) - rope)
            slope -= c * law.rope_shape * (1.0 if abs(z) < 2.0 else 0.0)
    return move + give * tension - flow, slope + give


@njit(cache=True)
def load_stretch(law: Spring, old: float, tension: float, held: float, place: float) -> tuple[float, float]:
    """Return how far the load gives in a step (mm), and its slope; `held` and `place` are the state of its joint."""
    step = tension - old
    if law.plain:
        return step / law.load_k1, 1.0 / law.load_k1
    if law.fung > 0.0:
        b = law.fung / law.load_k1
        move = (log1p(b * tension) - log1p(b * old)) / law.fung
        slope = 1.0 / (law.load_k1 * (1.0 + b * tension))
    elif law.joint_share > 0.0:
        z = held + law.joint_share / (1.0 + law.joint_share) * step
        new = min(max(z, -law.joint_n), law.joint_n)
        move = (step - new + held) / law.load_k1
        slope = (1.0 if new != z else 1.0 / (1.0 + law.joint_share)) / law.load_k1
    else:
        move, slope = step / law.load_k1, 1.0 / law.load_k1
    if law.play > 0.0:
        new = place + step / law.play_n
        move += law.play * (min(max(new, 0.0), 1.0) - place)
        slope += law.play / law.play_n if 0.0 < new < 1.0 else 0.0
    return move, slope


@njit(cache=True)
def foresee_creep(line: Line, law: Spring, trial: Trial, dt: float) -> None:
    """Write how much every segment will creep in a step of dt: give x tension - flow (mm)."""
    for k in range(line.compliance.size):
        flow, give = 0.0, 0.0
        for i in range(line.creep_s.size):
            r = dt / (dt + line.creep_s[i])
            flow += r * line.crept[k, i]
            give += r * law.creep * line.creep_share[i] * line.compliance[k]
        trial.flow[k], trial.give[k] = flow, give


@njit(cache=True)
def settle(line: Line, law: Spring, dt: float, tension: Array) -> None:
    """Carry creep, rope and load over a step that ends at these tensions."""
    if law.plain:
        return
    last = line.compliance.size - 1
    for k in range(last + 1):
        step = tension[k] - line.tension[k]
        if law.rope != 0.0 and law.rope_code == 1:
            line.rope[k] = min(max(line.rope[k] + step, -2.0), 2.0)
        if law.creep != 0.0:
            for i in range(line.creep_s.size):
                goal = law.creep * line.creep_share[i] * line.compliance[k]
                line.crept[k, i] += dt / (dt + line.creep_s[i]) * (goal * tension[k] - line.crept[k, i])
    step = tension[last] - line.tension[last]
    if law.joint_share > 0.0:
        z = line.joint[0] + law.joint_share / (1.0 + law.joint_share) * step
        line.joint[0] = min(max(z, -law.joint_n), law.joint_n)
    if law.play > 0.0:
        line.joint[1] = min(max(line.joint[1] + step / law.play_n, 0.0), 1.0)
