"""Slips of the gate that the other runs of a log betray, or the energy of a loop, or the curve of an output."""

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import quiet
from soon import asked
from test_identification_gate import leads, loop

from sstl_cli.identification import gate
from sstl_cli.identification.gate.curves import curve_of
from sstl_cli.identification.gate.movement import loop_work

BENDS = {"b1": 0.12, "b2": 0.2, "b3": 0.3, "b4": 0.42}


def log(label=lambda system, bend: bend, kinds=("multisine", "trapezoid"), **more):
    """Return act and sstl runs of four bends, each bend moved in a way of its own."""
    found = []
    for i, (bend, wrap) in enumerate(BENDS.items()):
        for j, system in enumerate(("act", "sstl")):
            run = loop(wrap, system, seed=2 * i + j, kind=kinds[i % 2], config_id=label(system, bend), trajectory=f"{kinds[i % 2]} {i}")
            found.append(replace(run, run_id=f"{system}-{bend}", **more))
    return found


def rules(runs):
    return [(r.rule, set(r.run_ids)) for r in gate.remarks(runs)]


def changed(runs, change, *names):
    return [replace(r, **change(r)) if r.run_id in names else r for r in runs]


def output(change):
    return lambda r: {"tension_out_n": change(r.tension_out_n)}


def test_a_sound_log_of_four_bends_is_passed_over():
    assert rules(log()) == []


def test_configurations_that_went_round_in_one_system_are_told():
    after = dict(zip(BENDS, [*list(BENDS)[1:], "b1"], strict=True))
    said = rules(log(lambda system, bend: after[bend] if system == "sstl" else bend))
    assert said[0] == ("exchanged", {f"sstl-{b}" for b in BENDS})


def test_a_second_rig_without_a_common_movement_is_told_by_its_recorder():
    here = log()
    there = [
        replace(
            loop(2.4 * w, "act", seed=40 + i, rate=50.0, sd=0.05, kind="trapezoid"), run_id=f"other-{b}", config_id=b, trajectory=f"own {i}"
        )
        for i, (b, w) in enumerate(BENDS.items())
    ]
    said = dict(rules(here + there))
    assert said["two_rigs"] == {f"other-{b}" for b in BENDS} and "passes" not in said and "labels" not in said


def test_all_runs_that_are_late_by_as_much_are_named():
    def late(r):
        return {"tension_out_n": np.interp(r.time_s - 0.4, r.time_s, r.tension_out_n)}

    names = ("act-b1", "sstl-b3", "act-b4")
    assert dict(rules(changed(log(), late, *names)))["lead"] == set(names)


@pytest.mark.parametrize("by", [2.0, 5.0])
def test_one_offset_on_both_channels_of_a_run_is_told(by):
    runs = changed(log(), lambda r: {"tension_in_n": r.tension_in_n + by, "tension_out_n": r.tension_out_n + by}, "sstl-b3")
    (said,) = [r for r in gate.remarks(runs) if r.rule == "zero"]
    assert said.run_ids == ("sstl-b3",) and said.number == pytest.approx(by, abs=0.3)


def test_a_smoothed_input_stands_alone_among_the_runs_of_both_systems():
    few = [r for r in log() if r.run_id not in ("act-b2", "sstl-b2")]
    runs = changed(few, lambda r: {"tension_in_n": np.convolve(np.pad(r.tension_in_n, 15, "edge"), np.ones(31) / 31.0, "valid")}, "act-b3")
    assert ("odd_run", {"act-b3"}) in rules(runs) or ("noiseless", {"act-b3"}) in rules(runs)


def test_decimals_cut_off_in_one_run_are_told_and_a_coarse_converter_of_all_is_not():
    assert ("odd_run", {"sstl-b2"}) in rules(changed(log(), output(np.round), "sstl-b2"))
    every = [replace(r, tension_out_n=np.round(r.tension_out_n)) for r in log()]
    assert "odd_run" not in dict(rules(every))


def test_several_runs_of_both_systems_with_one_gain_are_told():
    late = ("act-b2", "sstl-b2")
    assert rules(changed(log(), output(lambda v: 1.3 * v), *late)) == [("gain", set(late))]


def test_an_output_that_runs_backwards_gives_energy():
    run = loop(0.3, "sstl", kind="trapezoid")
    forward, backward = (loop_work(run.tension_in_n, y) for y in (run.tension_out_n, run.tension_out_n[::-1]))
    assert forward < -0.05 and backward > 0.05
    assert rules([replace(run, tension_out_n=quiet(run.tension_in_n) - run.tension_out_n)])[0][0] == "energy"


def test_what_a_loop_gives_by_hand():
    # from the first passage of the middle to the last: up along 0, down along 1; the way is 4, and 2 are taken
    x = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0])
    y = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    assert loop_work(x, y) == pytest.approx(-2.0 / 4.0)
    assert loop_work(x, 1.0 - y) == pytest.approx(2.0 / 4.0)
    assert loop_work(np.arange(9.0), y) == 0.0


def test_what_friction_holds_back_is_no_energy_once_it_is_let_go():
    # from a level that an earlier pull has left: up beside it, and down along the line of release
    x = np.array([8.0, 10.0, 13.0, 10.0, 7.0, 8.0, 10.0, 12.0])
    y = play(x, (np.exp(-0.5), 0.0, np.exp(0.5), 0.0))
    y[:3] = 14.0
    y[3:] = np.minimum.accumulate(np.minimum(14.0, np.exp(0.5) * x[3:]))
    assert np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)) > 0.0
    assert loop_work(x, y) <= 0.0


def test_a_part_of_the_input_in_the_output_of_some_runs_shows_in_their_noise():
    names = ("act-b2", "sstl-b2")
    mixed = changed(log(), lambda r: {"tension_out_n": r.tension_out_n + 0.4 * r.tension_in_n}, *names)
    assert ("crosstalk", set(names)) in rules(mixed)


@pytest.mark.slow
@pytest.mark.parametrize("low", [0.0, 1.0])
def test_an_output_scaled_to_its_own_range_is_told(low):
    runs = [
        replace(
            r,
            tension_out_n=(r.tension_out_n - (1 - low) * r.tension_out_n.min())
            / (r.tension_out_n.max() - (1 - low) * r.tension_out_n.min()),
        )
        for r in log()
    ]
    assert rules(runs)[0] == ("normalised", {r.run_id for r in runs})


CURVES = {
    "root": np.sqrt,
    "decibels": lambda v: 20.0 * np.log10(v),
    "square": lambda v: v**2 / 30.0,
    "an amplifier that gives way": lambda v: 24.0 * np.tanh(v / 24.0),
}


@pytest.mark.parametrize("name", asked(CURVES, "root", "square"))
def test_an_output_behind_a_curve_is_told(name):
    said = [r for r in gate.remarks(changed(log(), output(CURVES[name]), "act-b2")) if r.rule == "curved"]
    assert said and said[0].run_ids == ("act-b2",) and (said[0].number > 1.0) == (name == "square")


@pytest.mark.parametrize("share", [0.02, -0.05])
def test_a_sensor_that_bends_as_sensors_do_is_no_other_quantity(share):
    runs = changed(log(), output(lambda v: v * (1.0 + share * (1.0 - v / v.max()))), *[f"act-{b}" for b in BENDS])
    assert "curved" not in dict(rules(runs))


def test_the_curve_of_a_bare_play_is_found_with_its_slopes():
    _, x = multisine(3, seconds=40.0, rate=50.0)
    y = np.sqrt(play(x, (np.exp(-0.3), 0.0, np.exp(0.3), 0.0)))
    rng = np.random.default_rng(1)
    e = gate.evidence_of(replace(loop(0.3, rate=50.0), tension_in_n=x + 1e-3 * rng.standard_normal(len(x)), tension_out_n=y))
    found = curve_of(x, y, 40.0, e.causes, e.play)
    # the slope of a root falls as one over the root
    assert found is not None and found.share < 0.4 and 0.3 < found.ratio < 0.8


def test_the_one_lead_that_is_wrong_is_named():
    runs = leads([0.44, 0.46, 0.48, 0.50, 0.52, 0.58])
    wrong = [replace(r, lead_mm=5.0) if r is runs[-1] else r for r in runs]
    (said,) = gate.remarks(wrong)
    assert (said.rule, said.run_ids) == ("lead_order", (runs[-1].run_id,)) and "5 mm" in said.sentence


def test_an_output_that_wanders_within_the_backlash_gives_no_energy():
    t, x = multisine(5, seconds=40.0, rate=100.0)
    x = 15.0 + (x - x.mean()) / np.ptp(x)
    rng = np.random.default_rng(3)
    # a sensor's slow noise that happens to go before its input
    y = 12.0 + 0.05 * np.interp(t + 0.8, t, x - 15.0)
    run = replace(
        loop(0.3, "sstl"),
        time_s=t,
        tension_in_n=x + 0.01 * rng.standard_normal(len(t)),
        tension_out_n=y + 0.01 * rng.standard_normal(len(t)),
    )
    assert gate.evidence_of(run).loop_work > 0.02
    assert "energy" not in dict(rules([run]))


def test_a_force_that_drives_the_band_of_a_brake_gives_its_energy():
    # a machine pushes and pulls the drum, by more than one end of the band ever bears
    rng = np.random.default_rng(4)
    t = 0.01 * np.arange(4000)
    force, tension = 10.0 * np.sin(t), 5.0 * np.maximum(np.sin(t - 0.2), 0.0)

    def brake(drive):
        noise = 0.02 * rng.standard_normal((2, len(t)))
        return replace(loop(0.3, "act"), time_s=t, tension_in_n=tension + noise[0], tension_out_n=drive + noise[1])

    assert gate.evidence_of(brake(force)).loop_work > 0.02
    assert "energy" not in dict(rules([brake(force)]))
    # what lost its mean behind a high-pass does not
    assert "energy" in dict(rules([brake(0.4 * force)]))
