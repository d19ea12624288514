"""Sensors and recorder of the bristle simulator, against numbers worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.physics.bristle import QUIET, NoiseSpec, resolve_effects
from sstl_cli.physics.bristle.sensors import record

TIME = np.arange(20_000) * 0.005
RAMP = 5.0 + 0.2 * TIME
WAVE = 10.0 + 4.0 * np.sin(0.9 * TIME)


def seen(effects, true_in=WAVE, true_out=RAMP, noise=QUIET, seed=0, system="act"):
    return record(TIME, (true_in, true_out, 0.1 * TIME), resolve_effects(effects), system, noise, seed)


def test_without_effects_and_noise_the_record_is_the_truth():
    stamps, t_in, t_out, x = seen({})
    for found, true in ((stamps, TIME), (t_in, WAVE), (t_out, RAMP), (x, 0.1 * TIME)):
        assert np.array_equal(found, true)


@pytest.mark.parametrize(
    ("effects", "t_in", "t_out"),
    [
        ({"zero_offset": {"z_in_act_n": 0.3, "z_out_act_n": -0.4, "z_out_sstl_n": 1.0}}, WAVE + 0.3, RAMP - 0.4),
        ({"zero_drift": {"r_out_act_n": 0.5}}, WAVE, RAMP + 0.5 * TIME / TIME[-1]),
        ({"gain_error": {"g_act": 1.1, "g_sstl": 0.9}}, WAVE, 1.1 * RAMP),
        ({"crosstalk": {"c_in_to_out": 0.02, "c_out_to_in": 0.03}}, WAVE + 0.03 * RAMP, RAMP + 0.02 * WAVE),
        ({"sensor_nonlinearity": {"a_in": 0.02}}, WAVE + 0.02 * WAVE * (1 - WAVE / 50), RAMP),
        ({"sensor_nonlinearity": {"a_out": -0.01}}, WAVE, RAMP - 0.01 * RAMP * (1 - RAMP / 50)),
        ({"saturation": {"t_max_in_n": 12.0, "t_max_out_n": 9.0}}, np.minimum(WAVE, 12.0), np.minimum(RAMP, 9.0)),
    ],
    ids=lambda e: next(iter(e)) if isinstance(e, dict) else "",
)  # fmt: skip
def test_readings_by_hand(effects, t_in, t_out):
    _, found_in, found_out, _ = seen(effects)
    assert found_in == pytest.approx(t_in, abs=1e-12)
    assert found_out == pytest.approx(t_out, abs=1e-12)


def test_late_and_slow_channels_lag_a_ramp_by_their_time():
    for effect in ("channel_delay", "channel_lowpass"):
        _, t_in, t_out, _ = seen({effect: {"tau_act_s": 0.1, "tau_sstl_s": 0.2}})
        assert np.array_equal(t_in, WAVE)
        assert t_out[2000:] == pytest.approx(RAMP[2000:] - 0.2 * 0.1, abs=1e-4)
    slow = seen({"channel_lowpass": {"tau_act_s": 0.3}}, true_out=np.sin(6.0 * TIME))[2][8000:]
    assert np.sqrt(2.0) * slow.std() == pytest.approx(1.0 / np.hypot(1.0, 1.8), rel=0.01)


def test_play_of_the_sensor_and_rounding():
    _, _, t_out, _ = seen({"sensor_nonlinearity": {"h_n": 0.1}}, true_out=WAVE)
    up = np.gradient(WAVE) > 1e-3
    assert np.abs(t_out - WAVE).max() <= 0.1 + 1e-12
    assert np.median((t_out - WAVE)[up]) == pytest.approx(-0.1)
    _, t_in, t_out, _ = seen({"quantisation": {"q_in_n": 0.2, "q_out_n": 0.05}})
    assert np.allclose(t_in / 0.2, np.rint(t_in / 0.2)) and np.abs(t_in - WAVE).max() <= 0.1 + 1e-12
    assert np.allclose(t_out / 0.05, np.rint(t_out / 0.05)) and np.abs(t_out - RAMP).max() <= 0.025 + 1e-12


def test_noise_has_its_level_its_colour_and_its_own_stream():
    noise = NoiseSpec(white_n=0.03, coloured_n=0.05, correlation_s=0.2, position_mm=0.01)
    _, t_in, t_out, x = seen({}, noise=noise, seed=3)
    first, second = t_in - WAVE, t_out - RAMP
    assert first.std() == pytest.approx(np.hypot(0.03, 0.05), rel=0.1)
    lag = 20  # 0.1 s
    assert np.mean(first[lag:] * first[:-lag]) == pytest.approx(0.05**2 * np.exp(-0.5), rel=0.25)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.1
    assert (x - 0.1 * TIME).std() == pytest.approx(0.01, rel=0.05)
    # what is done to the output leaves the noise of the input alone
    other = seen({"acquisition_faults": {"dropout_pct": 1.0}, "gain_error": {"g_act": 1.1}}, noise=noise, seed=3)[1]
    assert np.mean(other == t_in) > 0.97
    assert not np.array_equal(seen({}, noise=noise, seed=4)[1], t_in)


def test_faults_come_as_often_as_asked():
    faults = {"spike_pct": 1.0, "spike_n": 20.0}
    _, _, t_out, _ = seen({"acquisition_faults": faults}, seed=1)
    hit = np.abs(t_out - RAMP) > 1.0
    assert np.mean(hit) == pytest.approx(0.01, rel=0.3)
    assert np.abs(t_out - RAMP)[hit] == pytest.approx(20.0)
    _, t_in, t_out, _ = seen({"acquisition_faults": {"dropout_pct": 2.0}}, seed=1)
    assert np.mean(t_out == 0.0) == pytest.approx(0.02, rel=0.3) and np.array_equal(t_in == 0.0, t_out == 0.0)
    _, _, t_out, _ = seen({"acquisition_faults": {"frozen_pct": 2.0}}, seed=1)
    assert np.mean(np.diff(t_out) == 0.0) == pytest.approx(0.02, rel=0.4)
    stamps, _, t_out, _ = seen({"acquisition_faults": {"jitter_pct": 2.0}}, seed=1)
    assert (stamps - TIME).std() == pytest.approx(0.2 * 0.005, rel=0.1) and np.all(np.diff(stamps) > 0.0)
    assert t_out == pytest.approx(np.interp(stamps, TIME, RAMP))
