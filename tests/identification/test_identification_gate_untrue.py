"""What the gate must not say: of stamps that do not rise, of an output that rests, of movements that share but a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.causes import NO_CAUSES
from sstl_cli.identification.gate.limits import limit_of
from sstl_cli.identification.gate.rules.gain import gain_of
from sstl_cli.identification.gate.slopes import NO_SLOPES, agreed

T = np.arange(1600) / 100.0


def moving(run_id, x, wrap, noise=0.01, step=0.0, system="sstl", t=T, **labels):
    """Return a run of an ideal capstan, behind a converter where there is a ``step`` (N)."""
    scatter = noise * np.random.default_rng(sum(map(ord, run_id))).standard_normal((2, len(t)))
    read = [v + s for v, s in zip((x, play(x, lines(wrap))), scatter, strict=True)]
    return Run(run_id, system, t, *(np.round(v / step) * step if step else v for v in read), **labels)


def decay():
    """Return a movement of which friction passes on the first rise alone."""
    return 20.5 - 19.7 * np.exp(-T / 15.0) * np.cos(2.0 * np.pi * T / 3.2)


@pytest.mark.parametrize("stamp_s", [0.1, 100.0])
def test_stamps_that_do_not_rise_end_no_rule(stamp_s):
    runs = [moving(f"r{i}", multisine(i, seconds=16.0)[1], 0.4, system="act") for i in range(2)]
    said = gate.remarks([replace(r, time_s=np.floor(r.time_s / stamp_s) * stamp_s) for r in runs])
    assert not [r for r in said if r.rule == "drift"]


def test_an_output_that_rests_has_no_lines_of_its_own():
    others = [moving(f"r{i}", multisine(i, seconds=16.0)[1], 1.27, step=0.1) for i in range(5)]
    rests = moving("rests", decay(), 1.27, noise=0.003, step=0.1)
    assert gate.remarks([*others, rests]) == ()
    # moved by a delay until nothing but the rest is compared, free lines are flat but for rounding, which may order them as friction does
    play = gate.evidence_of(others[0]).play
    flat = replace(play, gamma_p=5e-18, beta_p=10.7, gamma_r=8e-17, beta_r=10.7, explained=1.0, shares=(0.05, 0.04), reaches=(0.3, 0.2))
    span_n, step_n = 39.0, 0.1
    assert agreed(NO_SLOPES, flat, NO_CAUSES, 0.0, span_n, step_n) is NO_SLOPES
    # a line that rises by more than a level is one
    rising = replace(flat, gamma_p=0.28, gamma_r=3.5)
    assert agreed(NO_SLOPES, rising, NO_CAUSES, 0.0, span_n, step_n).friction == pytest.approx(1.26, abs=0.01)


def test_a_channel_however_small_has_a_gain():
    r = moving("a", multisine(1, seconds=16.0)[1], 0.4)
    with np.errstate(all="ignore"):
        tiny = gate.evidence_of(replace(r, tension_out_n=1e-300 * r.tension_out_n))
    assert np.log10(tiny.slopes.gain) == pytest.approx(-300.0, abs=0.2)


def test_two_movements_of_one_name_say_nothing_of_a_clock():
    def loops(period_s, edge):
        return 5.0 + 20.0 * np.abs((T / period_s) % 1.0 - 0.5) ** edge

    beside = [moving(f"a{i}", loops(2.0, 1.0), 0.3 + 0.1 * i, system="act", trajectory="up and down") for i in range(3)]
    # about as many samples a loop, and another way
    other = moving("b", loops(2.15, 1.0) * (0.4 + 0.03 * T), 0.4, system="act", trajectory="up and down")
    (said,) = [r for r in gate.remarks([*beside, replace(other, time_s=0.5 * other.time_s)]) if r.rule == "rate"]
    assert "clock" not in said.sentence
    # the same movement is one
    same = moving("c", loops(2.0, 1.0), 0.4, system="act", trajectory="up and down")
    (said,) = [r for r in gate.remarks([*beside, replace(same, time_s=0.5 * same.time_s)]) if r.rule == "rate"]
    assert "clock is probably off" in said.sentence


def test_hum_that_both_cells_pick_up_makes_no_copy_of_an_output_that_rests():
    """The line holds: the output is near any line, and what both readings share is the mains."""
    t = np.arange(3600) / 180.0
    hum = np.sin(2.0 * np.pi * 49.97 * t)
    scatter = 0.01 * np.random.default_rng(5).standard_normal((2, len(t)))
    rests = Run("rests", "sstl", t, 16.0 + 10.0 * np.sin(0.5 * t) + 0.03 * hum + scatter[0], 10.4 + 0.11 * hum + scatter[1])
    assert "same_channel" not in {r.rule for r in gate.remarks([rests])}
    # the same reading twice is a copy, hum and all
    twice = replace(rests, tension_out_n=0.5 * rests.tension_in_n + 1.0)
    assert "same_channel" in {r.rule for r in gate.remarks([twice])}


def test_a_hold_between_two_pauses_of_the_recorder_is_part_of_a_run_that_moved():
    runs = [moving(f"r{i}", multisine(i, seconds=16.0)[1], 0.4, system="act") for i in range(2)]
    rest = moving("r0~2", np.full(80, 5.0), 0.4, system="act", t=T[:80])
    assert gate.remarks([*runs, rest]) == ()
    assert [r.run_ids for r in gate.remarks([*runs, replace(rest, run_id="still")]) if r.rule == "dead"] == [("still",)]


def test_a_piece_that_is_only_released_may_read_far_more_than_its_input():
    x = 4.7 - 3.6 * np.clip((T[:80] - 0.1) / 0.25, 0.0, 1.0)
    late = np.concatenate((np.full(3, x[0]), x[:-3]))
    rest, noise = moving("rest", x, 0.5, t=T[:80]), 0.02 * np.random.default_rng(5).standard_normal(80)
    piece = replace(rest, tension_out_n=late * np.exp(0.97) + noise)
    e = gate.evidence_of(piece)
    assert e.ranges[1].high > 2.5 * e.ranges[0].high and not e.causes.enough and not e.slopes.known
    assert np.isnan(gain_of(e))
    # so large a factor is no friction
    assert gain_of(gate.evidence_of(replace(piece, tension_out_n=30.0 * piece.tension_out_n))) > 30.0


def worn(factors, wrong=""):
    """Return runs of two bends recorded three times each, whose friction goes by these factors from run to run."""
    x = multisine(1, seconds=16.0)[1]
    bends = {"b020": 0.30, "b060": 0.55}
    log = [
        moving(f"{bend}-{k}", x, wrap * f, system="act", config_id=bend, trajectory="m")
        for bend, wrap in bends.items()
        for k, f in enumerate(factors)
    ]
    return [replace(r, config_id="b020") if r.run_id == wrong else r for r in log]


@pytest.mark.parametrize("factors", [(1.0, 1.08, 1.16), (1.09, 1.0, 0.92), (1.0, 0.86, 0.87)])
def test_wear_and_scatter_from_run_to_run_are_no_wrong_label(factors):
    assert not [r for r in gate.remarks(worn(factors)) if r.rule == "labels"]
    # a label that is wrong leaves its run with the other bend, however much they wear
    (said,) = [r for r in gate.remarks(worn(factors, wrong="b060-1")) if r.rule in ("labels", "relabelled")]
    assert "b060-1" in said.run_ids


def test_an_output_that_relaxes_through_short_holds_is_no_input_at_its_limit():
    t = np.arange(2400) / 100.0
    phase = t % 6.0
    x = np.interp(phase, [0.0, 2.5, 3.4, 5.5, 6.0], [3.0, 24.0, 24.0, 3.0, 3.0])
    held = np.where((phase > 2.5) & (phase < 3.4), phase - 2.5, 0.0)
    relaxed = np.log1p(held / 0.6) / np.log(1.0 + 0.9 / 0.6)
    noise = 0.01 * np.random.default_rng(3).standard_normal((2, len(t)))
    wrap, top = 0.8, 24.0 * np.exp(-0.8)
    rising = np.minimum(top, x * np.exp(-wrap))
    # a fifth of friction goes while the input is held, and stays gone until it is low
    kept = np.maximum.accumulate(np.where(phase < 2.5, 0.0, relaxed).reshape(4, -1), axis=1).ravel()
    y = np.where(phase < 2.5, rising, np.minimum(top * np.exp(0.2 * wrap * kept), x * np.exp(wrap)))
    assert np.isnan(limit_of(t, x + noise[0], y + noise[1], (0.01, 0.01), wrap=wrap))
    # by more than friction has to give, the input must have gone on
    assert limit_of(t, x + noise[0], y + noise[1], (0.01, 0.01), wrap=0.2) == pytest.approx(24.0, abs=0.1)
