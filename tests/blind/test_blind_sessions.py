"""Cases in two sessions: what is withheld comes with the second one, the rig's own habit is there on both days."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.blind import cases, sessions
from sstl_cli.blind.learning import right_answer
from sstl_cli.blind.record import DISTURBANCE
from sstl_cli.blind.schedule import Entry, Job
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.verdict import UNKNOWN

JOB = Job(Entry("single", ("zero_offset",), 6.0), 31, "variant", True, accepted=True)


@pytest.fixture(scope="module")
def without_habit():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sessions, "HABITS", (0.0,))
        yield sessions.draw(replace(JOB, seed=33))


def off(run, clean):
    """RMS of what a session reads beside what sensors without noise would (N), both channels."""
    parts = [getattr(run, n) - np.interp(run.time_s, clean.time_s, getattr(clean, n)) for n in ("tension_in_n", "tension_out_n")]
    return float(np.sqrt(np.mean(np.square(parts))))


def test_the_withheld_effect_comes_with_the_second_session(without_habit):
    case = without_habit
    source, effects = cases.rebuild(case.truth)
    was, now = ({r.run_id: r for r in source.clean(e)} for e in ({}, effects))
    moved = [i for i in was if off(now[i], was[i]) > 2.0 * source.noise_n]
    assert moved
    for a, b in zip(case.before, case.after, strict=True):
        if case.truth.halves:
            assert a.time_s[-1] < b.time_s[0]
        else:
            assert not np.array_equal(a.tension_in_n, b.tension_in_n)
        if a.run_id in moved:
            assert off(a, was[a.run_id]) < 2.0 * source.noise_n < off(a, now[a.run_id])
            assert off(b, now[b.run_id]) < 2.0 * source.noise_n < off(b, was[b.run_id])


def test_a_habit_comes_back_and_counts_beside_what_is_told(monkeypatch):
    monkeypatch.setattr(sessions, "HABITS", (4.0,))
    case = sessions.draw(JOB)
    plain = cases.draw(JOB.entry, JOB.seed, JOB.quick, JOB.simulator)
    assert case.truth.habit == 4.0
    assert case.truth.strength == pytest.approx(plain.truth.strength / np.hypot(1.0, 4.0))
    source, _ = cases.rebuild(plain.truth)
    drawn, amplitude = sessions._habit(source, np.random.default_rng(1), 4.0 * source.noise_n)
    assert drawn.carriers and "time_s" not in drawn.carriers
    gap = replace(source, disturbance=drawn).gap({DISTURBANCE: {"amplitude": amplitude}})[0]
    assert gap == pytest.approx(4.0 * source.noise_n, rel=0.3)


def test_two_sessions_are_the_same_whoever_draws_them(without_habit, monkeypatch):
    monkeypatch.setattr(sessions, "HABITS", (0.0,))
    again = sessions.draw(replace(JOB, seed=33))
    for a, b in zip(without_habit.after, again.after, strict=True):
        assert np.array_equal(a.tension_out_n, b.tension_out_n)


@pytest.mark.parametrize("part", [0.3, 4.0])
def test_a_rig_with_a_habit_has_a_cause_with_a_name_where_the_habit_is_small(part, monkeypatch):
    monkeypatch.setattr(sessions, "BESIDE", (part,))
    job = replace(JOB, accepted=False, habits=True)
    case, plain = sessions.with_habit(job), cases.draw(job.entry, job.seed, job.quick, job.simulator)
    assert case.truth.habit == pytest.approx(part * plain.truth.strength)
    named = part < 1.0
    assert right_answer(case.truth) == (("zero_offset",) if named else UNKNOWN)
    assert case.truth.strength == pytest.approx(plain.truth.strength * (1.0 if named else part))
    # the same withheld effect, and the habit beside it
    noise_n = plain.truth.noise_n
    apart = [off(a, b) for a, b in zip(case.runs, plain.runs, strict=True)]
    assert max(apart) > 0.5 * part * plain.truth.strength * noise_n


def test_what_nothing_is_withheld_from_has_no_habit_beside_it():
    with pytest.raises(SstlError, match="nothing that a habit could stand beside"):
        sessions.with_habit(Job(Entry("none"), 31, "variant", True, habits=True))
