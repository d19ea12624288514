"""Section III-B written plainly: pandas, ``filtfilt``, ``find_peaks``, one ``RANSACRegressor`` a half loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt, find_peaks
from sklearn.linear_model import RANSACRegressor

Array = NDArray[np.float64]


def theta(path: Path, cutoff_hz: float = 10.0, prominence_n: float = 1.0, delta_n: float = 0.15) -> pd.DataFrame:
    """Return one row a run: the medians of the slopes and biases over its half loops."""
    columns = ["run_id", "time_s", "tension_in_n", "tension_out_n"]
    rows = []
    for run_id, log in pd.read_parquet(path, columns=columns).groupby("run_id", sort=False):
        rows.append({"run_id": run_id, **_run(log, cutoff_hz, prominence_n, delta_n)})
    return pd.DataFrame(rows)


def _run(log: pd.DataFrame, cutoff_hz: float, prominence_n: float, delta_n: float) -> dict[str, float]:
    time = log["time_s"].to_numpy()
    b, a = butter(2, cutoff_hz, fs=1.0 / np.median(np.diff(time)))
    x, y = (filtfilt(b, a, log[name].to_numpy()) for name in ("tension_in_n", "tension_out_n"))
    high, _ = find_peaks(x, prominence=prominence_n)
    low, _ = find_peaks(-x, prominence=prominence_n)
    turns = np.sort(np.concatenate((high, low)))
    found: dict[str, list[tuple[float, float]]] = {"p": [], "r": []}
    for start, end in zip(turns[:-1], turns[1:], strict=True):
        # backlash: until the output has left the value it was held at
        moved = np.flatnonzero(np.abs(y[start:end] - y[start]) > delta_n)
        if len(moved) < 1 or end - start - moved[0] < 20:
            continue
        part = slice(start + moved[0], end)
        line = RANSACRegressor(random_state=0).fit(x[part, None], y[part])
        fitted = line.estimator_
        found["p" if x[end] > x[start] else "r"].append((float(fitted.coef_[0]), float(fitted.intercept_)))
    values = {}
    for direction, lines in found.items():
        gamma, beta = np.median(np.array(lines), axis=0) if lines else (np.nan, np.nan)
        values[f"gamma_{direction}"], values[f"beta_{direction}"] = float(gamma), float(beta)
    return values
