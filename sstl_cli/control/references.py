"""References to track: the paper's sinusoid and random multi-sine, a trapezoid, or a file's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.sound import LARGEST, unsound

Array = NDArray[np.float64]
NAMES = ("sinusoid", "random", "trapezoid")
SINES = 8
# nearly three hours at 1 kHz; a day's pause in a file must not take the memory of the machine
MOST_PERIODS = 1e7


@dataclass(frozen=True)
class Reference:
    """A reference of the output tension: time in s, tension in N, length of its first cycle in s."""

    name: str
    time_s: Array
    tension_n: Array
    cycle_s: float

    @property
    def dt_s(self) -> float:
        return float(self.time_s[1] - self.time_s[0])


def sinusoid(
    dt_s: float = 0.002, cycles: int = 2, frequency_hz: float = 0.01, amplitude_n: float = 5.0, offset_n: float = 10.0
) -> Reference:
    """Return offset + amplitude sin(2 pi f t) over whole cycles (Section V: 0.01 Hz, 5 N, 10 N)."""
    time = _grid("sinusoid", cycles / frequency_hz, dt_s)
    tension = offset_n + amplitude_n * np.sin(2 * np.pi * frequency_hz * time)
    return Reference("sinusoid", time, tension, 1.0 / frequency_hz)


def random(
    rng: np.random.Generator,
    dt_s: float = 0.002,
    duration_s: float = 400.0,
    low_n: float = 5.0,
    high_n: float = 30.0,
    low_hz: float = 0.02,
    high_hz: float = 0.15,
) -> Reference:
    """Return a multi-sine whose overall range is [low, high] N (PAPER.md reads "5-30 N" so)."""
    time = _grid("random", duration_s, dt_s)
    frequency, angle = rng.uniform(low_hz, high_hz, SINES), rng.uniform(0, 2 * np.pi, SINES)
    amplitude = rng.uniform(0.4, 1.0, SINES)
    wave = np.zeros_like(time)
    for a, f, phi in zip(amplitude, frequency, angle, strict=True):
        wave += a * np.sin(2 * np.pi * f * time + phi)
    tension = low_n + (high_n - low_n) * (wave - wave.min()) / (wave.max() - wave.min())
    return Reference("random", time, tension, 1.0 / low_hz)


def trapezoid(dt_s: float = 0.002, duration_s: float = 12.0, cycles: int = 2, low_n: float = 5.0, high_n: float = 15.0) -> Reference:
    """Return ramps with holds: 40 % up, 5 % hold, 50 % down, 5 % hold per cycle."""
    time = _grid("trapezoid", duration_s * cycles, dt_s)
    shape = np.interp(time / duration_s % 1.0, [0.0, 0.4, 0.45, 0.95, 1.0], [0.0, 1.0, 1.0, 0.0, 0.0])
    return Reference("trapezoid", time, low_n + (high_n - low_n) * shape, duration_s)


def make(name: str, rng: np.random.Generator, dt_s: float = 0.002, cycles: int = 2) -> Reference:
    """Return a reference by its name; the random one is 400 s long whatever ``cycles``."""
    if name == "sinusoid":
        return sinusoid(dt_s, cycles)
    if name == "random":
        return random(rng, dt_s)
    if name == "trapezoid":
        return trapezoid(dt_s, cycles=cycles)
    raise SstlError(f"no reference '{name}'", fix=f"use one of {', '.join(NAMES)} or a file", code="E407")


def _grid(name: str, duration_s: float, dt_s: float) -> Array:
    """Return the times in s of whole periods, two at least."""
    periods = duration_s / dt_s
    if not 2.0 <= periods <= MOST_PERIODS:
        raise SstlError(
            f"{duration_s:g} s at {dt_s:g} s gives {periods:.6g} periods, not 2 to {MOST_PERIODS:.0e}",
            where=name,
            fix="give another period, or other cycles",
            code="E407",
        )
    return np.arange(round(periods), dtype=np.float64) * dt_s


def from_samples(name: str, time_s: Array, tension_n: Array, dt_s: float) -> Reference:
    """Return recorded samples as a reference at the controller's period, by linear interpolation.

    Raises
    ------
    SstlError
        If there are fewer than two samples, a value is not finite, or time does not rise.
    """
    time, tension = np.asarray(time_s, float), np.asarray(tension_n, float)
    if len(time) < 2:
        raise SstlError(f"reference has {len(time)} samples", where=name, fix="give at least two", code="E407")
    if unsound(time).any() or unsound(tension).any():
        what = f"reference holds values that are no finite numbers up to {LARGEST:.0e}"
        raise SstlError(what, where=name, fix="repair them", code="E407")
    if (np.diff(time) <= 0).any():
        bad = int(np.argmax(np.diff(time) <= 0)) + 1
        raise SstlError(f"time does not rise at sample {bad}", where=name, fix="sort it and drop repeats", code="E407")
    periods = float((time[-1] - time[0]) / dt_s)
    if not 1.0 - 1e-6 <= periods <= MOST_PERIODS:
        raise SstlError(
            f"{time[-1] - time[0]:g} s at {dt_s:g} s gives {periods:.6g} periods, not 1 to {MOST_PERIODS:.0e}",
            where=name,
            fix="is there a pause in it, or a longer period?",
            code="E407",
        )
    n = int(np.floor(periods + 1e-6)) + 1
    grid = np.arange(n, dtype=np.float64) * dt_s
    values = np.interp(grid + time[0], time, tension)
    return Reference(name, grid, values, first_cycle_s(grid, values))


def first_cycle_s(time_s: Array, tension_n: Array) -> float:
    """Return when the reference has turned twice by more than a tenth of its range (its end if it never does)."""
    band = 0.1 * float(np.ptp(tension_n))
    if band == 0.0:
        return float(time_s[-1])
    turns, at = 0, 0
    rising: bool | None = None
    while turns < 2:
        rest = tension_n[at:]
        if rising is None:
            moved = np.flatnonzero(np.abs(rest - rest[0]) > band)
            if not len(moved):
                return float(time_s[-1])
            rising = bool(rest[moved[0]] > rest[0])
        extreme = np.maximum.accumulate(rest) if rising else np.minimum.accumulate(rest)
        back = np.flatnonzero(np.abs(rest - extreme) > band)
        if not len(back):
            return float(time_s[-1])
        at += int(np.flatnonzero(rest[: back[0] + 1] == extreme[back[0]])[-1])
        rising = not rising
        turns += 1
    return float(time_s[at] - time_s[0])
