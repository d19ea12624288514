"""Sensors of two makes: recordings in which nothing is missing, and input and output have each a noise of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.blind import cases
from sstl_cli.blind.schedule import Entry
from sstl_cli.physics.given import NoiseSpec
from sstl_cli.physics.noise import NoiseModel, sensor_noise
from sstl_cli.steps.diagnose import DiagnoseOptions, run

SEED = 902
QUIET, SLOW, QUICK, LONG = NoiseModel(0.01), NoiseModel(0.01, 0.02, 0.3), NoiseModel(0.01, 0.025, 0.1), NoiseModel(0.01, 0.01, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("into", "out"), [(SLOW, QUIET), (QUIET, SLOW), (QUICK, LONG)])
@pytest.mark.parametrize("simulator", ["rig", "bristle", "variant"])
def test_nothing_is_missing_whichever_sensor_is_the_noisy_one(simulator, into, out):
    case = cases.draw(Entry("none"), SEED, True, simulator)
    source, _ = cases.rebuild(case.truth)
    bench = replace(source.bench, noise=NoiseSpec(0.0, 0.0, 0.3, 0.0))
    rng = np.random.default_rng(7)

    def noisy(r):
        into_n, out_n = (sensor_noise(model, len(r), 1.0 / bench.rate_hz, rng) for model in (into, out))
        return replace(r, tension_in_n=r.tension_in_n + into_n, tension_out_n=r.tension_out_n + out_n)

    runs = [noisy(r) for r in replace(source, bench=bench).record(bench.runs, {})]
    found = run(runs, DiagnoseOptions(sim=case.sim)).verdict
    assert (found.status, found.effects) == ("none", ())
