"""Where a reference has just turned round, and how much of the tracking error stands there."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: a reversal region lasts until the reference has moved on by this much (N)
MOVED_N = 2.0


@dataclass(frozen=True)
class Regions:
    """Tracking error apart: RMSE (N) in reversal regions and elsewhere, largest error (N) in reversal regions."""

    reversal_n: float
    elsewhere_n: float
    peak_n: float


def near(reference_n: Array, moved_n: float = MOVED_N) -> NDArray[np.bool_]:
    """Return which samples follow a turn of the reference (N, shape (n,)) before it has moved on by ``moved_n``."""
    moving = np.flatnonzero(np.diff(reference_n))
    signs = np.sign(np.diff(reference_n))[moving]
    # a flat top turns where it ends: until then nothing has to be reversed
    turns = moving[np.flatnonzero(signs[1:] != signs[:-1]) + 1]
    mask = np.zeros(len(reference_n), dtype=bool)
    for first, last in itertools.pairwise([*turns, len(reference_n)]):
        mask[first:last] = np.abs(reference_n[first:last] - reference_n[first]) < moved_n
    return mask


def apart(reference_n: Array, output_n: Array) -> Regions:
    """Return the error of an output (N) in reversal regions and elsewhere; NaN where the reference never turns."""
    error = np.abs(np.asarray(reference_n) - np.asarray(output_n))
    inside = near(np.asarray(reference_n))
    if not inside.any() or inside.all():
        return Regions(float("nan"), float("nan"), float("nan"))
    first, other = (float(np.sqrt(np.mean(error[part] ** 2))) for part in (inside, ~inside))
    return Regions(first, other, float(error[inside].max()))
