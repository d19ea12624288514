"""A limit of a sensor with noise behind it: readings scatter about the highest level while the other end of the line goes on.

A line rests, too, where its input turns, and it may do so at its highest. What tells is a play fitted to the rest of the runs:
behind a limit it goes on beyond the level by more than it is off elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import CLIPPED_LEAST, CLIPPED_MOST, CLIPPED_SIGMA, DOUBT_NATS, FINEST, HALF, START_FACTORS
from sstl_cli.identification.gate.playfit import line_beside

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Pair:
    """What both ends of the line read in one run (N, shape (n,)), and the white noise of the sensor that may be limited (N).

    ``is_out`` tells whether that is the output's.
    """

    into: Array
    out: Array
    noise_n: float
    is_out: bool

    @property
    def value(self) -> Array:
        """Readings of the sensor that may be limited (N)."""
        return self.out if self.is_out else self.into

    def short(self, line: Array) -> Array:
        """Return by how much (N) what the sensor read falls short of a line of the output (N)."""
        return line - self.out if self.is_out else self.out - line


@dataclass(frozen=True)
class Limit:
    """The level (N) of a sensor that may be its limit, which readings of each run stand there, by how much (N) the line goes beyond it on
    average, and by how much it is off elsewhere (RMS, N).
    """

    level_n: float
    there: tuple[Mask, ...]
    beyond_n: float
    off_n: float

    @property
    def share(self) -> float:
        """By which share of its tension the line is short of what it would give, beyond what it is off by elsewhere: friction that grows
        towards a turn does so for every sensor.
        """
        return float(np.sqrt(max(self.beyond_n**2 - self.off_n**2, 0.0))) / max(abs(self.level_n), self.off_n)

    def nats(self, usual: float = 0.0) -> float:
        """Return what a limit gains, beside lines that are ``usual``-ly short by a share of their tension where they rest at their highest.

        What a model misses in one rest it misses in all: together they are one number, that is off by as much as others are.
        """
        # nothing at all beyond it, or no level
        return 0.5 * (self.beyond_n / float(np.hypot(self.off_n, usual * self.level_n))) ** 2 if self.beyond_n > 0.0 else 0.0


def limit_of(pairs: Sequence[Pair]) -> Limit:
    """Return the highest level about which readings of a sensor rest in its runs, and by how much it is likelier to be a limit."""
    noise = float(np.median([p.noise_n for p in pairs]))
    values = [p.value for p in pairs]
    nowhere = tuple(np.zeros(len(v), bool) for v in values)
    # without noise a plateau of the movement is as flat
    if noise <= FINEST * max(float(np.ptp(v)) for v in values):
        return Limit(float("inf"), nowhere, 0.0, noise)
    level = _piled(np.concatenate(values), noise)
    first = np.concatenate([v[_resting(v, level, noise)] for v in values])
    level = float(np.median(first)) if len(first) else level
    # a limit lets nothing pass but the noise behind it
    if max(float(v.max()) for v in values) > level + CLIPPED_SIGMA * noise:
        return Limit(level, nowhere, 0.0, noise)
    # a reading at the limit is hardly ever further below it; what the line gives as well costs nothing to leave out
    there = tuple(_resting(v, level, noise, HALF * CLIPPED_SIGMA) for v in values)
    lines = {i: _line(p, t) for i, (p, t) in enumerate(zip(pairs, there, strict=True)) if t.any()}
    silent = {i for i, line in lines.items() if not _both_ways(line, there[i], noise)}
    short = {i: pairs[i].short(line) for i, line in lines.items() if i not in silent}
    if not short:
        return Limit(level, there, 0.0, noise)
    beyond = np.concatenate([_since_entering(s, there[i]) for i, s in short.items()])
    off = np.concatenate([s[~there[i]] for i, s in short.items()])
    found = Limit(level, there, max(float(beyond.mean()), 0.0), max(float(np.sqrt(np.mean(off**2))), noise))
    heard = [i for i in range(len(pairs)) if i not in silent]
    return found if found.nats() <= DOUBT_NATS else _with_knee(pairs, found, noise, heard)


def _since_entering(short: Array, there: Mask) -> Array:
    """Return by how much (N) a line goes beyond a level where readings rest there, above what it was off by on the way to it.

    A limit holds nothing back before it is reached; friction that is other than the line's does, over the rise as at the top.
    """
    parts = [short[a:b] - max(float(short[max(a - (b - a), 0) : a].mean()) if a else 0.0, 0.0) for a, b in stretches(there)]
    return np.concatenate(parts)


def _with_knee(pairs: Sequence[Pair], found: Limit, noise: float, heard: Sequence[int]) -> Limit:
    """Return a limit with the readings below it that an amplifier compresses before it gives out: those short by more than others are off.

    The line is fitted again without them, until they stay the same, in the runs that are ``heard``: of others none is known.
    """
    there, cut = found.there, found.level_n
    while True:
        short = np.concatenate([pairs[i].short(_line(pairs[i], there[i])) for i in heard])
        at_limit, left_out = (np.concatenate([t[i] for i in heard]) for t in (found.there, there))
        off = max(float(np.sqrt(np.mean(short[~left_out] ** 2))), noise)
        step = np.maximum((found.level_n - np.concatenate([pairs[i].value for i in heard])) / noise, 0.0).astype(int)
        mean = np.bincount(step, short) / np.maximum(np.bincount(step), 1)
        lower = found.level_n - noise * int(np.argmax(mean <= off))
        if lower >= cut:
            return Limit(found.level_n, there, max(float(short[at_limit].mean()), 0.0), off)
        cut = lower
        there = tuple(t | (p.value >= cut) for p, t in zip(pairs, found.there, strict=True))


def _both_ways(line: Array, there: Mask, noise: float) -> bool:
    """Whether a line is pulled and released elsewhere as well, so that a run tells both of its lines.

    Of one that only comes down from its highest nobody knows how far the pull had gone; of one that ends there, where the release begins.
    """
    elsewhere = ~(there[1:] | there[:-1])
    way = np.concatenate(([0.0], np.cumsum(np.where(elsewhere, np.diff(line), 0.0))))
    up, down = np.max(way - np.minimum.accumulate(way)), np.max(np.maximum.accumulate(way) - way)
    return bool(min(up, down) > CLIPPED_SIGMA * noise)


def _piled(values: Array, noise: float) -> float:
    """Return the level (N) about which most readings lie within noise, of the highest ones."""
    values = np.sort(values)
    top = values[values >= values[-1] - 2.0 * CLIPPED_SIGMA * noise]
    near = np.searchsorted(top, top + noise, "right") - np.searchsorted(top, top - noise, "left")
    return float(top[len(top) - 1 - int(np.argmax(near[::-1]))])


def _resting(value: Array, level: float, noise: float, below: float = 0.0) -> Mask:
    """Return which readings are within noise of a level, from the first to the last that is above it, or ``below`` by so many noises.

    No run is there all of the time.
    """
    found = np.zeros(len(value), bool)
    for a, b in stretches(np.abs(value - level) < CLIPPED_SIGMA * noise):
        if np.count_nonzero(value[a:b] >= level) >= CLIPPED_LEAST:
            there = a + np.flatnonzero(value[a:b] >= level - below * noise)
            found[there[0] : there[-1] + 1] = True
    return found if found.mean() < CLIPPED_MOST else np.zeros(len(value), bool)


def _line(p: Pair, there: Mask) -> Array:
    """Return the output (N) of the play between two free lines that is nearest to a run where it is not at a limit."""
    # what the tube holds back is not known yet: from as good as nothing to most of the tension
    starts = [np.array([np.exp(-wrap), 0.0, np.exp(wrap), 0.0]) for wrap in START_FACTORS]
    # behind a limit of the input the output went where no input is known
    behind = () if p.is_out else tuple(b for _, b in stretches(there) if b < len(there))
    return min((line_beside(p.into, p.out, lines, ~there, behind) for lines in starts), key=lambda found: found[1])[0]
