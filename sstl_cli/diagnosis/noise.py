"""Sensor noise measured where the output is held: in backlash nothing but noise moves it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.records import Problem, Record

Array = NDArray[np.float64]
WINDOW_S = 1.0


def hold_noise(problem: Problem, prediction: Array, slices: list[slice]) -> tuple[float, float]:
    """Return the RMS noise of the output (N) at the analysis rate and on the raw grid.

    Each hold, where the base model's output stands still, is cut into short windows; a line is
    taken out of each, so that presliding, creep or drift do not count as noise. The median over
    windows keeps jumps out.
    """
    fine, raw = [], []
    for r, s in zip(problem.records, slices, strict=True):
        held = np.concatenate((np.abs(np.diff(prediction[s])) < 1e-9, [False])) & (r.weight > 0)
        fine += _windows(r.y, held, round(WINDOW_S / (r.dt_s * r.factor)))
        step = max(1, round(r.dt_s * r.factor / r.raw.dt_s))
        held_raw = np.repeat(held, step)[: len(r.raw)]
        held_raw = np.pad(held_raw, (0, len(r.raw) - len(held_raw))) & (r.raw_weight > 0)
        raw += _windows(r.raw.tension_out_n, held_raw, round(WINDOW_S / r.raw.dt_s))
    if not fine:
        both = [_by_differences(r) for r in problem.records]
        return float(np.median([b[0] for b in both])), float(np.median([b[1] for b in both]))
    return float(np.sqrt(np.median(fine) / _MEDIAN)), float(np.sqrt(np.median(raw) / _MEDIAN)) if raw else 0.0


# the median of a mean square over many samples lies a little below its mean
_MEDIAN = 0.97


def _windows(signal: Array, held: NDArray[np.bool_], length: int) -> list[float]:
    """Return the mean square about a line in each fully held window."""
    length = max(length, 8)
    n = len(signal) // length * length
    whole = held[:n].reshape(-1, length).all(axis=1)
    blocks = signal[:n].reshape(-1, length)[whole]
    if len(blocks) == 0:
        return []
    x = np.arange(length) - (length - 1) / 2
    centred = blocks - blocks.mean(axis=1, keepdims=True)
    slope = centred @ x / (x @ x)
    return list(((centred - slope[:, None] * x) ** 2).sum(axis=1) / (length - 2))


def _by_differences(r: Record) -> tuple[float, float]:
    def white(x: Array) -> float:
        second = np.diff(x, 2)
        return 1.4826 * float(np.median(np.abs(second - np.median(second)))) / np.sqrt(6.0)

    return white(r.y), white(r.raw.tension_out_n)
