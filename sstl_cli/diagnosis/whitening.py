"""Coloured noise: one autoregressive filter per system, taken from the richest model, applied to all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

Array = NDArray[np.float64]
ORDER = 10


@dataclass(frozen=True)
class Whitener:
    """Filters that turn the noise of each run into white noise of unit variance."""

    coefficients: tuple[Array, ...]
    scale: tuple[float, ...]
    slices: tuple[slice, ...]
    keep: Array

    def __call__(self, columns: Array) -> Array:
        """Return whitened residuals or Jacobian columns, shape (samples,) or (samples, k)."""
        out = np.empty_like(columns)
        for s, a, sigma in zip(self.slices, self.coefficients, self.scale, strict=True):
            out[s] = lfilter(a, [1.0], columns[s], axis=0) / sigma
        return out * (self.keep if columns.ndim == 1 else self.keep[:, None])


def identity(slices: list[slice], weight: Array, scale: float = 1.0) -> Whitener:
    """Return the whitener of white noise with one standard deviation (N)."""
    one = np.ones(1)
    return Whitener(tuple(one for _ in slices), tuple(scale for _ in slices), tuple(slices), weight.copy())


def fit_whitener(
    residual: Array, weight: Array, slices: list[slice], groups: list[str], order: int = ORDER
) -> Whitener:
    """Return autoregressive whiteners fitted to residuals, one per group of runs (system).

    Parameters
    ----------
    residual, weight : ndarray, shape (samples,)
        Residual of the richest model in N, and 0 where the record says nothing.
    groups : list of str
        Group of each run; runs of a group share a filter.
    """
    filters: dict[str, tuple[Array, float]] = {}
    for group in sorted(set(groups)):
        members = [s for s, g in zip(slices, groups, strict=True) if g == group]
        acf = np.zeros(order + 1)
        count = np.zeros(order + 1)
        for s in members:
            x, w = residual[s], weight[s]
            for lag in range(min(order, len(x) - 1) + 1):
                both = w[lag:] * w[: len(w) - lag]
                acf[lag] += float(np.sum(both * x[lag:] * x[: len(x) - lag]))
                count[lag] += float(both.sum())
        acf = acf / np.maximum(count, 1.0)
        acf[0] = acf[0] * (1.0 + 1e-6) + 1e-14
        phi = solve_toeplitz(acf[:-1], acf[1:])
        variance = max(float(acf[0] - phi @ acf[1:]), 1e-3 * float(acf[0]), 1e-14)
        filters[group] = (np.concatenate(([1.0], -phi)), float(np.sqrt(variance)))
    return _assemble(filters, weight, slices, groups)


def spread_whitener(
    sample: Whitener, sample_groups: list[str], weight: Array, slices: list[slice], groups: list[str]
) -> Whitener:
    """Return the filters found on some runs, applied to all runs of the same groups."""
    filters = {g: (a, s) for g, a, s in zip(sample_groups, sample.coefficients, sample.scale, strict=True)}
    return _assemble(filters, weight, slices, groups)


def _assemble(
    filters: dict[str, tuple[Array, float]], weight: Array, slices: list[slice], groups: list[str]
) -> Whitener:
    keep = np.empty_like(weight)
    for s, g in zip(slices, groups, strict=True):
        w, order = weight[s], len(filters[g][0]) - 1
        bad = np.convolve(1.0 - w, np.ones(order + 1))[: len(w)] > 0
        keep[s] = np.where(bad, 0.0, 1.0)
        # the first samples have no past: they are left out rather than guessed
        keep[s][: min(order, len(w))] = 0.0
    return Whitener(tuple(filters[g][0] for g in groups), tuple(filters[g][1] for g in groups), tuple(slices), keep)
