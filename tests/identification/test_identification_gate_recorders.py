"""What a recorder does to a run: a value that is held, rows of another place, a clock in another unit; and movements that only look so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import bend, lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate import evidence_of
from sstl_cli.identification.gate.rules import joined, lead, passes, position, stuck, time_unit


def rested(first: float, second: float, noise: float, seed: int = 0) -> Run:
    """Return a run whose input goes between two levels over a small backlash in which the output stands."""
    t = np.arange(6000) * 0.02
    x = 14.0 + first * np.sin(0.4 * t) + second * np.sin(1.1 * t)
    y = play(x, lines(0.6))
    sd = noise * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run("held", "act", t, x + sd[0], y + sd[1], config_id="a", trajectory="rand")


def held(run: Run, begin: int, length: int) -> Run:
    x = run.tension_in_n.copy()
    x[begin : begin + length] = x[begin]
    return replace(run, tension_in_n=x)


@pytest.mark.parametrize("begin", [1000, 2500, 4000])
def test_an_input_that_loses_its_noise_is_stuck_whatever_the_output_does(begin):
    run = rested(5.0, 2.0, 0.03)
    assert not list(stuck.look([evidence_of(run)]))
    told = [r for r in stuck.look([evidence_of(held(run, begin, 150))]) if r.rule == "stuck"]
    assert len(told) == 1 and told[0].number == pytest.approx(3.0, abs=0.05)


def test_a_sensor_that_is_silent_at_rest_is_not_stuck():
    run = rested(5.0, 2.0, 0.03)
    # the input rests now and then, and reads the same there: vibration is all its noise
    x = run.tension_in_n.copy()
    for begin in range(500, 5900, 900):
        x[begin : begin + 150] = x[begin]
    evidence = evidence_of(replace(run, tension_in_n=x))
    assert not evidence.sensors[0].restless
    assert not [r for r in stuck.look([evidence]) if "has noise of" in r.sentence]


@pytest.mark.parametrize("step", [0.05, 0.5])
def test_a_value_that_a_converter_or_a_slow_sensor_repeats_is_no_stuck_one(step):
    run = rested(5.0, 2.0, 0.03)
    slow = np.repeat(run.tension_in_n[::10], 10)
    for x in (step * np.round(run.tension_in_n / step), slow, step * np.round(slow / step)):
        assert not list(stuck.look([evidence_of(replace(run, tension_in_n=x))]))


def turned(run: Run, at: int) -> Run:
    """Return a run whose later part was put first, its clock as it was."""
    return replace(run, **{n: np.roll(getattr(run, n), -at) for n in ("tension_in_n", "tension_out_n")})


def jump(run: Run, at: int) -> tuple[float, float]:
    """Return by how much (N) both channels jump where the end of a run meets its beginning."""
    return tuple(abs(float(v[0] - v[-1])) for v in (run.tension_in_n, run.tension_out_n))


def test_pieces_in_another_order_are_told_at_a_high_level_too():
    # the output goes over less than half of its level, as behind a large backlash
    run = rested(6.0, 3.0, 0.02)
    piece = replace(run, **{n: getattr(run, n)[:5000] for n in ("time_s", "tension_in_n", "tension_out_n")})
    evidence = evidence_of(turned(piece, 2000))
    assert evidence.ranges[1].span < 0.5 * evidence.ranges[1].largest
    assert min(jump(piece, 2000)) > 50.0 * 0.02
    told = list(joined.look([evidence]))
    assert told and evidence.seam_at_s == pytest.approx(60.0, abs=0.05)
    assert not list(joined.look([evidence_of(piece)]))


@pytest.mark.parametrize("count", [1, 2, 6])
def test_a_drive_that_steps_at_a_high_level_is_no_seam(count):
    t = np.arange(4000) * 0.02
    level = 20.0 + 4.0 * (np.searchsorted(np.linspace(0.0, 80.0, count + 2)[1:-1], t) % 2)
    noise = 0.02 * np.random.default_rng(count).standard_normal((2, len(t)))
    y = play(level, lines(0.3))
    evidence = evidence_of(Run("step", "act", t, level + noise[0], y + noise[1], config_id="a"))
    assert not evidence.seam_alone
    assert not list(joined.look([evidence]))


def test_seconds_taken_as_ms_are_among_the_units_named():
    run = rested(5.0, 2.0, 0.03)
    assert not list(time_unit.look([evidence_of(run)]))
    (remark,) = time_unit.look([evidence_of(replace(run, time_s=run.time_s / 1000.0))])
    assert remark.mend.startswith('time_s = { column = ..., unit = "s"') and "scale = 1000" in remark.mend and "min" in remark.mend


def test_causes_that_look_alike_are_all_named():
    one = evidence_of(bend("b020", 0.2, "act", 1))
    late, early = lead._clocks([one], 0.8), lead._clocks([one], -0.8)
    assert "filter" in late.sentence and "before the filter" in late.mend
    assert "filter" not in early.sentence
    (single,) = passes._told([replace(one, system="sstl")], "failure", "here")
    assert "before its way back" in single.sentence
    (soft,) = position.look([replace(one, position_span_mm=1e5)])
    assert "counts" in soft.mend and '"um"' in soft.mend


def positioned(seed: int, movement: int, name: str) -> Run:
    """Return a run with the position of its drive: an elastic line with a little backlash."""
    run = bend(name, 0.4, "act", seed, movement=movement)
    mm = (
        0.5 * run.tension_in_n + 0.4 * np.sign(np.gradient(run.tension_in_n)) + 0.02 * np.random.default_rng(seed).standard_normal(len(run))
    )
    return replace(run, position_in_mm=mm)


def test_a_position_that_goes_the_way_of_another_run_is_told():
    log = [positioned(i, movement, f"b{i}") for i, movement in enumerate((7, 8, 9, 10, 7))]
    found = [evidence_of(r) for r in log]
    assert not list(position.look(found))
    foreign = evidence_of(replace(log[1], position_in_mm=log[2].position_in_mm))
    told = list(position.look([found[0], foreign, *found[2:]]))
    assert [r.run_ids for r in told] == [(log[1].run_id,)] and "another run" in told[0].sentence
    # runs of one movement may exchange theirs
    assert not list(position.look([evidence_of(replace(log[0], position_in_mm=log[4].position_in_mm)), *found[1:]]))


def test_marks_between_thousands_read_as_decimal_ones_are_no_kilonewtons():
    """4.974 mN for 4974: the mending line said kN."""

    run = bend("b020", 0.2, "act", 1)
    # as written in whole mN with a mark between thousands
    read = replace(run, tension_in_n=np.round(run.tension_in_n, 3) / 1e3, tension_out_n=np.round(run.tension_out_n, 3) / 1e3)
    [said] = [r for r in gate.remarks([read]) if r.rule == "magnitude"]
    assert "marks between thousands" in said.mend and "kN" not in said.mend + said.sentence
