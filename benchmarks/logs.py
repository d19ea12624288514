"""Logs of the benchmarks: hysteresis loops with noise, written by the product so that reading them is its usual work."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, write_runs
from sstl_cli.physics.transmission import play_operator

TRUTH = (0.583, -1.444, 1.688, -1.043)
RATE_HZ = 500.0


def loops(runs: int, samples: int, seed: int = 0, period_s: float = 12.0) -> Iterator[Run]:
    """Yield runs of sinusoidal loops (5 to 25 N) with 0.02 N of white noise on both sensors."""
    time = np.arange(samples) / RATE_HZ
    path = 15.0 - 10.0 * np.cos(2.0 * np.pi * time / min(period_s, time[-1] / 3.0))
    out = play_operator(path, *TRUTH, np.nan)
    for i in range(runs):
        noise = np.random.default_rng((seed, i)).normal(0.0, 0.02, (2, samples))
        name = f"run-{i:04d}"
        yield Run(name, "act", time, path + noise[0], out + noise[1], config_id=name, location="CP", trajectory="loop")


def write(path: Path, runs: int, samples: int, seed: int = 0) -> Path:
    """Write such a log."""
    write_runs(path, loops(runs, samples, seed), Provenance("benchmark", seed, []), force=True)
    return path
