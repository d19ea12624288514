"""Each kind of bad sample is found, counted, and not found where it is not."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from identification_loops import ACT, record, trapezoid

from sstl_cli.core.runs import Run
from sstl_cli.identification import samples
from sstl_cli.identification.gate import evidence_of
from sstl_cli.steps.info import RunSummary, draw_loop
from sstl_cli.steps.info import run as summarise

RUN = record(*trapezoid(rate=100.0, cycles=2), ACT, 1)
N = len(RUN)


def findings(time=None, x=None, y=None, **kwargs):
    columns = {
        "time_s": RUN.time_s if time is None else time,
        "tension_in_n": RUN.tension_in_n if x is None else x,
        "tension_out_n": RUN.tension_out_n if y is None else y,
    }
    return {(f.what, f.column): f for f in samples.findings(samples.Piece("r", columns, **kwargs))}


def test_a_clean_run_has_no_findings():
    assert findings() == {}


def test_saturation_is_a_flat_top_of_a_noisy_channel():
    found = findings(x=np.minimum(RUN.tension_in_n, 25.0))
    assert list(found) == [("saturation", "tension_in_n")]
    assert found["saturation", "tension_in_n"].count == np.sum(RUN.tension_in_n >= 25.0)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_holds_without_noise_are_not_saturation(kind):
    t, x = trapezoid(rate=100.0)
    run = record(t, x, ACT, sd=0.0)
    found = findings(time=t, x=run.tension_in_n.astype(kind).astype(float), y=run.tension_out_n.astype(kind).astype(float))
    assert not [k for k in found if k[0] in ("saturation", "frozen stretches")]


def test_quantisation_names_the_step():
    found = findings(x=np.round(RUN.tension_in_n / 0.25) * 0.25)
    assert "0.25 N" in found["quantised", "tension_in_n"].detail
    assert found["quantised", "tension_in_n"].level == samples.REMARK
    coarse = findings(x=np.round(RUN.tension_in_n / 5.0) * 5.0)
    assert coarse["quantised", "tension_in_n"].level == samples.FAILURE


def test_the_step_of_a_converter_is_the_smallest_gap_of_its_levels_not_the_usual_one():
    # two levels in five were read
    levels = 0.025 * np.sort(np.random.default_rng(1).choice(1100, 440, replace=False))
    x = levels[np.searchsorted(levels[:-1], RUN.tension_in_n)]
    assert "0.025 N apart" in findings(x=x)["quantised", "tension_in_n"].detail


@pytest.mark.parametrize("levels", [2, 3])
def test_few_levels_are_coarse(levels):
    step = float(np.ptp(RUN.tension_in_n)) / (levels - 1)
    assert findings(x=np.round(RUN.tension_in_n / step) * step)["quantised", "tension_in_n"].level == samples.FAILURE


def test_flat_frozen_spikes():
    assert findings(y=np.full(N, 2.0))["flat channel", "tension_out_n"].level == samples.FAILURE
    frozen = RUN.tension_out_n.copy()
    frozen[500:540] = frozen[500]
    assert findings(y=frozen)["frozen stretches", "tension_out_n"].count == 39
    spiky = RUN.tension_in_n.copy()
    spiky[[100, 700, 901]] += 4.0
    assert findings(x=spiky)["spikes", "tension_in_n"].count == 3
    spiky[[0, -1]] -= 4.0
    assert findings(x=spiky)["spikes", "tension_in_n"].count == 5


def test_time_faults_are_counted():
    time = RUN.time_s.copy()
    time[10] = time[9]
    time[20] = time[18] - 0.001
    time[1000:] += 3.0
    time[1500:] += 0.03
    found = findings(time=time)
    assert found["time repeats", "time_s"].count == 1
    assert found["time runs backwards", "time_s"].count == 1
    assert found["gaps", "time_s"].count == 1
    assert found["missing samples", "time_s"].level == samples.REMARK
    jittery = RUN.time_s + np.random.default_rng(0).uniform(-0.002, 0.002, N)
    assert ("sampling jitter", "time_s") in findings(time=jittery)


def test_nan_infinity_nulls_and_labels():
    x = RUN.tension_in_n.copy()
    x[:4], x[4] = np.nan, np.inf
    found = findings(x=x, nulls={"tension_in_n": 1}, labels={"system": ["act", "other"], "config_id": ["a"]})
    assert found["not a number", "tension_in_n"].count == 3
    assert found["infinite values", "tension_in_n"].count == 1
    assert found["empty values", "tension_in_n"].count == 1
    assert ("label changes within the run", "system") in found and ("unknown system", "system") in found


@pytest.mark.parametrize("n", [0, 1, 2, 15])
def test_short_runs_are_failures_not_crashes(n):
    found = findings(RUN.time_s[:n], RUN.tension_in_n[:n], RUN.tension_out_n[:n])
    assert found["too few samples", ""].count == n


def test_loop_drawing_fills_the_corners_it_passes():
    drawn = draw_loop([0, 1, 1, 0, 0], [0, 0, 1, 1, 0], 6, 3)
    assert len(drawn) == 3 and all(len(row) == 6 for row in drawn)
    assert all(ord(row[0]) > 0x2800 and ord(row[-1]) > 0x2800 for row in drawn)
    assert drawn[1][1:-1] == "\u2800" * 4
    assert draw_loop([1, 1], [0, 1]) == [] and draw_loop([1.0], [1.0]) == []
    assert draw_loop([0.0, float("nan"), 1.0], [0.0, 1.0, 1.0], 2, 1) != []


def test_summaries_of_stretches_are_joined():
    parts = [
        RunSummary("a", "act", None, None, 5, 0.0, 4.0, 1, 2, 3, 4),
        RunSummary("b", "act", None, None, 1, 0, 0, 0, 0, 0, 0),
        RunSummary("a", "act", None, None, 6, 5.0, 10.0, 0, 9, 2, 5),
    ]
    one, two = summarise(parts)
    assert (one.samples, one.in_min_n, one.in_max_n, one.out_min_n, one.out_max_n) == (11, 0, 9, 2, 5)
    assert one.rate_hz == 1.0 and two.rate_hz is None


def test_a_clock_that_began_anew_is_split_and_rows_in_another_order_are_sorted():
    began = RUN.time_s - np.where(np.arange(N) < N // 2, 0.0, RUN.time_s[N // 2])
    assert 'backward = "split"' in findings(time=began)["time runs backwards", "time_s"].fix
    late = RUN.time_s.copy()
    late[[40, 41]] = late[[41, 40]]
    assert findings(time=late)["time runs backwards", "time_s"].fix.startswith("sort the rows")


def test_stamps_too_coarse_for_the_rows_ask_for_the_rate_and_rows_that_are_there_twice_do_not():
    step = float(np.median(np.diff(RUN.time_s)))
    coarse = np.floor(RUN.time_s / (10.0 * step)) * 10.0 * step
    assert "rate_hz" in findings(time=coarse)["time repeats", "time_s"].fix
    twice = [np.repeat(v[: N // 2], 2)[:N] for v in (RUN.time_s, RUN.tension_in_n, RUN.tension_out_n)]
    assert 'repeated = "last"' in findings(time=twice[0], x=twice[1], y=twice[2])["time repeats", "time_s"].fix


def test_a_run_of_two_samples_costs_next_to_nothing():
    # a log may hold a million of them: what is counted is Python's own work, which is the same on every machine
    t, x = np.array([0.0, 0.01]), np.array([5.0, 6.0])
    piece = samples.Piece("r", {"time_s": t, "tension_in_n": x, "tension_out_n": 0.6 * x})
    calls = {"check": 0, "gate": 0}
    for name, work in (("check", lambda: samples.findings(piece)), ("gate", lambda: evidence_of(Run("r", "act", t, x, 0.6 * x)))):
        # what is imported or made once is not counted
        work()

        def count(frame, event, argument, name=name):
            calls[name] += event == "call"

        sys.setprofile(count)
        try:
            work()
        finally:
            sys.setprofile(None)
    assert calls["check"] < 60 and calls["gate"] < 60
