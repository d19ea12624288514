"""Sensors behind filters of several kinds: a low-pass of second order is no delay, whatever its ramps look like."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.verdict import IDENTIFIED
from sstl_cli.steps.diagnose import DiagnoseOptions, run

# the mechanics are made ten times finer than they are read
DT, FINE = 0.01, 10
NOISE, CUTOFF_HZ = 0.003, 5.0
# a filter of second order is as late on ramps as this (s)
LATE = np.sqrt(2.0) / (2.0 * np.pi * CUTOFF_HZ)
OPTIONS = DiagnoseOptions(effects=("channel_delay", "channel_lowpass", "viscous"), max_effects=1)


def butterworth(y):
    b, a = butter(2, CUTOFF_HZ, fs=FINE / DT)
    return y[0] + lfilter(b, a, y - y[0])


def late(y):
    return np.concatenate((np.full(round(LATE * FINE / DT), y[0]), y))[: len(y)]


def recorded(seed, sensor):
    """Return a run of a play that jumps between ramps, its output behind a sensor."""
    rng = np.random.default_rng(seed)
    turns = np.cumsum(np.concatenate(([0.0], rng.uniform(0.15, 1.0, 50))))
    time = np.arange(0.0, turns[-1], DT / FINE)
    u = np.interp(time, turns, rng.uniform(4.0, 24.0, len(turns)))
    y, last = np.empty_like(u), u[0]
    for k, v in enumerate(u):
        last = y[k] = max(np.exp(-0.4) * v, min(last, np.exp(0.4) * v))
    seen = (x[::FINE] + NOISE * rng.standard_normal(len(time[::FINE])) for x in (u, sensor(y)))
    return Run(f"r{seed}", "act", time[::FINE], *seen, config_id="a", trajectory=f"m{seed}")


@pytest.fixture(scope="module")
def filtered():
    return [recorded(1, butterworth), recorded(2, butterworth)]


@pytest.mark.slow
def test_a_filter_of_second_order_is_seen_for_what_it_is(filtered):
    found = gather(filtered, OPTIONS).search
    fit = found.best(("channel_lowpass",)).fit
    values = {f.parameter.name: v for f, v in zip(fit.free, fit.values, strict=True)}
    assert values["tau_act_s"] == pytest.approx(LATE, rel=0.05) and values["second"] > 0.4
    # by first order alone the delay would be far ahead
    assert found.best(("channel_lowpass",)).evidence > found.best(("channel_delay",)).evidence


@pytest.mark.slow
def test_such_a_filter_is_never_called_a_delay(filtered):
    verdict = run(filtered, OPTIONS).verdict
    assert not (verdict.status == IDENTIFIED and "channel_delay" in verdict.effects)


def test_a_delay_is_still_the_more_evident_where_it_is_one():
    found = gather([recorded(3, late), recorded(4, late)], OPTIONS).search
    assert found.best(("channel_delay",)).evidence > found.best(("channel_lowpass",)).evidence
