"""What the columns beside the tensions tell: how far the position goes, whether it follows the input, wraps around or rests, and the scale and lag of the reference."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification.gate import overflows
from sstl_cli.identification.gate.causes import FRICTION, UNKNOWN, Cause, best_fit, bundled, floor_of
from sstl_cli.identification.gate.movement import NO_MOVEMENT, Movement, movement_of, unlike

Array = NDArray[np.float64]
MIN_SAMPLES = 32
# correlation from which on a reference is followed
FOLLOWED = 0.9
# steps of a counter that a position must go for its rest to say anything
STEPS = 50


@dataclass(frozen=True)
class Standstill:
    """The stretch of one position in which the input moves most: its length and beginning (s), and by how much (N); ``fine`` is whether the position goes many of its steps."""

    length_s: float
    at_s: float
    moved_n: float
    fine: bool


def wrap_of(position: Array | None, x: Array) -> float:
    """Return by how much (mm) a position jumps from one end of its range to the other while the input goes on, NaN where it does not."""
    return overflows.size_n(position, overflows.turns(position, x)) if _throughout(position) else math.nan


def standstill_of(time_s: Array, position: Array | None, x: Array) -> Standstill | None:
    """Return where a position stands still, to the last digit, None where it does not or was not recorded throughout."""
    if not _throughout(position):
        return None
    steps = np.abs(np.diff(position))
    # between n samples that are alike lie n - 1 steps; a stretch of a few samples is none
    long = [(a, b + 1) for a, b in stretches(steps == 0.0) if b + 1 - a >= MIN_SAMPLES]
    if not long:
        return None
    a, b = max(long, key=lambda s: float(np.ptp(x[s[0] : s[1]])))
    fine = bool(steps.any()) and float(np.ptp(position)) > STEPS * float(np.min(steps[steps > 0.0]))
    return Standstill(float(time_s[b - 1] - time_s[a]), float(time_s[a] - time_s[0]), float(np.ptp(x[a:b])), fine)


def _throughout(position: Array | None) -> TypeGuard[Array]:
    """Whether a position was recorded in every sample of a run that is long enough to tell."""
    return position is not None and len(position) >= MIN_SAMPLES and bool(np.isfinite(position).all())


def span_of(values: Array | None) -> float:
    """Return how far a column goes, NaN where it is not recorded."""
    if values is None:
        return math.nan
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if len(finite) else math.nan


def follows_of(position: Array | None, x: Array) -> float:
    """Return the correlation of position and input, NaN where either is not recorded or does not move."""
    good = np.isfinite(position) if position is not None else np.zeros(len(x), np.bool_)
    if position is None or np.count_nonzero(good) < MIN_SAMPLES or not float(np.std(position[good])) * float(np.std(x[good])) > 0.0:
        return math.nan
    return float(np.corrcoef(position[good], x[good])[0, 1])


def instead_of(position: Array | None, points: tuple[Array, Array], noise: tuple[float, float]) -> tuple[Cause, Cause]:
    """Return what friction alone makes of a run with a position in the place of the input and of the output, which leaves a share of the output's span."""
    if not _throughout(position):
        return UNKNOWN, UNKNOWN
    x, y = points
    return _alone(position, y, noise[1]), _alone(x, position, noise[0])


def _alone(x: Array, y: Array, noise_n: float) -> Cause:
    # friction that fades over a path without end is a gain, which is what an exchange must not need
    found = best_fit(x, y, bundled(FRICTION), floor_of(noise_n, y))
    return replace(found, rms_n=found.rms_n / max(float(np.ptp(y)), 1e-300))


def column_movement(column: Array | None) -> Movement:
    """Return how a position or a reference moves, nothing where it was not recorded throughout."""
    return movement_of(column) if _throughout(column) else NO_MOVEMENT


def off_of(column: Array | None, x: Array) -> float:
    """Return by how much a column's readings are off those of the input (RMS, share of the input's span), NaN where it is not recorded or never moves."""
    pair = _recorded(column, x)
    return math.nan if pair is None else float(np.sqrt(np.mean((pair[1] - pair[0]) ** 2))) / max(float(np.ptp(x)), 1e-300)


def _recorded(reference: Array | None, x: Array) -> tuple[Array, Array] | None:
    """Return reference and input where the reference was recorded, None where that is too little or never moves."""
    if reference is None:
        return None
    good = np.isfinite(reference)
    r = reference[good]
    return None if len(r) < MIN_SAMPLES or float(np.ptp(r)) == 0.0 else (r, x[good])


def reference_gain(reference: Array | None, x: Array) -> float:
    """Return the slope of input over reference, NaN where no reference is followed."""
    pair = _recorded(reference, x)
    if pair is None or float(np.corrcoef(*pair)[0, 1]) < FOLLOWED:
        return math.nan
    return float(np.std(pair[1]) / np.std(pair[0]))


def reference_left(reference: Array | None, x: Array) -> float:
    """Return what the movement of the reference leaves of that of the input (0 where it is followed, 1 where it has nothing to do with it), NaN where there is none."""
    pair = _recorded(reference, x)
    return math.nan if pair is None else unlike(movement_of(pair[0]), movement_of(pair[1]))


def reference_lag(time_s: Array, reference: Array | None, x: Array) -> tuple[float, float]:
    """Return by how much (s) the input comes after its reference, and the standard error; NaN where no reference is followed.

    To first order, which is enough to compare two runs of one movement: what is missing of the reference is its speed times the lag.
    """
    if math.isnan(reference_gain(reference, x)) or reference is None:
        return math.nan, math.nan
    good = np.isfinite(reference)
    r, v = reference[good], x[good]
    speed = np.gradient(r, time_s[good])
    missing = r - v
    missing, speed = missing - np.mean(missing), speed - np.mean(speed)
    power = float(speed @ speed)
    if not power > 0.0:
        return math.nan, math.nan
    lag = float(speed @ missing) / power
    return lag, float(np.std(missing - lag * speed)) / math.sqrt(power)
