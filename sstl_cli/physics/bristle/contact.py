"""Bristle friction of one node: its state, its force under a capstan load, and what raises or lowers the level g.

The state of node i is its mean bristle deflection z over `bristle_mm`, here zeta = z / delta. LuGre's dz/dt = v - |v|
z / g(v) (C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419-425,
Eq. (1)) creeps under load cycles below break-away; in its elasto-plastic form (P. Dupont, V. Hayward, B. Armstrong,
F. Altpeter, IEEE Trans. Automatic Control 47 (2002) 787-792) bristles only bend until they carry `ELASTIC_SHARE` of
g, and back whenever motion turns: d zeta = (1 - alpha s zeta / g) du / delta for a slip du in direction s, alpha 0
there and 1 beyond. Over a step in which g stands still that has the exact solution used in `deflect`, whatever the
length of the step.
"""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Contact(NamedTuple):
    """What the contacts of the M nodes are made of, and their memory."""

    grips: IntArray  # (M,) 1 where there is friction
    living: IntArray  # (M,) 1 where the level g may change: everywhere but at the pulley
    theta_pull: FloatArray  # (M,) exponent of the capstan at zeta = 1
    theta_release: FloatArray  # (M,) the same at zeta = -1
    bias: FloatArray  # (M,) N, load that does not come from the tension, times its friction coefficient
    delta: FloatArray  # (M,) mm, deflection of a bristle that carries Coulomb friction
    drag: FloatArray  # (M,) N s/mm
    level: FloatArray  # (M,) g of the step being solved
    zeta: FloatArray  # (M,) committed deflection over delta
    trial: FloatArray  # (M,) the same, being solved
    film_age: FloatArray  # (M,) s, how long the film has been where it is
    age: FloatArray  # (M,) s, how long the asperities have been in touch


class ContactLaw(NamedTuple):
    """Parameters of the contact laws; but for the first two, which a simulator has, what an effect sets, by default to nothing."""

    renewal_mm: float
    film_mm: float
    alpha: float = 0.0
    c_t: float = 0.0
    drift: float = 0.0
    drift_s: float = 1.0
    stribeck_ratio: float = 1.0
    stribeck_speed: float = 1.0
    stick_ratio: float = 1.0
    stick_s: float = 1.0  # rest after which half of the static excess is back
    dwell_b: float = 0.0
    dwell_t0: float = 1.0


# Bristles bend without yielding up to this share of the friction level.
ELASTIC_SHARE = 0.5
REFERENCE_TENSION_N = 10.0
# Adhesion of the strands to the sheath: load that is there without tension, which keeps Hertz's law finite.
ADHESION_N = 1.0


@njit(cache=True)
def deflect(zeta: float, level: float, side: float, slip: float, delta: float) -> tuple[float, float]:
    """Deflection after a slip (mm, >= 0) towards `side` (1 or -1), and its derivative with respect to that slip."""
    carried = side * zeta
    bending = max(ELASTIC_SHARE * level - carried, 0.0)
    if slip < bending * delta:
        return zeta + side * slip / delta, 1.0 / delta
    rest = level - carried - bending
    fade = exp(bending / level - slip / (delta * level))
    # Beyond its level a bristle softens; the Newton matrix takes it as yielding, which keeps it definite.
    return side * (level - rest * fade), max(rest, 0.0) * fade / (delta * level)


@njit(cache=True)
def bend_factor(law: ContactLaw, tension: float) -> tuple[float, float]:
    """Normal load over tension, one at 10 N without effects, and its derivative with respect to the tension (N).

    Load: mu N with a contact area ~ (N + N_a)^(1 - alpha), Hertz with adhesion (Derjaguin, Muller, Toporov 1975).
    Sheath: it bends by c_T a newton at first and stiffens towards three times its angle, as a coil does that closes
    on one side.
    """
    if law.alpha == 0.0 and law.c_t == 0.0:
        return 1.0, 0.0
    load = (tension + ADHESION_N) / (REFERENCE_TENSION_N + ADHESION_N)
    power, closing = load ** (-law.alpha), 1.0 + 0.5 * law.c_t * tension
    bent = 1.0 + law.c_t * tension / closing
    return power * bent, power * (law.c_t / closing**2 - bent * law.alpha / (tension + ADHESION_N))


@njit(cache=True)
def bristle_force(pull: float, release: float, bias: float, law: ContactLaw, zeta: float, tension: float) -> tuple[float, float, float]:
    """Friction (N) of a node above the tension behind it, with its derivatives by zeta and by that tension.

    Along the arc of a node dT/d phi = zeta mu T, so T_before = (T_behind + zeta b) exp(zeta theta): the capstan
    equation, its exponent theta (`pull` or `release`) scaled by the deflection of the bristles. Scalars, not a
    Contact: numba counts the references of every array it hands over.
    """
    theta = pull if zeta >= 0.0 else release
    behind = max(tension, 0.0)
    # the load on a node is that of its middle
    middle = max(1.0 + 0.5 * zeta * theta, 0.1)
    factor, slope = bend_factor(law, behind * middle)
    growth = exp(zeta * theta * factor)
    loaded = behind + zeta * bias
    by_zeta = growth * (bias + loaded * theta * (factor + 0.5 * zeta * theta * slope * behind))
    by_tension = 0.0
    if tension > 0.0:
        by_tension = growth * (1.0 + loaded * zeta * theta * slope * middle) - 1.0
    return loaded * growth - behind, by_zeta, by_tension


@njit(cache=True)
def aged(age: float, slip: float, renewal: float, dt: float) -> float:
    """Age (s) of contacts that a slip renews: d age / dt = 1 - v age / D, solved over a step of steady speed."""
    worn = slip / renewal
    if worn < 1e-9:
        return age + dt
    fade = exp(-worn)
    return age * fade + dt * (1.0 - fade) / worn


@njit(cache=True)
def level(law: ContactLaw, elapsed: float, film_age: float, age: float) -> float:
    """Friction level g of a contact, one without effects; `elapsed` is the time since the run began (s).

    Stribeck: Tustin's exponential (1947), LuGre's g(v) with exponent one, at the speed film / film_age that the film
    remembers. Static excess: rising with rest t as t^2 / (t^2 + t_h^2) (after Armstrong-Helouvry 1994, seven
    parameters). Dwell: a power of the time of contact (Rabinowicz 1958), b per e-fold for small b. Drift: by time,
    heat or wear.
    """
    found = 1.0
    if law.drift != 0.0:
        found += law.drift * exp(-elapsed / law.drift_s)
    if law.stribeck_ratio > 1.0 and film_age > 0.0:
        found *= 1.0 + (law.stribeck_ratio - 1.0) * exp(-law.film_mm / (film_age * law.stribeck_speed))
    if law.stick_ratio > 1.0:
        rest = (age / law.stick_s) ** 2
        found *= 1.0 + (law.stick_ratio - 1.0) * rest / (1.0 + rest)
    if law.dwell_b > 0.0:
        found *= (1.0 + age / law.dwell_t0) ** law.dwell_b
    return found
