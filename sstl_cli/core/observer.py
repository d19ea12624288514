"""What the best observer of two simple hypotheses could do: the curve that a score is held against."""

from __future__ import annotations

from math import erf, log, sqrt

ODDS = log(49.0)


def ideal(d2: float) -> float:
    """Return how often an ideal observer of two simple hypotheses at this distance has odds of 49 to 1 for the true one.

    Parameters
    ----------
    d2 : float
        Squared distance in units of the noise; the log-likelihood ratio is normal with mean d2 / 2 and variance d2.

    Examples
    --------
    >>> round(ideal(24.0), 2)
    0.95
    """
    return 0.0 if d2 <= 0.0 else 0.5 * (1.0 + erf((0.5 * d2 - ODDS) / sqrt(2.0 * d2)))
