"""A random function of one coordinate, about unit size: waves, a wander, levels or pulses, bent or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FORMS = ("waves", "wander", "levels", "pulses")
BENDS = ("none", "abs", "square", "sign", "one_sided")
# knots of a wander or of levels, and places of pulses, before they repeat
KNOTS = 257


@dataclass(frozen=True)
class RandomFunction:
    """What was drawn: form, how its values are bent, the stretches it varies over, and the seed of its values.

    `waves` has one wave a stretch; the others use the first stretch alone. `tilt` weighs long waves over short ones,
    or is the share of the stretch that a pulse takes to rise.
    """

    form: str
    bend: str
    stretches: tuple[float, ...]
    tilt: float
    seed: int

    @property
    def description(self) -> str:
        """Say what it is in a few words."""
        spans = ", ".join(f"{s:.2g}" for s in self.stretches)
        return f"{self.form} of {spans}" + ("" if self.bend == "none" else f" ({self.bend})")

    def __call__(self, x: Array) -> Array:
        """Return the values at coordinates of any shape."""
        rng = np.random.default_rng(self.seed)
        y = {"waves": self._waves, "wander": self._wander, "levels": self._levels, "pulses": self._pulses}[self.form](x, rng)
        if self.bend == "abs":
            return np.asarray(np.abs(y))
        if self.bend == "square":
            return np.asarray(y * y)
        if self.bend == "sign":
            return np.asarray(np.sign(y))
        return np.asarray(np.maximum(y, 0.0)) if self.bend == "one_sided" else y

    def _waves(self, x: Array, rng: np.random.Generator) -> Array:
        weights = np.array([s**self.tilt for s in self.stretches]) * rng.uniform(0.5, 1.0, len(self.stretches))
        phases = rng.uniform(0.0, 2.0 * np.pi, len(self.stretches))
        terms = (w * np.sin(2.0 * np.pi * x / s + p) for w, s, p in zip(weights, self.stretches, phases, strict=True))
        return np.asarray(sum(terms, np.zeros(np.shape(x))) * np.sqrt(2.0 / np.sum(weights**2)))

    def _wander(self, x: Array, rng: np.random.Generator) -> Array:
        values = rng.standard_normal(KNOTS)
        at = np.mod(x / self.stretches[0], KNOTS)
        left = np.floor(at).astype(np.int64) % KNOTS
        share = at - np.floor(at)
        # half a cosine between knots: no corners
        share = 0.5 - 0.5 * np.cos(np.pi * share)
        return np.asarray(values[left] * (1.0 - share) + values[(left + 1) % KNOTS] * share)

    def _levels(self, x: Array, rng: np.random.Generator) -> Array:
        edges = np.cumsum(rng.exponential(1.0, KNOTS))
        values = rng.standard_normal(KNOTS)
        return np.asarray(values[np.searchsorted(edges, np.mod(x / self.stretches[0], edges[-1]), "right") % KNOTS])

    def _pulses(self, x: Array, rng: np.random.Generator) -> Array:
        places = np.cumsum(rng.exponential(5.0, KNOTS))
        heights = 2.0 * (rng.standard_normal(KNOTS) if rng.random() < 0.5 else rng.exponential(1.0, KNOTS))
        at = np.mod(np.asarray(x) / self.stretches[0], places[-1])
        nearest = np.searchsorted(places, at, "right")
        since = at - np.concatenate(([0.0], places))[nearest]
        height = np.concatenate(([0.0], heights))[nearest]
        rise = max(self.tilt, 0.02)
        return np.asarray(height * np.minimum(since / rise, 1.0) * np.exp(-2.0 * np.maximum(since - rise, 0.0)))


def draw_function(rng: np.random.Generator, shortest: float, longest: float) -> RandomFunction:
    """Return a random function that varies over stretches between two lengths of its coordinate."""
    form = str(rng.choice(FORMS, p=[0.4, 0.25, 0.15, 0.2]))
    count = 1 if form != "waves" else int(rng.choice((1, 2, 3, 5), p=[0.4, 0.2, 0.2, 0.2]))
    # pulses are on average five of their stretches apart
    longest = max(longest / 5.0, shortest) if form == "pulses" else longest
    stretches = tuple(float(s) for s in np.exp(rng.uniform(np.log(shortest), np.log(longest), count)))
    bend = str(rng.choice(BENDS, p=[0.6, 0.1, 0.1, 0.1, 0.1]))
    # the sign of a pulse train that is never below zero is no function
    bend = "none" if form == "pulses" and bend in ("sign", "one_sided") else bend
    return RandomFunction(form, bend, stretches, float(rng.uniform(0.0, 1.0)), int(rng.integers(2**32)))
