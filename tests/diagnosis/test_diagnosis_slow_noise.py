"""An output that wanders is noise of its sensor for as long as sensors do, and something without a name beyond that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from sstl_cli.core.runs import Run
from sstl_cli.steps.diagnose import DiagnoseOptions, run
from tests.diagnosis.rig_logs import record

OPTIONS = DiagnoseOptions(effects=("zero_offset", "const_friction", "zero_drift"), max_effects=1)


def wandering(runs: list[Run], lasts_s: float, size_n: float) -> list[Run]:
    """Return runs whose outputs wander as an Ornstein-Uhlenbeck process does."""
    rng = np.random.default_rng(5)
    made = []
    for r in runs:
        memory = np.exp(-float(np.median(np.diff(r.time_s))) / lasts_s)
        steps = size_n * np.sqrt(1.0 - memory**2) * rng.standard_normal(len(r))
        steps[0] = size_n * rng.standard_normal()
        made.append(replace(r, tension_out_n=r.tension_out_n + lfilter([1.0], [1.0, -memory], steps)))
    return made


@pytest.mark.parametrize(("lasts_s", "status"), [(5.0, "unknown"), pytest.param(0.3, "none", marks=pytest.mark.slow)])
def test_for_how_long_an_output_wanders_decides(lasts_s, status):
    found = run(wandering(record({}, 1), lasts_s, 0.03), OPTIONS).document()
    assert found["verdict"]["status"] == status
    assert ("wander for longer than noise of a sensor does" in found["sentence"]) == (status == "unknown")
