"""Fewer points for the same picture: extremes and the sharpest corner are kept in every stretch of time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def keep(channels: list[Array], stretches: int) -> NDArray[np.intp]:
    """Return sorted sample indices that preserve the extremes and the corner of every channel in every stretch.

    Parameters
    ----------
    channels : list of ndarray, shape (n,)
        Signals drawn against one another or against time.
    stretches : int
        Equal parts of the record; at most ``stretches * (3 * len(channels) + 1) + 1`` samples remain.

    Returns
    -------
    ndarray of int
        Indices, first and last sample included.

    Examples
    --------
    >>> import numpy as np
    >>> signal = np.zeros(1000); signal[123] = 5.0
    >>> 123 in keep([signal], 10)
    True
    """
    n = len(channels[0])
    if n <= stretches * (3 * len(channels) + 1):
        return np.arange(n)
    edges = np.linspace(0, n, stretches + 1).astype(np.intp)
    picked = [edges[:-1], np.array([n - 1], dtype=np.intp)]
    spans = list(pairwise(edges))
    for channel in channels:
        # NaN would win every comparison: it is never an extreme
        for fill, best in ((np.inf, np.argmin), (-np.inf, np.argmax)):
            values = np.where(np.isnan(channel), fill, channel)
            picked.append(np.array([a + best(values[a:b]) for a, b in spans]))
        picked.append(np.array([a + _corner(channel[a:b]) for a, b in spans]))
    return np.unique(np.concatenate(picked))


def _corner(values: Array) -> int:
    """Return the place of the largest distance from the straight line between the ends."""
    away = np.abs(values - np.linspace(values[0], values[-1], len(values)))
    return int(np.argmax(np.where(np.isnan(away), -1.0, away)))
