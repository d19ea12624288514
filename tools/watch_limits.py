"""Print the limits of ``sstl watch``'s charts (identification/change.py), found by simulation.

Usage: python tools/watch_limits.py [--repetitions 20000]

One CUSUM side is run over normal noise with lag-one correlation 0, 0.3 and 0.5, its parameters learned from the first
K values. The limit for N loops is exceeded within N loops with probability 1 / (2 SIDES), for the worst correlation.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.identification.change import CLIP, LEARN, LOOPS, MAX_CORRELATION, SIDES, SLACK

Array = NDArray[np.float64]
CORRELATIONS = (0.0, 0.3, 0.5)
# for tails heavier than normal
MARGIN = 2


@njit(cache=True)
def highest(repetitions: int, learn: int, phi: float, marks: NDArray[np.int64], seed: int) -> Array:
    """Return, shape (repetitions, marks), the highest value of a CUSUM up to each mark."""
    np.random.seed(seed)
    out = np.empty((repetitions, marks.size))
    x = np.empty(learn)
    fresh = math.sqrt(1.0 - phi * phi)
    nu = learn - 3.0
    shrink = (8.0 * nu + 1.0) / (8.0 * nu + 3.0)
    for r in range(repetitions):
        v = np.random.randn()
        for i in range(learn):
            v = phi * v + fresh * np.random.randn()
            x[i] = v
        d = x - x.mean()
        lag = np.sum(d[1:] * d[:-1]) / np.sum(d * d)
        f = min(max(lag + (1.0 + 4.0 * lag) / learn, 0.0), MAX_CORRELATION)
        e = x[1:] - f * x[:-1]
        mean = e.mean()
        sd = math.sqrt(np.sum((e - mean) ** 2) / nu * (1.0 + 1.0 / (learn - 1)))
        total, best, j = 0.0, 0.0, 0
        for n in range(1, marks[-1] + 1):
            last = v
            v = phi * v + fresh * np.random.randn()
            t = (v - f * last - mean) / sd
            z = math.copysign(shrink * math.sqrt(nu * math.log1p(t * t / nu)), t)
            total = max(0.0, total + min(max(z, -CLIP), CLIP) - SLACK)
            best = max(best, total)
            if n == marks[j]:
                out[r, j] = best
                j += 1
    return out


def main() -> None:
    """Print the table as rows of Python."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=20000)
    repetitions = parser.parse_args().repetitions
    for learn in LEARN:
        worst = np.zeros(len(LOOPS))
        for k, phi in enumerate(CORRELATIONS):
            found = highest(repetitions, learn, phi, np.array(LOOPS), 1000 * learn + k)
            worst = np.maximum(worst, np.quantile(found, 1.0 - 1.0 / (MARGIN * SIDES), axis=0))
        print("[" + ", ".join(f"{math.ceil(10 * h) / 10:.1f}" for h in worst) + "],", flush=True)


if __name__ == "__main__":
    main()
