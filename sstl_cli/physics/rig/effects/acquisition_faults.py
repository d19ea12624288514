"""Spikes, dropouts, frozen samples and a clock that jitters."""

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, FloatArray, Reading, Values

# Longest run of samples that one dropout or one freeze of the recorder lasts.
DROPOUT_RUN = 4
FROZEN_RUN = 25


def _starts(size: int, share: float, length: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Start indices of faults of `length` samples that together cover about `share` of the record."""
    if share <= 0.0:
        return np.zeros(0, dtype=np.int64)
    count = max(1, round(share * size / length))
    return np.sort(rng.choice(np.arange(1, size), size=min(count, size - 1), replace=False))


def jittered_clock(time: FloatArray, share: float, rng: np.random.Generator) -> FloatArray:
    """Instants at which the recorder really samples: a share of them up to 0.4 periods early or late."""
    shifted = time.copy()
    if share > 0.0:
        inner = np.zeros(time.size, dtype=bool)
        inner[_starts(time.size - 1, share, 1, rng)] = True
        spacing = np.minimum(np.diff(time, prepend=2 * time[0] - time[1]), np.diff(time, append=2 * time[-1] - time[-2]))
        # Below half a period, so that stamps stay in order.
        shifted[inner] += (rng.uniform(-0.4, 0.4, time.size) * spacing)[inner]
    return shifted


def _sample(seen: Reading, v: Values) -> None:
    seen.stamps = jittered_clock(seen.time, 0.01 * v["jitter_pct"], seen.clock)


def _store(seen: Reading, v: Values) -> None:
    """Write spikes (one channel), frozen stretches and dropouts to 0 N (both channels) into the records, in place."""
    size, rng, both = seen.time.size, seen.faults, (seen.t_in, seen.t_out)
    for signal in both:
        for start in _starts(size, 0.01 * v["spike_pct"], 1, rng):
            signal[start] += v["spike_n"] * rng.choice((-1.0, 1.0))
    for start in _starts(size, 0.01 * v["frozen_pct"], FROZEN_RUN, rng):
        for signal in both:
            signal[start : start + FROZEN_RUN] = signal[start - 1]
    for start in _starts(size, 0.01 * v["dropout_pct"], DROPOUT_RUN, rng):
        length = int(rng.integers(1, 2 * DROPOUT_RUN))
        for signal in both:
            signal[start : start + length] = 0.0


EFFECT = Effect(
    {**{f"{fault}_pct": Bounds(0.0, 0.0, 2.0) for fault in ("spike", "dropout", "frozen", "jitter")}, "spike_n": Bounds(5.0, 0.5, 50.0)},
    order=90,
    sample=_sample,
    store=_store,
)
