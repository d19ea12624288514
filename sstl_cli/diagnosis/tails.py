"""Innovations with heavy tails: what a model is known to leave comes in jerks, not only in drifts.

Student's distribution is a Gaussian one of which each sample has a precision of its own (Lange, Little and Taylor 1989). Given
those precisions everything stays linear: they are taken from a fit's own innovations, and the fit is made anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from sstl_cli.diagnosis.constants import HEAVIEST

Array = NDArray[np.float64]


def trust(z: Array, tail: float | Array) -> Array:
    """Return the precision of every innovation over the usual one, shape (samples,); ``tail`` are degrees of freedom."""
    return np.asarray((tail + 1.0) / (tail + z**2))


def nats(z: Array, tail: float | Array) -> Array:
    """Return the negative log-density of innovations less the constant of a Gaussian one, shape (samples,) (nats)."""
    const = gammaln(0.5 * tail) - gammaln(0.5 * (tail + 1.0)) + 0.5 * np.log(0.5 * tail)
    return np.asarray(0.5 * (tail + 1.0) * np.log1p(z**2 / tail) + const)


def variance(tail: float) -> float:
    """Return the variance of Student's distribution of unit scale; of the heaviest tails, which have none, that of three degrees of freedom."""
    return max(tail, HEAVIEST) / (max(tail, HEAVIEST) - 2.0) if np.isfinite(tail) else 1.0
