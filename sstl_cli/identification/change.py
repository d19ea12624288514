"""Change detection on a sequence of vectors with a stated false-alarm rate: CUSUM charts that learn first.

The first loops give mean, spread and lag-one correlation of every component. What follows is whitened by that
correlation, scaled by Student's t for the few loops learned from, and summed up by one-sided CUSUMs [1]_. The limits
come from simulation with the learning included (``tools/watch_limits.py``), for the worst of the lag-one correlations
0, 0.3 and 0.5: of ``SIDES`` one-sided charts together half a false alarm is to be expected in the stated number of
loops (the other half is left to noise with longer tails than normal).

.. [1] E. S. Page, Biometrika 41 (1954) 100-115; on limits with estimated parameters: W. A. Jensen et al.,
   J. Quality Technology 38 (2006) 349-364.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLACK = 1.0
# a loop far off weighs no more than this: one alone is no change
CLIP = 4.0
MAX_CORRELATION = 0.8
SIDES = 9
LEARN = (10, 15, 20, 30, 50, 100)
LOOPS = (50, 100, 200, 500, 1000, 2000, 5000)
LIMITS = np.array(
    [
        [6.1, 8.2, 10.3, 13.0, 15.2, 17.3, 21.0],
        [4.9, 6.3, 8.0, 10.3, 11.9, 13.9, 16.3],
        [4.2, 5.3, 6.4, 8.0, 9.6, 11.0, 13.0],
        [3.6, 4.4, 5.3, 6.5, 7.6, 8.5, 9.9],
        [3.0, 3.7, 4.4, 5.2, 6.0, 6.8, 7.9],
        [2.9, 3.3, 3.7, 4.5, 5.0, 5.5, 6.3],
    ]
)


def limit(learn: int, loops: float) -> float:
    """Return the limit of a CUSUM for a number of learned loops and of loops per false alarm (clipped to the table).

    Examples
    --------
    >>> limit(20, 500) > limit(50, 500) > limit(50, 100)
    True
    """
    rows = [np.interp(math.log(loops), np.log(LOOPS), row) for row in LIMITS]
    return float(np.interp(-1.0 / learn, [-1.0 / k for k in LEARN], rows))


@dataclass(frozen=True)
class Change:
    """A chart over its limit: which component, in which direction, and the observation it began with (from 0)."""

    component: int
    direction: int
    began: int
    score: float


class Chart:
    """CUSUM charts of several components that share a clock of observations.

    Parameters
    ----------
    sides : sequence of int
        Per component: 0 watches both directions, 1 only upwards.
    learn : int
        Observations to learn from, 10 to 100.
    loops : float
        Observations in which one false alarm is accepted, 50 to 5000.
    """

    def __init__(self, sides: tuple[int, ...], learn: int, loops: float) -> None:
        self.sides, self.learn = sides, learn
        self.limit = limit(learn, loops)
        c = len(sides)
        self.seen = 0
        self._first: list[list[float]] = [[] for _ in range(c)]
        self._error: list[list[float]] = [[] for _ in range(c)]
        self._fit: list[tuple[float, float, float] | None] = [None] * c
        self._last = np.full(c, np.nan)
        self.sums = np.zeros((c, 2))
        # standardised values of each side since it was last at zero, with their observations
        self._rise: list[tuple[list[tuple[int, float]], list[tuple[int, float]]]] = [([], []) for _ in range(c)]

    @property
    def learning(self) -> bool:
        """Whether no component is judged yet."""
        return all(f is None for f in self._fit)

    @property
    def learned(self) -> int:
        """How many observations the component that knows most has learned from, at most ``learn``."""
        return max(map(len, self._first))

    @property
    def level(self) -> float:
        """The highest chart as a share of its limit."""
        return float(self.sums.max()) / self.limit

    def mean(self, component: int) -> float | None:
        """Return the learned mean of a component, None while it is learned."""
        fit = self._fit[component]
        return None if fit is None else fit[1] / (1.0 - fit[0])

    def add(self, values: Array, errors: Array | None = None) -> Change | None:
        """Take one observation and return the change it completes, if any.

        Parameters
        ----------
        values : ndarray, shape (components,)
            NaN where a component is not known.
        errors : ndarray, shape (components,), optional
            Standard errors: the learned spread is not taken to be smaller than they are.
        """
        at, found = self.seen, None
        self.seen += 1
        for j, value in enumerate(values):
            if not math.isfinite(value):
                continue
            fit = self._fit[j]
            if fit is None:
                error = float(errors[j]) if errors is not None else 0.0
                self._learn(j, float(value), error if math.isfinite(error) else 0.0)
                continue
            phi, mean, sd = fit
            expected = phi * self._last[j] + mean
            t = float((value - expected) / sd)
            z = normal_of_t(t, self.learn - 3)
            if abs(z) > CLIP:
                # nor may it make the next one look odd
                z = math.copysign(CLIP, z)
                value = expected + z * sd
            self._last[j] = value
            for d, sign in enumerate((1.0, -1.0)):
                if sign < 0.0 and self.sides[j] > 0:
                    continue
                self.sums[j, d] = max(0.0, self.sums[j, d] + sign * z - SLACK)
                rise = self._rise[j][d]
                rise.append((at, sign * z))
                if self.sums[j, d] == 0.0:
                    rise.clear()
                elif self.sums[j, d] > self.limit and (found is None or self.sums[j, d] > found.score):
                    found = Change(j, int(sign), _began(rise), float(self.sums[j, d]))
        return found

    def _learn(self, j: int, value: float, error: float) -> None:
        first = self._first[j]
        first.append(value)
        self._error[j].append(error)
        if len(first) < self.learn:
            return
        x = np.array(first)
        phi = correlation(x)
        e = x[1:] - phi * x[:-1]
        mean = float(e.mean())
        variance = float(np.sum((e - mean) ** 2)) / (len(x) - 3)
        floor = float(np.mean(np.square(self._error[j]))) * (1.0 - phi * phi)
        # identical loops (a simulator without noise) leave rounding errors only
        variance = max(variance, floor, (1e-9 * max(abs(mean), 1e-3)) ** 2)
        self._fit[j] = (phi, mean, math.sqrt(variance * (1.0 + 1.0 / len(e))))
        self._last[j] = value


def _began(rise: list[tuple[int, float]]) -> int:
    """Return the observation from which a step to the latest level is most likely."""
    z = np.array([v for _, v in rise])
    level = float(np.median(z[-3:]))
    gain = np.cumsum((level * z - 0.5 * level**2)[::-1])[::-1]
    return rise[int(np.argmax(gain))][0]


def correlation(x: Array) -> float:
    """Return the lag-one correlation of a series, corrected for its length, between 0 and ``MAX_CORRELATION``."""
    d = x - x.mean()
    power = float(d @ d)
    if power <= 0.0:
        return 0.0
    r = float(d[1:] @ d[:-1]) / power
    return min(max(r + (1.0 + 4.0 * r) / len(x), 0.0), MAX_CORRELATION)


def normal_of_t(t: float, degrees: int) -> float:
    """Return the normal value as probable as a value of Student's t (D. L. Wallace, Ann. Math. Stat. 30 (1959) 1121).

    Examples
    --------
    >>> round(normal_of_t(2.228, 10), 2)
    1.96
    """
    size = (8 * degrees + 1) / (8 * degrees + 3) * math.sqrt(degrees * math.log1p(t * t / degrees))
    return math.copysign(size, t)
