"""Which runs are left out, in what order, until when, and which of them are told."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis import left_out
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.verdict import Verdict

SAID = Verdict("identified", ("viscous",), 0.9, (("viscous",),), {}, "")
OTHER = Verdict("identified", ("slack",), 0.9, (("slack",),), {}, "")


def differing(monkeypatch, then, suspects=("b", "c"), passed=lambda _: False, confirmed=5):
    """Return what is told where the others alone say ``then`` (by run; None: they cannot be diagnosed), and what was diagnosed."""
    names, asked = ("a", "b", "c"), []
    runs = tuple(SimpleNamespace(run_id=n) for n in names)
    found = SimpleNamespace(problem=SimpleNamespace(records=runs), search="search", rows="rows", beside="gaps", runs=runs)

    def gathered(rest, question, before):
        assert before is found and question.effects == ("viscous",)
        (lacking,) = set(names) - {r.run_id for r in rest}
        asked.append(lacking)
        if then[lacking] is None:
            raise SstlError("no run can be diagnosed", code="E901")
        return SimpleNamespace(rows=then[lacking])

    monkeypatch.setattr(left_out, "CONFIRMED_RUNS", confirmed)
    monkeypatch.setattr(left_out.gathering, "gather", gathered)
    monkeypatch.setattr(left_out.gathering, "beside", lambda search, recorder, gaps: [search, recorder, gaps])
    monkeypatch.setattr(left_out.faults, "beyond", lambda search, given, lacking: lacking)
    monkeypatch.setattr(left_out.odd, "rows_without", lambda search, rows, beside: [search, rows, beside(2)])
    monkeypatch.setattr(left_out.verdict, "verdict", lambda rows, weights, prior: rows)

    def suspected(said, rows, run_ids, without, decide):
        assert (
            said is SAID and run_ids == ["a", "b", "c"] and without == ["search", "rows", ["search", 2, "gaps"]] and decide(OTHER) is OTHER
        )
        return [SimpleNamespace(run_id=i) for i in suspects]

    monkeypatch.setattr(left_out.odd, "suspects", suspected)
    told = left_out.differing(found, SAID, Question(effects=("viscous",)), None, passed)
    return None if told is None else [(x.run_id, x.verdict.effects) for x in told], asked


def test_a_run_is_told_where_the_others_say_something_else(monkeypatch):
    assert differing(monkeypatch, {"b": OTHER, "c": SAID}) == ([("b", ("slack",))], ["b", "c"])
    assert differing(monkeypatch, {"b": SAID, "c": SAID}) == ([], ["b", "c"]) and differing(monkeypatch, {}, ()) == ([], [])
    # where the others cannot be diagnosed the next one is looked at
    assert differing(monkeypatch, {"b": None, "c": OTHER}) == ([("c", ("slack",))], ["b", "c"])


def test_as_many_as_are_worth_their_time_are_left_out(monkeypatch):
    assert left_out.CONFIRMED_RUNS == 1 and left_out.FEWEST_RUNS == 3
    assert differing(monkeypatch, {"b": OTHER}, confirmed=1) == ([("b", ("slack",))], ["b"])


@pytest.mark.parametrize(("allowed", "told", "asked"), [(0, None, []), (1, None, []), (2, [("b", ("slack",))], ["b"])])
def test_where_time_is_over_what_was_found_is_told_or_that_nothing_was_looked_at(monkeypatch, allowed, told, asked):
    left = iter([False] * allowed + [True] * 9)
    found = differing(monkeypatch, {"b": OTHER, "c": OTHER}, passed=lambda stage: stage == "odd runs" and next(left))
    assert found == (told, asked)
