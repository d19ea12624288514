"""Sensors of two makes: recordings in which nothing is missing, and input and output have each a noise of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from sstl_cli.blind import cases
from sstl_cli.blind.schedule import Entry
from sstl_cli.physics.given import NoiseSpec
from sstl_cli.steps.diagnose import DiagnoseOptions, run

SEED = 902
# white, slow noise (N) and how long that lasts (s)
QUIET, SLOW, QUICK, LONG = (0.01, 0.0, 0.3), (0.01, 0.02, 0.3), (0.01, 0.025, 0.1), (0.01, 0.01, 1.0)


def noise(rng, time_s, white_n, slow_n, slow_s):
    memory = np.exp(-np.median(np.diff(time_s)) / slow_s)
    fresh = np.sqrt(1.0 - memory**2) * rng.standard_normal(len(time_s))
    slow = lfilter([1.0], [1.0, -memory], fresh, zi=[memory * rng.standard_normal()])[0]
    return white_n * rng.standard_normal(len(time_s)) + slow_n * slow


@pytest.mark.slow
@pytest.mark.parametrize(("into", "out"), [(SLOW, QUIET), (QUIET, SLOW), (QUICK, LONG)])
@pytest.mark.parametrize("simulator", ["rig", "bristle", "variant"])
def test_nothing_is_missing_whichever_sensor_is_the_noisy_one(simulator, into, out):
    case = cases.draw(Entry("none"), SEED, True, simulator)
    source, _ = cases.rebuild(case.truth)
    bench = replace(source.bench, noise=NoiseSpec(0.0, 0.0, 0.3, 0.0))
    rng = np.random.default_rng(7)
    runs = [
        replace(r, tension_in_n=r.tension_in_n + noise(rng, r.time_s, *into), tension_out_n=r.tension_out_n + noise(rng, r.time_s, *out))
        for r in replace(source, bench=bench).record(bench.runs, {})
    ]
    found = run(runs, DiagnoseOptions(sim=case.sim)).verdict
    assert (found.status, found.effects) == ("none", ())
