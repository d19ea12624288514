"""When a next movement is proposed, and which."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from sstl_cli.diagnosis import following
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.following import Experiment, proposed, rivals
from sstl_cli.diagnosis.verdict import Verdict

SAID = Verdict("ambiguous", ("b",), 0.5, (("b",), ("c",)), {("a",): 0.5, ("b",): 0.3, ("c",): 0.2}, "")


def model(*ids, foretold=True):
    return SimpleNamespace(ids=ids, fit=SimpleNamespace(hypothesis=SimpleNamespace(foretold=foretold)))


MODELS = [model("a"), model("c"), model("b"), model("a", "b"), model("runs", foretold=False)]


def asked(monkeypatch, said=SAID, d2=30.0, here=5.0, models=MODELS, nameless=None, propagates=1.0, passed=False):
    between = []

    def best(found, first, second, limits):
        between.append((first.ids, second.ids, limits))
        return None if d2 is None else Experiment((first.ids[0], second.ids[0]), (), d2, here)

    monkeypatch.setattr(following, "best_experiment", best)
    monkeypatch.setattr(following, "without_name", lambda found, rows: nameless)
    found, rows = SimpleNamespace(ranked=lambda: models), SimpleNamespace(log=SimpleNamespace(propagates=propagates))
    return proposed(found, rows, said, "limits", lambda stage: passed and stage == "next experiment"), between


def test_rivals_are_those_of_the_group_the_most_probable_first_then_the_others():
    assert [w.ids for w in rivals(MODELS, SAID)] == [("b",), ("c",), ("a",)]


def test_the_two_leading_rivals_are_to_be_parted(monkeypatch):
    found, between = asked(monkeypatch)
    assert between == [(("b",), ("c",), "limits")] and found.d2 == 30.0


@pytest.mark.parametrize(
    "settled",
    [
        {"said": replace(SAID, status="identified")}, {"said": replace(SAID, status="none")}, {"nameless": "loop"}, {"propagates": 0.0}, {"passed": True},
        {"models": MODELS[:1]},
    ],
)  # fmt: skip
def test_what_is_settled_or_has_no_time_asks_for_nothing(monkeypatch, settled):
    assert asked(monkeypatch, **settled) == (None, [])
    # an unknown cause has rivals as well
    assert asked(monkeypatch, said=replace(SAID, status="unknown"))[0] is not None


@pytest.mark.parametrize(
    ("d2", "here", "told"), [(30.0, 29.9, True), (30.0, 30.0, False), (5.0, 23.9, True), (5.0, 24.0, False), (None, 0.0, False)]
)
def test_a_movement_has_to_tell_more_than_was_told_here_or_decide(monkeypatch, d2, here, told):
    assert (asked(monkeypatch, d2=d2, here=here)[0] is not None) is told and DECIDABLE == 24.0
