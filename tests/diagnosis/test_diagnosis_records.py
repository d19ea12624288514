"""Runs made ready: blocks, gaps, starts, and what stands for all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.records import prepare, representatives

DT = 0.005
T = np.arange(0.0, 20.0, DT)
U = 12.0 + 8.0 * np.sin(2.0 * np.pi * (T + 1.0) / 8.0)


def made(name="r", config="a", movement="m", scale=0.6, sd=0.01, seed=0):
    noise = sd * np.random.default_rng(seed).standard_normal((2, len(T)))
    return Run(name, "act", T, U + noise[0], scale * U + noise[1], config_id=config, trajectory=movement)


def test_residuals_live_at_the_analysis_rate_as_means_of_blocks():
    (r,) = prepare([made()]).records
    assert r.factor == 4 and len(r) == len(T) // 4 and len(r.u) == len(T)
    assert r.y == pytest.approx(r.raw.tension_out_n.reshape(-1, 4).mean(axis=1))


def test_a_run_starts_where_it_was_read_though_it_moves():
    (r,) = prepare([made(sd=0.01)]).records
    # three blocks later the output is 0.2 N on
    assert abs(r.start_n - 0.6 * U[0]) < 4.0 * r.start_error_n < 0.06


def test_a_gap_is_bridged_and_has_no_weight():
    keep = (T < 6.0) | (T > 7.0)
    run = made()
    cut = replace(run, time_s=T[keep], tension_in_n=run.tension_in_n[keep], tension_out_n=run.tension_out_n[keep])
    (r,) = prepare([cut]).records
    dark = r.weight == 0.0
    assert len(r) == len(T) // 4
    assert r.time_s[dark].min() > 6.0 - 0.05 and r.time_s[dark].max() < 7.0 + 0.05 and dark.sum() == pytest.approx(50, abs=3)


def test_after_a_turn_that_nobody_saw_the_model_begins_anew_where_the_output_is_read_again():
    keep = (T < 8.5) | (T > 9.5)
    run = made()
    cut = replace(run, time_s=T[keep], tension_in_n=run.tension_in_n[keep], tension_out_n=run.tension_out_n[keep])
    (r,) = prepare([cut]).records
    dark = r.time_s[r.weight == 0.0]
    assert dark.min() > 8.45 and dark.max() < 9.55
    (start,) = r.again
    assert start.at * r.dt_s == pytest.approx(9.5, abs=0.03) and start.output_n == pytest.approx(
        np.interp(9.5, T, run.tension_out_n), abs=0.1
    )


def test_the_error_of_the_input_is_below_its_noise():
    (r,) = prepare([made(sd=0.02)]).records
    assert 0.0 < np.median(r.error_n) < 0.5 * 0.02


def test_a_sure_input_has_no_error():
    (r,) = prepare([made(sd=0.0)]).records
    assert not r.error_n.any() and not r.error_law.any() and np.array_equal(r.u, U)


def test_representatives_hold_every_movement_and_follow_no_name():
    runs = [made(f"{c}{m}", c, m, scale, seed=k) for k, (c, m, scale) in enumerate(
        (c, m, s) for c, s in (("a", 0.6), ("b", 0.5)) for m in ("m", "n")
    )]  # fmt: skip
    chosen = representatives(prepare(runs)).records
    assert {r.trajectory for r in chosen} == {"m", "n"}
    turned = [replace(r, run_id=r.run_id[::-1], config_id={"a": "b", "b": "a"}[r.config_id]) for r in runs]
    again = representatives(prepare(turned)).records
    assert sorted(r.run_id for r in chosen) == sorted(r.run_id[::-1] for r in again)


def test_an_input_that_rests_is_an_error():
    rest = replace(made(), tension_in_n=np.full(len(T), 5.0))
    with pytest.raises(SstlError, match="hardly moves"):
        prepare([rest])


def test_a_slow_sensor_is_compared_at_its_readings_and_the_input_keeps_its_rate():
    rng = np.random.default_rng(7)
    time = np.arange(4000) / 200.0
    wave = 10.0 + 6.0 * np.sin(2.0 * np.pi * 0.5 * time)
    fresh = np.concatenate(([True], np.diff(np.floor(time * 21.0)) > 0))
    held = (wave + 0.02 * rng.standard_normal(4000))[np.maximum.accumulate(np.where(fresh, np.arange(4000), 0))]
    run = Run("r", "act", time, wave + 0.02 * rng.standard_normal(4000), held, config_id="c")
    record = prepare([run]).records[0]
    assert record.weight.sum() == pytest.approx(fresh.sum(), rel=0.05) and np.all(record.readings[record.weight > 0] == 1.0)
    truth = (wave[: len(record.share)] * record.share).reshape(-1, record.factor).sum(axis=1)
    off = (record.y - truth)[record.weight > 0]
    assert np.sqrt(np.mean(off**2)) == pytest.approx(0.02, rel=0.25)
    assert np.abs(record.u - wave[: len(record.u)]).max() < 0.05
