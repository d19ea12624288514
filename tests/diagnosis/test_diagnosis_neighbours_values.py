"""Which runs pull beside a run, and how hard, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.neighbours import NEIGHBOUR, with_neighbours


def run(name, tendon, tension, start=0.0, stop=10.0, n=101, **more):
    t = np.linspace(start, stop, n)
    known = {"system": "act", "config_id": "A", "trajectory": "ramp", "tendon": tendon, **more}
    system = known.pop("system")
    return Run(name, system, t, tension(t) if callable(tension) else np.full(n, tension), np.zeros(n), **known)


OWN = run("own", "a", 1.0)


def beside(*runs):
    return with_neighbours(OWN, [OWN, *runs]).extra.get(NEIGHBOUR)


def test_tensions_are_those_of_the_same_instants_and_add_up():
    found = beside(run("b", "b", lambda t: 2.0 * t, -1.0, 12.0, 27), run("c", "c", 3.0))
    assert found == pytest.approx(2.0 * OWN.time_s + 3.0)
    # of readings that are none the line between the others stands
    spoilt = run("b", "b", lambda t: np.where(np.abs(t - 5.0) < 0.05, np.nan, 2.0 * t))
    assert beside(spoilt) == pytest.approx(2.0 * OWN.time_s)
    assert OWN.extra == {} and with_neighbours(run("own", "a", 1.0, config_id=None), [OWN, run("b", "b", 2.0)]).extra == {}


@pytest.mark.parametrize(("stop", "known"), [(9.51, True), (9.49, False)])
def test_a_neighbour_covers_all_but_a_twentieth_of_the_time(stop, known):
    assert (beside(run("b", "b", 2.0, 0.0, stop)) is not None) is known
    assert (beside(run("b", "b", 2.0, 10.0 - stop, 12.0)) is not None) is known


@pytest.mark.parametrize(
    "other",
    [
        {"config_id": "B"}, {"trajectory": "sine"}, {"n": 1},
    ],
)  # fmt: skip
def test_another_bend_or_movement_and_a_single_reading_say_nothing(other):
    n = other.pop("n", 101)
    assert beside(run("b", "b", 2.0, n=n, **other)) is None


def test_each_tendon_is_known_once():
    assert beside(run("b", "b", 2.0), run("b2", "b", 3.0)) is None
    # runs of the own tendon and of the loop are no neighbours; a tendon without a name is one
    assert beside(run("a2", "a", 2.0)).tolist() == [0.0] * 101
    assert beside(run("b", "b", 2.0, system="sstl")).tolist() == [0.0] * 101
    assert beside(run("none", None, 4.0)).tolist() == [4.0] * 101
    short = run("own", "a", 1.0, n=1)
    assert with_neighbours(short, [short, run("b", "b", 2.0)]) is short
