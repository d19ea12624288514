"""Fingerprints of a recording, by which a copy of it is recognised."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import fast_part
from sstl_cli.identification.gate.periodic import without_lines

Array = NDArray[np.float64]
Keys = NDArray[np.uint64]
NO_KEYS = np.empty(0, np.uint64)
# all keys are below
ALL = 2**64
# a run of a log with many keeps at least so many
LEFT = 256
FINGERPRINTS, WINDOW, LONG, FEW = 32_768, 16, 256, 64
# second differences kept, the fewest that count, and correlation of neighbours in noise
DRAWN, LEAST_DRAWN, TURNS = 1024, 64, -0.5
# part of the largest value below which they are rounding of single precision, which two runs of one movement share
ROUNDING = 3e-7


@dataclass(frozen=True)
class Prints:
    """Fingerprints of a run in ascending order: all that are less than ``below``, which are a random part of them."""

    keys: Keys
    below: int = ALL

    def __len__(self) -> int:
        return len(self.keys)

    def less(self, below: int) -> int:
        """Return how many are less than a number."""
        return len(self) if below >= self.below else int(np.searchsorted(self.keys, np.uint64(below)))

    def thinned(self, below: int) -> Prints:
        """Return those that are less than a number, or more where LEFT would not be left."""
        if below >= self.below or len(self) <= LEFT:
            return self
        count = self.less(below)
        if count < LEFT:
            count, below = LEFT, int(self.keys[LEFT])
        # a copy: the others are not kept
        return Prints(self.keys[:count].copy(), below)


NO_PRINTS = Prints(NO_KEYS)


@dataclass(frozen=True)
class Again:
    """The part of a recording's stretches that come in it more than once, and how many samples later."""

    share: float
    later: int


NEVER = Again(0.0, 0)


def copies_of(columns: Mapping[str, Array]) -> tuple[tuple[str, str], ...]:
    """Return the pairs of columns that hold the same numbers, sample by sample; what never changes is like anything."""
    moving = [name for name, v in columns.items() if bool(np.any(v[1:] != v[:-1])) and bool(np.isfinite(v).all())]
    return tuple((a, b) for a, b in combinations(moving, 2) if np.array_equal(columns[a], columns[b]))


def prints_of(x: Array, y: Array) -> Prints:
    """Return fingerprints of stretches of 16 samples, of 256 where sensors are slow; where little changes there is nothing to recognise."""
    a, b = (np.ascontiguousarray(v[: FINGERPRINTS + LONG], np.float64) for v in (x, y))
    found = _keys(a, b, WINDOW)
    return Prints(found if len(found) >= FEW else _keys(a, b, LONG))


def again_of(x: Array, y: Array) -> Again:
    """Return how much of a recording comes again in it, sample by sample.

    Of a long one the beginnings of both halves are compared.
    """
    half = max(0, (len(x) + 1) // 2)
    at = np.arange(len(x)) if half <= FINGERPRINTS else np.concatenate([np.arange(k, k + FINGERPRINTS) for k in (0, len(x) - half)])
    a, b = (np.ascontiguousarray(v[at], np.float64) for v in (x, y))
    for window in (WINDOW, LONG):
        key, lively = _all_keys(a, b, window)
        where = np.flatnonzero(lively)
        if len(where) < FEW:
            continue
        order = where[np.argsort(key[where], kind="stable")]
        same = np.flatnonzero((key[order[1:]] == key[order[:-1]]) & (order[1:] - order[:-1] >= window))
        first, second = order[same], order[same + 1]
        found = np.union1d(first, second)
        return Again(len(found) / len(where), int(np.median(at[second] - at[first]))) if len(found) else NEVER
    return NEVER


def _keys(a: Array, b: Array, window: int) -> Keys:
    key, lively = _all_keys(a, b, window)
    # numpy's own looks integers up one by one, at ten times the price
    key = np.sort(key[lively])
    return key[np.append(True, key[1:] != key[:-1])] if len(key) else NO_KEYS


def _all_keys(a: Array, b: Array, window: int) -> tuple[Keys, NDArray[np.bool_]]:
    """Return a key for each stretch, and whether enough changes in it for something to be recognised."""
    if len(a) <= window:
        return NO_KEYS, np.empty(0, np.bool_)
    key = _mixed(a.view(np.uint64), b.view(np.uint64))
    step = 1
    while step < window:
        key = _mixed(key[:-step], key[step:])
        step *= 2
    lively = np.ones(len(key), np.bool_)
    # slow sensors change one at a time
    together = [(np.diff(a) != 0.0) & (np.diff(b) != 0.0)] if window == WINDOW else [np.diff(v) != 0.0 for v in (a, b)]
    for moved in together:
        changes = np.concatenate(([0], np.cumsum(moved)))
        lively &= changes[window - 1 :] - changes[: len(changes) - window + 1] >= WINDOW // 2
    return key, lively


def _mixed(first: Keys, second: Keys) -> Keys:
    with np.errstate(over="ignore"):
        key = (first ^ (second >> np.uint64(31)) ^ (second << np.uint64(33))) * np.uint64(0x9E3779B97F4A7C15)
        return np.asarray(key ^ (key >> np.uint64(29)))


@dataclass(frozen=True)
class Sketch:
    """The fast part of both channels (``fast``, shape (2, n), n = 0 where none was drawn), each of length 1.

    ``turns`` tells whether it alternates as noise does, ``noise`` whether it is noise and no flicker between levels.

    It is that of one recording in whatever unit, with whatever zero and rounding it was written.
    """

    fast: NDArray[np.float32]
    turns: tuple[bool, bool]
    noise: tuple[bool, bool]


NO_SKETCH = Sketch(np.zeros((2, 0), np.float32), (False, False), (False, False))


def sketch_of(x: Array, y: Array, strides: tuple[int, int], fine: tuple[bool, bool]) -> Sketch:
    """Return second differences of the first thousand samples.

    ``strides`` are the samples for which a channel is held; ``fine`` tells whether noise shows between its levels.
    """
    fast = np.zeros((2, DRAWN), np.float32)
    rounding = [False, False]
    for i, (v, stride) in enumerate(zip((x, y), strides, strict=True)):
        # corners of the movement return in every run, and so does the hum of one mains
        second = fast_part(v[: (DRAWN + 2) * stride : stride])
        if len(second) < LEAST_DRAWN:
            continue
        second = without_lines(second)
        if second.any():
            size = float(np.linalg.norm(second))
            fast[i, : len(second)] = second / size
            rounding[i] = size < ROUNDING * np.sqrt(len(second)) * float(np.max(np.abs(v)))
    # those of white noise alternate with -2/3
    first, second = ((np.sum(fast[:, 1:] * fast[:, :-1], axis=1) < TURNS) & ~np.array(rounding)).tolist()
    found = Sketch(fast, (first, second), (first and fine[0], second and fine[1]))
    return found if fast.any(axis=1).all() and (first or second) else NO_SKETCH


def words_of(sketch: Sketch) -> Keys:
    """Return sixteen signs of the noise a key, with their place: two copies share many of them, whatever was rounded."""
    if not any(sketch.turns):
        return NO_KEYS
    up = sketch.fast[list(sketch.turns)] > 0.0
    words = up.reshape(len(up), -1, 16)
    telling = np.count_nonzero(words[..., 1:] != words[..., :-1], axis=2) >= 5
    packed = np.packbits(words, axis=2).view(np.uint16)[..., 0].astype(np.uint64)
    place = np.arange(words.shape[1], dtype=np.uint64) + np.flatnonzero(sketch.turns).astype(np.uint64)[:, None] * np.uint64(words.shape[1])
    found: Keys = (place * np.uint64(65_536) + packed)[telling]
    return found
