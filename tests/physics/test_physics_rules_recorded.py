"""Rules of movements, sensors, recorder faults and scenarios, each just at its limit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from sstl_cli.core.errors import SstlError
from sstl_cli.physics.effect import Effect, Mechanics, Sampling
from sstl_cli.physics.effects import catalogue, get, parse, typical
from sstl_cli.physics.scenario import RigSection, Scenario, Trajectory, builtin_names, load
from sstl_cli.physics.scenario_file import dump
from sstl_cli.physics.trajectories import tension_path, times

GOLDEN = Path(__file__).with_name("test_physics_values.csv")
TIME = np.linspace(0.0, 1.0, 11)


def test_movements_at_their_limits() -> None:
    t = Trajectory(kind="trapezoid", duration_s=1.0)
    assert len(times(t, 4.0)) == 4
    for hz in (3.0, 1e9):
        with pytest.raises(SstlError, match="E711"):
            times(t, hz)
    for low, high in ((5.0, 5.0), (6.0, 5.0)):
        with pytest.raises(SstlError, match="E712"):
            tension_path(Trajectory(kind="chirp", low_n=low, high_n=high), "act", TIME, np.random.default_rng(0))
    fast = Trajectory(kind="sinusoid", speed=2.0)
    x = tension_path(fast, "act", times(fast, 10.0), np.random.default_rng(0))
    assert len(x) == 500 and x[250] == pytest.approx(15.0)
    held = Trajectory(kind="minor_loops", hold_s=1.0)
    y = tension_path(held, "act", times(held, 100.0), np.random.default_rng(0))
    assert np.mean(np.diff(y) == 0.0) == pytest.approx(12 / 60, abs=0.03)
    long = Trajectory(kind="ramp_hold", hold_s=50.0)
    # holds take no more than six tenths of the time, shared out over ten levels
    z = tension_path(long, "act", times(long, 100.0), np.random.default_rng(0))
    assert np.mean(np.diff(z) == 0.0) == pytest.approx(9 * 0.06, abs=0.01)
    chirp = Trajectory(kind="chirp", frequency_hz=0.1, top_frequency_hz=0.4, duration_s=20.0)
    w = tension_path(chirp, "act", times(chirp, 100.0), np.random.default_rng(0))
    assert np.sum(np.diff(np.sign(w - 15.5)) != 0) == round(2 * 0.3 / math.log(4) * 20)


def test_order_of_the_sensor_chain() -> None:
    # a signal meets crosstalk and curvature in the sensor before gain and zero, then filter, delay, ceiling, converter, recorder
    chain = [
        "sensor_nonlinearity",
        "crosstalk",
        "gain_error",
        "zero_offset",
        "zero_drift",
        "channel_lowpass",
        "channel_delay",
        "saturation",
        "quantisation",
        "acquisition_faults",
    ]
    assert [get(e).order for e in chain] == [52, 54, 55, 60, 61, 70, 75, 85, 90, 95]
    assert {e.order for e in catalogue().values() if e.id not in chain} == {50}
    assert sorted(e.id for e in catalogue().values() if not e.fitted) == ["acquisition_faults", "quantisation", "saturation"]


def test_typical_strengths() -> None:
    assert typical(get("slack")) == {"gap_mm": pytest.approx(5 / 3)} and typical(get("gain_error")) == {"g_act": pytest.approx(1.05)}
    assert parse(" slack ") == ("slack", get("slack").complete({"gap_mm": 5 / 3}))
    assert parse("stribeck: ratio = 1.2 , v_s_mm_s=2") == ("stribeck", get("stribeck").complete({"ratio": 1.2, "v_s_mm_s": 2.0}))
    effect = get("slack")
    assert isinstance(effect, Effect) and not effect.active({"gap_mm": 0.0}) and effect.active({"gap_mm": 0.1}) and not effect.active({})
    assert not get("stribeck").active({"v_s_mm_s": 5.0})
    for value in (-0.1, 5.1):
        with pytest.raises(SstlError, match="E702"):
            effect.complete({"gap_mm": value}, usual=True)
    with pytest.raises(SstlError, match="E702"):
        effect.complete({"gap_mm": -0.1})
    assert effect.complete({"gap_mm": 5.0}) == {"gap_mm": 5.0}


def test_recorder_faults_of_the_fast_model() -> None:
    x = np.arange(1000.0) + 100.0

    def faulty(**values: float) -> np.ndarray:
        e = get("acquisition_faults")
        return e.output(x, x, Sampling("act", 0.01, x, np.random.default_rng(3)), e.complete(values))  # type: ignore[misc]

    rng = np.random.default_rng(3)
    hit = rng.random(1000) < 0.02
    up = np.where(rng.random(int(hit.sum())) < 0.5, -1.0, 1.0)
    assert (faulty(spike_pct=2.0, spike_n=7.0) - x)[hit] == pytest.approx(7.0 * up) and not (faulty(spike_pct=2.0) - x)[~hit].any()
    assert np.array_equal(faulty(dropout_pct=2.0) == 0.0, np.random.default_rng(3).random(1000) < 0.02)
    # a clock late by 10 % of a period per percent
    late = np.clip(np.arange(1000) + 0.2 * np.random.default_rng(3).standard_normal(1000), 0, 999) + 100.0
    assert faulty(jitter_pct=2.0) == pytest.approx(late)
    # 50 ms are 5 samples: starts are that much rarer than frozen samples
    starts = np.flatnonzero(np.random.default_rng(3).random(1000) < 0.02 / 5)
    frozen = x.copy()
    for s in starts:
        frozen[s : s + 5] = frozen[s]
    assert len(starts) > 0 and np.array_equal(faulty(frozen_pct=2.0), frozen)


def test_scenarios_and_their_limits() -> None:
    s = Scenario.model_validate({"schema": "sstl.scenario/1", "configurations": [{"id": "A", "theta": 0.4}, {"id": "B", "theta": 0.6}, {"id": "C", "sstl": {"gamma_p": 0.2, "beta_p": 0, "gamma_r": 3, "beta_r": 0}}],
                                 "tendons": [{"id": "x"}], "trajectories": [{"kind": "chirp", "systems": ["act"], "record_reference": True}]})  # fmt: skip
    assert (s.theta_of("A"), s.theta_of("B"), s.theta_of("C"), s.theta_of(None)) == (0.4, 0.6, 0.5, 0.5)
    assert Scenario(schema="sstl.scenario/1").theta_of("A") == 0.53  # type: ignore[call-arg]
    t = s.tendons[0]
    assert (t.theta_factor, t.level, t.delay_s, s.trajectories[0].name, s.sampling_hz, s.simulator) == (
        1.0,
        1.0,
        0.0,
        "chirp",
        500.0,
        "transmission",
    )
    text = dump(s)
    assert "record_reference = true" in text and 'systems = ["act"]' in text and "sstl = { " in text
    assert (s.rig.mechanics(), s.rig.nodes, s.noise.white_n, s.noise.correlation_s) == (Mechanics(), 30, 0.02, 0.3)
    for twice in ({"configurations": [{"id": "A", "theta": 0.4}] * 2}, {"tendons": [{"id": "x"}] * 2}, {"configurations": [{"id": "A"}]}):
        with pytest.raises(ValidationError):
            Scenario.model_validate({"schema": "sstl.scenario/1", **twice})
    for rig in ({"bend_centres": {"A": 0.12}}, {"bend_centres": {"A": 0.88}}):
        with pytest.raises(ValidationError, match="leaves the tube"):
            RigSection.model_validate(rig)
    assert RigSection.model_validate({"bend_centres": {"A": 0.125, "B": 0.875}}).arc_fraction == 0.25


@pytest.mark.parametrize("name", ["default", "sample", "two-tendons"])
def test_a_scenario_is_written_and_read_back(name: str, tmp_path: Path) -> None:
    assert name in builtin_names()
    (tmp_path / "s.toml").write_text(dump(load(name)))
    assert load(str(tmp_path / "s.toml")) == load(name)
    with pytest.raises(SstlError, match="E710"):
        load("no-such-scenario")
