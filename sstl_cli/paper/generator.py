"""Bending configurations whose propagation lines have the statistics of the paper's Tables I and II.

A phenomenological generator: it draws the eight numbers of a configuration, not their cause.
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


@dataclass(frozen=True)
class Place:
    """How a bending location departs from CP: gain of the maximum bend, extra friction of the pulley."""

    name: str
    bend_gain: float
    pulley_pull: float = 0.0
    pulley_release: float = 0.0
    pulley_n: float = 0.0


CP = Place("CP", 1.0)
# theta reaches 0.68-0.69 at NP and ND (range of Table III); pulley load differs by location
PLACES = (Place("NP", 1.08, -0.01, -0.01, -0.1), CP, Place("ND", 1.12, 0.03, 0.03, 0.3))


def configurations(place: Place, count: int, rng: np.random.Generator, scatter: float = 1.0) -> list[Configuration]:
    """Return ``count`` configurations at one location, lead rising in steps of 2.5 mm.

    Parameters
    ----------
    scatter : float
        Factor on the scatter between configurations (1 gives Tables I and II).
    """
    u = (np.arange(count) + 0.5) / count
    bent = u**1.75
    z = (bent - bent.mean()) / bent.std()
    e1, e2 = rng.standard_normal((2, count)) * scatter
    n = rng.standard_normal((4, count)) * scatter
    gp_act = -0.5400 - 0.0460 * z + 0.0035 * e1 + 0.0076 * n[0]
    gr_act = 0.5228 + 0.0347 * z + 0.0035 * e1 + 0.0030 * n[1]
    gp_sstl = -1.3141 - 0.0875 * z + 0.0137 * e2 + 0.0129 * n[2]
    gr_sstl = 1.1919 + 0.1034 * z + 0.0137 * e2 + 0.0232 * n[3]
    g = place.bend_gain
    logs = (gp_act * g, gr_act * g, gp_sstl * g - place.pulley_pull, gr_sstl * g + place.pulley_release)
    slopes = np.exp(np.array(logs))
    shift = {"act": (0.0, 0.0), "sstl": (-0.5 * place.pulley_n, 1.7 * place.pulley_n)}
    biases = {
        s: [m + d + sd * rng.standard_normal(count) for (m, sd), d in zip(BIAS_N[s], shift[s], strict=True)] for s in BIAS_N
    }
    return [
        Configuration(
            id=f"{place.name}-{round(LEAD_STEP_MM * i * 10):04d}",
            location=place.name,
            lead_mm=LEAD_STEP_MM * i,
            act=Lines(gamma_p=slopes[0, i], beta_p=biases["act"][0][i], gamma_r=slopes[1, i], beta_r=biases["act"][1][i]),
            sstl=Lines(
                gamma_p=slopes[2, i], beta_p=biases["sstl"][0][i], gamma_r=slopes[3, i], beta_r=biases["sstl"][1][i]
            ),
        )
        for i in range(count)
    ]


def generate(name: str, rng: np.random.Generator) -> list[Configuration]:
    """Return the configurations of a named generator: ``paper-cp40`` or ``paper-150``."""
    if name == "paper-cp40":
        return configurations(CP, 40, rng)
    return [c for place in PLACES for c in configurations(place, 50, rng)]
