"""Learned weights as their document has them, what is asked of them, and what a question leaves in."""

from __future__ import annotations

import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.question import Question, candidates
from sstl_cli.diagnosis.weights import Weights, from_document, learned
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Scenario

OWN = {
    "candidate": {"rank": 1.0}, "none": {"one": 2.0}, "unknown": {"one": 3.0}, "effect": {"slack": 4.0}, "commit": 0.8, "member": {"lag": 0.1}, "quiet": 0.3,
    "cover": 0.2, "shows_d2": 24.0, "reliability": {"none": [["0.5", "0.25"], [1, 0.75]]}, "provenance": {"seeds": [[1, 5], ["7", 9]]},
}  # fmt: skip


def test_every_weight_stands_where_its_document_has_it():
    w = from_document(OWN)
    assert (w.candidate, w.none, w.unknown, w.effect) == ({"rank": 1.0}, {"one": 2.0}, {"one": 3.0}, {"slack": 4.0})
    assert (w.commit, w.member, w.quiet, w.cover, w.shows_d2) == (0.8, {"lag": 0.1}, 0.3, 0.2, 24.0)
    assert w.reliability == {"none": ((0.5, 0.25), (1.0, 0.75))} and w.temper == 1.0 and w.known is None and w.without == {}
    assert w.seeds == [(1, 5), (7, 9)] and from_document({**OWN, "provenance": {}}).seeds == []


def test_what_was_learned_beside_an_accepted_model_and_without_a_simulator_comes_with_it():
    known = {**OWN, "temper": 0.5, "provenance": {"seeds": [[20, 30]]}}
    w = from_document({**OWN, "temper": 0.7, "known": known, "without": {"rig": {"candidate": {"rank": 9.0}, "quiet": 0.4}}})
    assert w.temper == 0.7 and w.known == from_document(known) and w.seeds == [(1, 5), (7, 9), (20, 30)]
    left = w.without["rig"]
    assert isinstance(left, Weights) and (left.candidate, left.quiet, left.commit, left.temper) == ({"rank": 9.0}, 0.4, 0.8, 0.7)


def test_a_model_that_was_accepted_makes_it_a_question_of_what_has_changed():
    assert learned(True) == learned().known and learned(True) != learned()
    fresh, kept = Scenario(), Scenario(package_version="1")
    assert Question().weights == Question(sim=fresh).weights == learned() and Question(sim=kept).weights == learned(True)


def test_candidates_are_those_that_were_asked_for_less_those_that_were_not():
    assert candidates(Question()) == list(catalogue()) and candidates(Question(effects=("slack", "viscous"), exclude=("slack",))) == [
        "viscous"
    ]
    assert candidates(Question(exclude=("slack",))) == [i for i in catalogue() if i != "slack"]
    with pytest.raises(SstlError):
        candidates(Question(exclude=("nobody",)))


def test_where_no_simulator_is_given_one_in_proportion_is():
    assert Question(sim=(own := Scenario())).given(10.0) is own
    usual = Question().given(10.0).rig
    assert usual.ea_n == pytest.approx(10.0 * Scenario().rig.ea_n) and usual.load_n_per_mm == pytest.approx(
        10.0 * Scenario().rig.load_n_per_mm
    )
