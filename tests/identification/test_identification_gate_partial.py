"""Movements that show a part of a loop only, and slips that their own runs tell: told where they are, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play, trapezoid
from soon import asked
from test_identification_gate_judged import loop

from sstl_cli.core.runs import Run
from sstl_cli.core.stretches import stretches
from sstl_cli.identification import gate, samples
from sstl_cli.identification.gate.measuring import evidence_of
from sstl_cli.identification.gate.rules import limit, reversed_time
from sstl_cli.identification.gate.seam import seam_of


def bent(theta, sd=0.02, seed=0, run_id="a", system="sstl", x=None, t=None):
    """A loop through lines of friction whose output relaxes in its holds, as those of a tube do."""
    if x is None:
        t, x = trapezoid(cycles=4)
    y = play(x, (np.exp(-theta), 0.0, np.exp(theta), 0.0))
    # the way back begins before the line slides: the tendon within the bend gives a part of it
    y = y + 0.15 * (1.0 - np.exp(-theta)) * (x - x.max()) * (np.gradient(x) < 0.0)
    rng = np.random.default_rng(seed)
    return Run(run_id, system, t, *(v + sd * rng.standard_normal(len(t)) for v in (x, y)), config_id=run_id)


@pytest.mark.parametrize("theta", asked([0.6, 1.0, 1.6, 2.2], 0.6, 2.2))
def test_a_loop_of_which_little_is_seen_has_no_gain(theta):
    assert not [r for r in gate.remarks([bent(theta)]) if r.rule in ("gain", "lead")]


def test_a_weak_bend_beside_strong_ones_is_no_single_pass():
    runs = [loop("weak", theta=0.12, system="sstl"), *(loop(f"b{v}", theta=v, system="sstl", seed=round(10 * v)) for v in (0.9, 1.1))]
    assert not [r for r in gate.remarks(runs) if r.rule == "passes"]


def test_a_movement_that_repeats_does_not_tell_a_delay_of_loops():
    t = np.arange(0.0, 40.0, 0.01)
    x = 14.0 + 10.0 * np.abs(((t / 4.0) % 1.0) * 2.0 - 1.0)
    late = 0.3
    y = play(np.interp(t - late, t, x), (0.6, 0.0, 1.7, 0.0))
    rng = np.random.default_rng(0)
    for moved in (0.0, 8.0):
        run = Run(
            "r", "act", t, x + 0.02 * rng.standard_normal(len(t)), np.roll(y, round(moved / 0.01)) + 0.02 * rng.standard_normal(len(t))
        )
        assert not [r for r in gate.remarks([run]) if r.rule == "lead" and abs(r.number) > 2.0]


def test_rows_in_reverse_order_are_told():
    run = loop(kind="multisine")
    back = replace(run, tension_in_n=run.tension_in_n[::-1].copy(), tension_out_n=run.tension_out_n[::-1].copy())
    (said,) = gate.remarks([back])
    assert said.rule == "reversed_time" and said.failed
    # what moves one way alone has no loop
    assert reversed_time._reversed(evidence_of(back)) and not reversed_time._reversed(replace(evidence_of(back), loops=0))
    up = evidence_of(
        bent(
            0.6,
            x=np.repeat(np.linspace(4.0, 16.0, 9), 300) + np.tile(np.minimum(np.arange(300) / 60.0, 1.0) * 1.5, 9),
            t=np.arange(2700) / 100.0,
        )
    )
    assert up.loops == 0
    # exchanged channels let the loop run the wrong way as well, and are told as what they are
    (other,) = gate.remarks([replace(run, tension_in_n=run.tension_out_n, tension_out_n=run.tension_in_n)])
    assert other.rule == "swapped"


def test_a_zero_of_one_run_is_told_beside_the_others():
    runs = [loop(str(k), theta=0.3 + 0.1 * k, kind="multisine", seed=k) for k in range(4)]
    moved = replace(runs[1], tension_out_n=runs[1].tension_out_n - 1.5)
    (said,) = gate.remarks([runs[0], moved, *runs[2:]])
    assert (said.rule, said.severity, said.run_ids) == ("zero", "remark", ("1",))
    assert said.number == pytest.approx(-1.5, abs=0.1)
    assert gate.remarks([runs[0], replace(moved, tension_out_n=runs[1].tension_out_n - 0.2), *runs[2:]]) == ()


def test_a_reading_below_no_tension_is_told():
    run = loop(kind="multisine")
    low = replace(run, tension_in_n=run.tension_in_n - run.tension_in_n.min() - 1.5)
    assert [(r.rule, r.severity) for r in gate.remarks([low]) if "push" in r.sentence] == [("zero", "remark")]


def test_systems_with_recorders_of_their_own_may_differ_in_rate():
    act = [loop("a", kind="multisine"), loop("b", theta=0.5, kind="multisine", seed=1)]
    half = [replace(r, time_s=r.time_s[::2], tension_in_n=r.tension_in_n[::2], tension_out_n=r.tension_out_n[::2]) for r in act]
    loops = [replace(r, run_id=f"s{r.run_id}", system="sstl", tension_out_n=play(r.tension_in_n, (0.45, 0.0, 2.2, 0.0))) for r in half]
    assert not [r for r in gate.remarks([*act, *loops]) if r.rule == "rate"]
    assert [r.rule for r in gate.remarks([act[0], half[1]]) if r.rule == "rate"] == ["rate"]


def said(t, x, y):
    return {(f.what, f.column): f for f in samples.findings(samples.Piece("r", {"time_s": t, "tension_in_n": x, "tension_out_n": y}))}


def test_a_reading_that_steps_to_and_fro_between_two_levels_is_no_spike():
    run = loop(kind="multisine", sd=0.05)
    x, y = (0.4 * np.round(v / 0.4) for v in (run.tension_in_n, run.tension_out_n))
    assert not [k for k in said(run.time_s, x, y) if k[0] == "spikes"]
    y[[500, 1500, 2500]] += 4.0
    assert said(run.time_s, x, y)["spikes", "tension_out_n"].count == 3


def test_stamps_that_scatter_miss_nothing():
    run = loop(kind="multisine")
    jitter = np.sort(run.time_s + 0.3 * 0.01 * np.random.default_rng(2).uniform(-1.0, 1.0, len(run.time_s)))
    found = said(jitter, run.tension_in_n, run.tension_out_n)
    assert ("sampling jitter", "time_s") in found and ("missing samples", "time_s") not in found
    kept = np.arange(len(run.time_s)) % 50 != 7
    assert said(run.time_s[kept], run.tension_in_n[kept], run.tension_out_n[kept])["missing samples", "time_s"].count == np.sum(~kept)


def test_a_recorder_that_stops_amid_motion_is_told_however_long():
    run = loop(kind="multisine")
    x, y = run.tension_in_n.copy(), run.tension_out_n.copy()
    x[1000:1600], y[1000:1600] = x[1000], y[1000]
    found = said(run.time_s, x, y)
    assert found["frozen stretches", ""].level == "failure" and "600 samples" in found["frozen stretches", ""].detail
    # a record without noise holds both, and is no fault
    t, clean = trapezoid(cycles=4)
    assert not [k for k in said(t, clean, play(clean, (0.6, 0.0, 1.7, 0.0))) if k[0] == "frozen stretches"]


def test_an_output_that_backlash_holds_at_its_largest_is_not_cut_off():
    t, x = trapezoid(cycles=6)
    rng = np.random.default_rng(4)
    y = play(x, (np.exp(-0.4), 0.0, np.exp(0.4), 0.0))

    def said(output):
        run = Run("held", "sstl", t, *(v + 0.01 * rng.standard_normal(len(t)) for v in (x, output)), config_id="a")
        found = evidence_of(run)
        # both rest at their largest while the input comes and goes
        return [r.rule for r in limit.look([replace(found, shapes=replace(found.shapes, limit_n=(np.nan, float(output.max()))))])]

    assert said(y) == [] and said(np.minimum(y, 0.8 * y.max())) == ["limit"]


def test_rows_that_are_missing_are_no_seam():
    t = np.arange(3000) * 0.01
    kept = np.delete(np.arange(3000), np.arange(1000, 1060))
    channels = tuple((8.0 - a * np.cos(0.4 * np.pi * t))[kept] for a in (6.0, 4.0))
    spans = (12.0, 8.0)
    assert seam_of(t[kept], channels, spans)[0] == (0.0, 0.0)
    # without the gap in the stamps it is one
    assert min(seam_of(t[: len(kept)], channels, spans)[0]) > 0.1


def test_a_converter_that_repeats_its_largest_reading_at_a_turn_is_not_saturated():
    rng = np.random.default_rng(6)
    t = np.arange(4000) * 0.01
    v = np.round((8.0 - 6.0 * np.cos(0.4 * np.pi * t) + 0.004 * rng.standard_normal(4000)) / 0.02) * 0.02
    cut = np.minimum(v, 13.0)

    def said(channel):
        return [f.what for f in samples.findings(samples.Piece("r", {"tension_in_n": channel})) if f.what == "saturation"]

    assert max(b - a for a, b in stretches(v == v.max())) >= 3 and said(v) == [] and said(cut) == ["saturation"]
