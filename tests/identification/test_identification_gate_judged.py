"""Slips that hands who had not read the rules made, and that were missed or told in the wrong words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play, trapezoid

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate, samples


def lines(theta):
    return np.exp(-theta), 0.0, np.exp(theta), 0.0


def loop(run_id="a", theta=0.4, system="act", kind="trapezoid", sd=0.02, seed=0, seconds=40.0):
    t, x = trapezoid(cycles=4) if kind == "trapezoid" else multisine(3, seconds=seconds, rate=100.0)
    y = play(x, lines(theta * (2 if system == "sstl" else 1)))
    rng = np.random.default_rng(seed)
    return Run(run_id, system, t, *(v + sd * rng.standard_normal(len(t)) for v in (x, y)), config_id="c")


def cut(run, here):
    return replace(run, time_s=run.time_s[here], tension_in_n=run.tension_in_n[here], tension_out_n=run.tension_out_n[here])


def shifted(run, by_s):
    """Return the output ``by_s`` seconds late (early where negative); rows that have no partner are cut off."""
    k = round(abs(by_s) / (run.time_s[1] - run.time_s[0]))
    late, early = slice(None, -k), slice(k, None)
    mine, other = (early, late) if by_s > 0 else (late, early)
    return replace(run, time_s=run.time_s[mine], tension_in_n=run.tension_in_n[mine], tension_out_n=run.tension_out_n[other])


def drifting(run, rate):
    at = run.time_s[0] + (run.time_s - run.time_s[0]) * rate
    return cut(replace(run, tension_out_n=np.interp(at, run.time_s, run.tension_out_n)), at <= run.time_s[-1])


@pytest.mark.each_once
@pytest.mark.parametrize("kind", ["trapezoid", "multisine"])
@pytest.mark.parametrize(("by_s", "severity"), [(-2.0, "failure"), (1.5, "remark")])
def test_a_clock_that_is_off_by_seconds_is_told(kind, by_s, severity):
    (said,) = gate.remarks([shifted(loop(kind=kind), by_s)])
    assert (said.rule, said.severity) == ("lead", severity)
    assert said.number == pytest.approx(by_s, abs=0.1)


def test_a_clock_that_drifts_by_some_percent_is_told():
    (said,) = gate.remarks([drifting(loop(kind="multisine", sd=0.04), 1.03)])
    assert said.rule == "drift" and abs(said.number) == pytest.approx(3.0, abs=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("theta", [0.2, 0.5])
def test_a_channel_zeroed_under_load_is_no_flipped_sign(theta):
    run = loop(theta=theta)
    x, y = run.tension_in_n - run.tension_in_n.max(), run.tension_out_n - run.tension_out_n.max()
    for changed in (dict(tension_in_n=x), dict(tension_out_n=y), dict(tension_in_n=x, tension_out_n=y)):
        said = gate.remarks([replace(run, **changed)])
        assert [r.rule for r in said] == ["zero"] * len(changed) and all(r.failed for r in said)


@pytest.mark.parametrize("signs", [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_a_flipped_sign_is_still_one(signs):
    run = loop()
    (said,) = gate.remarks([replace(run, tension_in_n=signs[0] * run.tension_in_n, tension_out_n=signs[1] * run.tension_out_n)])
    assert said.rule == "sign" and said.failed


def test_an_output_that_friction_holds_is_not_dead():
    t, x = multisine(3, seconds=40.0, rate=100.0)
    x = 2.0 + 18.0 * (x - x.min()) / np.ptp(x)
    rng = np.random.default_rng(1)
    held = Run("held", "sstl", t, x + 0.02 * rng.standard_normal(len(t)), 3.0 + 0.02 * rng.standard_normal(len(t)))
    assert not [r for r in gate.remarks([held]) if r.rule == "dead"]
    assert [r.rule for r in gate.remarks([replace(held, tension_out_n=held.tension_out_n - 3.0)])] == ["dead"]


def test_a_loop_that_an_amplifier_clips_has_no_other_clock():
    run = loop(kind="multisine")
    clipped = replace(run, tension_out_n=np.minimum(run.tension_out_n, 0.6 * run.tension_out_n.max()))
    assert not [r for r in gate.remarks([clipped]) if r.rule == "lead"]


@pytest.mark.parametrize(("channel", "said"), [(1, "the output was amplified"), (0, "the input is in kgf")])
def test_the_noise_tells_which_channel_of_one_run_has_changed(channel, said):
    runs = [loop(str(k), kind="multisine", seed=k) for k in range(4)]
    odd = (
        replace(runs[0], tension_out_n=9.8 * runs[0].tension_out_n)
        if channel
        else replace(runs[0], tension_in_n=runs[0].tension_in_n / 9.8)
    )
    (told,) = [r for r in gate.remarks([odd, *runs[1:]]) if r.rule == "gain"]
    assert said in told.sentence and "or the " not in told.sentence.split("probably")[1]


def found(x, y):
    piece = samples.Piece("a", {"time_s": np.arange(len(x)) / 100.0, "tension_in_n": x, "tension_out_n": y})
    return {(f.what, f.level) for f in samples.findings(piece)}


def test_rows_sorted_as_text_are_rows_out_of_order():
    run = loop(kind="multisine")
    order = sorted(range(len(run)), key=str)
    said = found(run.tension_in_n[order], run.tension_out_n[order])
    assert ("rows out of order", samples.FAILURE) in said and "spikes" not in {what for what, _ in said}


def test_a_sharp_corner_is_no_spike_and_a_spike_is_one():
    rng = np.random.default_rng(2)
    x = 5.0 + np.abs((np.arange(3000) + 0.3) % 101 - 50.0) * 0.5 + 0.005 * rng.standard_normal(3000)
    assert "spikes" not in {what for what, _ in found(x, 0.7 * x + 0.005 * rng.standard_normal(3000))}
    x[1500] += 3.0
    assert ("spikes", samples.REMARK) in found(x, 0.7 * x + 0.005 * rng.standard_normal(3000))


def test_a_channel_that_hardly_moves_is_not_coarse():
    x = 5.0 + np.arange(3000) * 0.01
    y = np.round(3.0 + 0.3 * np.sin(np.arange(3000) / 300.0), 1)
    assert ("quantised", samples.REMARK) in found(x, y)
    assert ("quantised", samples.FAILURE) in found(np.round(5.0 + 0.3 * np.sin(np.arange(3000) / 200.0), 1), y)


def test_readings_of_an_error_code_are_told_alike_by_both_checks():
    run = loop(kind="multisine")
    lost = np.random.default_rng(1).random(len(run)) < 0.004
    y = np.where(lost, -999.0, run.tension_out_n)
    (spikes,) = [
        f
        for f in samples.findings(samples.Piece("a", {"time_s": run.time_s, "tension_in_n": run.tension_in_n, "tension_out_n": y}))
        if f.what == "spikes"
    ]
    (filled,) = [r for r in gate.remarks([replace(run, tension_out_n=y)]) if r.rule == "filled"]
    assert spikes.fix == filled.mend and "-999 N" in spikes.detail


@pytest.mark.parametrize(("noise", "wrap"), [(0.003, 0.5), (0.02, 0.8)])
def test_a_rest_before_an_error_code_is_left_by_no_jump(noise, wrap):
    t = np.arange(1800) / 100.0
    x = 12.0 - 9.0 * np.cos(2.0 * np.pi * t / 9.0)
    rng = np.random.default_rng(3)
    y = np.round((play(x, lines(wrap)) + noise * rng.standard_normal(len(t))) / 0.2) * 0.2
    run = Run("a", "sstl", t, x + 0.02 * rng.standard_normal(len(t)), y)
    assert gate.remarks([run]) == ()
    changes = np.flatnonzero(np.diff(y) != 0.0)
    end = int(changes[np.argmax(np.diff(changes)) + 1])
    lost = y.copy()
    lost[[100, 500, end - 20, end - 19, 1000, 1700]] = -999.0
    assert [r.rule for r in gate.remarks([replace(run, tension_out_n=lost)])] == ["filled"]


def test_the_last_digit_of_a_file_far_below_the_noise_is_no_converter():
    noise = 0.005 * np.random.default_rng(1).standard_normal(800)
    x = np.repeat(np.round(5.0 + 0.02 * np.sin(np.arange(800) / 40.0) + noise, 5), 5)
    y = 4.0 + np.sin(np.arange(4000) / 200.0)
    assert "quantised" not in {what for what, _ in found(x, y)}
    assert ("quantised", samples.REMARK) in found(np.round(x, 2), y)


@pytest.mark.parametrize("wrap", [0.8, 1.0, 1.3])
def test_a_run_that_is_hardly_released_is_in_the_unit_of_the_others(wrap):
    t = np.arange(1600) / 100.0

    def decay(k, wrap, loop_s):
        x = 20.5 - 19.7 * np.exp(-t / 15.0) * np.cos(2.0 * np.pi * t / loop_s)
        scatter = 0.03 * np.random.default_rng(k).standard_normal((2, len(t)))
        return Run(f"r{k}", "act", t, (x + scatter[0]) / 9.80665, play(x, lines(wrap)) + scatter[1], config_id="c", trajectory="m")

    log = [*(decay(k, 0.4, 3.2 + 0.1 * k) for k in range(4)), decay(9, wrap, 5.0)]
    (said,) = [r for r in gate.remarks(log) if r.rule == "gain"]
    assert "the input is in kgf" in said.sentence and len(said.run_ids) == 5
