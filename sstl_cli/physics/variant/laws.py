"""The laws: for every effect one or more other laws than the first of the catalogue, with their sources.

A law may leave one number open (an exponent, a time constant); it is drawn between two published or plausible values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import exp, log
from zlib import crc32

import numpy as np


@dataclass(frozen=True)
class Law:
    """One law of one effect: id, equation, source, and the range of its open number (logarithmic if both > 0)."""

    id: str
    equation: str
    source: str
    low: float = 1.0
    high: float = 1.0


@dataclass(frozen=True)
class Chosen:
    """The law in force: its id, its place among the laws of the effect, and its open number."""

    id: str
    code: int
    shape: float


LAWS: dict[str, tuple[Law, ...]] = {
    "const_friction": (
        Law("adhesive", "dT = -zeta mu kappa (T + A) ds: by bend angle", "Derjaguin, Z. Phys. 88 (1934) 661: F = mu (N + A)"),
        Law("terminal", "half of w L at either end of a pass", "Catalogue, fingerprint of terminal friction; seals, textbook"),
    ),
    "pulley_friction": (
        Law("rolling", "m T (T/10)^(1/3); f0 (1 - exp(-T/2))", "Greenwood, Minshall, Tabor, Proc. R. Soc. A 259 (1961) 480", 1 / 3, 1 / 3),
        Law("bearing", "m T (T/10)^y; f0 max(1, v/v0)^(2/3)", "Palmgren, Ball and Roller Bearing Engineering (1959): M1 and M0", 0.1, 0.5),
    ),
    "load_dependent_friction": (
        Law("hertz", "mu = mu0 (1 - 3a + 3a (T/10)^(-1/3))", "Briscoe, Tabor, Wear 34 (1975) 29: shear strength on a Hertz contact"),
        Law("step", "mu = mu0 (1 + 0.69 a tanh((Ts - T) / 1.5))", "Catalogue: the tendon changes sides in the sheath", 6.0, 14.0),
    ),
    "asymmetric_friction": (
        Law("one_sided", "mu_p = mu (1 + 2a), mu_r = mu", "Section III-C2 of the paper, all of it in the pull [G]"),
        Law("by_load", "mu (1 +- a (T/10)^n)", "tilted asperities whose contact grows with load [G]", 0.33, 0.67),
    ),
    "sheath_compliance": (
        Law("beam_column", "Phi = Phi0 / (1 - c T); u = k T (1 + T/50)", "Timoshenko, Gere, Theory of Elastic Stability (1961) 1.11"),
        Law("stop", "Phi = Phi0 (1 + c Ts (1 - exp(-T/Ts)))", "coils that close, textbook", 8.0, 30.0),
    ),
    "friction_drift": (
        Law("time", "1 + d exp(-t/tau), tau = path / s", "Blau, Tribol. Int. 38 (2005) 1007: running-in by time", 3.0, 10.0),
        Law("heat", "1 + d (1 - h), dh = dW/W0 (1 - h) - h dt/tau_c", "friction heat with Newtonian cooling, textbook", 20.0, 120.0),
        Law(
            "wear",
            "1 + d exp(-W_j/W0) at each place, W = friction work",
            "Archard, J. Appl. Phys. 24 (1953) 981; Fouvry et al., Wear 255 (2003) 287",
        ),
    ),
    "tendon_crosstalk": (
        Law("pressing", "dT = -zeta mu kappa (T + c T_n 10 N) ds", "tendons that lie on one another, textbook normal force"),
        Law("stiffening", "theta (1 + c T_n / (1 + |c| T_n))", "large deflection of the tube, Howell, Compliant Mechanisms (2001)"),
    ),
    "stribeck": (
        Law("hess_soom", "1 + (r - 1) / (1 + (v/vs)^2)", "Hess, Soom, J. Tribol. 112 (1990) 147"),
        Law(
            "exponent",
            "1 + (r - 1) exp(-(v/vs)^n)",
            "Tustin, J. IEE 94 (1947) (n = 1); Bo, Pavelescu, Wear 82 (1982) 277 (n = 0.5-1)",
            0.5,
            1.2,
        ),
    ),
    "viscous": (
        Law("curvature", "c v per bend angle, none in the straight", "lubricant film under normal load, textbook"),
        Law("power", "c v0 (v/v0)^n per length", "Ostwald-de Waele shear-thinning grease", 0.5, 0.8),
        Law("eyring", "c v0 asinh(v/v0) per length", "Johnson, Tevaarwerk, Proc. R. Soc. A 356 (1977) 215", 0.5, 3.0),
    ),
    "presliding": (
        Law("dahl", "dF/du = (1 - F/Fc sgn v) 2 Fc/b", "Dahl, TOR-158(3107-18), Aerospace Corp. (1968)"),
        Law("bouc_wen", "dF = 2 Fc/b (du - (|du| F + du |F|) / (2 Fc))", "Wen, J. Eng. Mech. Div. 102 (1976) 249, n = 1, beta = gamma"),
    ),
    "stick_slip": (
        Law("kato", "1 + (r - 1)(1 - exp(-(t/tc)^m))", "Kato, Sato, Matsubayashi, J. Lubr. Technol. 94 (1972) 234", 0.36, 0.67),
        Law("armstrong", "1 + (r - 1) t / (t + tc)", "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083"),
    ),
    "dwell_aging": (
        Law("power", "1 + b ((1 + t/t0)^n - 1) / n", "Rabinowicz, Proc. Phys. Soc. 71 (1958) 668", 0.1, 0.3),
        Law("kato", "1 + L b (1 - exp(-(t/t0)^m / L)), L = 3", "Kato, Sato, Matsubayashi (1972)", 0.4, 0.7),
    ),
    "viscoelastic_creep": (
        Law("two_times", "two Kelvin elements, tau/s and tau s", "Findley, Lai, Onaran, Creep and Relaxation (1976) ch. 5", 3.0, 6.0),
        Law("power", "J = C f (t/tau)^n over four decades (Prony series)", "Findley, Lai, Onaran (1976) ch. 5; Nutting 1921", 0.15, 0.5),
    ),
    "slack": (
        Law("catenary", "gap T^2 / (T^2 + Tc^2)", "Irvine, Cable Structures (1981): excess length by 1/T^2", 0.2, 1.0),
        Law("toe", "gap (1 - exp(-T/Tc))", "toe of a rope: Feyrer, Wire Ropes (2015)", 0.2, 1.0),
    ),
    "tendon_elasticity": (
        Law(
            "stiffening",
            "e = C (T + s Ta (1 - exp(-T/Ta))), Ta = 4 N",
            "Feyrer, Wire Ropes (2015): modulus that rises with stress",
            0.3,
            0.8,
        ),
        Law(
            "hysteretic",
            "e = C (T - s z), z = stop of T, +-2 N",
            "Raoof, Hobbs, J. Eng. Mech. 114 (1988) 1166: slip between wires",
            0.15,
            0.4,
        ),
    ),
    "load_spring": (
        Law("fung", "T = k1/b (exp(b x) - 1); play over dT", "Fung, Biomechanics (1993)", 0.3, 3.0),
        Law("hysteretic", "T = k1 x + z, |z| <= 1.5 N; play over dT", "Jenkins element: Iwan, J. Appl. Mech. 33 (1966) 893", 0.3, 3.0),
    ),
    "tension_loop_lag": (
        Law("second_order", "T'' = w^2 (T_cmd - T) - 2 z w T', 2 z/w = tau", "textbook servo loop", 0.5, 0.9),
        Law("transport", "T_cmd late by tau/2, then tau/2 of first order; slew tanh", "textbook drive with transport delay"),
    ),
    "zero_offset": (
        Law("preload", "z theta / 0.53", "Catalogue: preload that grows with the bend"),
        Law("zero_return", "z (1 - exp(-max T / s))", "zero return after load, OIML R 60", 4.0, 12.0),
    ),
    "gain_error": (
        Law("both_sensors", "out sqrt(g), in 1/sqrt(g)", "only the ratio shows: both sensors share it"),
        Law("off_axis", "1 + (g - 1) 1.4 T / (T + s)", "a line of pull that straightens under load, geometry", 2.0, 6.0),
    ),
    "zero_drift": (
        Law("warm_up", "r (1 - exp(-t/tau)) / (1 - exp(-D/tau)), tau = s D", "self-heating of a bridge, textbook", 0.1, 0.4),
        Law("steps", "r in steps at random times", "zero jumps of connectors and amplifiers, textbook", 2.0, 6.0),
        Law("random_walk", "bridge of a random walk that ends at r", "flicker drift, IEEE Std 952", 0.3, 0.6),
    ),
    "channel_delay": (
        Law("jitter", "tau (1 + s n(t)), n correlated over 0.1 s", "Cervin et al., IEEE Control Syst. Mag. 23 (2003) 16", 0.15, 0.4),
        Law("bus", "held between refreshes 2 tau apart", "sample and hold of a slow bus, textbook"),
    ),
    "channel_lowpass": (
        Law("butterworth", "second order, same delay at low frequency", "Butterworth 1930"),
        Law("moving_average", "mean over the last 2 tau", "sigma-delta converters: sinc filter"),
    ),
    "crosstalk": (
        Law("both_ways", "T_i + c T_j, and s c back", "Catalogue: cross-talk both ways", 0.3, 1.0),
        Law("mounting", "T_i + c (T_i + T_j) through a common mount", "Catalogue: mounting stiffness"),
    ),
    "sensor_nonlinearity": (
        Law("cubic", "T + 2 a T (1 - (T/50)^2); three plays", "load-cell calibration polynomial, ISO 376", 0.5, 1.5),
        Law("piecewise", "slopes 1 + a and 1 - a/3 about a knee; three plays", "spring that comes to rest on a stop, textbook", 6.0, 15.0),
    ),
    "quantisation": (
        Law("truncate", "q floor(T/q)", "converter that truncates, textbook"),
        Law("deadband", "a new value once T has moved by q", "send-on-delta: Miskowicz, Sensors 6 (2006) 49"),
    ),
    "saturation": (
        Law("soft_knee", "T - w ln(1 + exp((T - Tmax)/w)), w = s Tmax", "amplifier compression, textbook", 0.01, 0.04),
        Law("wrap", "T mod Tmax", "overflow of an unsigned word, textbook"),
    ),
    "acquisition_faults": (
        Law(
            "bursts",
            "two-state bursts, exponential heights, geometric lengths, wandering clock",
            "Gilbert, Bell Syst. Tech. J. 39 (1960) 1253",
            3.0,
            10.0,
        ),
        Law("held", "lost samples show the last good one; spikes decay over some samples", "recorders with a watchdog, textbook", 2.0, 6.0),
    ),
}


def choose(given: Mapping[str, str], seed: int, effects: Iterable[str] | None = None) -> dict[str, Chosen]:
    """Return the law of every effect (or of some): as given, else drawn from a seed.

    Raises
    ------
    ValueError
        An effect or a law is unknown.
    """
    for effect in given:
        if effect not in LAWS:
            raise ValueError(f"variant: laws name the unknown effect {effect!r}{_hint(effect, LAWS)}")
    return {effect: _one(effect, given.get(effect), seed) for effect in (LAWS if effects is None else effects)}


def _one(effect: str, name: str | None, seed: int) -> Chosen:
    laws = LAWS[effect]
    rng = np.random.default_rng([seed, crc32(effect.encode())])
    code = int(rng.integers(len(laws)))
    place = float(rng.random())
    if name is not None:
        names = [law.id for law in laws]
        if name not in names:
            raise ValueError(f"variant: {effect} has no law {name!r}{_hint(name, names)} (known: {', '.join(names)})")
        code = names.index(name)
    law = laws[code]
    return Chosen(law.id, code, exp(log(law.low) + place * (log(law.high) - log(law.low))))


def _hint(name: str, known: Iterable[str]) -> str:
    near = get_close_matches(name, list(known), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""
