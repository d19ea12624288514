"""Beside which models something is let differ from run to run, and what a spread gains of runs that tell so much."""

from __future__ import annotations

from math import log, log1p
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import f as f_ratio

from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.by_run import FRICTION, INPUT, OUTPUT, Told


def weighed(*ids, evidence=1.0):
    return SimpleNamespace(ids=ids, evidence=evidence, fit=None)


def searched(singles, runs=((0, "act"), (0, "act"), (0, "act")), combined=(), scatters=False):
    records = tuple(SimpleNamespace(config=c, system=s) for c, s in runs)
    found = SimpleNamespace(
        sim=SimpleNamespace(scatters=scatters, problem=SimpleNamespace(records=records)), base=None,
        singles={w.ids[0]: (w,) for w in singles}, combined={tuple(sorted(w.ids)): w for w in combined},
    )  # fmt: skip
    found.ranked = lambda: sorted([v[0] for v in found.singles.values()] + list(found.combined.values()), key=lambda w: -w.evidence)
    return found


@pytest.fixture
def asked(monkeypatch):
    """What a thing that differs was asked beside; its evidence is that of what it stands beside and 10."""
    beside = []

    def one(found, on, kind, told=True):
        ids = getattr(on, "ids", None) or ()
        beside.append((ids, kind, told))
        return weighed(*ids, by_run.EFFECTS[kind], evidence=on.evidence + (10.0 if kind is not INPUT else 2.0))

    monkeypatch.setattr(by_run, "_weighed", one)
    monkeypatch.setattr(by_run, "replace", lambda w, evidence: weighed(*w.ids, evidence=evidence))
    monkeypatch.setattr(by_run, "Weighed", lambda fit, gain, evidence: SimpleNamespace(ids=(), fit=fit, gain=gain, evidence=evidence))
    return beside


def test_it_is_asked_on_the_base_and_beside_the_leading_effects(asked):
    names = ["gain_error", "viscous", "slack", "crosstalk", "zero_offset"]
    singles = [weighed(n, evidence=9.0 - i) for i, n in enumerate(names)] + [
        weighed("friction_drift", evidence=-1.0),
        weighed("zero_drift", evidence=0.0),
    ]
    found = searched(singles)
    by_run.add(found, 2)
    kinds = [FRICTION, OUTPUT, INPUT]
    # four lead, those without evidence do not
    assert asked == [((), k, True) for k in kinds] + [((n,), k, True) for n in names[:4] for k in kinds]
    assert [w.evidence for w in found.singles["friction_drift"]] == [10.0, -1.0] and [w.evidence for w in found.singles["zero_drift"]] == [
        10.0,
        2.0,
        0.0,
    ]
    # of two zeros beside one effect the likelier is kept, and what was likelier before
    assert {k: w.evidence for k, w in found.combined.items() if "gain_error" in k} == {
        ("friction_drift", "gain_error"): 19.0,
        ("gain_error", "zero_drift"): 19.0,
    }
    before = weighed("gain_error", "zero_drift", evidence=99.0)
    found = searched(singles, combined=[before])
    by_run.add(found, 2)
    assert found.combined[before.ids] is before


def test_effects_of_runs_lead_beside_the_other_one_alone_and_nothing_where_one_effect_stands(asked):
    found = searched([weighed("friction_drift", evidence=0.5), weighed("zero_drift", evidence=-9.0)])
    by_run.add(found, 2)
    # what differs has evidence of its own by then, but did not lead
    assert asked == [
        ((), FRICTION, True),
        ((), OUTPUT, True),
        ((), INPUT, True),
        (("friction_drift",), OUTPUT, True),
        (("friction_drift",), INPUT, True),
    ]
    asked.clear()
    found = searched([weighed("friction_drift", evidence=5.0), weighed("gain_error", evidence=9.0)])
    by_run.add(found, 1)
    assert asked == [((), FRICTION, True)] and not found.combined
    asked.clear()
    # nor beside a model that was accepted, nor of what is no candidate
    by_run.add(searched([weighed("friction_drift")], scatters=True), 2)
    by_run.add(searched([weighed("viscous")]), 2)
    assert asked == []


@pytest.mark.parametrize(
    ("runs", "tried"),
    [(((0, "act"), (1, "act")), True), (((0, "act"), (0, "sstl")), False), (((0, "act"), (1, "act"), (1, "act"), (0, "sstl")), False)],
)
def test_where_bends_were_recorded_once_a_zero_is_as_likely_as_what_stays_and_half_of_what_decides(asked, runs, tried):
    found = searched([weighed("zero_drift", evidence=-9.0), weighed("zero_offset", evidence=7.0)], runs)
    by_run.add(found, 2)
    assert asked == ([((), OUTPUT, False), ((), INPUT, False)] if tried else [])
    most = 7.0 - 0.5 * log(49.0)
    # a zero of the input is less likely than that by itself
    assert [w.evidence for w in found.singles["zero_drift"]] == ([pytest.approx(most), 2.0, -9.0] if tried else [-9.0])
    alone = searched([weighed("zero_drift", evidence=-9.0)], runs)
    by_run.add(alone, 2)
    assert [w.evidence for w in alone.singles["zero_drift"]] == ([pytest.approx(-0.5 * log(49.0))] * 2 + [-9.0] if tried else [-9.0])


TOLD = Told(
    np.array([400.0, 900.0]),
    np.array([100.0, 25.0]),
    np.zeros(2),
    np.array([40.0, -30.0]),
    np.array([10.0, 5.0]),
    np.array([0, 1]),
    np.array([0, 0]),
)


def test_what_a_spread_gains_of_runs_that_tell_nothing_of_theta_beside():
    gain, part, shift = by_run.gain_of(0.1, TOLD)
    # 400 and 900 by a variance of 0.01 are 4 and 9
    assert part == pytest.approx([40.0 * 0.01 / 5.0, -30.0 * 0.01 / 10.0]) and shift == pytest.approx([0.1, 0.2])
    own = 0.5 * (40.0**2 * 0.01 / 5.0 + 30.0**2 * 0.01 / 10.0) - 0.5 * (log1p(4.0) + log1p(9.0))
    assert gain == pytest.approx(own + 0.5 * (100.0 * 0.01 + 25.0 * 0.04)) and by_run.charged(0.1, TOLD) == pytest.approx(
        -0.5 * (log(5.0) + log(10.0))
    )
    # runs that tell of theta by what is their own tell less of it
    both = Told(TOLD.own, TOLD.theta, np.array([100.0, 0.0]), *(getattr(TOLD, k) for k in ("own_score", "theta_score", "place", "system")))
    assert by_run.charged(0.1, both) == pytest.approx(0.5 * log(100.0 / (100.0 - 1e4 * 0.01 / 5.0)) - 0.5 * (log(5.0) + log(10.0)))


@pytest.mark.parametrize(
    ("runs", "within", "between"),
    [
        (((0, "act"), (0, "act"), (0, "sstl"), (0, "sstl")), 2, 1),
        (((0, "act"), (0, "act"), (1, "act")), 1, 0),
        (((0, "act"), (0, "sstl")), 0, 1),
    ],
)
def test_what_systems_have_in_common_beyond_chance_is_taken_off(runs, within, between):
    sim = searched([], runs).sim
    assert by_run.contrasts(sim) == within
    most = f_ratio.ppf(48.0 / 49.0, between, within) if within and between else 0.0
    expected = 50.0 - max(40.0 - 10.0 * most * between / max(within, 1), 0.0)
    assert by_run.by_chance(sim, 50.0, 40.0) == pytest.approx(expected)
    assert by_run.by_chance(sim, 50.0, 0.0) == 50.0
