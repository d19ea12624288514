"""How the slopes of both systems relate: the numbers of Table I (correlation) and Table II (slopes, product)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Correlation:
    """One direction of Table I: Gamma_sstl against Gamma_act squared, all dimensionless.

    ``identity_rmse`` is that of Eq. (gamma_relation), ``slope``, ``bias`` and ``fit_rmse`` those of the
    least-squares line Gamma_sstl = slope * Gamma_act^2 + bias.
    """

    n: int
    pearson_r: float
    identity_rmse: float
    slope: float
    bias: float
    fit_rmse: float


@dataclass(frozen=True)
class Summary:
    """One entry of Table II; ``std`` has n - 1 degrees of freedom."""

    n: int
    mean: float
    std: float
    min: float
    max: float


@dataclass(frozen=True)
class Relations:
    """Tables I and II: ``correlation`` by ``pull`` and ``release``, ``slopes`` by system and quantity."""

    correlation: dict[str, Correlation]
    slopes: dict[str, dict[str, Summary]]


def correlation(gamma_sstl: Array, gamma_act: Array) -> Correlation:
    """Return one direction of Table I from paired slopes, shape (n,); what n or spread does not allow is NaN.

    Examples
    --------
    >>> correlation(np.array([0.2, 0.3, 0.4]), np.sqrt([0.2, 0.3, 0.4])).slope.__round__(6)
    1.0
    """
    squared, sstl = np.asarray(gamma_act, float) ** 2, np.asarray(gamma_sstl, float)
    n = len(sstl)
    identity = _rms(sstl - squared)
    nan = float("nan")
    if n < 2 or np.ptp(squared) == 0:
        return Correlation(n, nan, identity, nan, nan, nan)
    dx, dy = squared - squared.mean(), sstl - sstl.mean()
    slope = float(dx @ dy / (dx @ dx))
    bias = float(sstl.mean() - slope * squared.mean())
    spread = float(np.sqrt((dx @ dx) * (dy @ dy)))
    r = float(dx @ dy) / spread if spread > 0 else nan
    return Correlation(n, r, identity, slope, bias, _rms(sstl - slope * squared - bias))


def summary(values: Array) -> Summary:
    """Return mean, standard deviation and range of values, shape (n,)."""
    values = np.asarray(values, float)
    if not len(values):
        return Summary(0, *[float("nan")] * 4)
    std = float(values.std(ddof=1)) if len(values) > 1 else float("nan")
    return Summary(len(values), float(values.mean()), std, float(values.min()), float(values.max()))


def relations(sstl: Array, act: Array) -> Relations:
    """Return Tables I and II from paired slopes Gamma_p, Gamma_r, each of shape (n, 2)."""
    sstl, act = np.asarray(sstl, float).reshape(-1, 2), np.asarray(act, float).reshape(-1, 2)
    return Relations(
        {d: correlation(sstl[:, i], act[:, i]) for i, d in enumerate(("pull", "release"))},
        {
            system: {"gamma_p": summary(v[:, 0]), "gamma_r": summary(v[:, 1]), "product": summary(v[:, 0] * v[:, 1])}
            for system, v in (("act", act), ("sstl", sstl))
        },
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
