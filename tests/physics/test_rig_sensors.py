"""Sensors and recorder of the rig: noise of the stated level and colour, and each instrument effect on its own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import welch

from sstl_cli.physics.rig import QUIET, NoiseSpec, RigRun, RigSpec, simulate_rig

DT = 0.01


def ramp(effects, noise=QUIET, size=4000, system="act", seed=0):
    time = np.arange(size) * DT
    command = np.linspace(5.0, 35.0, size)
    return simulate_rig(RigSpec(), RigRun(system, 0.5, "CP", time, "tension", command), effects, noise, seed)


def errors(noise, size=60_000):
    result = ramp({}, noise, size)
    return result.tension_in_n - result.true_tension_in_n, result.tension_out_n - result.true_tension_out_n


def test_white_noise_is_flat_of_the_stated_level_and_independent():
    a, b = errors(NoiseSpec(white_n=0.02))
    for error in (a, b):
        assert np.std(error) == pytest.approx(0.02, rel=0.03)
        frequency, density = welch(error, 1 / DT, nperseg=512)
        low, high = density[(frequency > 1) & (frequency < 20)].mean(), density[frequency > 30].mean()
        assert low / high == pytest.approx(1.0, abs=0.1)
        assert density[5:-5].mean() == pytest.approx(0.02**2 * 2 * DT, rel=0.05)
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.02


def test_coloured_noise_has_the_stated_correlation_time():
    for error in errors(NoiseSpec(white_n=0.0, coloured_n=0.05, correlation_s=0.3)):
        assert np.std(error) == pytest.approx(0.05, rel=0.1)
        lag = round(0.3 / DT)
        assert np.corrcoef(error[:-lag], error[lag:])[0, 1] == pytest.approx(np.exp(-1), abs=0.06)


def test_position_noise_and_bad_noise():
    result = ramp({}, NoiseSpec(position_mm=0.01), 20_000)
    assert np.std(result.position_in_mm - result.true_position_in_mm) == pytest.approx(0.01, rel=0.05)
    with pytest.raises(ValueError, match="white_n"):
        NoiseSpec(white_n=-1.0)
    with pytest.raises(ValueError, match="correlation_s"):
        NoiseSpec(correlation_s=0.0)


@pytest.mark.parametrize("effect", ["channel_delay", "channel_lowpass"])
def test_delay_and_lowpass_are_late_by_tau_on_a_ramp(effect):
    result = ramp({effect: {"tau_act_s": 0.1}})
    rate = 30.0 / 40.0 * np.exp(-0.5)
    assert result.true_tension_out_n[-1] - result.tension_out_n[-1] == pytest.approx(0.1 * rate, rel=0.01)
    other = ramp({effect: {"tau_sstl_s": 0.1}})
    assert np.array_equal(other.tension_out_n, other.true_tension_out_n)


def test_each_static_sensor_effect():
    base = ramp({})
    t_in, t_out = base.true_tension_in_n, base.true_tension_out_n
    cross = ramp({"crosstalk": {"c_in_to_out": 0.03, "c_out_to_in": 0.01}})
    assert cross.tension_out_n == pytest.approx(t_out + 0.03 * t_in)
    assert cross.tension_in_n == pytest.approx(t_in + 0.01 * t_out)
    bent = ramp({"sensor_nonlinearity": {"a_in": 0.02}})
    assert bent.tension_in_n == pytest.approx(t_in * (1 + 0.02 * (1 - t_in / 50.0)))
    loose = ramp({"sensor_nonlinearity": {"h_n": 0.1}})
    assert loose.tension_out_n[-1] == pytest.approx(t_out[-1] - 0.1)
    drift = ramp({"zero_drift": {"r_out_act_n": 0.4, "r_in_sstl_n": 1.0}})
    assert drift.tension_out_n - t_out == pytest.approx(np.linspace(0.0, 0.4, t_out.size))
    assert np.array_equal(drift.tension_in_n, t_in)
    steps = ramp({"quantisation": {"q_in_n": 0.25}})
    assert np.allclose(steps.tension_in_n % 0.25, 0.0)
    assert np.max(np.abs(steps.tension_in_n - t_in)) <= 0.125 + 1e-12
    flat = ramp({"saturation": {"t_max_in_n": 20.0}})
    assert flat.tension_in_n.max() == 20.0
    assert flat.true_tension_in_n.max() == 35.0


def test_recorder_faults_cover_the_stated_share():
    size = 20_000
    base = ramp({}, NoiseSpec(), size)
    spikes = ramp({"acquisition_faults": {"spike_pct": 1.0, "spike_n": 5.0}}, NoiseSpec(), size)
    change = spikes.tension_out_n - base.tension_out_n
    assert np.mean(change != 0.0) == pytest.approx(0.01, abs=1e-3)
    assert np.abs(change[change != 0.0]) == pytest.approx(5.0)
    dropouts = ramp({"acquisition_faults": {"dropout_pct": 1.0}}, NoiseSpec(), size)
    assert np.mean(dropouts.tension_in_n == 0.0) == pytest.approx(0.01, rel=0.3)
    assert np.array_equal(dropouts.tension_in_n == 0.0, dropouts.tension_out_n == 0.0)
    frozen = ramp({"acquisition_faults": {"frozen_pct": 1.0}}, NoiseSpec(), size)
    assert np.mean(np.diff(frozen.tension_in_n) == 0.0) == pytest.approx(0.01, rel=0.3)
    jitter = ramp({"acquisition_faults": {"jitter_pct": 2.0}}, QUIET, size)
    assert np.all(np.diff(jitter.time_s) > 0.0)
    moved = jitter.time_s != base.time_s
    assert np.mean(moved) == pytest.approx(0.02, rel=0.1)
    # The stamp is true: the value belongs to the instant it names.
    rate = 30.0 / (base.time_s[-1])
    assert jitter.tension_in_n == pytest.approx(5.0 + rate * jitter.time_s, abs=1e-9)


def test_one_effect_does_not_change_the_noise_of_another_sensor():
    base = ramp({}, NoiseSpec(), seed=3)
    other = ramp({"zero_offset": {"z_out_act_n": 1.0}, "acquisition_faults": {"spike_pct": 0.1}}, NoiseSpec(), seed=3)
    same = np.isclose(other.tension_in_n, base.tension_in_n)
    assert np.mean(same) > 0.99
    assert np.mean(np.isclose(other.tension_out_n - 1.0, base.tension_out_n)) > 0.99
