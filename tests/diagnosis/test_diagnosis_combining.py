"""Combinations of effects: what promises most, and what stands beside the best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, gained, made, named, noise, simulator, thetas

from sstl_cli.diagnosis import combining as of
from sstl_cli.diagnosis.constants import EDGE, JOINS_NATS, LEADERS
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge, weigh
from sstl_cli.diagnosis.fit import fit, settle
from sstl_cli.diagnosis.found import NOTHING, Search
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.starts import grid
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
ZERO = full("zero_offset", ("act",))
OUT = named("zero_offset", "z_out_act_n")
FRICTION, GAIN = (variants(e, ("act",))[0] for e in ("const_friction", "gain_error"))
LATE, CREEP = (full(e, ("act",)) for e in ("channel_delay", "viscoelastic_creep"))


def searched(base, *singles, combined=(), sim=SIM):
    models = {w.ids[0]: (w,) for w in singles}
    return Search(sim, NOISE, NOISE, base, models, {tuple(sorted(w.ids)): w for w in combined})


def test_normal_equations_beside_a_fit_are_those_of_what_it_leaves():
    f = made(noise(2) + 0.02, GAIN, (1.0,))
    models = [Weighed(made(0.0, h, v), 0.0, 0.0) for h, v in ((ZERO, (0.0, 0.1)), (FRICTION, (0.1,)))]
    gram, score, places = of._projected(SIM, f, [m.fit.jacobian[:, 1:] for m in models])
    assert places == [slice(0, 2), slice(2, 3)]
    known = np.column_stack((thetas(f), f.whiten(f.jacobian[:, 1])))
    columns = f.whiten(np.column_stack([m.fit.jacobian[:, 1:] for m in models]))
    r = f.whiten(f.residual)
    out = columns - known @ np.linalg.lstsq(known, columns, rcond=None)[0]
    assert gram == pytest.approx(out.T @ out, rel=1e-5, abs=1e-6 * np.abs(gram).max()) and score == pytest.approx(
        out.T @ r, rel=1e-5, abs=1e-4 * np.abs(score).max()
    )
    empty = of._projected(SIM, f, [])
    assert empty[0].shape == (0, 0) and len(empty[1]) == 0 and empty[2] == []


def worth(gain, strengths):
    return gain - strengths_charge(strengths, 2.0 * gain)


def test_partners_and_pairs_promise_what_they_gain_to_first_order_less_what_their_strengths_cost():
    base = made(noise(3) + 0.02)
    models = [Weighed(made(0.0, h, v), 0.0, 0.0) for h, v in ((ZERO, (0.0, 0.1)), (FRICTION, (0.1,)), (GAIN, (1.0,)))]
    r, known = base.whiten(base.residual), thetas(base)
    columns = [base.whiten(m.fit.jacobian[:, 1:]) for m in models]
    for (w, promise, step), c in zip(of._partners(SIM, Weighed(base, 0.0, 0.0), models), columns, strict=True):
        # what all of it does beside the leader is a column of its own
        whole = base.whiten(SIM.predict(THETA, w.fit.effects) - base.prediction)
        gain = gained(np.column_stack((c, whole)), known, r)
        assert promise == pytest.approx(worth(gain, c.shape[1]), abs=1e-2 * gain) and len(step) == len(w.fit.free)
    pairs = of._pairs(SIM, base, models)
    assert [(a.ids, b.ids) for (a, b), _, _ in pairs] == [(models[i].ids, models[k].ids) for i, k in ((0, 1), (0, 2), (1, 2))]
    for (_, promise, steps), (i, k) in zip(pairs, ((0, 1), (0, 2), (1, 2)), strict=True):
        gain = gained(np.column_stack((columns[i], columns[k])), known, r)
        assert promise == pytest.approx(worth(gain, columns[i].shape[1] + columns[k].shape[1]), abs=1e-2 * gain)
        assert [len(s) for s in steps] == [columns[i].shape[1], columns[k].shape[1]]

    # two laws of one effect are no pair
    assert of._pairs(SIM, base, [models[0], Weighed(made(0.0, OUT, (0.1,)), 0.0, 0.0)]) == []


def test_a_partner_begins_at_its_step_and_never_at_nothing():
    f = made(0.0, named("stribeck", "mean_ratio", "mean_mm_s"), (1.3, 2.0))
    assert of._begin(f, np.array([0.2, 9.0])) == pytest.approx([1.2, 2.0])
    assert of._begin(f, np.array([1e-9, 0.0])) == pytest.approx([1.0 + EDGE * 0.5, 2.0])
    assert of._begin(f, np.array([-0.2, 0.0]))[0] == 1.0 and of._begin(f, np.array([99.0, 0.0]))[0] == 3.0


def test_pairs_are_led_by_a_few_models_and_triples_by_the_most_evident_pair(monkeypatch):
    ids = ("zero_offset", "gain_error", "const_friction", "viscous", "slack", "asymmetric_friction")
    singles = [
        Weighed(made(0.0, full(i, ("act",)), tuple(f.parameter.neutral for f in full(i, ("act",)).free)), 9.0, 6.0 - 1.2 * k)
        for k, i in enumerate(ids)
    ]
    pairs = [
        Weighed(made(0.0, ZERO.joined(h), (0.0, 0.0, h.free[0].parameter.neutral)), 20.0, e) for h, e in ((GAIN, 7.0), (FRICTION, 8.0))
    ]
    found, led = searched(made(), *singles, combined=pairs), []
    # every law of an effect is a partner, not only the one that explains most alone
    found.singles["viscous"] += (replace(found.singles["viscous"][0], evidence=-5.0),)

    def partners(sim, leader, others, _workers):
        led.append((leader.ids, [w.ids[0] for w in others]))
        return []

    monkeypatch.setattr(of, "_partners", partners)
    monkeypatch.setattr(of, "_pairs", lambda *_: [])
    monkeypatch.setattr(of, "_swap", lambda *_: False)
    assert of.combine(found, 2, 1) == 0
    # the last of six has no evidence, and four lead
    assert [ids for ids, _ in led] == [(i,) for i in ids[:LEADERS]] and led[0][1] == [*ids[1:4], "viscous", *ids[4:]]
    led.clear()
    # of three no two are joined to the base at once, nor where nothing is evident alone
    monkeypatch.setattr(of, "_pairs", lambda *_: [((singles[0], singles[1]), 99.0, (np.zeros(2), np.zeros(1)))])
    assert of.combine(found, 3, 1) == 0
    assert of.combine(searched(made(), *(replace(w, evidence=-1.0) for w in singles)), 2, 1) == 0
    assert led == [(("zero_offset", "const_friction"), ["gain_error", "viscous", "viscous", "slack", "asymmetric_friction"])]


@pytest.mark.parametrize(("gain", "fitted"), [(3.1, 1), (3.0, 0), (2.9, 0)])
def test_a_partner_joins_where_it_adds_more_than_it_costs(monkeypatch, gain, fitted):
    leader, partner = Weighed(made(0.0, GAIN, (1.0,)), 9.0, 6.0), Weighed(made(0.0, FRICTION, (0.1,)), 0.0, -1.0)
    found = searched(made(), leader, partner)
    monkeypatch.setattr(of, "_partners", lambda sim, leader, others, _workers: [(w, gain, np.array([0.1])) for w in others])
    monkeypatch.setattr(of, "_swap", lambda *_: False)
    # two as evident together as the leader alone promise nothing
    monkeypatch.setattr(of, "_pairs", lambda *_: [((leader, partner), 6.0, (np.zeros(1), np.zeros(1)))])
    assert of.combine(found, 2, 1) == fitted and set(found.combined) == ({("const_friction", "gain_error")} if fitted else set())


def truth(*hypotheses):
    """Return a simulator whose records were made by some hypotheses at (hypothesis, values), and its base."""
    sim, whole, values = replace(SIM), hypotheses[0][0], tuple(hypotheses[0][1])
    for h, v in hypotheses[1:]:
        whole, values = whole.joined(h), (*values, *v)
    sim.y = sim.predict(THETA, as_effects(whole.free, np.array(values))) + noise(8)
    return sim, fit(sim, made().whiten, made().hypothesis, THETA, np.zeros(0))


def alone(sim, base, h, start):
    return Weighed(fit(sim, base.whiten, h, base.theta, np.array(start)), 0.0, 0.0)


def test_a_partner_of_a_late_sensor_answers_late():
    sim, base = truth((LATE, (0.5,)), (FRICTION, (0.3,)))
    leader, partner = (alone(sim, base, h, v) for h, v in ((LATE, (0.3,)), (FRICTION, (0.1,))))
    r, known = leader.fit.whiten(leader.fit.residual), np.column_stack((thetas(leader.fit), leader.fit.whiten(leader.fit.jacobian[:, 1])))
    early = gained(leader.fit.whiten(partner.fit.jacobian[:, 1:]), known, r)
    ((_, gain, _),) = of._partners(sim, leader, [partner])
    both = fit(sim, base.whiten, LATE.joined(FRICTION), leader.fit.theta, np.append(leader.fit.values, 0.1))
    assert 1.2 * early < gain and gain > 0.5 * (leader.fit.cost - both.cost)


def test_the_leading_pair_is_looked_beside():
    sim, base = truth((LATE, (0.5,)), (FRICTION, (0.3,)))
    late, friction, zero = (alone(sim, base, h, v) for h, v in ((LATE, (0.3,)), (FRICTION, (0.1,)), (ZERO, (0.1, 0.1))))
    wrong = fit(sim, base.whiten, LATE.joined(ZERO), late.fit.theta, np.append(late.fit.values, (0.0, 0.1)))
    found = searched(base, late, friction, zero, combined=[Weighed(wrong, base.cost - wrong.cost, base.cost - wrong.cost - 20.0)], sim=sim)
    assert found.ranked()[0].ids == ("channel_delay", "zero_offset")
    assert of._swap(found, 1)
    best = found.ranked()[0]
    assert set(best.ids) == {"channel_delay", "const_friction"}
    assert dict(zip((f.parameter.name for f in best.fit.free), best.fit.values, strict=True)) == pytest.approx(
        {"tau_act_s": 0.5, "w_l_n": 0.3}, rel=0.05
    )


def test_a_part_gives_way_to_another_hypothesis_of_its_own():
    bend, length = (next(h for h in variants("viscous", ("act",)) if n in {f.parameter.name for f in h.free}) for n in BEND_LENGTH)
    leader = Weighed(made(0.0, GAIN.joined(bend), (1.0, 0.01, 0.1)), 50.0, 40.0)
    found = searched(made(), Weighed(made(0.0, GAIN, (1.0,)), 0.0, 0.0), combined=[leader])
    found.singles["viscous"] = tuple(Weighed(made(0.0, h, (0.01, 0.1)), 0.0, 0.0) for h in (bend, length))
    # what stands there already is not fitted again, and the other part has no other hypothesis
    assert [w.fit.hypothesis for w in of._others(found, leader, "viscous")] == [length]
    assert of._others(found, leader, "gain_error") == []


def test_any_effect_may_stand_for_a_part_and_shapes_are_sought_of_what_looks_like_it():
    drift = named("zero_drift", "s_out_act_n", "session_s")
    leader = Weighed(made(0.0, FRICTION.joined(OUT), (0.1, 0.1)), 50.0, 40.0)
    found = searched(made(), *(Weighed(made(0.0, h, v), 0.0, 0.0) for h, v in ((OUT, (0.1,)), (FRICTION, (0.1,)), (drift, (0.1, 900.0)))))
    assert all(drift in [w.fit.hypothesis for w in of._others(found, leader, part)] for part in ("zero_offset", "const_friction"))
    # what one fault of a sensor does, another one may
    assert of._alike("zero_offset", "zero_drift") and not of._alike("const_friction", "zero_drift")
    assert of._alike("const_friction", "viscous") and of._alike("viscous", "viscous")


def test_of_each_effect_the_law_that_promises_most_and_the_one_that_explains_most_alone_stand_for_a_part():
    bend, length = (next(h for h in variants("viscous", ("act",)) if n in {f.parameter.name for f in h.free}) for n in BEND_LENGTH)
    laws = [Weighed(made(0.0, h, (0.01, 0.1)), 0.0, 0.0) for h in (length, bend)]
    found = searched(made(), Weighed(made(0.0, GAIN, (1.0,)), 0.0, 0.0))
    found.singles["viscous"] = tuple(laws)
    gain = found.singles["gain_error"][0]
    assert of._instead(found, [laws[1], gain, laws[0]]) == [laws[1], gain, laws[0]]
    # one that stands in the pair as it is stands for nothing
    assert of._instead(found, [laws[1], gain]) == [laws[1], gain]


def test_what_a_sensor_takes_for_its_time_constant_alone_is_looked_for_anew_beside_the_leader():
    """Alone it takes up what friction does, ever more slowly; beside friction the drift is as fast as it is."""
    drift = named("zero_drift", "s_out_act_n", "session_s")
    sim, base = truth((FRICTION, (0.3,)), (drift, (0.4, 25.0)))
    leader, slow = alone(sim, base, FRICTION, (0.1,)), Weighed(made(0.0, drift, (0.1, 9000.0)), 0.0, 0.0)
    ((_, promise, start),) = of._shaped(sim, leader, [slow, Weighed(made(0.0, OUT, (0.1,)), 0.0, 0.0)])
    assert start[1] < 100.0
    joined = of._joined(searched(base, leader, slow, sim=sim), of._Job(0.0, leader, (slow,), (start,)))
    assert joined.fit.values[-2:] == pytest.approx([0.4, 25.0], rel=0.1) and promise > 0.5 * (leader.fit.cost - joined.fit.cost)


BEND_LENGTH = ("c_bend_n_s_per_mm", "c_l_n_s_per_mm")


def test_without_a_leading_pair_nothing_is_looked_beside():
    found = searched(made(), Weighed(made(0.0, GAIN, (1.0,)), 9.0, 6.0))
    assert not of._swap(found, 1) and found.combined == {}


@pytest.mark.parametrize(("more", "looked"), [(0.99 * JOINS_NATS, False), (1.01 * JOINS_NATS, True)])
def test_beside_a_pair_is_looked_where_a_part_joins_it_for_good(monkeypatch, more, looked):
    parts = [Weighed(made(0.0, GAIN, (1.0,)), 9.0, 6.0), Weighed(made(0.0, FRICTION, (0.1,)), 0.0, -1.0)]
    pair = Weighed(made(0.0, GAIN.joined(FRICTION), (1.0, 0.1)), 20.0, 6.0 + more)
    asked = []
    monkeypatch.setattr(of, "_others", lambda found, leader, part: asked.append(part) or [])
    # nothing is like a part here, so that nothing is likelier
    assert not of._swap(searched(made(), *parts, combined=[pair]), 1) and asked == (list(pair.ids) if looked else [])


def test_a_pair_is_no_less_likely_than_the_leader_that_it_contains():
    # friction that builds up by another law is far off: steps by the leader's phases lead away from what its own allow
    dahl, cut = (next(h for h in variants("presliding", ("act",)) if h.free[0].parameter.name == n) for n in ("dahl_mm", "breakaway_mm"))
    sim, base = truth((cut, (0.6, 0.3, 0.3)), (variants("asymmetric_friction", ("act",))[0], (0.06,)))
    f = settle(sim, NOISE, alone(sim, base, dahl, (0.5, 0.5, 0.3)).fit)
    leader, partner = Weighed(f, 0.0, 0.0), alone(sim, base, CREEP, grid(CREEP.free)[0])
    ((_, _, step),) = of._partners(sim, leader, [partner])
    both = of._joined(searched(base, leader, partner, sim=sim), of._Job(0.0, leader, (partner,), (of._begin(partner.fit, step),)))
    assert both.fit.cost <= leader.fit.cost


def test_the_parts_of_a_leading_pair_are_fitted_alone_from_where_they_stand_there():
    """A fit that stopped in a valley of its own is left for the deeper one that a pair has found."""
    left = noise(9)
    sim = replace(SIM)
    sim.y = SIM.predict(THETA, as_effects(GAIN.free, np.array([1.1]))) + left
    base = settle(sim, NOISE, fit(sim, made().whiten, NOTHING, THETA, np.zeros(0)))
    stuck = weigh(sim, fit(sim, base.whiten, GAIN, base.theta, np.array([1.0]), 0), base)
    other = weigh(sim, settle(sim, NOISE, fit(sim, base.whiten, ZERO, base.theta, np.zeros(2))), base)
    both = GAIN.joined(ZERO)
    pair = weigh(sim, settle(sim, NOISE, fit(sim, base.whiten, both, THETA, np.array([1.1, 0.0, 0.0]))), base, [other, stuck])
    found = searched(base, stuck, other, combined=(pair,), sim=sim)
    of._parted(found, 1)
    best = found.singles["gain_error"][0]
    assert best.evidence > stuck.evidence + 50.0 and best.fit.values == pytest.approx([1.1], abs=0.01)
    assert found.singles["gain_error"][1] is stuck
