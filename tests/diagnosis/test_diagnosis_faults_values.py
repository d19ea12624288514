"""Faults beyond those that a simulator knows: which runs, whose noise, in which unit."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import faults
from sstl_cli.diagnosis.faults import RecorderEffect, beyond, once
from sstl_cli.diagnosis.whitening import Noise, Sensor


def asked(monkeypatch, lacking=None, beside=None, effects=()):
    seen = {}

    def found(records, predictions, noise_n, known):
        seen.update(records=[r.name for r in records], predictions=predictions, noise_n=noise_n, known=known)
        return [SimpleNamespace(id=i) for i in ("saturation", "quantisation")]

    monkeypatch.setattr(faults, "recorder_effects", found)
    noise = Noise({}, {"act": Sensor(0.3, 0.4, 1.0), "sstl": Sensor(0.0, 0.0, 1.0)}, {})
    monkeypatch.setattr(faults, "of_readings", lambda records, own: noise if own == "noise" else None)
    records = (
        SimpleNamespace(name="a", system="act", louder=1.0, slower=1.0), SimpleNamespace(name="b", system="act", louder=2.0, slower=0.5),
        SimpleNamespace(name="c", system="sstl", louder=1.0, slower=1.0),
    )  # fmt: skip
    sim = SimpleNamespace(
        problem=SimpleNamespace(records=records, unit_n=10.0),
        predict_fine=lambda theta, effects: [f"{theta} {effects} {i}" for i in range(3)],
    )
    search = SimpleNamespace(sim=sim, noise="noise", base=SimpleNamespace(theta="base", effects="none"))
    told = beyond(search, SimpleNamespace(faults={"saturation": 500.0}, effects=effects), lacking, beside)
    return [e.id for e in told], seen


def test_readings_are_held_against_the_noise_of_their_run_and_what_is_known_in_its_unit(monkeypatch):
    told, seen = asked(monkeypatch)
    assert told == ["saturation", "quantisation"] and seen["records"] == ["a", "b", "c"]
    assert seen["noise_n"] == pytest.approx([0.5, np.hypot(0.6, 0.2), 1e-9]) and seen["known"] == {"saturation": pytest.approx(5.0)}
    assert seen["predictions"] == ["base none 0", "base none 1", "base none 2"]


def test_a_run_may_be_left_out_a_model_stand_beside_and_a_fault_be_known(monkeypatch):
    told, seen = asked(monkeypatch, 1, SimpleNamespace(theta="own", effects="some"), {"saturation": {}})
    assert (
        told == ["quantisation"]
        and seen["records"] == ["a", "c"]
        and seen["predictions"] == ["own some 0", "own some 2"]
        and len(seen["noise_n"]) == 2
    )
    assert asked(monkeypatch, 0)[1]["records"] == ["b", "c"]


def test_how_much_an_error_falls_without_a_fault():
    # a quarter of the squared error is left: half of the error
    assert RecorderEffect("x", 1.0, {}, 3.0, 1.0, total_n2=4.0).fall_pct == 50.0
    assert (
        RecorderEffect("x", 1.0, {}, 9.0, 1.0, total_n2=4.0).fall_pct == 100.0
        and RecorderEffect("x", 1.0, {}, 0.0, 1.0, total_n2=0.0).fall_pct == 0.0
    )
    assert RecorderEffect("x", 1.0, {}, 8.0, 0.5).nats == 16.0 and RecorderEffect("x", 1.0, {}, 8.0, 0.5).fall_pct == 0.0


@pytest.mark.parametrize(("left", "kept"), [(4.9, True), (5.1, False)])
def test_a_model_of_what_the_recorder_shows_stays_where_it_leads_and_explains_half_of_it(monkeypatch, left, kept):
    monkeypatch.setattr(faults, "replace", lambda found, **new: SimpleNamespace(**new))
    lead, other = SimpleNamespace(ids=("saturation",)), SimpleNamespace(ids=("viscous",))
    fault = RecorderEffect("saturation", 0.5, {}, 10.0, 1.0)
    singles, combined = {"saturation": 1, "viscous": 2}, {("saturation", "viscous"): 3, ("slack", "viscous"): 4}

    def found(first):
        return SimpleNamespace(ranked=lambda: [first], singles=singles, combined=combined)

    def beside(w):
        return [RecorderEffect("saturation", 0.5, {}, left, 1.0)]

    now = once(found(lead), [fault], beside)
    assert (now.singles, now.combined) == ((singles, combined) if kept else ({"viscous": 2}, {("slack", "viscous"): 4}))
    # one that does not lead never does, and without a fault all stay
    assert once(found(other), [fault], beside).singles == {"viscous": 2} and once(found(lead), [], beside).singles == singles
    assert once(found(lead), [fault], lambda w: []).singles == singles
