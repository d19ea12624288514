"""How well an output follows its reference: RMSE, STD of the signed error, MAPE with a stated floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
MAPE_FLOOR_N = 0.5
WINDOW_ALL, WINDOW_STEADY = "all", "without first cycle"


@dataclass(frozen=True)
class Score:
    """Tracking scores over one window; ``mape_pct`` is None where every sample is below the floor."""

    rmse_n: float
    std_n: float
    mape_pct: float | None
    mape_floor_n: float
    masked_pct: float
    mape_bound_pct: float | None


def score(reference_n: Array, output_n: Array, floor_n: float = MAPE_FLOOR_N) -> Score:
    """Return the scores of an output against its reference (N, shape (n,) each), Eq. (mape).

    Samples whose reference is below ``floor_n`` are left out of MAPE and counted in ``masked_pct``.
    ``mape_bound_pct`` is 100 rmse rms(1 / reference): no MAPE over the same samples can be larger.

    Raises
    ------
    SstlError
        If the arrays are empty, unequal in length or hold values that are not finite.
    """
    if len(reference_n) == 0 or len(reference_n) != len(output_n):
        raise SstlError(f"cannot score {len(output_n)} samples against {len(reference_n)}", code="E409")
    error = np.asarray(reference_n) - np.asarray(output_n)
    if not np.isfinite(error).all():
        raise SstlError(f"{int((~np.isfinite(error)).sum())} samples to be scored are not numbers", code="E409")
    rmse = float(np.sqrt(np.mean(error**2)))
    kept = reference_n >= floor_n
    mape = bound = None
    if kept.any():
        inverse = 1.0 / reference_n[kept]
        mape = float(100.0 * np.mean(np.abs(error[kept]) * inverse))
        bound = float(100.0 * np.sqrt(np.mean(error[kept] ** 2) * np.mean(inverse**2)))
    return Score(rmse, float(np.std(error)), mape, floor_n, float(100.0 * np.mean(~kept)), bound)


def windows(time_s: Array, cycle_s: float) -> dict[str, slice]:
    """Return the scoring windows: all samples, and those after the first cycle where any are left."""
    found = {WINDOW_ALL: slice(None)}
    first = int(np.searchsorted(time_s - time_s[0], cycle_s - 1e-9))
    if 0 < first < len(time_s) - 1:
        found[WINDOW_STEADY] = slice(first, None)
    return found


def reduction_pct(rmse_n: float, baseline_n: float | None) -> float | None:
    """Return the reduction of RMSE against the baseline in percent (None without a baseline)."""
    if baseline_n is None or baseline_n <= 0.0:
        return None
    return 100.0 * (1.0 - rmse_n / baseline_n)
