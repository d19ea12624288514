"""Which slip the gate names where several could be meant, and movements, frictions and recorders that are no slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play, trapezoid
from identification_slips import BENDS, bend, changed, lines, overflowing, rig
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate, samples


def rules(runs: list[Run]) -> set[str]:
    return {r.rule for r in gate.remarks(runs)}


def sine(t, low, high, hz):
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(2.0 * np.pi * hz * t)


def recorded(t, x, y, sd=0.02, seed=0, system="act", **labels):
    noise = sd * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(labels.pop("run_id", "r"), system, t, x + noise[0], y + noise[1], **labels)


def seconds(duration, rate=100.0):
    return np.arange(round(duration * rate)) / rate


def test_a_sound_log_is_passed_over():
    assert gate.remarks(rig()) == ()


@pytest.mark.each_once
@pytest.mark.parametrize("zero", [-8.0, -3.0])
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
def test_a_zero_that_one_run_holds_is_told_with_its_size(zero, channel):
    runs = changed(lambda r: replace(r, **{channel: getattr(r, channel) + zero}), "act-b020")
    (said,) = gate.remarks(runs)
    assert said.rule == "zero" and said.run_ids == ("act-b020",) and channel in said.mend
    if "at no tension" in said.sentence:
        assert said.number == pytest.approx(zero, abs=0.2)


def falling_with_speed(x, wrap, falls=0.25):
    """Return a play whose friction is smaller the faster the input moves."""
    speed = np.abs(np.gradient(np.log(x)))
    part = 1.0 - falls * (1.0 - np.exp(-speed / np.quantile(speed, 0.7)))
    y, out = x[0] * np.exp(-wrap), []
    for low, high in zip(x * np.exp(-wrap * part), x * np.exp(wrap * part), strict=True):
        y = min(max(y, low), high)
        out.append(y)
    return np.array(out)


@pytest.mark.parametrize(
    ("low", "high", "hz"), asked([(1.5, 9.5, 0.2), (3.0, 25.0, 0.4), (5.0, 40.0, 0.25)], (3.0, 25.0, 0.4), several=True)
)
def test_friction_that_falls_with_speed_is_no_early_output(low, high, hz):
    t = seconds(30.0)
    x = sine(t, low, high, hz)
    runs = [recorded(t, x, falling_with_speed(x, w), seed=i, run_id=f"r{i}") for i, w in enumerate((0.3, 0.6, 0.9))]
    assert "lead" not in rules(runs)
    # and an early output still is one
    early = [replace(r, tension_out_n=np.interp(t + 0.3, t, r.tension_out_n)) for r in runs[:1]]
    assert "lead" in rules(early) or hz < 0.3


def test_a_small_movement_within_the_backlash_has_no_delay_and_no_other_recording():
    t = seconds(30.0)
    x = sine(t, 8.0, 11.0, 0.3)
    # many plays side by side creep along with a movement that none of them follows
    y = np.mean([play(x, lines(w)) for w in np.linspace(0.02, 1.5, 12)], axis=0)
    late = np.interp(t - 1.1, t, y)
    said = rules([recorded(t, x, v, sd=0.005, seed=i, run_id=f"r{i}") for i, v in enumerate((y, late))])
    assert not said & {"lead", "unrelated", "drift", "gain", "zero", "passes"}


def test_a_sensor_that_catches_up_in_a_hold_is_not_at_its_limit():
    t, x = trapezoid(3.0, 25.0, rate=100.0, cycles=5, seconds=6.0)
    y = play(x, lines(0.5))
    slow = [y[0]]
    for v in y[1:]:
        slow.append(slow[-1] + 0.1 * (v - slow[-1]))
    assert "limit" not in rules([recorded(t, x, np.array(slow))])
    # of a small movement noise alone is a good part
    x = 2.5 - 1.5 * np.cos(1.5 * t) * np.exp(-t / 30.0)
    assert "limit" not in rules([recorded(t, x, play(x, lines(0.15)), sd=0.05)])


def test_a_limit_is_no_early_output_and_no_reversed_record():
    runs = rig()
    t = runs[0].time_s
    early = [replace(r, tension_out_n=np.interp(t + 0.5, t, r.tension_out_n)) for r in runs if r.system == "act"]
    assert rules(early) == {"lead"}


def test_a_step_of_the_movement_behind_a_slow_sensor_is_no_seam():
    t = seconds(30.0, 200.0)
    x = 12.0 + 10.0 * np.clip(6.0 * np.sin(2.0 * np.pi * 0.2 * t) ** 3, -1.0, 1.0)
    r = recorded(t, x, play(x, lines(0.6)), sd=0.05)
    held = r.tension_out_n[np.arange(len(t)) // 10 * 10]
    assert "joined" not in rules([replace(r, tension_out_n=held)])


def test_a_recorder_that_stood_still_amid_motion_is_told():
    def pause(r):
        here = (r.time_s > 9.0) & (r.time_s < 12.0)
        at = int(np.argmax(here))
        return replace(r, **{c: np.where(here, getattr(r, c)[at], getattr(r, c)) for c in ("tension_in_n", "tension_out_n")})

    (said,) = [r for r in gate.remarks(changed(pause, "act-b050")) if r.rule == "stuck"]
    assert said.run_ids == ("act-b050",) and "input and output both" in said.sentence


def test_a_command_ahead_of_the_tension_is_told_by_its_rounding():
    def commanded(r):
        clean, r = (bend(r.config_id, BENDS[r.config_id], r.system, 0, sd=sd) for sd in (0.0, 0.04))
        return replace(r, tension_in_n=np.round(np.interp(r.time_s + 0.25, r.time_s, clean.tension_in_n), 3))

    assert "noiseless" in rules(changed(commanded))


def test_loggers_of_their_own_for_each_system_are_no_slip():
    runs = [
        r if r.system == "act" else replace(r, **{c: getattr(r, c)[::2] for c in ("time_s", "tension_in_n", "tension_out_n")})
        for r in rig()
    ]
    assert "rate" not in rules(runs)
    # the same movement five times as fast is a clock
    (said,) = [r for r in gate.remarks(changed(lambda r: replace(r, time_s=r.time_s / 5.0), "sstl-b050")) if r.rule == "rate"]
    assert said.run_ids == ("sstl-b050",) and said.mend == "time_s = { rate_hz = 100 } (for this file)"


def test_labels_of_systems_exchanged_in_all_bends_are_told_in_all():
    runs = [replace(r, system="act" if r.system == "sstl" else "sstl") for r in rig()]
    said = [r for r in gate.remarks(runs) if r.rule == "passes"]
    assert {name for r in said for name in r.run_ids} == {r.run_id for r in runs} and all(r.failed for r in said)


def test_a_slight_bend_with_a_name_is_no_single_pass():
    t, x = trapezoid(3.0, 25.0, rate=100.0, cycles=4, seconds=8.0)
    slight = recorded(t, x, play(x, lines(0.2)), system="sstl", config_id="b010")
    assert "passes" not in rules([slight])


def test_an_overflow_names_its_channel_and_a_dropout_is_none():
    (said,) = list(gate.remarks(changed(overflowing, "act-b020")))
    assert said.rule == "overflow" and said.number == pytest.approx(24.0, abs=0.5)

    def dropping(r):
        lost = (np.arange(len(r)) % 300) < 20
        return replace(r, tension_out_n=np.where(lost, -2.0, r.tension_out_n))

    assert "overflow" not in rules(changed(dropping, "act-b020"))


def test_a_run_whose_jumps_do_not_tell_wraps_where_its_sensor_does_in_another_run():
    wrapped, hidden, *rest = [gate.evidence_of(r) for r in changed(overflowing, "act-b020", "act-b080") if r.system == "act"][::2]
    assert not rest and np.isfinite(hidden.shapes.wrap_n[1])
    # both read from one end to the other of one range, and what is known of the second one is that no friction explains it
    silent = replace(hidden, extremes=wrapped.extremes, shapes=replace(hidden.shapes, wrap_n=(np.nan, np.nan)))
    others = [gate.evidence_of(r) for r in rig() if r.system == "sstl"]
    told = {r.rule: r.run_ids for r in gate.judge([wrapped, silent, *others])}
    assert told["overflow"] == ("act-b020", "act-b080") and "unrelated" not in told
    # one that friction explains has that range of its own
    sound = replace(gate.evidence_of(rig()[4]), extremes=wrapped.extremes)
    assert sound.run_id == "act-b080"
    assert {r.rule: r.run_ids for r in gate.judge([wrapped, sound, *others])}["overflow"] == ("act-b020",)


def found(t, x, y):
    return {f.what for f in samples.findings(samples.Piece("r", {"time_s": t, "tension_in_n": x, "tension_out_n": y}))}


def test_stamps_that_jitter_miss_no_samples():
    r = rig()[0]
    t = r.time_s + np.random.default_rng(2).uniform(-0.003, 0.003, len(r))
    assert "missing samples" not in found(t, r.tension_in_n, r.tension_out_n)
    keep = np.ones(len(r), np.bool_)
    keep[[500, 501, 1200]] = False
    assert "missing samples" in found(t[keep], r.tension_in_n[keep], r.tension_out_n[keep])


def test_what_dithers_between_two_levels_is_no_spike():
    r = bend("b020", 0.2, "act", 5, sd=0.06)
    x, y = (0.4 * np.round(v / 0.4) for v in (r.tension_in_n, r.tension_out_n))
    assert "spikes" not in found(r.time_s, x, y)
    y = r.tension_out_n.copy()
    y[700] += 6.0
    assert "spikes" in found(r.time_s, x, y)
