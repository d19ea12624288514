"""Spikes, lost and frozen samples in bursts, and a clock that wanders."""

import numpy as np
from scipy.signal import lfilter

from sstl_cli.physics.variant.effect import Effect, Reading, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

# mean length of a burst of lost or frozen samples
BURST = 6.0
LAWS = (
    Law(
        "bursts",
        "two-state bursts, exponential heights, geometric lengths, wandering clock",
        "Gilbert, Bell Syst. Tech. J. 39 (1960) 1253",
        3.0,
        10.0,
    ),
    Law("held", "lost samples show the last good one; spikes decay over some samples", "recorders with a watchdog, textbook", 2.0, 6.0),
)


def _bursts(size: int, share: float, rng: np.random.Generator, mean: float = BURST) -> Array:
    """Return which samples lie in bursts that cover about a share of the record (Gilbert's two-state channel)."""
    hit = np.zeros(size, bool)
    if share <= 0.0:
        return hit
    for start in np.flatnonzero(rng.random(size) < share / mean).tolist():
        hit[max(start, 1) : max(start, 1) + int(rng.geometric(1.0 / mean))] = True
    return hit


def _hold(signal: Array, lost: Array) -> None:
    """Let lost samples repeat the last good one, in place."""
    good = np.maximum.accumulate(np.where(lost, 0, np.arange(signal.size)))
    signal[:] = signal[good]


def wandering_clock(time: Array, share: float, law: Chosen, rng: np.random.Generator) -> Array:
    """Return the instants (s) at which the recorder really samples."""
    if share <= 0.0:
        return time
    period = float(np.min(np.diff(time)))
    if law.id == "bursts":
        step = 10.0 * share * rng.standard_normal(time.size)
        return np.asarray(time + period * np.clip(lfilter([1.0], [1.0, -0.98], step), -0.45, 0.45))
    late = rng.random(time.size) < 5.0 * share
    return np.asarray(time + period * np.where(late, rng.uniform(0.0, 0.9, time.size), 0.0))


def _sample(seen: Reading, v: Values, law: Chosen) -> None:
    seen.stamps = seen.read_at = wandering_clock(seen.time, 0.01 * v["jitter_pct"], law, seen.clock)


def _store(seen: Reading, v: Values, law: Chosen) -> None:
    size, rng, signals = seen.time.size, seen.faults, (seen.t_in, seen.t_out)
    for signal in signals:
        hit = np.flatnonzero(rng.random(size) < 0.01 * v["spike_pct"] / (law.shape if law.id == "bursts" else 1.0))
        for n in hit:
            sign = rng.choice((-1.0, 1.0))
            if law.id == "bursts":
                # heights and places of a burst are random
                places = n + rng.integers(0, 40, int(rng.geometric(1.0 / law.shape)))
                places = np.unique(places[places < size])
                signal[places] += v["spike_n"] * sign * rng.exponential(1.0, places.size)
            else:
                tail = signal[n : n + 20]
                tail += v["spike_n"] * sign * np.exp(-np.arange(tail.size) * 2.0 / law.shape)
    frozen = _bursts(size, 0.01 * v["frozen_pct"], rng, 4.0 * BURST)
    lost = _bursts(size, 0.01 * v["dropout_pct"], rng)
    for signal in signals:
        _hold(signal, frozen)
        if law.id == "held":
            _hold(signal, lost)
        else:
            signal[lost] = 0.0


EFFECT = Effect(
    {**{f"{fault}_pct": wide(0.0, 0.0, 2.0) for fault in ("spike", "dropout", "frozen", "jitter")}, "spike_n": positive(5.0, 0.5, 50.0)},
    LAWS,
    order=90,
    sample=_sample,
    store=_store,
)
