"""Records that are one hold each, and first-order coloured noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter


@dataclass
class Held:
    """What the noise of a hold is read from."""

    y: np.ndarray
    dt_s: float = 0.01
    factor: int = 1
    louder: float = 1.0
    slower: float = 1.0
    read: np.ndarray | None = None

    @property
    def weight(self):
        return np.ones(len(self.y)) if self.read is None else self.read

    @property
    def readings(self):
        return np.full(len(self.y), float(self.factor))

    def __len__(self):
        return len(self.y)


def coloured(rng, n, step_s, sd, correlation_s):
    """Return first-order coloured noise."""
    memory = np.exp(-step_s / correlation_s)
    fresh = rng.standard_normal(n) * sd * np.sqrt(1.0 - memory**2)
    fresh[0] = rng.standard_normal() * sd
    return lfilter([1.0], [1.0, -memory], fresh)
