"""A sensor whose reading is no multiple of tension: friction behind any smooth curve of the output."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import FRICTION, Causes, bundled, guess
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.strands import played

Array = NDArray[np.float64]
# n theta that are tried, finer steps about the best one; one play, and strands that slide one after the other
WRAPS, FINER, KINDS = np.geomspace(0.04, 2.2, 17), (1.12, 1.0 / 1.12, 1.06, 1.0 / 1.06), (FRICTION, bundled(FRICTION))
# terms of the curve, and the quantiles of tension between which its slope is compared
DEGREE, ENDS = 3, (0.1, 0.9)
# what other slips must leave of the output's span for a curve to be asked for, and fewest points behind the first slide
ODD, LEAST_POINTS = 0.015, 100


@dataclass(frozen=True)
class Curve:
    """What friction behind a curve leaves (N RMS), over what any slip leaves, and the slope of the curve at high over that at low tension."""

    rms_n: float
    share: float
    ratio: float


def curve_of(x: Array, y: Array, duration_s: float, causes: Causes, play: PlayFit | None) -> Curve | None:
    """Return the curve of an output that no slip explains, None where one does or the output hardly slides.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Input and output in N.
    """
    least = min(causes.least_n(duration_s), math.inf if play is None else play.rms_n)
    if causes.enough or not least > ODD * float(np.ptp(y)):
        return None
    rms, ratio, wrap, kind = min(_curved(x, y, w, k) for k in KINDS for w in WRAPS)
    rms, ratio, *_ = min([(rms, ratio, wrap, kind), *(_curved(x, y, wrap * k, kind) for k in FINER)])
    return Curve(rms, rms / least, ratio) if math.isfinite(rms) else None


def _curved(x: Array, y: Array, wrap: float, kind: tuple[int, ...]) -> tuple[float, float, float, tuple[int, ...]]:
    """Return what a cubic of the tension behind this friction leaves (N RMS), the ratio of its slopes, and the friction."""
    tension = played(x, np.zeros(len(x)), guess(wrap, kind), np.array([x[0], len(x), math.inf, 0.0]))
    # before it first slides nothing is known of the tension
    moved = np.flatnonzero(tension != tension[0])
    if len(moved) < LEAST_POINTS:
        return math.inf, math.nan, wrap, kind
    tension, shown = tension[moved[0] :], y[moved[0] :]
    scale = float(np.max(np.abs(tension)))
    terms = np.vander(tension / scale, DEGREE + 1)
    curve = np.linalg.lstsq(terms, shown, rcond=None)[0]
    slopes = np.polyval(np.polyder(curve), np.quantile(tension / scale, ENDS))
    return float(np.sqrt(np.mean((shown - terms @ curve) ** 2))), float(slopes[1] / slopes[0]), wrap, kind
