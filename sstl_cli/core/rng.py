"""Random numbers: one named stream per purpose, the same for any order or number of workers."""

from __future__ import annotations

import zlib

import numpy as np


def stream(seed: int, *names: str | int) -> np.random.Generator:
    """Return the generator that belongs to ``seed`` and a path of names.

    Examples
    --------
    >>> float(stream(1, "noise", "run-0").random()) == float(stream(1, "noise", "run-0").random())
    True
    """
    keys = [n if isinstance(n, int) else zlib.crc32(n.encode()) for n in names]
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=tuple(keys)))


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between ``low`` and ``high`` (both positive) of which every decade is as likely."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
