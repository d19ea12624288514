"""Pieces of the search against dense linear algebra on the small made records, and one whole small search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, NOTHING, THETA, made, named, noise, simulator, thetas

from sstl_cli.diagnosis import search as of
from sstl_cli.diagnosis.constants import LEADERS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import fit
from sstl_cli.diagnosis.found import Search, each
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.search import run
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
ZERO = full("zero_offset", ("act",))
FRICTION, GAIN = (variants(e, ("act",))[0] for e in ("const_friction", "gain_error"))


OUT = named("zero_offset", "z_out_act_n")


def searched(base, *singles, combined=()):
    models = {w.ids[0]: (w,) for w in singles}
    return Search(SIM, NOISE, NOISE, base, models, {tuple(sorted(w.ids)): w for w in combined})


def test_models_are_ranked_by_evidence_and_the_best_of_each_is_kept():
    a, b = Weighed(made(0.0, OUT, (0.1,)), 5.0, 3.0), Weighed(made(0.0, GAIN, (1.1,)), 5.0, 4.0)
    worse = Weighed(made(0.0, ZERO, (0.0, 0.1)), 5.0, 2.0)
    both = Weighed(made(0.0, GAIN.joined(OUT), (1.1, 0.1)), 9.0, 3.5)
    found = Search(SIM, NOISE, NOISE, made(), {"zero_offset": (a, worse), "gain_error": (b,)}, {("gain_error", "zero_offset"): both})
    assert found.ranked() == [b, both, a]
    assert found.best(("zero_offset",)) is a and found.best(("zero_offset", "gain_error")) is both


def test_subsets_lose_what_the_curvature_says():
    whole = made(noise(4), ZERO, (0.002, 0.3))
    rows = of._subsets(SIM, whole)
    # without the offset of the output nearly nothing is left: the other one goes first
    assert [[f.parameter.name for f in h.free] for h, _, _ in rows] == [["z_out_act_n"], ["z_in_act_n"]]
    j = np.column_stack((thetas(whole), whole.whiten(whole.jacobian[:, 1:])))
    a = j.T @ j
    for (_, values, theta), kept in zip(rows, (1, 0), strict=True):
        loose, fixed = [0, 1, 2 + kept], [3 - kept]
        off = -whole.values[[1 - kept]]
        moved = np.append(THETA, whole.values[kept]) - np.linalg.solve(a[np.ix_(loose, loose)], a[np.ix_(loose, fixed)] @ off)
        assert theta == pytest.approx(moved[:2], rel=1e-4) and values == pytest.approx(np.clip(moved[2:], -20.0, 20.0), rel=1e-4)


def test_work_is_in_order_however_many_do_it():
    assert each(lambda x: x * x, range(5), 1) == each(lambda x: x * x, range(5), 3) == [0, 1, 4, 9, 16]
    assert of._spread(np.zeros(3), [2, 0], np.array([5.0, 6.0])).tolist() == [6.0, 0.0, 5.0]


def test_a_fit_that_ends_above_the_base_begins_once_more_from_the_base():
    sim = replace(SIM)
    sim.y = made().prediction + 0.1 + noise(5)
    base = fit(sim, made().whiten, NOTHING, THETA, np.zeros(0))
    found = replace(searched(base), sim=sim)
    stuck = fit(sim, base.whiten, OUT, np.array([3.0, 3.0]), np.array([-5.0]), 0)
    assert stuck.cost > base.cost
    again = of._near(found, stuck)
    assert again.cost < base.cost and again.values[0] == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize(("h", "value"), [(named("channel_delay", "tau_act_s"), 0.15), (OUT, 3.0)])
def test_what_makes_all_late_is_judged_by_its_own_phases_where_the_unwhitened_fit_found_it(monkeypatch, h, value):
    """By those of the base it seems far off; another effect begins near the base then."""
    sim = replace(SIM)
    sim.y = made().prediction + noise(9)
    base = fit(sim, made().whiten, NOTHING, THETA, np.zeros(0))
    rough = fit(sim, base.whiten, h, THETA, np.array([value]), 0)
    assert rough.cost > base.cost
    begun, real = [], of.settle
    monkeypatch.setattr(of, "settle", lambda s, n, start, *a, **k: begun.append(float(start.values[0])) or real(s, n, start, *a, **k))
    of._first_round(replace(searched(base), sim=sim), [rough], [0, 1], 1)
    assert (begun[0] == value) == (h.ids == ("channel_delay",))


@pytest.fixture(scope="module")
def whole():
    """Return a search on records with a zero of the output and a little friction that does not propagate, and how far it said it was."""
    sim, shares, asked = replace(SIM), [], []
    truth = OUT.joined(FRICTION)
    y = sim.predict(THETA, as_effects(truth.free, np.array([0.7, 0.2]))) + noise(6)
    ends = np.cumsum([len(r) for r in sim.problem.records])
    records = tuple(replace(r, y=y[e - len(r) : e], y_fine=y[e - len(r) : e]) for r, e in zip(sim.problem.records, ends, strict=True))
    sim = replace(sim, problem=replace(sim.problem, records=records))
    found = run(
        sim, ("zero_offset", "const_friction", "gain_error"), 0.9 * THETA, 2, shares.append, 1, lambda size: asked.append(size) or False
    )
    return found, shares, asked


def test_a_whole_search_finds_both_effects_and_their_sizes(whole):
    found, shares, asked = whole
    assert set(found.singles) == {"zero_offset", "const_friction", "gain_error"} and asked == ["pairs"]
    assert found.ranked()[0].ids in (("zero_offset", "const_friction"), ("const_friction", "zero_offset"))
    best = found.ranked()[0].fit
    # with next to no noise it is the fits that tell the same friction along the sheath from that at both of its ends
    friction = sum(v for name, v in best.effects["const_friction"].items() if name.startswith("w_"))
    assert best.effects["zero_offset"]["z_out_act_n"] == pytest.approx(0.7, abs=0.1) and friction == pytest.approx(0.2, abs=0.1)
    assert best.theta == pytest.approx(THETA, abs=0.02)
    assert all(w.gain == pytest.approx(found.base.cost - w.fit.cost) for w in found.ranked())
    # screening, coarse and last fits of each of three starts (where and how friction acts, and preloads, are more screened and coarsely fitted), and one size
    assert len(shares) == 3 * 3 + 17 and sum(shares) == pytest.approx(1.0)


def test_noise_is_heard_beside_what_explains_most_of_the_whole_log_and_beside_several_effects(whole, monkeypatch):
    """Laws and sensors of one effect would take the places of others, and what nothing explains there the noise takes up."""
    beside, real = [], of.hearing.heard
    monkeypatch.setattr(of.hearing, "heard", lambda sim, fits, measured: beside.append(fits) or real(sim, fits, measured))
    run(whole[0].sim, ("zero_offset", "const_friction", "gain_error"), 0.9 * THETA, 1)
    ((base, *rich),) = beside
    assert base.ids == ()
    assert [f.cost for f in rich] == sorted(f.cost for f in rich) and len(rich) == LEADERS


def test_effects_come_before_further_laws_of_one():
    fits = [made(0.0, h, v) for h, v in ((OUT, (0.1,)), (ZERO, (0.1, 0.1)), (GAIN, (1.1,)), (OUT, (0.2,)))]
    assert of._effects_first(fits) == [fits[0], fits[2], fits[1], fits[3]]


def test_combinations_that_have_no_time_are_left_out(whole):
    found, _, _ = whole
    sim = found.sim
    late = run(sim, ("zero_offset", "const_friction"), THETA, 2, passed=lambda _: True)
    assert late.combined == {} and set(late.singles) == {"zero_offset", "const_friction"}
    alone = run(sim, ("zero_offset", "const_friction"), THETA, 1)
    assert alone.combined == {} and alone.base.cost == pytest.approx(late.base.cost)


@pytest.mark.slow
def test_a_bend_that_no_representative_run_shows_begins_where_it_is_said_to_be(monkeypatch):
    """Of two bends, one half as much as the other, the slighter one alone is in the runs that are searched first."""
    sim = replace(SIM)
    bends = np.array([0.25, 1.3])
    sim.y = sim.predict(bends, {}) + noise(7)
    part = replace(
        sim.problem, configs=(sim.problem.configs[1],), records=tuple(replace(r, config=0) for r in sim.problem.records if r.config == 1)
    )
    monkeypatch.setattr(of, "representatives", lambda problem: part)
    begun = []
    whole = of.fit

    def fitted(s, whiten, h, theta, *more, **how):
        begun.append((s, np.array(theta)))
        return whole(s, whiten, h, theta, *more, **how)

    monkeypatch.setattr(of, "fit", fitted)
    said = np.array([0.3, 1.2])
    run(sim, [], said, 1)
    first = next(theta for s, theta in begun if s is sim)
    assert first[0] == said[0]
    assert first[1] != said[1]
