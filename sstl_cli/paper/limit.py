"""The least error any mapping can reach on data of the generator: its Bayes-optimal predictor, in closed form.

A configuration is one of finitely many (location, lead) pairs, all equally likely, about which the logarithms
of the slopes scatter normally. So E[act | sstl] is a mixture of log-normal means, weighted by how likely each
pair makes the observed sensing loop; nothing is sampled or fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.generator import Place, draw_slopes, log_covariance, log_means

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """RMSE of the pull and the release slope, and the root of the mean of their squares (Table III's Total)."""

    rmse_p: float
    rmse_r: float

    @property
    def total(self) -> float:
        return float(np.sqrt(0.5 * (self.rmse_p**2 + self.rmse_r**2)))


def errors(predicted: Array, true: Array) -> Errors:
    """Return the errors of predicted slopes, shape (n, 2) each."""
    rmse = np.sqrt(np.mean((predicted - true) ** 2, axis=0))
    return Errors(float(rmse[0]), float(rmse[1]))


def bayes(sstl: Array, places: Sequence[Place], count: int) -> Array:
    """Return E[act slopes | sstl slopes], shape (n, 2), for the generator of ``count`` leads at ``places``.

    Parameters
    ----------
    sstl : ndarray, shape (n, 2)
        Slopes (Gamma_p, Gamma_r) of the sensing loop.
    """
    seen = np.log(sstl)
    weights, means = [], []
    for place in places:
        centre, cov = log_means(place, count), log_covariance(place)
        inverse = np.linalg.inv(cov[2:, 2:])
        off = seen[:, None, :] - centre[None, :, 2:]
        weights.append(-0.5 * np.einsum("nki,ij,nkj->nk", off, inverse, off) + 0.5 * np.log(np.linalg.det(inverse)))
        means.append(np.exp(centre[:, :2] + 0.5 * np.diag(cov)[:2]))
    log = np.concatenate(weights, axis=1)
    w = np.exp(log - log.max(axis=1, keepdims=True))
    return np.asarray(w @ np.concatenate(means) / w.sum(axis=1, keepdims=True))


def bayes_error(places: Sequence[Place], count: int, rng: np.random.Generator, repeats: int = 400) -> Errors:
    """Return the error of the Bayes-optimal predictor over ``repeats`` draws of the whole generator."""
    drawn = np.concatenate([draw_slopes(p, count, rng) for _ in range(repeats) for p in places])
    return errors(bayes(drawn[:, 2:], places, count), drawn[:, :2])


def linear_error(places: Sequence[Place], count: int, rng: np.random.Generator, train_share: float = 0.75) -> Errors:
    """Return the held-out error of linear regression on one draw, split at random by configuration."""
    drawn = np.concatenate([draw_slopes(p, count, rng) for p in places])
    order = rng.permutation(len(drawn))
    cut = round(train_share * len(drawn))
    design = np.column_stack([drawn[:, 2:], np.ones(len(drawn))])
    train, test = order[:cut], order[cut:]
    weights = np.linalg.lstsq(design[train], drawn[train, :2], rcond=None)[0]
    return errors(design[test] @ weights, drawn[test, :2])
