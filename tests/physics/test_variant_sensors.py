"""Sensors and recorder of the variant rig: each law on a signal whose reading is known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.physics.variant import QUIET, NoiseSpec, VariantRun, VariantSpec, laws_of, read_variant

HZ = 200.0
TIME = np.arange(4000) / HZ
# a pull from 2 to 22 N at 2 N/s, then a hold
RAMP = np.minimum(2.0 + 2.0 * TIME, 22.0)
MOVING = slice(200, 1900)


def read(effect: str, law: str, values: dict[str, float], theta: float = 0.53, noise: NoiseSpec = QUIET) -> SimpleNamespace:
    """Return what the recorder stores of an input of RAMP and an output of half of it."""
    spec = VariantSpec(laws={effect: law}, law_seed=1)
    run = VariantRun("act", theta, "CP", TIME, "tension", RAMP)
    stamps, t_in, t_out, x = read_variant(spec, run, (RAMP, 0.5 * RAMP, 0.3 * RAMP), {effect: values}, noise, 5)
    return SimpleNamespace(time=stamps, t_in=t_in, t_out=t_out, x=x, shape=laws_of(spec)[effect].shape)


@pytest.mark.parametrize("law", ["butterworth", "moving_average"])
@pytest.mark.parametrize("tau", [1e-7, 0.08])
def test_filters_are_late_by_tau_on_a_ramp(law: str, tau: float) -> None:
    found = read("channel_lowpass", law, {"tau_act_s": tau})
    assert np.allclose(0.5 * RAMP[MOVING] - found.t_out[MOVING], 1.0 * tau, atol=1e-3 * tau + 1e-6)
    assert found.t_out[-1] == pytest.approx(11.0, abs=1e-6), "and settle"
    assert np.array_equal(found.t_in, RAMP)


def test_butterworth_is_that_of_scipy() -> None:
    from scipy.signal import lsim, lti

    tau, omega = 0.08, 2.0**0.5 / 0.08
    signal = 5.0 + np.sin(2.0 * np.pi * 3.0 * TIME) + 0.3 * TIME
    from sstl_cli.physics.variant.filters import second_order

    _, expected, _ = lsim(lti([omega**2], [1.0, 2.0**0.5 * omega, omega**2]), signal - signal[0], TIME)
    assert np.allclose(second_order(TIME, signal, tau, 0.5**0.5, 0.0) - signal[0], expected, atol=1e-9)


@pytest.mark.parametrize("law", ["jitter", "bus"])
def test_delays_are_tau_on_the_mean_and_scatter(law: str) -> None:
    found = read("channel_delay", law, {"tau_act_s": 0.1})
    late = 0.5 * RAMP[MOVING] - found.t_out[MOVING]
    assert late.mean() == pytest.approx(0.1, rel=0.15)
    assert 0.01 < late.std() < 0.08
    if law == "bus":
        assert set(np.diff(np.flatnonzero(np.diff(found.t_out[MOVING])))) == {40}, "refreshed every 0.2 s"


def test_cross_talk() -> None:
    found = read("crosstalk", "mounting", {"c_in_to_out": 0.02})
    assert np.allclose(found.t_out, 0.5 * RAMP + 0.02 * 1.5 * RAMP) and np.array_equal(found.t_in, RAMP)
    found = read("crosstalk", "both_ways", {"c_in_to_out": 0.02})
    assert np.allclose(found.t_out, 0.52 * RAMP) and np.allclose(found.t_in, RAMP + found.shape * 0.02 * 0.5 * RAMP)


def test_gain() -> None:
    found = read("gain_error", "both_sensors", {"g_act": 1.1})
    assert np.allclose(found.t_out / found.t_in, 0.55)
    found = read("gain_error", "off_axis", {"g_act": 1.1})
    gain = found.t_out / (0.5 * RAMP)
    assert np.all(np.diff(gain) >= -1e-12) and gain[-1] == pytest.approx(1.0 + 0.14 * 11.0 / (11.0 + found.shape))


def test_zeros() -> None:
    for theta in (0.3, 0.6):
        found = read("zero_offset", "preload", {"z_out_act_n": 0.5}, theta)
        assert np.allclose(found.t_out - 0.5 * RAMP, 0.5 * theta / 0.53)
    found = read("zero_offset", "zero_return", {"z_in_act_n": -0.5})
    assert np.allclose(found.t_in - RAMP, -0.5 * (1.0 - np.exp(-RAMP / found.shape)))


@pytest.mark.parametrize("law", ["warm_up", "steps", "random_walk"])
def test_drift_ends_where_the_linear_one_does(law: str) -> None:
    found = read("zero_drift", law, {"r_out_act_n": 0.8})
    drift = found.t_out - 0.5 * RAMP
    assert drift[0] == pytest.approx(0.0, abs=1e-9) and drift[-1] == pytest.approx(0.8)
    assert np.abs(drift - 0.8 * TIME / TIME[-1]).max() > 0.08, "but is not linear"
    if law == "steps":
        assert np.count_nonzero(np.diff(drift - drift.mean()) > 1e-6) == round(found.shape)


def test_curved_sensors() -> None:
    found = read("sensor_nonlinearity", "cubic", {"a_out": 0.02})
    t = 0.5 * RAMP
    assert np.allclose(found.t_out - t, 0.04 * found.shape * t * (1.0 - (t / 50.0) ** 2))
    found = read("sensor_nonlinearity", "piecewise", {"a_in": 0.03})
    slopes = np.diff(found.t_in) / np.where(np.diff(RAMP) > 0.0, np.diff(RAMP), np.inf)
    assert slopes[10] == pytest.approx(1.03) and slopes[1990] == pytest.approx(0.99)
    found = read("sensor_nonlinearity", "cubic", {"h_n": 0.1})
    assert np.allclose(t[MOVING] - found.t_out[MOVING], 0.1), "the mean of three plays"


def test_resolution() -> None:
    found = read("quantisation", "truncate", {"q_out_n": 0.25})
    assert np.all((0.5 * RAMP - found.t_out >= -1e-9) & (0.5 * RAMP - found.t_out < 0.25 + 1e-9))
    found = read("quantisation", "deadband", {"q_in_n": 0.3})
    steps = np.diff(found.t_in)
    assert np.all((steps == 0.0) | (steps >= 0.3 - 1e-12)) and np.abs(found.t_in - RAMP).max() < 0.3


def test_saturation() -> None:
    found = read("saturation", "soft_knee", {"t_max_in_n": 10.0})
    assert found.t_in.max() <= 10.0 + 1e-9 and found.t_in[-1] == pytest.approx(10.0, abs=0.01)
    assert np.all(np.diff(found.t_in) >= -1e-9) and np.allclose(found.t_in[:200], RAMP[:200], atol=1e-3)
    found = read("saturation", "wrap", {"t_max_in_n": 10.0})
    assert found.t_in.max() < 10.0 and np.allclose(found.t_in, np.mod(RAMP, 10.0))


@pytest.mark.parametrize("law", ["bursts", "held"])
def test_faults_cover_about_their_share(law: str) -> None:
    for name, share in (("frozen_pct", 2.0), ("dropout_pct", 2.0)):
        shares = []
        for seed in range(40):
            spec = VariantSpec(laws={"acquisition_faults": law}, law_seed=1)
            run = VariantRun("act", 0.5, None, TIME, "tension", RAMP)
            signal = 5.0 + np.sin(TIME)
            got = read_variant(spec, run, (signal, signal, signal), {"acquisition_faults": {name: share}}, QUIET, seed)
            shares.append(np.mean(got[1] != signal))
        assert 100.0 * np.mean(shares) == pytest.approx(share, rel=0.35), name
    found = read("acquisition_faults", law, {"spike_pct": 1.0, "spike_n": 20.0})
    assert np.abs(found.t_in - RAMP).max() > 10.0 and np.mean(found.t_in != RAMP) < 0.25
    found = read("acquisition_faults", law, {"jitter_pct": 2.0})
    assert np.all(np.diff(found.time) > 0.0) and np.allclose(found.t_in, np.interp(found.time, TIME, RAMP))


def test_noise_has_the_asked_size_and_its_own_stream_for_each_sensor() -> None:
    noise = NoiseSpec(0.02, 0.03, 0.3, 0.01)
    found = read("viscous", "power", {}, noise=noise)
    first, second = found.t_in - RAMP, found.t_out - 0.5 * RAMP
    assert first.std() == pytest.approx(np.hypot(0.02, 0.03), rel=0.3)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.2
    assert (found.x - 0.3 * RAMP).std() == pytest.approx(0.01, rel=0.1)
    other = read("zero_offset", "preload", {"z_in_act_n": 0.1}, noise=noise)
    assert np.array_equal(other.t_out, found.t_out), "an effect of one sensor leaves the noise of the other"
