"""What goes into a diagnosis and what is kept of it, piece by piece, on stand-ins."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import THETA, made, named, noise, simulator

from sstl_cli.diagnosis import accepted as of
from sstl_cli.diagnosis import gathering, nameless, worth
from sstl_cli.diagnosis.by_run import FRICTION, scatter
from sstl_cli.diagnosis.ending import held_back, parted
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.found import Search, deepest
from sstl_cli.diagnosis.free import LINE, LOOP
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.scale import Scale
from sstl_cli.diagnosis.verdict import Verdict
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Configuration, Scenario

SIM = simulator()
QUIET = Noise({"act": Sensor(0.01, 0.0, 0.1)}, {"act": Sensor(0.02, 0.03, 0.5)}, {"act": 1.0})
FRICTION_LAW = variants("const_friction", ("act",))[0]


def weighed(h, values, evidence=1.0):
    return Weighed(made(0.0, h, values), evidence + 4.0, evidence)


def search(*singles, combined=(), nameless=(), sim=SIM):
    models = {w.ids[0]: (w,) for w in singles}
    return Search(sim, QUIET, QUIET, made(), models, {tuple(sorted(w.ids)): w for w in combined}, tuple(nameless))


def said(*effects, status="identified"):
    return Verdict(status, effects, 0.9, (effects,), {}, "")


def evidence(found, recorder=(), beside=(), scale=None, unit_n=1.0):
    return SimpleNamespace(
        search=found,
        problem=replace(found.sim.problem, unit_n=unit_n),
        recorder=recorder,
        beside=beside,
        scale=scale,
        rows=SimpleNamespace(candidates=()),
        preload_n={},
    )


GAIN, ZERO = weighed(named("gain_error", "g_act"), (1.1,), 9.0), weighed(full("zero_offset", ("act",)), (0.1, 0.2), 7.0)
BOTH = Weighed(made(0.0, GAIN.fit.hypothesis.joined(ZERO.fit.hypothesis), (1.1, 0.1, 0.2)), 20.0, 12.0)


def test_the_best_of_every_effect_of_combinations_and_of_what_has_no_name():
    odd = Weighed(made(0.0, scatter(FRICTION), (0.1,)), 30.0, 20.0)
    found = search(ZERO, GAIN, combined=[BOTH], nameless=[odd])
    assert found.ranked() == [BOTH, GAIN, ZERO] and found.every() == [odd, BOTH, GAIN, ZERO] and found.best(odd.ids) is odd
    assert found.parts(BOTH.ids) == [GAIN, ZERO] and found.parts(GAIN.ids) == []
    assert found.best(("zero_offset",)) is ZERO and found.best(("zero_offset", "gain_error")) is BOTH
    # as evident ones by their names
    alike = replace(ZERO, evidence=9.0)
    assert search(alike, GAIN).ranked() == [GAIN, alike]


def test_the_deepest_base_is_the_cheapest_of_where_it_stands_and_the_bends_of_fits():
    base = made(noise(1))
    off = replace(base, theta=THETA * 1.2)
    assert deepest(SIM, QUIET, replace(base, cost=-1e12), [off]).cost == -1e12
    assert deepest(SIM, QUIET, replace(base, cost=1e12), [off, base]).cost < 1e12 and deepest(SIM, QUIET, base, []) is base


def test_the_fit_of_what_is_named_is_accepted_if_there_is_one():
    found = search(ZERO, GAIN, combined=[BOTH])
    assert of.accepted(evidence(found), said("gain_error")) is GAIN.fit
    assert of.accepted(evidence(found), said("gain_error", "zero_offset")) is BOTH.fit
    # a fault of the recorder has no fit, and its samples are left out of all
    fault = SimpleNamespace(id="saturation", parameters={})
    assert of.accepted(evidence(found, recorder=(fault,)), said("saturation", "zero_offset")) is ZERO.fit
    for effects in (("saturation",), ("viscous",), ("gain_error", "viscous"), ()):
        assert of.accepted(evidence(found, recorder=(fault,)), said(*effects)) is found.base
    assert not of._fitted(found, ("viscous",)) and of._fitted(found, ("gain_error", "zero_offset")) and of._fitted(found, ("zero_offset",))


@pytest.mark.parametrize(("status", "loop", "own"), [("unknown", True, True), ("identified", True, False), ("unknown", False, False)])
def test_friction_of_its_own_for_the_loop_is_kept_where_it_is_the_cause_and_has_no_name(monkeypatch, status, loop, own):
    h = nameless.HYPOTHESIS if loop else GAIN.fit.hypothesis.joined(nameless.HYPOTHESIS)
    odd = SimpleNamespace(fit=SimpleNamespace(hypothesis=h))
    monkeypatch.setattr(of, "without_name", lambda search, rows: odd)
    found = evidence(search(ZERO))
    assert of.kept(found, said(status=status)) is (odd.fit if own else found.search.base)
    monkeypatch.setattr(of, "without_name", lambda search, rows: None)
    assert of.kept(found, said(status=status)) is found.search.base


@pytest.mark.parametrize("unit_n", [1.0, 10.0])
def test_a_model_is_in_the_units_of_the_recording(unit_n):
    base = Scenario()
    scenario = of.model(evidence(search(ZERO, GAIN), unit_n=unit_n), said("zero_offset"), base)
    assert scenario.effects == {"zero_offset": pytest.approx({"z_in_act_n": 0.1 * unit_n, "z_out_act_n": 0.2 * unit_n})}
    assert [(c.id, c.theta) for c in scenario.configurations] == [("a", 0.5), ("b", 0.6)]
    heard = scenario.noise
    assert (heard.white_n, heard.coloured_n, heard.correlation_s) == pytest.approx((0.02 * unit_n, 0.03 * unit_n, 0.5))
    assert scenario.output is None and scenario.generator is None and scenario.package_version


def test_a_line_s_load_and_a_loop_s_friction_are_constants_of_the_rig():
    slip = next(h for h in variants("presliding", ("act",)) if h.free[0].parameter.name == "breakaway_mm")
    values = tuple(0.5 if f.effect is LINE else 0.3 for f in slip.free)
    scenario = of.model(evidence(search(weighed(slip, values)), unit_n=10.0), said("presliding"), Scenario())
    # 0.5 mm/N of the fit are 0.05 mm/N of the recording
    assert scenario.rig.load_n_per_mm == pytest.approx(20.0) and LINE.id not in scenario.effects and "presliding" in scenario.effects
    assert SIM.loop_friction({LOOP.id: {"d": 0.25}}) == pytest.approx(1.25 * SIM.mechanics.loop_friction)


def test_faults_and_what_lies_beside_are_kept_where_they_are_named():
    fault = SimpleNamespace(id="saturation", parameters={"t_max_in_n": 3.0, "t_max_out_n": 0.0})
    beside = SimpleNamespace(effect="tension_loop_lag", values={"tau_s": 0.2, "inverse_slew_s_per_n": 0.02})
    found = evidence(search(ZERO), recorder=(fault,), beside=(beside,), unit_n=10.0)
    one, other = of.model(found, said("saturation"), Scenario()).effects, of.model(found, said("tension_loop_lag"), Scenario()).effects
    assert (
        set(one) == {"saturation"}
        and one["saturation"]["t_max_in_n"] == 30.0
        and one["saturation"]["t_max_out_n"] == get("saturation").parameter("t_max_out_n").neutral
    )
    assert other == {"tension_loop_lag": pytest.approx({"tau_s": 0.2, "inverse_slew_s_per_n": 0.002})}
    assert of.model(found, said("zero_offset"), Scenario()).effects.keys() == {"zero_offset"}


def test_an_output_that_is_no_force_keeps_its_scale():
    scale = Scale("V", {"act": 0.5}, {"act": 1.5})
    kept = of.model(evidence(search(ZERO), scale=scale), said("zero_offset"), Scenario()).output
    assert (kept.unit, kept.per_n, kept.origin) == ("V", {"act": 0.5}, {"act": 1.5})


def test_records_are_taken_again_on_the_same_scale_alone():
    scale = Scale("V", {"act": 0.5}, {"act": 1.5})
    before = SimpleNamespace(scale=scale, prepared=replace(SIM.problem, unit_n=10.0))
    assert set(gathering._ready(before, scale, 10.0)) == {f"run{i}" for i in range(4)}
    assert gathering._ready(before, scale, 1.0) == gathering._ready(before, None, 10.0) == gathering._ready(None, None, 1.0) == {}


def test_an_effect_between_tendons_is_asked_for_where_the_others_were_recorded():
    assert gathering._shown(SIM.problem) == ("out",)
    beside = [replace(r, raw=replace(r.raw, extra={"neighbour_n": np.zeros(len(r.raw))})) for r in SIM.problem.records]
    assert gathering._shown(replace(SIM.problem, records=tuple(beside))) == ("out", "neighbour")
    # of every run of the actuation tendon, of which there are some
    assert gathering._shown(replace(SIM.problem, records=(*beside[:3], SIM.problem.records[3]))) == ("out",)
    assert gathering._shown(replace(SIM.problem, records=tuple(replace(r, system="sstl") for r in beside))) == ("out",)
    ids = ["zero_offset", "tension_loop_lag", "presliding"]
    assert gathering._fitted(ids, SIM.problem) == ["zero_offset", "presliding"]
    driven = replace(SIM.problem, records=tuple(replace(r, slip=np.ones(len(r.u))) for r in SIM.problem.records))
    assert gathering._fitted(ids, driven) == ["zero_offset"]


def test_an_effect_of_a_system_that_was_not_recorded_is_no_candidate():
    """A pulley of the loop stood in sets of what had not been ruled out where the tendon alone was recorded."""
    ids = ["zero_offset", "pulley_friction"]
    assert SIM.problem.systems == ("act",) and gathering._fitted(ids, SIM.problem) == ["zero_offset"]
    loop = replace(SIM.problem.records[0], system="sstl")
    for records in ((loop,), (*SIM.problem.records, loop)):
        assert gathering._fitted(ids, replace(SIM.problem, records=records)) == ids


def test_a_simulator_begins_at_what_it_says_of_bends_and_knows_which_it_has_seen(monkeypatch):
    monkeypatch.setattr(gathering, "likelier", lambda sim, nominal: (sim, nominal + 0.1))
    monkeypatch.setattr(gathering.variation, "applied", lambda sim, theta, wander, unit_n: sim)
    nominal = np.array([0.4, 0.7])
    sim, theta = gathering._begun(SIM.problem, Scenario(), nominal, {"act": 2.0})
    assert sim.accepted is None and sim.zeros_n == {"act": 2.0} and theta == pytest.approx([0.5, 0.8])
    seen = Scenario(configurations=(Configuration(id="b", theta=0.7),)).model_copy(update={"misfits": (object(),)})
    sim, theta = gathering._begun(SIM.problem, seen, nominal, {})
    # of the bend that it has not seen it says nothing
    assert sim.accepted == pytest.approx([0.5, 0.7]) and theta == pytest.approx([0.5, 0.8])


def test_rows_beside_are_of_what_the_output_was_not_fitted_with():
    recorder = [SimpleNamespace(id=i, row=lambda i=i: i) for i in ("saturation", "zero_offset")]
    gaps = [SimpleNamespace(effect=e, row=lambda e=e: e) for e in ("gain_error", "load_spring")]
    assert gathering.beside(search(ZERO, GAIN), recorder, gaps) == ["saturation", "load_spring"]


def test_a_controller_is_asked_of_an_effect_that_it_could_know():
    found = evidence(search(ZERO))
    assert worth.can_be_asked(found, ZERO.fit) and not worth.can_be_asked(evidence(search(ZERO), unit_n=10.0), ZERO.fit)
    assert not worth.can_be_asked(found, found.search.base)
    own = replace(ZERO.fit, hypothesis=ZERO.fit.hypothesis.joined(scatter(FRICTION)))
    assert not worth.can_be_asked(found, own)


def test_it_is_asked_at_the_middle_bend(monkeypatch):
    monkeypatch.setattr(worth, "tracking", lambda model, name, before: (name, before))
    monkeypatch.setattr(worth, "_before", lambda *_: "before")
    found = SimpleNamespace(problem=SimpleNamespace(configs=("a", "b", "c", "d")))
    for theta, name in (([0.9, 0.2, 0.5, 0.1], "c"), ([0.9, 0.2, 0.5], "c"), ([0.3], "a"), ([0.3, 0.1], "a")):
        assert worth.of_the_middle(found, SimpleNamespace(theta=np.array(theta)), None, None) == (name, (name, "before"))


def test_friction_at_the_end_is_parted_where_there_is_more():
    assert parted({"const_friction": {"w_end_n": 0.2}}, {"const_friction": {"w_end_n": 0.2}}) == ({"const_friction": {"w_end_n": 0.2}}, 0.0)
    more = parted({"const_friction": {"w_end_n": 0.5, "w_l_n": 1.0}}, {})
    assert more == ({"const_friction": {"w_end_n": 0.0, "w_l_n": 1.0}}, 0.5)
    assert held_back(np.array([0.0, 2.0, 1.5]), 0.5, np.array([0]), np.array([0.0])).tolist() == [0.0, 1.5, 1.5]
