"""Spikes, dropouts, frozen samples and a clock that jitters."""

import numpy as np

from sstl_cli.physics.bristle.effect import Effect, FloatArray, Reading, Values
from sstl_cli.physics.given import Bounds

# Mean number of samples that one dropout or one freeze of the recorder lasts.
DROPOUT_SAMPLES, FROZEN_SAMPLES = 3.0, 12.0
# A sample is never taken nearer than this share of a period to its neighbour's place.
LARGEST_JITTER = 0.45


def _instants(time: FloatArray, sd: float, rng: np.random.Generator) -> FloatArray:
    """When the recorder really samples: every stamp off by a share of a period with this standard deviation."""
    off = np.clip(sd * rng.standard_normal(time.size), -LARGEST_JITTER, LARGEST_JITTER)
    if sd == 0.0:
        return time
    gaps = np.diff(time)
    off[0] = off[-1] = 0.0
    room: FloatArray = np.minimum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
    return time + off * room


def _stretches(size: int, share: float, mean: float, rng: np.random.Generator) -> list[slice]:
    """Stretches of samples with a geometric length, which together cover about `share` of the record."""
    starts = 1 + np.flatnonzero(rng.random(size - 1) < share / mean)
    lengths = rng.geometric(1.0 / mean, starts.size)
    return [slice(a, a + n) for a, n in zip(starts.tolist(), lengths.tolist(), strict=True)]


def _sample(seen: Reading, v: Values) -> None:
    seen.stamps = _instants(seen.time, 0.1 * v["jitter_pct"], seen.clock)


def _store(seen: Reading, v: Values) -> None:
    rng, both = seen.faults, (seen.t_in, seen.t_out)
    for signal in both:
        hit = np.flatnonzero(rng.random(signal.size) < 0.01 * v["spike_pct"])
        signal[hit] += v["spike_n"] * np.sign(rng.random(hit.size) - 0.5)
    for hold in _stretches(seen.t_in.size, 0.01 * v["frozen_pct"], FROZEN_SAMPLES, rng):
        for signal in both:
            signal[hold] = signal[hold.start - 1]
    for lost in _stretches(seen.t_in.size, 0.01 * v["dropout_pct"], DROPOUT_SAMPLES, rng):
        for signal in both:
            signal[lost] = 0.0


EFFECT = Effect(
    {**{f"{fault}_pct": Bounds(0.0, 0.0, 2.0) for fault in ("spike", "dropout", "frozen", "jitter")}, "spike_n": Bounds(5.0, 0.5, 50.0)},
    order=90,
    sample=_sample,
    store=_store,
)
