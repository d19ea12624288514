"""Recordings of a pair that swings about no tension, written out."""

from __future__ import annotations

import numpy as np

from sstl_cli.core.runs import Run

PRELOAD_N, THETA = 30.0, 0.3


def pair(name="a", period=7.0, zero_n=0.0, size=1.0, unit="N", swing_n=10.0, seconds=40.0, step_s=0.02):
    """Return a run of a pair that swings about no tension: what one tendon carries beyond the preload, written out."""
    t = np.arange(0.0, seconds, step_s)
    u = swing_n * np.sin(2.0 * np.pi * t / period) * (0.6 + 0.4 * np.sin(2.0 * np.pi * t / seconds))
    y, last = np.empty_like(u), PRELOAD_N
    for k, x in enumerate(u + PRELOAD_N):
        last = y[k] = min(max(last, np.exp(-THETA) * x), np.exp(THETA) * x)
    noise = 0.02 * np.random.default_rng(int(10 * period)).standard_normal((2, len(t)))
    seen = size * (u + noise[0]), size * (y - PRELOAD_N + noise[1] + zero_n)
    return Run(name, "act", t, *seen, config_id="a", unit_out=unit)
