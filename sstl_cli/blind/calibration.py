"""What a stated confidence is worth: the share that was right, the calibration error beside that of chance, and the slope."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind.judge import Judged
from sstl_cli.core.documents.blind import CalibrationRow, ReliabilityBin
from sstl_cli.core.rng import stream

Array = NDArray[np.float64]
BINS = 10
DRAWS = 4000
# a share may be stated as 0 or 1, which has no logit
LEAST = 1e-3
NORMAL_95 = 1.959964
STEPS = 50


def reliability(cases: Sequence[Judged]) -> tuple[list[ReliabilityBin], float | None]:
    """Return bins of stated confidence with the share that was right, and the expected calibration error.

    Verdicts without a confidence are about nothing that could be judged; they do not count.
    """
    stated, right = _said(cases)
    if not len(stated):
        return [], None
    place = _places(stated)
    rows = [
        ReliabilityBin(
            p_low=b / BINS,
            p_high=(b + 1) / BINS,
            mean_p=float(stated[place == b].mean()),
            share_right=float(right[place == b].mean()),
            n=int(np.sum(place == b)),
        )
        for b in np.unique(place).tolist()
    ]
    return rows, _error(stated - right, place)


def calibrated(name: str, cases: Sequence[Judged]) -> CalibrationRow:
    """Return how well the stated confidence of some cases is calibrated, beside what chance alone would show."""
    stated, right = _said(cases)
    mean, most = chance(stated)
    value, low, high = slope(stated, right) or (None, None, None)
    return CalibrationRow(
        cases=name,
        n=len(stated),
        stated=float(stated.mean()) if len(stated) else None,
        right=float(right.mean()) if len(stated) else None,
        ece=reliability(cases)[1],
        ece_chance=mean,
        ece_chance_95=most,
        slope=value,
        slope_low=low,
        slope_high=high,
    )


def chance(stated: Array) -> tuple[float | None, float | None]:
    """Return mean and 95 % point of the calibration error of as many verdicts that are right exactly as often as they say.

    The error is a sum of absolute values and never zero, the fewer verdicts the larger: drawn again ``DRAWS`` times, with a
    seed of its own.
    """
    if not len(stated):
        return None, None
    rng, place = stream(0, "blind", "calibration"), _places(stated)
    errors = [_error(stated - (rng.random(len(stated)) < stated), place) for _ in range(DRAWS)]
    return float(np.mean(errors)), float(np.quantile(errors, 0.95))


def slope(stated: Array, right: Array) -> tuple[float, float, float] | None:
    """Return the calibration slope with its 95 % interval: logistic regression of right on the logit of what was stated.

    1 is calibrated, less is overconfident (what is stated spreads too far), more is underconfident (Cox 1958). None where all or none
    were right, or where what was right and what was wrong lie apart: then no finite slope is the most likely one.
    """
    p = np.clip(stated, LEAST, 1.0 - LEAST)
    x, hit = np.log(p / (1.0 - p)), right > 0.5
    if hit.all() or not hit.any() or x[hit].min() >= x[~hit].max() or x[~hit].min() >= x[hit].max():
        return None
    # about the mean, so that a step does not trade the slope for the level
    design = np.column_stack((np.ones(len(x)), x - x.mean()))
    weights = np.zeros(2)
    information = np.eye(2)
    for _ in range(STEPS):
        q = 1.0 / (1.0 + np.exp(-design @ weights))
        information = design.T @ (design * (q * (1.0 - q))[:, None])
        step = np.linalg.solve(information, design.T @ (hit - q))
        # far steps overshoot where few are wrong
        weights += step / max(1.0, float(np.abs(step).max()))
        if float(np.abs(step).max()) < 1e-9:
            break
    half = NORMAL_95 * float(np.sqrt(np.linalg.inv(information)[1, 1]))
    return float(weights[1]), float(weights[1]) - half, float(weights[1]) + half


def _said(cases: Sequence[Judged]) -> tuple[Array, Array]:
    """Return what was stated, and 1 where it was right."""
    told = [(c.confidence, float(c.right)) for c in cases if c.confidence is not None]
    stated, right = np.reshape(np.array(told, dtype=float), (-1, 2)).T
    return stated, right


def _places(stated: Array) -> NDArray[np.int64]:
    return np.minimum((stated * BINS).astype(np.int64), BINS - 1)


def _error(off: Array, place: NDArray[np.int64]) -> float:
    """Return the expected calibration error: in each bin how far what was stated is from what was right, by verdicts."""
    return float(np.abs(np.bincount(place, off, BINS)).sum() / len(off))
