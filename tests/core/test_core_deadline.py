"""A limit on time: what may still begin, and what is said of the rest."""

from __future__ import annotations

from sstl_cli.core.deadline import Deadline


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_without_a_limit_nothing_is_left_out():
    limit = Deadline()
    assert not limit.passed("pairs") and limit.notes == []


def test_what_comes_too_late_is_left_out_and_said():
    clock = Clock()
    limit = Deadline(20.0, clock=clock)
    clock.now = 119.9
    assert not limit.passed("pairs")
    clock.now = 120.0
    assert limit.passed("triples") and limit.passed("odd runs")
    assert limit.notes == ["left out after 20 s: triples, odd runs"]


def test_the_clock_may_have_begun_before():
    assert Deadline(20.0, since=79.0, clock=Clock()).passed("pairs")
    assert not Deadline(20.0, since=81.0, clock=Clock()).passed("pairs")
