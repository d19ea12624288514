"""Gain of one model over another in a channel beside the output, with coloured noise taken from what the best one leaves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

Array = NDArray[np.float64]
ORDER = 10


def costs(residuals: Sequence[Array], best: int, lengths: Sequence[int]) -> list[float]:
    """Return minus the log likelihood (nats, up to a constant) of each residual under one autoregression.

    Parameters
    ----------
    residuals : sequence of ndarray, shape (samples,)
        What each model leaves, runs laid end to end.
    best : int
        Index of the model whose residual gives the noise.
    lengths : sequence of int
        Samples of each run.
    """
    ends = np.cumsum(lengths)
    slices = [slice(int(e) - n, int(e)) for e, n in zip(ends, lengths, strict=True)]
    a, sigma = _filter(residuals[best], slices)
    found = []
    for r in residuals:
        white = [lfilter(a, [1.0], r[s])[ORDER:] / sigma for s in slices]
        found.append(0.5 * float(sum(w @ w for w in white)))
    return found


def _filter(x: Array, slices: Sequence[slice]) -> tuple[Array, float]:
    """Return the autoregressive filter of a residual and the standard deviation of its innovations (Yule-Walker)."""
    acf = np.array([sum(float(x[s][lag:] @ x[s][: len(x[s]) - lag]) for s in slices) for lag in range(ORDER + 1)])
    acf = acf / max(len(x), 1)
    acf[0] = acf[0] * (1.0 + 1e-6) + 1e-14
    phi = solve_toeplitz(acf[:-1], acf[1:])
    variance = max(float(acf[0] - phi @ acf[1:]), 1e-3 * float(acf[0]), 1e-14)
    return np.concatenate(([1.0], -phi)), float(np.sqrt(variance))
