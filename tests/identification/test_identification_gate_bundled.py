"""Slips beside friction that builds up over a path, rests that friction explains or not, and rows and readings that were put in.

Recordings are made here, by a bundle of plays in the logarithm of the tension with other strands than those of the gate.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def recorded(seed: int = 1, wrap: float = 0.5) -> Run:
    """Return a run of triangles of different heights through eleven strands, with noise of 0.02 N."""
    rng = np.random.default_rng(seed)
    t = np.arange(3000) / 100.0
    x = 2.0 + 38.0 * np.interp(t, np.arange(11) * 3.0, [0, 1, 0.1, 0.8, 0.0, 0.9, 0.2, 1, 0.05, 0.7, 0])
    half = wrap * np.linspace(0.2, 1.8, 11)
    state, y = np.log(x[0]) - half, np.empty(len(x))
    for k, u in enumerate(np.log(x)):
        state = np.clip(state, u - half, u + half)
        y[k] = np.exp(np.mean(state))
    return Run("r", "act", t, x + 0.02 * rng.standard_normal(len(x)), y + 0.02 * rng.standard_normal(len(x)))


def told(run: Run) -> set[str]:
    return {r.rule for r in gate.remarks([run])}


def test_friction_that_builds_up_is_no_slip() -> None:
    e = gate.evidence_of(recorded())
    assert told(recorded()) == set()
    # a single play leaves a good part of the span
    assert e.causes.friction.rms_n < 0.02 * e.ranges[1].span


@pytest.mark.slow
def test_an_output_that_is_late_or_early_is_told_beside_presliding() -> None:
    run, k = recorded(), 60
    late = Run("r", "act", run.time_s[k:], run.tension_in_n[k:], run.tension_out_n[:-k])
    early = Run("r", "act", run.time_s[:-k], run.tension_in_n[:-k], run.tension_out_n[k:])
    for r, delay in ((late, 0.6), (early, -0.6)):
        remarks = [m for m in gate.remarks([r]) if m.rule == "lead"]
        assert len(remarks) == 1 and abs(remarks[0].number - delay) < 0.06


def test_an_output_that_rests_against_friction_is_told_whatever_its_noise() -> None:
    run = recorded()
    rng = np.random.default_rng(2)
    y = run.tension_out_n.copy()
    y[1300:1900] = y[1300] + 0.02 * rng.standard_normal(600)
    found = gate.evidence_of(replace(run, tension_out_n=y)).shapes.rest
    assert found is not None and found.where == "between" and abs(found.at_s - 13.0) < 0.3
    assert "stuck" in told(replace(run, tension_out_n=y))


def test_missing_readings_filled_with_zero_are_told() -> None:
    run = recorded()
    y = run.tension_out_n.copy()
    for at in (200, 900, 1700, 2600):
        y[at : at + 9] = 0.0
    remarks = [m for m in gate.remarks([replace(run, tension_out_n=y)]) if m.rule == "filled"]
    assert len(remarks) == 1 and remarks[0].number == 36.0


@pytest.mark.slow
def test_rows_sorted_as_text_or_by_tension_and_runs_interleaved_are_told() -> None:
    run, other = recorded(1, 0.8), recorded(2, 0.2)
    text = np.array(sorted(range(len(run)), key=str))
    value = np.argsort(run.tension_in_n, kind="stable")
    for rows in (text, value):
        assert "order" in told(Run("r", "act", run.time_s, run.tension_in_n[rows], run.tension_out_n[rows]))
    both = [np.stack(v, 1).ravel() for v in ((run.tension_in_n, other.tension_in_n), (run.tension_out_n, other.tension_out_n))]
    assert "order" in told(Run("r", "act", np.arange(6000) / 200.0, *both))
