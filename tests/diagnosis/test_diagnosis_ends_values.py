"""When a loop's own load is asked for, from where it is sought, and what keeps it: on fits that are made up."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import ends
from sstl_cli.diagnosis.constants import ADDS
from sstl_cli.diagnosis.ends import LOAD, OWN

FOUND = SimpleNamespace(sim=SimpleNamespace(problem=SimpleNamespace(systems=("act", "sstl"))), noise="noise")
DRAG = SimpleNamespace(parameter=SimpleNamespace(name="c_l_n_s_per_mm"))


def fitted(free=(DRAG, LOAD), load=0.4):
    return SimpleNamespace(ids=("viscous",), free=free, values=np.array([0.1, load]), whiten=None, theta=None, cost=100.0)


@pytest.fixture
def sought(monkeypatch):
    """Return the loads that fits of the loop's end began with; they cost less the softer it is."""
    begun = []

    def fit(sim, whiten, h, theta, values, rounds):
        begun.append(float(values[-1]))
        return SimpleNamespace(hypothesis=h, values=values, cost=100.0 - 10.0 * values[-1])

    monkeypatch.setattr(ends, "fit", fit)
    monkeypatch.setattr(ends, "settle", lambda sim, noise, f: (f, noise))
    return begun


def test_the_end_begins_as_stiff_as_the_tendons_and_on_both_sides_and_the_best_is_settled(sought):
    best, noise = ends.apart(FOUND, fitted())
    assert sought == pytest.approx([0.4, 0.12, 1.2]) and noise == "noise"
    assert best.values == pytest.approx([0.1, 0.4, 1.2]) and best.hypothesis.free == (DRAG, LOAD, OWN)


def test_it_begins_within_what_it_may_be(sought):
    ends.apart(FOUND, fitted(load=2.0))
    assert max(sought) == OWN.parameter.most


def test_what_adds_too_little_is_not_settled(sought):
    # 10 nats a unit: three times this load are just what a partner has to add
    assert ends.apart(FOUND, fitted(load=0.99 * ADDS / 30.0)) is None
    assert ends.apart(FOUND, fitted(load=1.01 * ADDS / 30.0)) is not None


def test_it_is_asked_only_where_both_systems_tell_a_load(sought):
    alone = SimpleNamespace(sim=SimpleNamespace(problem=SimpleNamespace(systems=("act",))), noise="noise")
    assert ends.apart(alone, fitted()) is None
    assert ends.apart(FOUND, fitted(free=(DRAG, DRAG))) is None
    assert ends.apart(FOUND, fitted(free=(LOAD, OWN))) is None
    assert sought == []
