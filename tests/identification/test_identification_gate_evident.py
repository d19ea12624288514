"""Slips that another part of the log holds the evidence of: its bookkeeping, its other runs, or the rest of the run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import BENDS, bend, changed, lines, rig
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def led(leads=(20.0, 50.0, 80.0)):
    """Return the sound log with the setting of the lead screw of each bend."""
    return [
        replace(r, lead_mm=lead) for r in rig() for name, lead in zip(("b020", "b050", "b080"), leads, strict=True) if r.config_id == name
    ]


@pytest.mark.parametrize(
    ("run", "lead", "words"),
    [
        ("act-b020", 200.0, "decimal point"),
        ("act-b080", 800.0, "decimal point"),
        ("sstl-b080", 80.0 / 25.4, "in in, not mm"),
        ("act-b050", 5.0, "in cm, not mm"),
        ("act-b050", 80.0, "lead of configuration b080"),
    ],
)
def test_one_configuration_is_one_setting_of_the_lead_screw(run, lead, words):
    assert gate.remarks(led()) == ()
    (said,) = gate.remarks([replace(r, lead_mm=lead) if r.run_id == run else r for r in led()])
    assert said.rule == "lead_mm" and said.run_ids == (run,) and words in said.sentence and said.number == pytest.approx(lead)


def test_readings_of_a_lead_may_differ_as_readings_do():
    runs = led((20.0, 20.6, 80.0))
    assert gate.remarks([replace(r, lead_mm=r.lead_mm + 0.1 * (-1.0) ** i) for i, r in enumerate(runs)]) == ()
    # one bend, one label: the lead is the setting
    (said,) = [r for r in gate.remarks([replace(r, config_id="tube") for r in led() if r.system == "act"]) if r.rule == "lead_mm"]
    assert "3 settings" in said.sentence
    # of two that are as likely both are named
    (said,) = gate.remarks([replace(r, lead_mm=33.0) if r.run_id == "act-b050" else r for r in led()])
    assert set(said.run_ids) == {"act-b050", "sstl-b050"} and "2 settings" in said.sentence


def test_an_output_in_kn_is_told_whatever_its_zero():
    def of(i, wrap):
        t = np.arange(4000) / 100.0
        x = 13.0 - 12.0 * np.cos(2.0 * np.pi * 0.1 * t)
        noise = 0.02 * np.random.default_rng(i).standard_normal((2, len(t)))
        return Run(f"r{i}", "act", t, x + noise[0], 1e-3 * (play(x, lines(wrap)) - 0.3 + noise[1]), config_id=f"b{i}")

    log = [gate.evidence_of(of(i, wrap)) for i, wrap in enumerate((0.3, 0.55, 0.8))]
    (said,) = gate.judge(log)
    assert said.rule == "gain" and said.mend == 'tension_out_n = { column = ..., unit = "kN" }'
    # a bend that tells its gain badly has no slip of its own
    c = log[2].causes
    (said,) = gate.judge([*log[:2], replace(log[2], causes=replace(c, scale=replace(c.scale, size=c.scale.size - 0.8)))])
    assert len(said.run_ids) == 3 and 'unit = "kN"' in said.mend


def test_a_gain_of_one_run_is_told_beside_others_that_fit_friction_badly():
    # a pulley that takes its part of one direction
    runs = changed(lambda r: replace(r, tension_out_n=0.84 * r.tension_out_n), "sstl")
    assert gate.remarks(runs) == ()
    (said,) = gate.remarks([replace(r, tension_out_n=2.0 * r.tension_out_n) if r.run_id == "act-b050" else r for r in runs])
    assert said.rule == "gain" and said.run_ids == ("act-b050",) and "amplified 2" in said.sentence


def lag(r: Run, seconds: float) -> Run:
    """Return a run whose input follows its reference behind a drive of that lag."""
    state, x = r.tension_in_n[0], []
    for v in r.tension_in_n.tolist():
        state += (1.0 - np.exp(-r.dt_s / seconds)) * (v - state)
        x.append(state)
    noise = 0.02 * np.random.default_rng([*r.run_id.encode()]).standard_normal((2, len(r)))
    wrap = {"b020": 0.2, "b050": 0.4, "b080": 0.6}[str(r.config_id)] * (2.0 if r.system == "sstl" else 1.0)
    return replace(
        r, tension_ref_n=r.tension_in_n, tension_in_n=np.array(x) + noise[0], tension_out_n=play(x, lines(wrap)) + noise[1], trajectory=None
    )


def halved(r: Run) -> Run:
    return replace(r, time_s=2.0 * r.time_s)


@pytest.mark.slow
def test_a_clock_is_told_from_a_slow_movement_by_the_lag_of_the_drive():
    clean = [bend(r.config_id, 0.3, r.system, 0, sd=0.0) for r in rig()]
    sound = [lag(r, 0.1) for r in clean]
    off = [halved(r) if r.run_id == "act-b050" else r for r in sound]
    slow = [lag(halved(c), 0.1) if c.run_id == "act-b050" else r for c, r in zip(clean, sound, strict=True)]
    for runs, clock in ((off, True), (slow, False)):
        (said,) = gate.remarks(runs)
        assert said.rule == "rate" and said.run_ids == ("act-b050",)
        assert ("clock is probably off" in said.sentence) == clock and "unless" not in said.sentence
    # where no reference tells, either is possible
    (said,) = gate.remarks([replace(r, tension_ref_n=None) for r in off])
    assert "clock is probably off by this factor, unless" in said.sentence
    # another movement at another rate is no clock
    other = bend("b050", 0.4, "act", 3, movement=9)
    (said,) = gate.remarks([replace(halved(other), trajectory=None) if r.run_id == "act-b050" else r for r in sound])
    assert "no fault by itself" in said.sentence


@pytest.mark.parametrize(("a", "b"), asked([(0.45, 1.0), (0.3, 0.5), (0.0, 0.4)], (0.3, 0.5), several=True))
def test_a_sensor_that_is_lost_for_a_part_of_a_run_is_told_with_its_time(a, b):
    def lost(r):
        at = np.arange(len(r)) / len(r)
        noise = 0.02 * np.random.default_rng(8).standard_normal(len(r))
        return replace(r, tension_out_n=np.where((at >= a) & (at < b), noise - 0.03, r.tension_out_n))

    said = gate.remarks(changed(lost, "act-b050"))[0]
    assert said.rule == "dead" and said.failed and said.run_ids == ("act-b050",) and said.number == pytest.approx(30.0 * (b - a), rel=0.05)


def test_what_is_missing_is_told_where_a_quiet_input_rests_before():
    t = np.arange(3000) / 100.0
    x = np.round(np.interp(t, [0, 3, 8, 11, 16, 19, 24, 27, 30], [2, 2, 22, 22, 2, 2, 22, 22, 8]) / 0.05) * 0.05
    y = play(x, lines(0.3)) + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    # from a rest at the top to the way down
    keep = (t < 9.0) | (t >= 14.5)
    run = Run("r", "act", t[: np.count_nonzero(keep)], x[keep], y[keep])
    assert [r.rule for r in gate.remarks([run])] == ["joined"]
    assert "joined" not in [r.rule for r in gate.remarks([Run("r", "act", t, x, y)])]


def test_an_output_cut_off_once_at_no_tension_is_not_stuck():
    t = np.arange(4000) / 100.0
    x = np.interp(t, [0, 6, 12, 17, 22, 27, 33, 40], [20, 26, 12, 22, 4, 24, 14, 25])
    y = play(x, lines(0.4)) - 7.5
    noise = 0.01 * np.random.default_rng(2).standard_normal((2, len(t)))
    said = gate.remarks([Run("r", "act", t, x + noise[0], np.maximum(y + noise[1], 0.0))])
    assert "stuck" not in [r.rule for r in said] and "does not fall below" in " ".join(r.sentence for r in said)


def sheathed(more=0.25):
    """Return the sound log once more, on another sheath: that adds a bend of its own to each pass."""
    return [
        replace(bend(n, v + more, s, 300 + 20 * i + len(s)), run_id=f"{s}-{n}-2")
        for i, (n, v) in enumerate(BENDS.items())
        for s in ("act", "sstl")
    ]


def test_a_later_half_that_rubs_more_in_every_bend_is_another_rig_whatever_its_law():
    later = sheathed()
    (said,) = gate.remarks([*rig(), *later])
    assert said.rule == "two_rigs" and set(said.run_ids) == {r.run_id for r in later} and "1.42 to 2.2" in said.sentence
    # in any order they are no two kinds, unless their recorders are
    turned = [r for i, pair in enumerate(zip(rig(), later, strict=True)) for r in (pair if i % 2 else pair[::-1])]
    assert "two_rigs" not in [r.rule for r in gate.remarks(turned)]
    names = {r.run_id for r in later}
    coarse = [replace(r, tension_in_n=np.round(r.tension_in_n / 0.01) * 0.01) if r.run_id in names else r for r in turned]
    assert [r.rule for r in gate.remarks(coarse)] == ["two_rigs"]


def test_an_output_in_random_order_is_noise_that_no_sensor_of_the_log_has():
    runs = rig()
    mixed = replace(runs[0], tension_out_n=np.random.default_rng(3).permutation(runs[0].tension_out_n))
    for log in ([mixed, *runs[1:]], [mixed]):
        (said,) = (r for r in gate.remarks(log) if r.rule == "dead")
        assert said.failed and said.run_ids == (runs[0].run_id,) and "another order" in said.sentence
    assert not [r for r in gate.remarks(runs) if r.rule == "dead"]
