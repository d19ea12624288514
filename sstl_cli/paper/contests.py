"""Table III over data sets: whether one variant beats another beyond chance.

Every data set has its own configurations, noise and division, so the differences of two variants from one data set
to the next are independent and a paired t test holds; Holm's rule bounds the chance of any false claim among the
contests [1]_. Divisions of one data set share configurations and would need a correction of their own.

.. [1] S. Holm, Scand. J. Statistics 6 (1979) 65-70.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from sstl_cli.paper.spread import Spread

NETWORKS = ("plain", "plain-inv", "skip", "skip-inv")
CONTESTS = (*((n, "linear") for n in NETWORKS), ("plain-inv", "plain"), ("skip-inv", "skip"), ("skip", "plain"), ("skip-inv", "plain-inv"))
#: blocks of the stored spread
MEAN, SEEDS, SAMPLES, DIFFERENCE, WINS = "III", "III seeds", "III samples", "III difference", "III wins"
LEVEL = 0.05


@dataclass(frozen=True)
class Contest:
    """Two variants over data sets: mean difference of Total, share of data sets the first wins, p by t and by Holm."""

    first: str
    second: str
    difference: float
    sd: float
    wins: float
    p: float
    p_holm: float

    @property
    def verdict(self) -> str:
        """Return which is better beyond chance, or nothing."""
        if self.p_holm >= LEVEL:
            return ""
        return self.first if self.difference < 0.0 else self.second


def contests(spread: Spread) -> list[Contest]:
    """Return every contest of the stored spread (none where nothing is stored)."""
    known, wins = spread.of(DIFFERENCE), spread.of(WINS)
    keys = [("III", f"{a} - {b}", "total") for a, b in CONTESTS]
    if not all(k in known for k in keys):
        return []
    p = [_p(*known[k], spread.seeds) for k in keys]
    adjusted = holm(p)
    return [Contest(a, b, *known[k], wins[k][0], p[i], adjusted[i]) for i, ((a, b), k) in enumerate(zip(CONTESTS, keys, strict=True))]


def holm(p: list[float]) -> list[float]:
    """Return p values adjusted by Holm's rule.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    order = np.argsort(p)
    raised = np.maximum.accumulate([(len(p) - k) * p[i] for k, i in enumerate(order)])
    out = np.empty(len(p))
    out[order] = np.minimum(raised, 1.0)
    return [float(round(v, 15)) for v in out]


def _p(mean: float, sd: float, n: int) -> float:
    if not sd > 0.0:
        return 1.0 if mean == 0.0 else 0.0
    return float(2.0 * stats.t.sf(abs(mean) / (sd / math.sqrt(n)), n - 1))
