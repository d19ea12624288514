"""Recordings as labs make them: what the recorder changes, and that it changes nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.physics import recording
from sstl_cli.physics.recording import Recording

HZ = 100.0


def run(system: str = "act", seconds: float = 20.0) -> Run:
    time = np.arange(round(seconds * HZ)) / HZ
    t_in = 12.0 - 8.0 * np.cos(2.0 * np.pi * time / 5.0)
    return Run("r", system, time, t_in, 0.6 * t_in, position_in_mm=0.3 * t_in, tension_ref_n=t_in)


def test_defaults_change_nothing() -> None:
    given = run()
    found = recording.apply(Recording(), given, 0, 1)
    for name in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n"):
        assert np.array_equal(getattr(found, name), getattr(given, name)), name


@pytest.mark.parametrize("rate", [50.0, 2000.0])
def test_rate(rate: float) -> None:
    given = run()
    stamps, t_in = recording.at_rate(Recording(rate_hz=rate), given.time_s, given.tension_in_n)
    assert np.allclose(np.diff(stamps), 1.0 / rate)
    assert stamps[0] == 0.0 and given.time_s[-1] - 1.0 / rate < stamps[-1] <= given.time_s[-1] + 1e-9
    # half a cosine of 8 N sampled at 100 Hz bends by 8 (2 pi / 5)^2 0.01^2 / 8 between samples
    assert np.allclose(t_in, 12.0 - 8.0 * np.cos(2.0 * np.pi * stamps / 5.0), atol=2e-4)


def test_slow_sensor_is_held_between_refreshes() -> None:
    found = recording.apply(Recording(refresh_hz=12.5), run(), 0, 1)
    fresh = np.flatnonzero(np.diff(found.tension_out_n) != 0.0)
    assert set(np.diff(fresh)) == {8}
    assert np.array_equal(found.tension_in_n, run().tension_in_n), "the input sensor is as fast as ever"
    assert np.all(np.isin(found.tension_out_n, run().tension_out_n))


def test_resolution() -> None:
    found = recording.apply(Recording(step_in_n=0.05, step_out_n=0.2), run(), 0, 1)
    assert np.allclose(found.tension_out_n / 0.2, np.round(found.tension_out_n / 0.2))
    assert np.abs(found.tension_in_n - run().tension_in_n).max() <= 0.025 + 1e-12


@pytest.mark.parametrize("stamped", [True, False])
def test_jitter_moves_the_instants_and_leaves_the_noise(stamped: bool) -> None:
    given = run()
    noise = np.random.default_rng(1).standard_normal(len(given))
    noisy = Run("r", "act", given.time_s, given.tension_in_n + noise, given.tension_out_n)
    truth = (given.tension_in_n, given.tension_out_n)
    found = recording.apply(Recording(jitter=0.2, stamped=stamped), noisy, 0, 1, truth)
    moved = found.tension_out_n - given.tension_out_n
    assert np.allclose(found.tension_in_n - given.tension_in_n - noise, moved / 0.6)
    assert np.all(np.diff(found.time_s) > 0.0)
    assert np.std(moved) == pytest.approx(0.2 / HZ * np.std(np.gradient(given.tension_out_n, 1.0 / HZ)), rel=0.1)
    if stamped:
        assert np.allclose(found.tension_out_n, np.interp(found.time_s, given.time_s, given.tension_out_n))
    else:
        assert np.array_equal(found.time_s, given.time_s)


def test_gaps_take_samples_and_leave_the_rest() -> None:
    found = recording.apply(Recording(gaps=((0.25, 0.05), (0.5, 0.01))), run(), 0, 1)
    assert len(found) == pytest.approx(0.94 * len(run()), abs=3)
    kept = np.isin(run().time_s, found.time_s)
    assert np.array_equal(found.tension_out_n, run().tension_out_n[kept])
    assert found.position_in_mm is not None and found.position_in_mm.size == len(found)


def test_zeros_move_between_days() -> None:
    days = Recording(day_zero_n=((0.0,) * 4, (0.1, -0.2, 0.3, -0.4)))
    assert [recording.day_of(days, k, 4) for k in range(4)] == [0, 0, 1, 1]
    early, late = (recording.apply(days, run("sstl"), k, 4) for k in (1, 2))
    assert np.array_equal(early.tension_out_n, run("sstl").tension_out_n)
    assert np.allclose(late.tension_in_n - early.tension_in_n, 0.3)
    assert np.allclose(late.tension_out_n - early.tension_out_n, -0.4)


def test_what_is_recorded() -> None:
    part = Recording(systems=("sstl",), one_configuration=True, position=False, reference=False)
    assert [recording.kept(part, s, c) for s, c in (("act", 0), ("sstl", 0), ("sstl", 1))] == [False, True, False]
    found = recording.apply(part, run("sstl"), 0, 1)
    assert found.position_in_mm is None and found.tension_ref_n is None


def test_draws_cover_what_labs_do() -> None:
    many = [recording.draw(np.random.default_rng(k)) for k in range(300)]
    assert {d.rate_hz for d in many} >= {50.0, 100.0, 500.0, 2000.0}
    assert {d.systems for d in many} == {("act", "sstl"), ("act",), ("sstl",)}
    for share in (
        [d.refresh_hz > 0 for d in many],
        [d.step_out_n > 0 for d in many],
        [d.jitter > 0 for d in many],
        [bool(d.gaps) for d in many],
        [d.one_configuration for d in many],
        [len(d.day_zero_n) > 1 for d in many],
    ):
        assert 0.1 < np.mean(share) < 0.4
    for k, d in enumerate(many[:60]):
        stamps, t_in, t_out = recording.at_rate(d, run().time_s, run().tension_in_n, run().tension_out_n)
        found = recording.apply(d, Run("r", "act", stamps, t_in, t_out), k % 5, 5, (t_in, t_out))
        assert np.all(np.diff(found.time_s) > 0.0) and np.all(np.isfinite(found.tension_out_n))
        assert d.description
