"""Friction of each node: capstan limits of both directions, and the laws that make them depend on time and speed."""

from __future__ import annotations

from math import exp, log1p
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.rig.chain import Chain

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Contact(NamedTuple):
    """What the contacts of the M nodes are made of, and their memory."""

    theta: FloatArray  # (M,) mu * bend angle
    weight_n: FloatArray  # (M,) friction that does not depend on tension
    fixed: IntArray  # (M,) 1 where the limits are constant: the pulley
    speed: FloatArray  # (M,) remembered sliding speed, mm/s
    peak: FloatArray  # (M,) static excess of friction, as a share
    age_s: FloatArray  # (M,) age of the contact spots
    factor: FloatArray  # (M,) static over kinetic friction of the step being solved
    swollen: FloatArray  # (1,) bend angle over that without other tendons, at the step being solved


class ContactLaw(NamedTuple):
    """Parameters of the contact laws; but for the first three, which a rig has, what an effect sets, by default to nothing."""

    memory_s: float
    weakening_mm: float
    healing_mm: float
    asymmetry: float = 0.0
    drift: float = 0.0
    drift_path_n: float = 1.0
    stribeck_ratio: float = 1.0
    stribeck_speed: float = 1.0
    stick_ratio: float = 1.0
    stick_speed: float = 1.0
    dwell_b: float = 0.0
    dwell_t0: float = 1.0


@njit(cache=True)
def capstan_limit(angle: float, weight: float) -> tuple[float, float]:
    """Slope and bias of a node limit that turns T into exactly T exp(-+angle) -+ its share of a distributed weight.

    A node at mean tension needs 2 tanh(angle / 2) instead of angle for the capstan equation to hold across it; the
    rational form errs by angle^5 / 720.
    """
    shrink = 1.0 / (1.0 + angle * angle / 12.0)
    return angle * shrink, weight * shrink


@njit(cache=True)
def heal(contact: Contact, law: ContactLaw, i: int, slip: float, dt: float) -> tuple[float, float]:
    """Static excess and age of contact i after a step with this slip (mm) and duration (s).

    Both follow the ageing law of Dieterich (1979) and Ruina (1983): d age / dt = 1 - v age / D, and for the excess p
    d p / dt = (p_0 - p) v_c / H - p v / D. Between two jumps the tendon is at rest for the time in which the drive
    makes up about H of travel, so that p cannot come back when the drive is faster than v_c.
    """
    worn = slip / law.weakening_mm
    peak = contact.peak[i]
    if law.stick_ratio > 1.0:
        healed = law.stick_speed * dt / law.healing_mm
        rate = healed + worn
        goal = (law.stick_ratio - 1.0) * healed / rate
        peak = goal + (peak - goal) * exp(-rate)
    age = contact.age_s[i] + dt
    if worn > 0.0:
        wear = exp(-worn)
        age = contact.age_s[i] * wear + dt * (1.0 - wear) / worn
    return peak, age


@njit(cache=True)
def static_factor(law: ContactLaw, peak: float, age: float) -> float:
    """Static over kinetic friction of a contact with this excess and age (s)."""
    factor = 1.0 + peak
    if law.dwell_b > 0.0:
        factor *= 1.0 + law.dwell_b * log1p(age / law.dwell_t0)
    return factor


@njit(cache=True)
def trial_slip(chain: Chain, i: int) -> float:
    """Length (mm) that node i slipped in the trial step, the elastic part of its motion taken off."""
    if chain.mode[i] == 0:
        return 0.0
    slip: float = abs(chain.u[i] - chain.u_old[i] - (chain.force[i] - chain.force_old[i]) / chain.stick_stiffness[i])
    return slip


@njit(cache=True)
def set_limits(chain: Chain, contact: Contact, law: ContactLaw, path_n: float) -> None:
    """Write the friction limits of every node for the coming step; `path_n` is the accumulated |dT_in| (N)."""
    common = contact.swollen[0]
    if law.drift != 0.0:
        common *= 1.0 + law.drift * exp(-path_n / law.drift_path_n)
    for i in range(contact.theta.size):
        if contact.fixed[i] == 1:
            continue
        angle = contact.theta[i] * common * contact.factor[i]
        if angle > 0.0 and law.stribeck_ratio > 1.0:
            ratio = contact.speed[i] / law.stribeck_speed
            angle *= 1.0 + (law.stribeck_ratio - 1.0) * exp(-ratio * ratio)
        slope, bias = capstan_limit(angle * (1.0 + law.asymmetry), contact.weight_n[i])
        chain.slope_pull[i] = slope
        chain.bias_pull[i] = bias
        slope, bias = capstan_limit(angle * (1.0 - law.asymmetry), contact.weight_n[i])
        chain.slope_release[i] = slope
        chain.bias_release[i] = bias


@njit(cache=True)
def begin_contact(contact: Contact, law: ContactLaw, dt: float) -> None:
    """Static factors for a step in which nothing has slipped yet."""
    for i in range(contact.theta.size):
        if contact.theta[i] > 0.0:
            peak, age = heal(contact, law, i, 0.0, dt)
            contact.factor[i] = static_factor(law, peak, age)


@njit(cache=True)
def weaken(chain: Chain, contact: Contact, law: ContactLaw, dt: float) -> float:
    """Adapt the static factors to the slip of the trial step; returns their largest change.

    Solved again and again with weaker contacts, the step follows a break-away to where it comes to rest: a jump.
    """
    change = 0.0
    for i in range(contact.theta.size):
        if contact.theta[i] > 0.0:
            peak, age = heal(contact, law, i, trial_slip(chain, i), dt)
            factor = static_factor(law, peak, age)
            change = max(change, abs(factor - contact.factor[i]))
            contact.factor[i] = factor
    return change


@njit(cache=True)
def update_contact(chain: Chain, contact: Contact, law: ContactLaw, dt: float) -> None:
    """Carry sliding speed, excess and age over the step just solved; call before it is committed."""
    forget = 1.0 - exp(-dt / law.memory_s)
    for i in range(contact.theta.size):
        if contact.theta[i] > 0.0:
            contact.speed[i] += (abs(chain.u[i] - chain.u_old[i]) / dt - contact.speed[i]) * forget
            if law.stick_ratio > 1.0 or law.dwell_b > 0.0:
                contact.peak[i], contact.age_s[i] = heal(contact, law, i, trial_slip(chain, i), dt)
