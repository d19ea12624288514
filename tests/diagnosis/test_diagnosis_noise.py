"""Noise of the output where faults of the recorder are judged by it."""

from types import SimpleNamespace

import numpy as np
import pytest
from rig_logs import SHORT, record

from sstl_cli.diagnosis import faults
from sstl_cli.diagnosis.noise import measured
from sstl_cli.diagnosis.records import prepare
from sstl_cli.physics.scenario import Scenario


@pytest.mark.parametrize("hz", [1000.0, 4000.0])
def test_readings_are_held_against_the_noise_of_a_reading_at_any_rate(hz, monkeypatch):
    """The output's noise is known of means over a step of the simulation: at 4 kHz of four readings, half as large."""
    problem = prepare(record({}, hz=hz, moves=SHORT[1:2], configs=1), 1.0)
    known = measured(problem.records, np.ones(sum(len(r) for r in problem.records)))
    sim = SimpleNamespace(problem=problem, predict_fine=lambda theta, effects: [None] * len(problem.records))
    found = SimpleNamespace(sim=sim, noise=known, base=SimpleNamespace(theta=None, effects={}))
    told = []
    monkeypatch.setattr(faults, "recorder_effects", lambda r, p, noise_n, known: told.append(noise_n) or [])
    assert faults.beyond(found, Scenario()) == []
    assert told[0] == pytest.approx([0.02] * len(told[0]), rel=0.15)
