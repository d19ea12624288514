"""Faults of the recorder, found on raw samples before anything else: frozen, spikes, clipped, quantised.

The order matters: frozen stretches hide spikes, and both fake a repeated maximum.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, pdtrc

from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import (
    CLIPPED_LEAST,
    CLIPPED_MOST,
    CLIPPED_SIGMA,
    ENOUGH_HELD,
    FEW,
    FINEST,
    FROZEN_CHANCE,
    MIN_READINGS,
    PILED_CHANCE,
    REST,
    SAME_LEVEL,
    SHORTEST_READ,
    SPIKE_RUN,
    SPIKE_SIGMA,
    SPIKE_TRAVEL,
    STEADY,
    UNSEEN,
)
from sstl_cli.diagnosis.pulses import pulses
from sstl_cli.identification.gate.sensors import quantisation

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# of normal noise this share of the readings is below that share of sigma; relative error of a sigma so found, times the root of n
BELOW = 0.3
LIES_AT = float(ndtri(0.5 * (1.0 + BELOW)))
FOURTHS_ERROR = float(np.sqrt(BELOW * (1.0 - BELOW)) / (2.0 * np.exp(-(LIES_AT**2) / 2.0) / np.sqrt(2.0 * np.pi) * LIES_AT))
# weights of a third difference
THIRD = np.diff(np.eye(1)[0], 3, prepend=np.zeros(3), append=np.zeros(3))
# relative error of the noise that third differences show, times the root of their number: they are alike next to one another
THIRDS_ERROR = float(np.sqrt((np.pi / 2.0 - 1.0) * np.sum((np.convolve(THIRD, THIRD[::-1]) / (THIRD @ THIRD)) ** 2)))


@dataclass(frozen=True)
class Faults:
    """What the recorder did to one channel of one run; masks have shape (n,)."""

    spike: Mask
    frozen: Mask
    clipped: Mask
    clip_level_n: float
    step_n: float
    noise_n: float

    @property
    def rounding_n(self) -> float:
        """RMS of what rounding to the steps of the converter leaves (N)."""
        return self.step_n / float(np.sqrt(12.0))

    @property
    def bad(self) -> Mask:
        """Samples that say nothing of the tension."""
        return self.spike | self.frozen

    def same(self, other: Faults) -> bool:
        """Whether another look at the channel found the same."""
        return all(np.array_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))


def scan(signal: Array, time: Array | None = None, recorded: Mask | None = None) -> Faults:
    """Return the recorder faults of one channel (N, shape (n,)).

    White noise is estimated from third differences, robustly, so that slopes and corners do not count.

    Parameters
    ----------
    time : ndarray, shape (n,), optional
        Instants of readings that are not equally spaced, in any unit.
    recorded : ndarray of bool, shape (n,), optional
        Which samples are readings, and no bridge over a gap (default: all).
    """
    n = len(signal)
    none = np.zeros(n, bool)
    if n < MIN_READINGS:
        return Faults(none, none, none, float("inf"), 0.0, 0.0)
    step = quantisation(signal)
    noise = white_noise(signal, recorded)
    if noise <= FINEST * float(np.ptp(signal)):
        # without noise a plateau of the movement is as flat as a clipped or a frozen one
        return Faults(none, none, none, float("inf"), 0.0, noise)
    clipped, level = _clipped(signal, noise, step)
    if clipped.any() and max(noise**2 - step**2 / 12.0, 0.0) < (0.5 * step) ** 2:
        # on a grid too coarse for the noise every rest repeats a level, not the highest alone
        _, dwell = _levels(signal)
        if dwell[-1] < REST * dwell[:-1].max():
            clipped, level = none, float("inf")
    frozen = _frozen(signal, noise, step) & ~clipped
    # what stands still has no noise
    noise = white_noise(signal, ~frozen if recorded is None else recorded & ~frozen) if frozen.any() else noise
    rest = noise
    if time is not None:
        # between the readings of a slow sensor the line moves: that is no noise to a spike, nor is what stands still
        missed = fourths(signal, time)
        rest = min(noise, white_of_fourths(missed[missed > 0.0])) if missed.any() else noise
    beside = max(rest, 0.5 * step, 1e-6)
    spike = _spikes(signal, beside, frozen | clipped) | ((pulses(signal, beside) | _dropped(signal, beside)) & ~frozen & ~clipped)
    return Faults(spike, frozen, clipped, level, step, noise)


def white_noise(signal: Array, where: Mask | None = None) -> float:
    """Return the RMS of the white noise of a signal (N), from its third differences, which no curve of a movement reaches.

    They are taken ``where`` all four samples are set, if there are enough of those. The loudest twentieth, corners and spikes, is
    left out. A mean, because a median of quantised differences is a step or nothing: evidence is weighed by it, where
    ``filtering.noise_sd`` sets thresholds. Readings that are not equally spaced, or hold long rests, go by :func:`slow_noise`.
    """
    if len(signal) < SHORTEST_READ:
        return 0.0
    third = np.abs(np.diff(signal, 3))
    if where is not None:
        inside = four_in_a_row(where)
        third = third[inside] if inside.sum() >= ENOUGH_HELD else third
    return white_of_thirds(third)


def four_in_a_row(where: Mask) -> Mask:
    """Return where a sample is set and the three behind it, shape (n - 3,)."""
    return where[:-3] & where[1:-2] & where[2:-1] & where[3:]


def white_of_thirds(sizes: Array) -> float:
    """Return the white noise (N) of readings from the sizes of their third differences; its relative error is ``THIRDS_ERROR`` over the root of n."""
    return quiet(sizes) / float(np.sqrt(THIRD @ THIRD))


def quiet(sizes: Array) -> float:
    """Return the standard deviation of normal numbers from their sizes without the loudest twentieth."""
    rest = sizes[sizes <= np.quantile(sizes, 0.95)]
    # of normal noise the smaller 95 % have this mean over sigma
    return float(rest.mean()) / 0.717


def white_beside(white: float, slow: float, memory: float) -> float:
    """Return the white part of a noise whose third differences hold slow first-order noise as well.

    Parameters
    ----------
    white : float
        What the third differences say.
    slow, memory : float
        Standard deviation of the slow noise, and what a sample keeps of it.
    """
    lags = np.convolve(THIRD, THIRD[::-1])[len(THIRD) - 1 :]
    third = float(lags[0] + 2.0 * lags[1:] @ memory ** np.arange(1.0, len(lags))) / float(lags[0])
    return float(np.sqrt(max(white**2 - third * slow**2, (UNSEEN * white) ** 2)))


def slow_noise(signal: Array, time: Array) -> float:
    """Return the RMS of the white noise (N) of a sensor so slow that it moves between readings: from where it rests.

    Its readings are not equally spaced: it is renewed on a clock of its own. What a parabola through three readings misses
    the fourth by is weighed by their instants.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants of the readings, in any unit.
    """
    missed = fourths(signal, time)
    return white_of_fourths(missed) if missed.size else 0.0


def fourths(signal: Array, time: Array, where: Mask | None = None) -> Array:
    """Return by how much (N) the parabola through three readings misses the fourth, over the noise that one reading has.

    Parameters
    ----------
    where : ndarray of bool, shape (n,), optional
        Readings that count; of four all have to (default: all).
    """
    n = len(signal)
    if n < SHORTEST_READ:
        return np.empty(0)
    near = np.stack([time[i : n - 3 + i] for i in range(4)])
    apart = near[:, None] - near[None, :] + np.eye(4)[:, :, None]
    share = 1.0 / np.prod(apart, axis=1)
    missed = np.abs(sum(share[i] * signal[i : n - 3 + i] for i in range(4))) / np.sqrt(np.sum(share**2, axis=0))
    return np.asarray(missed if where is None else missed[four_in_a_row(where)])


def white_of_fourths(missed: Array) -> float:
    """Return the white noise (N) of readings from what parabolas miss them by; its relative error is ``FOURTHS_ERROR`` over the root of n."""
    return float(np.quantile(missed, BELOW)) / LIES_AT


def _spikes(signal: Array, noise: float, known: Mask) -> Mask:
    """Flag samples that leave both neighbours' line by far and come back within two samples.

    They are looked for again without those found: where several are close to one another the largest hide the rest. ``check`` flags single
    samples in one pass against both neighbours: a pair, and one on a fast ramp, which is off the line but not beyond both, are found here alone.
    """
    spike, at = np.zeros(len(signal), bool), np.arange(len(signal))
    while True:
        rest = signal if not spike.any() else np.interp(at, at[~spike], signal[~spike])
        found = _off(rest, noise, known | spike)
        if not found.any():
            return spike
        spike |= found


def _off(signal: Array, noise: float, known: Mask) -> Mask:
    """Flag samples that stand off; at the ends of a record, where only one side is known, one sample alone."""
    spike = np.zeros(len(signal), bool)
    windows = np.lib.stride_tricks.sliding_window_view(signal, 7)
    # at the ends the first and the last seven: a sample repeated would be its own middle
    windows = windows[np.clip(np.arange(len(signal)) - 3, 0, len(windows) - 1)]
    middle = np.median(windows, axis=1)
    # a steep ramp or corner moves the median by less than the travel inside the window
    travel = np.percentile(windows, 75, axis=1) - np.percentile(windows, 25, axis=1)
    far = (np.abs(signal - middle) > SPIKE_SIGMA * noise + SPIKE_TRAVEL * travel) | _alone(signal, noise)
    for a, b in stretches(far & ~known):
        spike[a:b] = b - a <= (SPIKE_RUN if a > 0 and b < len(signal) else 1) and _back(signal, a, b, noise)
    return spike


def _back(signal: Array, a: int, b: int, noise: float) -> bool:
    """Whether the samples beside some that stand off are back on the line, but for what a clock that is off smears into them.

    What rises and falls over several samples is a movement, or an impact, however short it is.
    """
    if a < 2 or b + 2 > len(signal):
        # with one side alone: off the line through the next two, by more than those bend from the third; and farther than the channel goes
        # between two readings anywhere else, since one that comes to rest there stands off as well
        first, second, third = signal[b : b + 3] if a < 2 else signal[a - 3 : a][::-1]
        bend, most = first - 2.0 * second + third, float(np.max(np.abs(np.diff(signal[b:] if a < 2 else signal[:a]))))
        off = abs(signal[b - 1 if a < 2 else a] - 2.0 * first + second)
        return bool(off > SPIKE_SIGMA * noise + max(abs(bend), most))
    off = np.abs(signal[a - 1 : b + 1] - np.linspace(signal[a - 2], signal[b + 1], b - a + 4)[1:-1])
    return bool(max(off[0], off[-1]) <= max(SPIKE_SIGMA * noise, STEADY * off[1:-1].max()))


def _alone(signal: Array, noise: float) -> Mask:
    """Flag samples that a cubic through two neighbours on either side misses by far, where those go on as before.

    A ramp moves it by nothing; a corner or a jump by less than by how much the steps around differ.
    """
    alone = np.zeros(len(signal), bool)
    step = np.diff(signal)
    before, after = np.stack((step[:-5], step[1:-4])), np.stack((step[4:-1], step[5:]))
    around = np.concatenate((before, after))
    # over the sample itself the line goes on by twice a step
    over = np.abs(signal[4:-2] - signal[2:-4] - 2.0 * np.median(around, axis=0))
    near, far = signal[2:-4] + signal[4:-2], signal[1:-5] + signal[5:-1]
    missed = np.abs(signal[3:-3] - 0.5 * near - (near - far) / 6.0)
    alone[3:-3] = missed > SPIKE_SIGMA * noise + np.maximum(np.ptp(around, axis=0), over)
    return alone


def _frozen(signal: Array, noise: float, step: float) -> Mask:
    """Flag runs of exactly equal samples that noise above the quantisation step cannot make."""
    frozen = np.zeros(len(signal), bool)
    # rounding is part of what second differences show; without noise of the sensor a hold repeats its level for ever
    sensor = float(np.sqrt(max(noise**2 - step**2 / 12.0, 0.0)))
    if noise <= 0.0 or sensor < 0.5 * step:
        return frozen
    # the difference of two readings has this density at 0, and a level is a step wide: at most every other reading repeats
    repeat = step / (2.0 * np.sqrt(np.pi) * sensor) if step > 0 else 1e-6
    need = FEW
    while repeat ** (need - 1) * len(signal) > FROZEN_CHANCE:
        need += 1
    for a, b in stretches(np.concatenate(([False], np.diff(signal) == 0.0))):
        if b - a + 1 >= need:
            frozen[a:b] = True
    return frozen


def _dropped(signal: Array, noise: float) -> Mask:
    """Flag samples that repeat one reading off those on either side, all to one side: a channel that dropped out and came back.

    A sensor that is held between its readings repeats all of them, and its turning points stand off as well.
    """
    dropped, repeats = np.zeros(len(signal), bool), np.concatenate(([False], np.diff(signal) == 0.0))
    for second, end in stretches(repeats):
        first = second - 1
        if end - first <= SPIKE_RUN or first < 2 or end + 2 > len(signal):
            continue
        others = (repeats.sum() - (end - second)) / len(signal)
        before, after = signal[second] - signal[first - 1], signal[second] - signal[end]
        moved = max(abs(signal[first - 1] - signal[first - 2]), abs(signal[end + 1] - signal[end]), abs(before - after))
        off = min(abs(before), abs(after)) > SPIKE_SIGMA * noise + SPIKE_TRAVEL * moved
        dropped[first:end] = off and before * after > 0.0 and others ** (end - second) < FROZEN_CHANCE
    return dropped


def limited(signal: Array) -> Mask:
    """Return which samples of one channel stand at a limit of the recorder, shape (n,)."""
    noise = white_noise(signal)
    # without noise a plateau of the movement is as flat
    return _clipped(signal, noise, quantisation(signal))[0] if noise > FINEST * float(np.ptp(signal)) else np.zeros(len(signal), bool)


def _clipped(signal: Array, noise: float, step: float) -> tuple[Mask, float]:
    """Return which samples stand at a limit of the recorder, and its level (infinity if there is none).

    Below its highest reading a signal with noise thins out; at a limit readings pile up. How many chance puts on one level
    is known from how many lie just below, and from how finely readings are told apart.
    """
    # a reading or two may be beyond it by what a recorder adds later; not by as much as noise
    levels, counts = _levels(signal[signal >= signal.max() - noise])
    most = len(counts) - 1 - int(np.argmax(counts[::-1]))
    top, count = float(levels[most]), int(counts[most])
    flat, window = signal >= top, CLIPPED_SIGMA * max(noise, step)
    none = np.zeros(len(signal), bool), float("inf")
    if count < CLIPPED_LEAST or flat.mean() >= CLIPPED_MOST:
        return none
    below = _levels(signal[(signal > top - window) & ~flat])
    finest = step if step > 0.0 else float(np.min(np.diff(below[0]), initial=window))
    if pdtrc(count - 1, below[1].sum() * finest / window) > PILED_CHANCE:
        return none
    # on a grid a rest repeats its level as well, if not so often and in a row
    longest = max(b - a for a, b in stretches(flat))
    return none if step > 0.0 and (longest < FEW or count < 2 * FEW) else (flat, top)


def _levels(values: Array) -> tuple[Array, Array]:
    """Return the levels of values and how often each was read; what the arithmetic of a unit tells apart is one level."""
    levels, counts = np.unique(values, return_counts=True)
    first = np.diff(levels, prepend=-np.inf) > SAME_LEVEL * np.abs(levels)
    return levels[first], np.bincount(np.cumsum(first) - 1, counts).astype(np.int64)
