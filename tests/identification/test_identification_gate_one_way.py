"""Runs that go one way, or partly: what needs a closed loop, or an output that propagates both ways, says nothing of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import rig
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.measuring import evidence_of
from sstl_cli.identification.gate.movement import both_ways, loop_work
from sstl_cli.identification.gate.rules import odd_run

RATE = 100.0


def pull(low=4.0, high=11.5, seconds=24.0):
    """Return the time and input of the rising half of a slow cosine, which lingers at both ends."""
    t = np.arange(round(seconds * RATE)) / RATE
    return t, low + (high - low) * (1.0 - np.cos(0.5 * np.pi * t / seconds))


def recorded(t, x, y, run_id="a", system="act", config_id="c", sd=0.02, seed=0):
    rng = np.random.default_rng(seed)
    return Run(run_id, system, t, *(v + sd * rng.standard_normal(len(t)) for v in (x, y)), config_id=config_id)


def rules_of(*runs):
    return {r.rule for r in gate.remarks(runs)}


@pytest.mark.parametrize("seed", asked(range(6), 0, 3))
def test_a_single_pull_holds_no_loop_that_could_give_energy(seed):
    t, x = pull()
    sd = 0.06
    # a far end that an earlier pull left under load stays, and then follows
    y = np.maximum(5.0, 0.72 * x)
    run = recorded(t, x, y, sd=sd, seed=seed)
    assert loop_work(run.tension_in_n, run.tension_out_n, sd) == 0.0
    # the middle of what was pulled lies where the input lingers
    rests = np.interp(t, [0.0, 10.0, 14.0, 24.0], [4.0, 7.7, 7.8, 11.5])
    run = recorded(t, rests, 5.0 + 0.01 * rests, sd=sd, seed=seed)
    assert loop_work(run.tension_in_n, run.tension_out_n, sd) == 0.0
    assert "energy" not in rules_of(run)


def test_a_loop_that_gives_is_told_as_before():
    t = np.arange(0.0, 40.0, 1.0 / RATE)
    x = 12.0 - 9.0 * np.cos(2.0 * np.pi * t / 8.0)
    y = play(x, (0.7, 0.0, 1.4, 0.0))
    assert loop_work(x, y, 0.02) < -0.02 and loop_work(x, x - y, 0.02) > 0.02


def test_a_partial_pull_within_presliding_is_no_copy_of_the_input():
    t, x = pull()
    creeps = recorded(t, x, 4.56 + 0.09 * x, "p", "sstl")
    whole = 16.0 - 14.0 * np.cos(2.0 * np.pi * t / 6.0)
    loops = [
        recorded(t, whole, play(whole, (np.exp(-n), 0.0, np.exp(n), 0.0)), f"{s}{n}", s, seed=1) for s, n in (("act", 0.6), ("sstl", 1.2))
    ]
    assert "same_channel" not in rules_of(creeps, *loops)
    # nor within a small loop of it, which is elastic: its line begins at what the output was left at
    wave = 7.7 - 3.7 * np.cos(2.0 * np.pi * t / 6.0)
    assert "same_channel" not in rules_of(recorded(t, wave, 4.56 + 0.09 * wave, "p", "sstl"), *loops)
    # two sensors at one end are one tension, seen both ways
    assert "same_channel" in rules_of(recorded(t, whole, 0.98 * whole, "p", "sstl"), *loops)


def test_two_sensors_at_one_end_are_told_beside_a_run_that_only_pulls():
    t, x = pull()
    wave = 9.0 - 6.0 * np.cos(2.0 * np.pi * t / 6.0)
    runs = [recorded(t, v, v, f"{k}", config_id=f"b{k}", seed=k) for k, v in enumerate((wave, wave, x))]
    (said,) = gate.remarks(runs)
    assert said.rule == "same_channel" and len(said.run_ids) == 3
    # pulls alone lose nothing that shows
    assert "same_channel" not in rules_of(*(recorded(t, x, x, f"{k}", config_id=f"b{k}", seed=k) for k in range(3)))


def test_a_pull_and_a_release_are_no_two_bends():
    t = np.arange(0.0, 12.0, 0.002)
    x = np.interp(t, [0.0, 4.8, 5.4, 7.0, 10.0, 12.0], [1.0, 30.0, 30.0, 10.0, 0.0, 0.0])
    # the release breaks away late, and then follows the same friction
    slides = play(x, (np.exp(-0.612), 0.0, np.exp(0.612), 0.0))
    stuck = (t > 5.4) & (np.exp(0.86) * x > slides.max())
    run = recorded(t, x, np.where(stuck, slides.max(), slides), "a")
    assert evidence_of(run).shapes.parted is None


def test_a_partial_pull_within_presliding_is_no_curve():
    t, x = pull()
    # what slides strand by strand: little of it at first, all of it in the end
    y = np.interp(
        x, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 10.6, 11.0, 11.3, 11.5], [4.87, 4.98, 5.12, 5.22, 5.35, 5.47, 5.62, 5.75, 5.87, 6.03, 6.2]
    )
    run = recorded(t, x, y)
    e = evidence_of(run)
    assert not e.propagates_back and e.curve is not None
    assert "curved" not in rules_of(run)


def test_the_way_back_is_measured_beyond_noise():
    rng = np.random.default_rng(0)
    up = np.linspace(4.0, 12.0, 1000) + 0.05 * rng.standard_normal(1000)
    assert both_ways(up, 0.05) < 0.02
    assert both_ways(np.concatenate((up, up[::-1])), 0.05) == pytest.approx(1.0, abs=0.05)
    assert both_ways(np.concatenate((up, up[:500][::-1])), 0.05) == pytest.approx(1.0, abs=0.05)
    assert both_ways(np.full(50, 3.0), 0.05) == 0.0


def test_an_output_that_folds_in_some_runs_flips_no_sign_in_the_others():
    t = np.arange(0.0, 40.0, 1.0 / RATE)
    wide = 16.0 - 14.0 * np.cos(2.0 * np.pi * t / 10.0)
    small = 7.0 - 3.0 * np.cos(2.0 * np.pi * t / 10.0)
    lines = (np.exp(-0.2), 0.0, np.exp(0.2), 0.0)
    runs = [recorded(t, x, play(x, lines) - 10.0, name, seed=k) for k, (name, x) in enumerate((("wide", wide), ("small", small)))]
    folded = [replace(r, tension_out_n=np.abs(r.tension_out_n)) for r in runs]
    said = gate.remarks(folded)
    assert {r.rule for r in said} == {"folded"} and set(said[0].run_ids) == {"wide", "small"}
    # alone it is what it looks like
    assert "sign" in rules_of(folded[1])


def test_an_output_that_stops_at_its_largest_again_and_again_is_at_its_limit_and_not_stuck():
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 60.0, 0.02)
    waves = sum(np.sin(2.0 * np.pi * f * t + p) for f, p in zip(rng.uniform(0.04, 0.15, 6), rng.uniform(0.0, 6.28, 6), strict=True))
    x = 3.0 + 31.0 * (waves - waves.min()) / np.ptp(waves)
    run = recorded(t, x, play(x, (0.8, 0.0, 1.25, 0.0)))
    cut = replace(run, tension_out_n=np.minimum(run.tension_out_n, 12.0))
    (said,) = gate.remarks([cut])
    assert said.rule == "limit" and said.number == pytest.approx(12.0)


@pytest.mark.parametrize(("back", "odd"), [(0.001, False), (0.9, True)])
def test_two_slopes_of_one_line_are_no_gain(back, odd):
    """Friction of a run that is only pulled: its output is as far below its input as with a gain of 1/1.3."""
    found = evidence_of(rig()[0])
    one = replace(found.slopes, gamma_p=0.7, gamma_r=0.82)
    pulled = replace(found, slopes=one, both_ways=(back, back))
    gain, friction = odd_run._values(pulled)[2:4]
    assert bool(np.isfinite(gain) and np.isfinite(friction)) is odd


@pytest.mark.parametrize("rate", [RATE, 3.0 * RATE])
def test_a_pull_that_is_faster_than_others_is_no_clock_and_lacks_no_rows(rate):
    """The same rows as those of a third of the others' time, or all of them at three times the rate: any pull is like any other."""
    runs = []
    for k, seconds in enumerate((24.0, 23.5, 24.3, 8.0)):
        t, x = pull(seconds=seconds)
        if k == 3 and rate > RATE:
            t = np.arange(round(seconds * rate)) / rate
            x = 4.0 + 7.5 * (1.0 - np.cos(0.5 * np.pi * t / seconds))
        runs.append(recorded(t, x, x * np.exp(-0.2 - 0.1 * k), f"r{k}", config_id=f"c{k}", seed=k))
    said = [r.sentence for r in gate.remarks(runs) if r.rule == "rate"]
    # another rate is worth a remark, whatever was played
    assert len(said) == (rate > RATE) and not [s for s in said if "clock" in s or "row" in s]
