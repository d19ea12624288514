"""Samples that no sensor gave: a straight line without noise over a gap, and holds of a channel that is renewed far more slowly than it is logged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification.filtering import quantile
from sstl_cli.identification.gate.sensors import Sensor

Array = NDArray[np.float64]
# part of the usual distance to the line between both neighbours within which a sample lies on it: noise does so once in a hundred, in both channels
# once in ten thousand; least length (samples) of a stretch of such
ON_LINE, LEAST = 0.02, 16
# part of neighbouring distances that lie on either side of the line: of noise three in four do, of a movement hardly any
TURNS = 0.5
# quantile of these distances that is usual, however much was filled
USUAL = 0.75
# noises by which a channel must move for a stretch to be no rest, and last part of a hold in which the other channel is looked at
MOVES, LAST = 10.0, 0.25


@dataclass(frozen=True)
class Filled:
    """The longest stretch in which both channels are straight lines in time, without their noise: its beginning and length (s, 0 where there is none)."""

    at_s: float = 0.0
    length_s: float = 0.0


NOT_FILLED = Filled()


def filled_of(time_s: Array, channels: tuple[Array, Array], sensors: tuple[Sensor, Sensor]) -> Filled:
    """Return the longest stretch that was interpolated; sensors whose noise does not show tell none."""
    if any(s.coarse or s.held or s.noise_n <= 0.0 for s in sensors):
        return NOT_FILLED
    on = np.ones(max(len(time_s) - 2, 0), np.bool_)
    before, after = np.diff(time_s)[:-1], np.diff(time_s)[1:]
    for v in channels:
        off = v[1:-1] - (v[:-2] * after + v[2:] * before) / (before + after)
        straight = np.abs(off) < ON_LINE * quantile(np.abs(off), USUAL) if len(off) else on
        beside = ~straight[1:] & ~straight[:-1]
        # what has no noise is straight where it likes
        if not beside.any() or float(np.mean((off[1:] * off[:-1] < 0.0)[beside])) < TURNS:
            return NOT_FILLED
        on &= straight
    lines = [(a, b + 1) for a, b in stretches(on) if b - a >= LEAST]
    moved = [(a, b) for a, b in lines if any(abs(float(v[b] - v[a])) > MOVES * s.noise_n for v, s in zip(channels, sensors, strict=True))]
    if not moved:
        return NOT_FILLED
    a, b = max(moved, key=lambda s: s[1] - s[0])
    return Filled(float(time_s[a]), float(time_s[b] - time_s[a]))


def held_while(v: Array, other: Array, sensors: tuple[Sensor, Sensor]) -> float:
    """Return what the other channel moves by (N) in the last quarter of a good many holds of a slow one, 0 where that is its noise.

    A movement in steps is held as well, but by then the other channel has come to rest.
    """
    mine, its = sensors
    edges = np.flatnonzero(np.diff(v) != 0.0) + 1
    if not mine.held or len(edges) < 2:
        return 0.0
    first, last = edges[1:] - 1 - np.maximum((LAST * np.diff(edges)).astype(np.int64), 1), edges[1:] - 1
    # an output rests in most holds of its input, but not in all
    moved = quantile(np.abs(other[last] - other[first]), USUAL)
    return moved if moved > 3.0 * max(its.noise_n, its.step_n) else 0.0
