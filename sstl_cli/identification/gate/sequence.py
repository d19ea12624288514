"""Rows that do not follow each other as recorded: sorted by another column or as text, or of two recordings in turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, quantile
from sstl_cli.identification.gate.hum import window_of
from sstl_cli.identification.gate.periodic import without_strongest

Array = NDArray[np.float64]
Disorder = Literal["", "text", "value", "interleaved"]
# least samples, and part of its span that a step must make to be seen beside neighbours
LEAST, STANDS_OFF = 64, 0.05
# rows that stand off both neighbours in both channels: least number and part of all, and part of them whose readings lie among the others
ROWS, ROWS_SHARE, AMONG = 8, 0.005, 0.9
# steps over those of samples in any order (1) beyond which a channel is but noise
MOVES = 0.4
# how far apart (samples) two that stand off have nothing to do with one another, and nats by which chance must be beaten: one run in a hundred thousand
APART, UNLIKELY = (3, 4, 5, 6, 7, 8), 12.0
# least number of levels (part of these rows) they take: what dropped out comes back at one
LEVELS = 0.5
# part of a step to the next sample that one to the sample after it may be, and largest over smallest of the former
EVERY_OTHER, DIFFERS = 0.3, 3.0
# how like (correlation) the spectrum of the movement that of what alternates must be: of two recordings 0.5 and more, of hum 0.3 at the most;
# and the part of the frequencies on which that is seen (one over twice it)
LIKE, SLOW = 0.4, 8
# steps of the other channel (part of its span) while a sorted one never falls, and part of these that go back
ZIGZAG, BACK = 0.02, 0.3
# and the largest of these steps, by which a channel that rests goes over to another branch
FAR = 0.3


def disorder_of(channels: tuple[Array, Array]) -> Disorder:
    """Return how the rows of a run were put in another order, as both channels show it together, "" where they were not."""
    if len(channels[0]) < LEAST:
        return ""
    if _sorted(*channels) or _sorted(*channels[::-1]):
        return "value"
    if any(_alternates(v) and _between_two(v) for v in channels):
        return "interleaved"
    return "text" if _misplaced(channels) else ""


def in_turn(channels: Sequence[Array]) -> bool:
    """Return whether the rows of two recordings take turns, as two loggers write them into one file by time; of fewer than two channels nothing is known."""
    return (
        len(channels) == 2
        and all(bool(np.isfinite(v).all()) for v in channels)
        and disorder_of((channels[0], channels[1])) == "interleaved"
    )


def _sorted(v: Array, other: Array) -> bool:
    """Whether a channel never falls (or never rises) while the other one goes to and fro at every sample."""
    step, its = np.diff(v), np.diff(other)
    if not (np.all(step >= 0.0) or np.all(step <= 0.0)) or len(np.unique(v)) < LEAST // 2:
        return False
    back = float(np.mean(its[1:] * its[:-1] < 0.0))
    span = float(np.ptp(other))
    # a channel that mostly rests goes from one branch to the other now and then, but by far more than noise does
    return back > BACK and (quantile(np.abs(its), 0.75) > ZIGZAG * span or quantile(np.abs(its), 0.95) > FAR * span)


def _alternates(v: Array) -> bool:
    """Whether every sample is like the one before the last, and unlike the last, by what differs along the run: interference does not."""
    step, least = np.abs(np.diff(v)), ZIGZAG * float(np.ptp(v))
    # hardly any channel does: counting tells that their median is no more, at a tenth of its price
    if np.count_nonzero(step > least) < len(step) // 2:
        return False
    next_one, after = median(step), median(np.abs(v[2:] - v[:-2]))
    few, many = quantile(step, 0.1), quantile(step, 0.9)
    return next_one > least and after < EVERY_OTHER * next_one and many > DIFFERS * few


def _between_two(v: Array) -> bool:
    """Whether what alternates goes at the frequencies of the movement, as the difference of two recordings does.

    Hum near half the sampling rate alternates as well, but at one frequency, that of its beat: one line is taken out of both.
    """
    apart, movement = (v[:-2] - 2.0 * v[1:-1] + v[2:]) / 4.0, (v[:-2] + 2.0 * v[1:-1] + v[2:]) / 4.0
    apart[1::2] *= -1.0
    window = window_of(len(apart))
    # what both filters pass alike, so that noise of theirs is like no other
    one, two = (np.abs(np.fft.rfft(window * without_strongest(c - np.mean(c))))[1 : len(apart) // SLOW] for c in (apart, movement))
    return float(np.corrcoef(one, two)[0, 1]) > LIKE


def _misplaced(channels: tuple[Array, Array]) -> bool:
    """Whether a good many rows stand off both neighbours in both channels, and belong among the readings of other times."""
    # of noise alone any row stands off
    if any(float(np.var(np.diff(v))) > MOVES * 2.0 * float(np.var(v)) for v in channels):
        return False
    each: list[NDArray[np.bool_]] = []
    for v in channels:
        before, after = v[1:-1] - v[:-2], v[2:] - v[1:-1]
        least = STANDS_OFF * float(np.ptp(v))
        # off in the same direction from both
        off = (np.abs(before) > least) & (np.abs(after) > least) & (before * after < 0.0)
        # and by far more than these two differ
        each.append(off & (np.abs(v[2:] - v[:-2]) < 0.5 * np.minimum(np.abs(before), np.abs(after))))
    off = each[0] & each[1]
    many = int(np.count_nonzero(off))
    if many < max(ROWS, ROWS_SHARE * len(off)) or not _together(many, each[0], each[1]):
        return False
    for v in channels:
        rows, rest = v[1:-1][off], v[1:-1][~off]
        low, high = np.quantile(rest, [0.001, 0.999])
        room = 0.02 * float(high - low)
        if float(np.mean((rows > low - room) & (rows < high + room))) < AMONG or len(np.unique(rows)) < LEVELS * many:
            return False
    return True


def _together(many: int, first: NDArray[np.bool_], second: NDArray[np.bool_]) -> bool:
    """Whether samples stand off in both channels at once more often than those of two noises do that know nothing of each other.

    How often these meet by chance is seen some samples apart, where no row can be the reason: noise stands off where the tendon rests, in both channels.
    """
    by_chance = [int(np.count_nonzero(a[lag:] & b[:-lag])) for lag in APART for a, b in ((first, second), (second, first))]
    expected = max(float(np.mean(by_chance)), float(np.mean(first)) * float(np.mean(second)) * len(first))
    # logarithm of the likelihoods of so many (Poisson), as they are over by chance
    return many > expected and many * math.log(many / max(expected, 1e-300)) - (many - expected) > UNLIKELY
