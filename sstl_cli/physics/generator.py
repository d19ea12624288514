"""Bending configurations whose propagation lines have the statistics of the paper's Tables I, II and III.

A phenomenological generator: it draws the eight numbers of a configuration, not their cause. At CP it gives
Tables I and II. For NP and ND the paper prints nothing but the range of the true slopes and the errors of
Table III, so their three numbers are guesses made to meet those: the gain of the bend, the friction that the
location adds to the sensing loop, and a scatter wider than at CP.

A linear map from the slope pair undoes any shift of the sensing loop that keeps one proportion between pull
and release. With pulley friction alike in both directions (0.18 / 0.19 / 0.22) and CP's scatter a linear
regression errs by 0.012 and a network by no less. So here NP adds to the pull direction and ND to the release
direction: the slope product then tells where the bend is, and only a curved map can use that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.scenario import Configuration, Lines

Array = NDArray[np.float64]
LEAD_STEP_MM = 2.5
# Section III-C3: mean and standard deviation of the biases (N)
BIAS_N = {"act": ((-1.444, 0.079), (-1.043, 0.047)), "sstl": ((0.033, 0.174), (4.366, 0.275))}
# ln of gamma_p, gamma_r (act), gamma_p, gamma_r (sstl): mean, slope along the standardised lead, common and own scatter
LOG_MEAN = np.array([-0.5400, 0.5228, -1.3110, 1.1919])
LOG_TREND = np.array([-0.0460, 0.0347, -0.0785, 0.1034])
COMMON = np.array([0.0035, 0.0035, 0.0118, 0.0137])
# the loop's pull slope falls faster the more the tube is bent: Table II's range is skewed to low values
LOOP_CURVE = 0.0160
OWN = np.array([0.0076, 0.0030, 0.0040, 0.0232])


@dataclass(frozen=True)
class Place:
    """How a bending location departs from CP.

    ``bend_gain`` multiplies the logarithms of all slopes; ``pull`` and ``release`` are friction added to the
    sensing loop in each direction (rad); ``scatter`` multiplies the scatter of the sensing loop between
    configurations; ``pulley_n`` is constant pulley friction (N), which only shifts the biases.
    """

    name: str
    bend_gain: float = 1.0
    pull: float = 0.0
    release: float = 0.0
    scatter: float = 1.0
    pulley_n: float = 0.0


CP = Place("CP")
PLACES = (Place("NP", 1.08, 0.165, 0.0, 2.8, -0.1), CP, Place("ND", 1.12, 0.0, 0.165, 2.8, 0.3))


def lead(count: int) -> Array:
    """Return the standardised bend along the lead, shape (count,): z of u^1.75."""
    bent = ((np.arange(count) + 0.5) / count) ** 1.75
    return np.asarray((bent - bent.mean()) / bent.std())


def log_means(place: Place, count: int) -> Array:
    """Return the mean logarithm of the four slopes at every lead, shape (count, 4)."""
    logs = place.bend_gain * (LOG_MEAN + lead(count)[:, None] * LOG_TREND)
    logs[:, 2] -= LOOP_CURVE * (lead(count) ** 2 - 1.0)
    return np.asarray(logs + np.array([0.0, 0.0, -place.pull, place.release]))


def log_covariance(place: Place, scatter: float = 1.0) -> Array:
    """Return the covariance of the logarithms about their means, shape (4, 4)."""
    cov = np.diag(OWN**2)
    for s in (slice(0, 2), slice(2, 4)):
        cov[s, s] += np.outer(COMMON[s], COMMON[s])
    widths = scatter * _widths(place)
    return np.asarray(cov * np.outer(widths, widths))


def draw_slopes(place: Place, count: int, rng: np.random.Generator, scatter: float = 1.0) -> Array:
    """Return drawn slopes, shape (count, 4), columns Gamma_p, Gamma_r of act, then of sstl."""
    shared = rng.standard_normal((2, count))
    own = rng.standard_normal((4, count))
    noise = COMMON * shared[[0, 0, 1, 1]].T + OWN * own.T
    return np.asarray(np.exp(log_means(place, count) + scatter * _widths(place) * noise))


def _widths(place: Place) -> Array:
    return np.array([1.0, 1.0, place.scatter, place.scatter])


def configurations(place: Place, count: int, rng: np.random.Generator, scatter: float = 1.0) -> list[Configuration]:
    """Return ``count`` configurations at one location, lead rising in steps of 2.5 mm.

    Parameters
    ----------
    scatter : float
        Factor on the scatter between configurations (1 gives Tables I and II).
    """
    slopes = draw_slopes(place, count, rng, scatter)
    shift = {"act": (0.0, 0.0), "sstl": (-0.5 * place.pulley_n, 1.7 * place.pulley_n)}
    biases = {s: [m + d + sd * rng.standard_normal(count) for (m, sd), d in zip(BIAS_N[s], shift[s], strict=True)] for s in BIAS_N}
    return [
        Configuration(
            id=f"{place.name}-{round(LEAD_STEP_MM * i * 10):04d}",
            location=place.name,
            lead_mm=LEAD_STEP_MM * i,
            act=Lines(gamma_p=slopes[i, 0], beta_p=biases["act"][0][i], gamma_r=slopes[i, 1], beta_r=biases["act"][1][i]),
            sstl=Lines(gamma_p=slopes[i, 2], beta_p=biases["sstl"][0][i], gamma_r=slopes[i, 3], beta_r=biases["sstl"][1][i]),
        )
        for i in range(count)
    ]


def generate(name: str, rng: np.random.Generator) -> list[Configuration]:
    """Return the configurations of a named generator: ``paper-cp40`` or ``paper-150``."""
    if name == "paper-cp40":
        return configurations(CP, 40, rng)
    return [c for place in PLACES for c in configurations(place, 50, rng)]
