"""Errors over all raw readings, shared out by place, on records of a few samples."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import recorded
from sstl_cli.diagnosis.recorder import Faults


def record(error, thin=2, system="act", gap=None, spoilt=None, u=8.0):
    """Return a record whose prediction is theta throughout, read with an error above 5 N; the input reads 8 N."""
    error = np.asarray(error, float)
    none = np.zeros(len(error), bool)
    faults = Faults(none, none, none, float("inf"), 0.0, 0.1)
    into = Faults(none if spoilt is None else np.array(spoilt, bool), none, none, float("inf"), 0.0, 0.1)
    run = Run(
        "r",
        system,
        0.01 * np.arange(len(error)),
        np.full(len(error), 8.0),
        5.0 + error,
        extra={} if gap is None else {"gap": np.array(gap, float)},
    )
    return SimpleNamespace(raw=run, system=system, u=np.full(len(error) // thin, u), faults_in=into, faults_out=faults, thin=thin)


def simulator(*records, config=(), configs=("A", "B")):
    counts = [len(r.raw) // r.thin for r in records]
    ends = np.cumsum(counts)
    return SimpleNamespace(
        problem=SimpleNamespace(records=records, configs=configs),
        predict_fine=lambda theta, effects: [np.full(n, theta) for n in counts],
        slices=lambda: [slice(e - n, e) for e, n in zip(ends, counts, strict=True)],
        config=np.repeat(config or [0] * len(records), counts),
    )


def test_the_squared_error_of_every_reading_has_the_phase_of_its_sample():
    first = record([1.0, 1.0, 3.0, 0.0, 0.0, 0.0, 2.0])
    second = record([0.0, 0.0, 1.0, 2.0], system="sstl")
    sim = simulator(first, second, config=[0, 1])
    # seven readings of three samples: the last one is of the last sample
    rows = recorded.shares(sim, 5.0, np.array([0, 1, 2, 3, 3]))
    found = {(r.system, r.phase, r.config_id): (r.share_pct, r.rmse_n) for r in rows}
    assert found == {
        ("act", "PP", "A"): (pytest.approx(900.0 / 16.0), pytest.approx(np.sqrt(4.5))),
        ("sstl", "RP", "B"): (pytest.approx(500.0 / 16.0), pytest.approx(np.sqrt(1.25))),
        ("act", "PB", "A"): (pytest.approx(200.0 / 16.0), 1.0),
        ("act", "RB", "A"): (0.0, 0.0),
    }
    assert [r.share_pct for r in rows] == sorted((r.share_pct for r in rows), reverse=True)


def test_runs_of_one_bend_are_taken_together_and_no_error_has_no_share():
    sim = simulator(record([1.0, 1.0]), record([3.0, 3.0]))
    (row,) = recorded.shares(sim, 5.0, np.array([1, 1]))
    assert (row.share_pct, row.rmse_n) == (100.0, pytest.approx(np.sqrt(5.0)))
    (none,) = recorded.shares(simulator(record([0.0, 0.0])), 5.0, np.array([1]))
    assert (none.share_pct, none.rmse_n) == (0.0, 0.0)


def test_spoilt_readings_of_the_input_count_as_well():
    sim = simulator(record([1.0, 1.0, 0.0, 0.0], spoilt=[1, 0, 0, 0], u=10.0))
    rows = {r.phase: r.rmse_n for r in recorded.shares(sim, 5.0, np.array([0, 1]))}
    assert rows == {"PB": pytest.approx(np.sqrt(6.0 / 2.0)), "PP": 0.0}
    assert recorded.rms_n(sim, 5.0, 5.0, SimpleNamespace(removed_n2=2.0)) == pytest.approx((np.sqrt(6.0 / 4.0), 1.0, np.sqrt(6.0 / 4.0)))


def test_errors_before_and_after_a_fault_are_over_what_was_recorded():
    sim = simulator(record([3.0, 1.0, 1.0, 1.0, 9.0, 9.0], gap=[0, 0, 0, 0, 1, 1]))
    before, after, given = recorded.rms_n(sim, 5.0, 4.0, SimpleNamespace(removed_n2=8.0))
    # 12 N^2 over four readings, 8 of them the fault's; 1 N more as given
    assert (before, after, given) == pytest.approx((np.sqrt(3.0), 1.0, np.sqrt((16.0 + 12.0) / 4.0)))
    assert recorded.rms_n(sim, 5.0, 4.0, SimpleNamespace(removed_n2=99.0))[1] == 0.0
    nothing = simulator(record([1.0, 1.0], gap=[1, 1]))
    assert recorded.rms_n(nothing, 5.0, 4.0, SimpleNamespace(removed_n2=0.0)) == (0.0, 0.0, 0.0)
