"""Fingerprints of a recording, by which a copy of it is recognised."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Keys = NDArray[np.uint64]
NO_KEYS = np.empty(0, np.uint64)
FINGERPRINTS, WINDOW, LONG, FEW = 32_768, 16, 256, 64


def keys_of(x: Array, y: Array) -> Keys:
    """Return fingerprints of stretches of 16 samples, of 256 where sensors are slow; where little changes there is nothing to recognise."""
    a, b = (np.ascontiguousarray(v[: FINGERPRINTS + LONG], np.float64) for v in (x, y))
    found = _keys(a, b, WINDOW)
    return found if len(found) >= FEW else _keys(a, b, LONG)


def _keys(a: Array, b: Array, window: int) -> Keys:
    if len(a) <= window:
        return NO_KEYS
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
    return np.unique(key[lively])


def _mixed(first: Keys, second: Keys) -> Keys:
    with np.errstate(over="ignore"):
        key = (first ^ (second >> np.uint64(31)) ^ (second << np.uint64(33))) * np.uint64(0x9E3779B97F4A7C15)
        return np.asarray(key ^ (key >> np.uint64(29)))


def signs_of(v: Array) -> Keys:
    """Return 64 signs of second differences a key; where the signs hardly change there is no noise to recognise."""
    up = np.diff(v[: FINGERPRINTS + 2], 2) > 0.0
    words = up[: len(up) // 64 * 64].reshape(-1, 64)
    if not len(words):
        return NO_KEYS
    telling = np.count_nonzero(words[:, 1:] != words[:, :-1], axis=1) >= 20
    return np.unique(np.packbits(words[telling], axis=1).view(np.uint64).ravel())
