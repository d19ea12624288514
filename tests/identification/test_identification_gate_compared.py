"""Explanations that compete with each other: the gate names the one that leaves least, and none where sound friction does as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import changed, humming, lines, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate, samples


def rules(runs: list[Run]) -> set[str]:
    return {r.rule for r in gate.remarks(runs)}


def steep(system: str, wrap: float, seed: int, gain: float = 1.0) -> Run:
    """Return a run of much friction, whose output rests at its largest while the input comes and goes."""
    t = np.arange(6000) / 100.0
    x = 12.5 - 10.0 * np.cos(2.0 * np.pi * 0.1 * t)
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(f"{system}{seed}", system, t, x + noise[0], gain * play(x, lines(wrap)) + noise[1], config_id=f"b{seed}")


def test_a_doubled_output_is_a_gain_and_not_saturated():
    runs = [steep("act", 0.4, 0, 2.0), steep("act", 0.6, 1, 2.0), steep("sstl", 0.8, 2, 2.0), steep("sstl", 1.0, 3, 2.0)]
    (said,) = gate.remarks(runs)
    assert said.rule == "gain" and said.number == pytest.approx(4.0, rel=0.1) and len(said.run_ids) == 4


def test_an_output_cut_off_by_its_sensor_is_saturated_and_no_gain():
    runs = [steep("act", w, i) for i, w in enumerate((0.2, 0.4, 0.6))]
    assert gate.remarks(runs) == ()
    runs[0] = replace(runs[0], tension_out_n=np.minimum(runs[0].tension_out_n, 13.0))
    said = gate.remarks(runs)
    assert [r.rule for r in said] == ["limit"] and said[0].run_ids == ("act0",) and said[0].number == pytest.approx(13.0, abs=0.1)


@pytest.mark.slow
def test_runs_that_go_to_the_level_at_which_others_are_cut_off_are_cut_off_too_and_not_early():
    runs = [steep("act", w, i) for i, w in enumerate((0.2, 0.4, 0.6, 0.8))]
    cut = [replace(r, tension_out_n=np.minimum(r.tension_out_n, 10.0)) for r in runs]
    # a rise that ends at the limit ends early; what stays below is as it was
    short = replace(runs[0], run_id="low", tension_in_n=0.5 * runs[0].tension_in_n, tension_out_n=0.5 * runs[0].tension_out_n)
    said = gate.remarks([*cut, short])
    assert [r.rule for r in said] == ["limit"]
    assert set(said[0].run_ids) == {r.run_id for r in cut if r.tension_out_n.max() == 10.0}


@pytest.mark.each_once
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
@pytest.mark.parametrize(("gain", "zero"), [(2.0, 0.0), (0.5, 0.0), (1.0, 5.0), (1.0, -5.0)])
def test_what_changes_midway_is_named_with_its_channel_size_and_time(channel, gain, zero):
    def change(r):
        v = getattr(r, channel)
        return replace(r, **{channel: np.where(r.time_s < 12.0, v, gain * v + zero)})

    (said,) = gate.remarks(changed(change, "act-b050"))
    assert said.rule == ("gain_change" if zero == 0.0 else "zero_change") and said.run_ids == ("act-b050",) and channel in said.mend
    assert said.number == pytest.approx(gain if zero == 0.0 else zero, rel=0.1) and "from 12" in said.sentence.replace("11.9", "12.")


@pytest.mark.slow
def test_a_zero_that_creeps_and_a_jump_of_both_channels_are_no_change_of_one():
    creeping = [replace(r, tension_out_n=r.tension_out_n + np.linspace(0.0, 1.0, len(r))) for r in rig()]
    assert not rules(creeping) & {"zero_change", "gain_change"}
    t = np.arange(4000) / 100.0
    stepped = 4.0 + 20.0 * (np.arange(4000) % 800 > 400)
    y = play(stepped, lines(0.3))
    noise = 0.02 * np.random.default_rng(1).standard_normal((2, 4000))
    assert not rules([Run("s", "act", t, stepped + noise[0], y + noise[1])]) & {"zero_change", "gain_change"}


def test_hum_is_told_in_the_channel_that_hums_and_its_frequency():
    (said,) = gate.remarks(changed(humming))
    rate = 1.0 / rig()[0].dt_s
    assert said.rule == "hum" and "output" in said.sentence and said.number == pytest.approx(1.5, rel=0.1)
    assert f"{0.21 * rate:.3g}"[:3] in said.sentence


@pytest.mark.parametrize("amplitude", [0.05, 0.2])
def test_a_vibration_of_both_channels_and_a_little_hum_are_none(amplitude):
    def shaken(r):
        wave = np.sin(2.0 * np.pi * 0.21 * np.arange(len(r)))
        return replace(
            r, tension_out_n=r.tension_out_n + amplitude * wave, tension_in_n=r.tension_in_n + (amplitude > 0.1) * amplitude * wave
        )

    assert "hum" not in rules(changed(shaken))


def test_two_quiet_sensors_have_no_order_and_need_none():
    rng = np.random.default_rng(2)
    t = np.arange(2000) / 100.0
    assert "order" not in rules([Run("q", "act", t, *(5.0 + 0.02 * rng.standard_normal((2, 2000))))])


@pytest.mark.parametrize("rate", [40.0, 90.0])
def test_a_turn_that_repeats_a_level_of_a_fine_converter_is_not_cut_off(rate):
    t = np.arange(0.0, 30.0, 1.0 / rate)
    clean = 12.0 + 9.0 * np.sin(2.0 * np.pi * (0.1 + 0.02 * t) * t)
    noise = np.random.default_rng(0).standard_normal(len(t))

    def said(values, step=0.02):
        return {f.what for f in samples.findings(samples.Piece("r", {"time_s": t, "tension_in_n": np.round(values / step) * step}))}

    assert "saturation" not in said(clean + 0.002 * noise)
    assert "saturation" in said(np.minimum(clean + 0.03 * noise, 18.0)) and "saturation" not in said(clean + 0.03 * noise)
    # holds of a quiet channel rest between two levels
    assert "saturation" not in said(np.clip(clean, 5.0, 18.0) + 0.001 * noise)


def test_an_output_that_is_but_noise_does_not_overflow():
    r = steep("act", 0.4, 0)
    noise = np.where(np.random.default_rng(4).random(len(r)) < 0.5, 0.0, 0.04) + 1e-3 * np.random.default_rng(5).standard_normal(len(r))
    assert "overflow" not in rules([replace(r, tension_out_n=noise)])
