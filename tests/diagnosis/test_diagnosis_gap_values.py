"""The gap in numbers, candidates side by side and bends that changed, on errors that are known beforehand."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, log
from types import MappingProxyType, SimpleNamespace

import numpy as np
import pytest
from made_fits import THETA, made, named, noise, simulator

from sstl_cli.diagnosis import bends, compared, gap
from sstl_cli.diagnosis.constants import DECIDES_NATS
from sstl_cli.diagnosis.evidence import strengths_charge
from sstl_cli.diagnosis.floor import Floor
from sstl_cli.diagnosis.shrink import Interval

SIM = simulator()
N = 50


def sizes(monkeypatch, base, accepted, floor_n=0.3, known_n=0.4, fault=None, same=False, fine_n=0.0):
    """Return the gap of errors that are alike at every sample, given 3 N beside what is known (1 N)."""
    monkeypatch.setattr(gap, "floor", lambda g, fine: Floor(hypot(floor_n, fine), 0.1, 0.2))
    monkeypatch.setattr(gap, "unrounded_n", lambda g: 0.05)
    monkeypatch.setattr(gap.misfit, "rms_n", lambda problem: known_n)
    monkeypatch.setattr(gap.shrink, "shrinkage", lambda sim, b, a, fine: Interval(float(b[0]), float(a[0]), fine))
    monkeypatch.setattr(gap.shrink, "worse_regions", lambda sim, b, a, code: [f"{b[0]:g} {a[0]:g} {code}"])
    monkeypatch.setattr(gap.recorded, "rms_n", lambda sim, theta, nominal, fault: (2.0, 0.5, 7.0))
    sim = SimpleNamespace(y=np.full(N, 5.0), predict=lambda theta, effects: np.full(N, 3.0))
    search = SimpleNamespace(sim=sim, base=SimpleNamespace(theta=None))
    g = SimpleNamespace(search=search, accepted=search.base if same else object(), fault=fault, nominal=None, problem=None)
    e = gap.Errors(np.full(N, base), np.full(N, accepted), fine_n, np.ones(N), np.ones(N))
    return gap.sizes(g, e, "code")


def test_the_gap_is_what_is_left_above_the_floor_and_what_is_known(monkeypatch):
    found = sizes(monkeypatch, 1.5, 0.75)
    assert (found.given_n, found.retuned_n, found.with_effect_n, found.known_n, found.fall_pct) == (3.0, 1.5, 0.75, 0.4, 50.0)
    # the floor and what is known are half a newton: 0.75 of 1.0 above
    assert found.explained_pct == pytest.approx(75.0) and found.floor.value_n == 0.3
    assert found.interval == Interval(1.5, 0.75, 0.0) and found.worse == ["1.5 0.75 code"]
    # noise above the rate of the analysis is in every error
    fine = sizes(monkeypatch, 1.5, 0.75, fine_n=2.0)
    assert (fine.given_n, fine.retuned_n, fine.with_effect_n) == (pytest.approx(13.0**0.5), 2.5, pytest.approx(hypot(0.75, 2.0)))
    # nothing named: no interval of a fall that nobody claims
    none = sizes(monkeypatch, 1.5, 1.5, same=True)
    assert none.interval is None and none.worse == [] and none.fall_pct == 0.0 and none.explained_pct == 0.0


def test_what_is_explained_stays_within_all_and_its_opposite(monkeypatch):
    assert sizes(monkeypatch, 1.5, 0.0).explained_pct == 100.0 and sizes(monkeypatch, 0.6, 1.5).explained_pct == -100.0
    assert sizes(monkeypatch, 0.6, 1.5).fall_pct == pytest.approx(-150.0) and sizes(monkeypatch, 0.0, 1.5).fall_pct == 0.0
    # a thousandth of the error above the floor is something that can be explained
    for above, told in ((1.1e-3, True), (0.9e-3, False)):
        assert (sizes(monkeypatch, 0.5 / (1.0 - above), 0.5).explained_pct is not None) is told
    assert sizes(monkeypatch, 0.4, 0.3).explained_pct is None


@pytest.mark.parametrize(("fault", "floor_n"), [("quantisation", 0.05), ("saturation", 0.3)])
def test_a_fault_is_told_over_all_readings(monkeypatch, fault, floor_n):
    found = sizes(monkeypatch, 1.5, 0.75, fault=SimpleNamespace(id=fault))
    assert (found.given_n, found.retuned_n, found.with_effect_n, found.fall_pct, found.interval) == (7.0, 2.0, 0.5, 75.0, None)
    assert found.floor.value_n == floor_n and found.explained_pct == pytest.approx(100.0 * 1.5 / (2.0 - hypot(floor_n, 0.4)))


def test_errors_hold_what_the_simulator_is_known_to_leave(monkeypatch):
    monkeypatch.setattr(gap.misfit, "known", lambda problem: np.array([1.0, 2.0]))
    monkeypatch.setattr(gap, "fine_n", lambda g, noise: 0.5)
    held = SimpleNamespace(residual=lambda f: f)
    search = SimpleNamespace(held_out=held, base=np.array([3.0, 0.0]), noise=None, sim=SimpleNamespace(weight=np.array([1.0, 0.0])))
    e = gap.errors(SimpleNamespace(search=search, accepted=np.array([0.0, 1.0]), problem=None))
    assert e.base.tolist() == [4.0, 2.0] and e.accepted.tolist() == [1.0, 3.0] and e.fine_n == 0.5
    assert e.rms(e.base) == pytest.approx(hypot(4.0, 0.5)) and replace(e, weight=np.zeros(2)).rms(e.base) == 0.5


def weighed(*ids, p=0.0, residual=1.0, free=(), evidence=0.0):
    strengths = tuple(x for x in free if not x.parameter.shape)
    f = SimpleNamespace(free=free, values=[x.value for x in free], residual=residual, hypothesis=SimpleNamespace(strengths=strengths))
    return SimpleNamespace(ids=tuple(ids), fit=f, p=p, evidence=evidence)


def listed(monkeypatch, ranked, effects=(), group=(), accepted=None, fixed=(), errors=None, singles=MappingProxyType({})):
    monkeypatch.setattr(compared.shrink, "parameter_intervals", lambda sim, f: [x.interval for x in f.free])
    monkeypatch.setattr(compared.shrink, "identifiability", lambda f, i, x: f.free[i].label)
    monkeypatch.setattr(compared.limit, "distance2", lambda sim, lead, f: 10.0 * lead.residual + f.residual)
    said = SimpleNamespace(probabilities={tuple(sorted(w.ids)): w.p for w in ranked if w.p}, effects=effects, group=group)
    held = SimpleNamespace(residual=lambda f: np.array([f.residual]))
    search = SimpleNamespace(ranked=lambda: ranked, sim=SimpleNamespace(fixed=fixed), held_out=held, singles=singles)
    g = SimpleNamespace(verdict=said, search=search, accepted=accepted, problem=SimpleNamespace(unit_n=10.0))
    e = gap.Errors(np.array([4.0]), np.array([0.5]), 0.0, np.ones(1), np.array([1.0]))
    return {c.model.ids: c for c in compared.compared(g, errors or e)}


def test_single_effects_the_likeliest_the_most_evident_and_what_is_named_are_listed(monkeypatch):
    pairs = [weighed("a", f"p{i}", p=0.01 * (i + 1)) for i in range(14)]
    # a model has its effects in any order, a verdict in that of their names
    pairs[6] = weighed("p6", "a", p=0.07)
    found = listed(monkeypatch, [*pairs, weighed("single")], effects=("a", "p6"), group=(("a", "p7"),))
    # five of the most evident, six of the most probable, and the two that are named
    assert set(found) == {("a", f"p{i}") for i in (0, 1, 2, 3, 4, 7, 8, 9, 10, 11, 12, 13)} | {("p6", "a"), ("single",)}
    # the most evident one leads where none is accepted; the distance of those from it that are probable is worked out
    near = {("a", f"p{i}") for i in (8, 9, 10, 11, 12)}
    assert {k for k, c in found.items() if c.d2 is not None} == near | {("a", "p13")} and found[("a", "p13")].probability == pytest.approx(
        0.14
    )
    lead = pairs[13]
    found = listed(monkeypatch, [*pairs, weighed("single")], accepted=lead.fit)
    assert {k for k, c in found.items() if c.d2 is not None} == near
    assert found[("a", "p12")].d2 == 11.0 and found[("single",)].probability == 0.0
    assert listed(monkeypatch, []) == {}


def free(interval, label, name, value, effect="viscous", shape=False):
    own = SimpleNamespace(name=name, unit="N", neutral=0.5, least=0.0, most=2.0, shape=shape)
    return SimpleNamespace(interval=interval, label=label, parameter=own, effect=SimpleNamespace(id=effect), value=value)


def test_other_hypotheses_of_an_effect_are_told_where_the_data_do_not_put_them_behind(monkeypatch):
    def of(*names, evidence):
        parts = [free(None, "weak", name, 2.0 + len(name)) for name in names]
        return weighed("viscous", free=[*parts, free(None, "weak", "shape", 9.0, shape=True)], evidence=evidence)

    best = of("in", evidence=100.0)
    others = (best, of("out", evidence=97.0), of("far", evidence=95.0), of("in", "out", evidence=99.0), of("in", evidence=99.5))
    found = listed(monkeypatch, [best, weighed("viscous", "slack")], singles={"viscous": others})
    # in the units of the recording; more strengths than it needs are no other answer
    assert found[("viscous",)].alternatives == ({"out": 50.0},)
    assert found[("viscous", "slack")].alternatives == ()


def test_the_numbers_of_a_candidate(monkeypatch):
    parts = (
        free(Interval(1.0, -1.0, 3.0), "weak", "a", 0.75), free(None, "not_identifiable", "b", 0.5, "slack"),
        free(Interval(1.0, 0.5, 1.5), "identifiable", "shape", 9.0, shape=True),
    )  # fmt: skip
    model, lead = weighed("viscous", p=0.2, free=parts, residual=2.0), weighed("slack", p=0.7, residual=3.0)
    found = listed(monkeypatch, [lead, model], accepted=lead.fit, fixed=("viscous",))
    c = found[("viscous",)]
    # 2 N and what is known, 1 N, of 4 N
    assert (c.rmse_n, c.fall_pct, c.probability, c.d2) == (3.0, pytest.approx(25.0), 0.2, 32.0)
    assert c.intervals == ((0.0, 2.0), None, (0.5, 1.5)) and c.labels == ("weak", "not_identifiable", "identifiable") and c.best == "weak"
    assert c.change == {"a": pytest.approx(2.5)} and found[("slack",)].change is None
    # what is accepted has the error that was worked out for it
    assert (found[("slack",)].rmse_n, found[("slack",)].fall_pct, found[("slack",)].best) == (0.5, pytest.approx(87.5), "not_identifiable")
    nothing = gap.Errors(np.array([0.0]), np.array([0.5]), 0.0, np.ones(1), np.array([1.0]))
    assert listed(monkeypatch, [lead, model], errors=nothing)[("viscous",)].fall_pct == 0.0


def since(monkeypatch, nats, errors_n=(1.0, 0.1), free=(), had=(0.5, 0.6), nominal=(0.5, 0.7), members=(), said=("identified", 0.0)):
    status, gain = said
    monkeypatch.setattr(bends, "fit", lambda *args: SimpleNamespace(cost=10.0 + nats))
    monkeypatch.setattr(bends, "_lost", lambda sim, f, theta: nats)
    f = SimpleNamespace(free=free, cost=10.0, discrepancy=0.0, whiten=None, theta=np.array([0.55, 0.65]))
    sim = SimpleNamespace(accepted=None if had is None else np.array(had))
    models = [SimpleNamespace(ids=(name,), fit=SimpleNamespace(theta=np.array(theta))) for name, theta in members]
    g = SimpleNamespace(
        search=SimpleNamespace(sim=sim, ranked=lambda: models, base=SimpleNamespace(cost=10.0 + gain)), accepted=f, nominal=np.array(nominal), problem=SimpleNamespace(configs=("a", "b")),
        verdict=SimpleNamespace(group=(("gain_error",), ("zero_offset",)), status=status),
    )  # fmt: skip
    return bends.since(g, *errors_n)


# what decides once one bend is charged for
ENOUGH = next(x for x in np.arange(3.0, 30.0, 1e-3) if x - strengths_charge(1, 2.0 * x) > log(49.0))


@pytest.mark.parametrize(("more", "changed"), [(0.01, True), (-0.01, False)])
@pytest.mark.parametrize("free", [(), ("viscous",)])
def test_a_bend_has_changed_beyond_49_to_1_each_charged_for(monkeypatch, more, changed, free):
    found = since(monkeypatch, ENOUGH + more, free=free)
    # of a bend that was not seen nothing is said
    assert found.changed is changed and found.before == {"a": 0.5} and found.with_effect == ({"a": 0.55} if free else None)
    assert since(monkeypatch, ENOUGH + more, nominal=(0.5, 0.6)).changed is False
    assert pytest.approx(log(49.0)) == DECIDES_NATS


def test_a_bend_alone_explains_half_of_the_squared_error_and_beside_an_effect_need_not(monkeypatch):
    for retuned, changed in ((1.4, True), (1.43, False)):
        assert since(monkeypatch, 99.0, (2.0, retuned)).changed is changed
    assert since(monkeypatch, 99.0, (1.0, 0.9), free=("viscous",)).changed
    assert not since(monkeypatch, 99.0, nominal=(0.4, 0.5)).changed and since(monkeypatch, 99.0, had=None) is None
    assert not since(monkeypatch, -5.0).changed


def test_a_bend_has_changed_beyond_what_the_model_is_known_to_leave_and_beside_every_cause_alike(monkeypatch):
    # half of the error was there before: laws are off by half of what they explain
    assert not since(monkeypatch, 1e3, (0.7, 0.1, 0.35), free=("viscous",)).changed
    assert since(monkeypatch, 1e3, (0.7, 0.1, 0.03), free=("viscous",)).changed
    up, down = ("gain_error", (0.52, 0.4)), ("zero_offset", (0.48, 0.9))
    assert since(monkeypatch, 99.0, free=("viscous",), members=(up,)).changed
    assert not since(monkeypatch, 99.0, free=("viscous",), members=(up, down)).changed
    # what is ruled out is not asked
    assert since(monkeypatch, 99.0, free=("viscous",), members=(up, ("slack", (0.4, 0.4)))).changed
    # a twentieth of what the effect explains may be its law's: of 10 000 nats a bend of 100 is none of its own
    assert since(monkeypatch, 100.0, (1.0, 0.1, 0.05), free=("viscous",), said=("identified", 100.0)).changed
    assert not since(monkeypatch, 100.0, (1.0, 0.1, 0.05), free=("viscous",), said=("identified", 1e4)).changed
    # where what has changed has no name, theta follows that
    assert not since(monkeypatch, 99.0, free=("viscous",), members=(up,), said=("unknown", 0.0)).changed


def test_what_a_fit_loses_at_another_theta_is_that_of_its_curvature():
    f = made(noise(3), named("gain_error", "g_act"), (1.0,))
    off = np.array([0.01, -0.02])
    j = np.zeros((len(SIM.y), 3))
    j[np.arange(len(SIM.y)), SIM.config] = f.jacobian[:, 0]
    j[:, 2] = f.jacobian[:, 1]
    a = f.whiten(j)
    moved = a[:, :2] @ off
    # the gain follows
    left = moved - a[:, 2] * (a[:, 2] @ moved) / (a[:, 2] @ a[:, 2])
    assert bends._lost(SIM, f, THETA + off) == pytest.approx(0.5 * left @ left, rel=1e-5)
