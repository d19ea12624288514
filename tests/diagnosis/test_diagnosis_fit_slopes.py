"""Slopes that follow steps, shares that are climbed to, fits that keep the best they have been, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, NOTHING, THETA, made, named, noise, simulator

from sstl_cli.diagnosis import fit as of
from sstl_cli.diagnosis.constants import JUMPS, SHARES
from sstl_cli.diagnosis.fit import fit, jacobian, settle
from sstl_cli.diagnosis.found import deepest
from sstl_cli.diagnosis.hypotheses import variants
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
FRICTION = variants("const_friction", ("act",))[0]
QUIET = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": Sensor(NOISE_N, 1e-4, 0.1)}, {"act": 1.0})


def counted(sim, name):
    """Return a simulator that counts the calls of one of its methods."""
    calls = []
    whole = getattr(sim, name)

    def call(*args, **more):
        calls.append(args)
        return whole(*args, **more)

    setattr(sim, name, call)
    return calls


def test_slopes_say_what_a_step_has_done_each_configuration_by_its_own() -> None:
    config, j = np.array([0, 0, 1, 1]), np.array([[1.0, 2.0], [0.0, 1.0], [3.0, 0.0], [1.0, 1.0]])
    step, scale = np.array([0.5, -1.0, 2.0]), np.array([4.0, 1.0, 9.0])
    moved = np.array([7.0, 1.0, -2.0, 0.5])
    own, before = np.array([[0.5, 2.0], [0.5, 2.0], [-1.0, 2.0], [-1.0, 2.0]]), j.copy()
    of._secant(config, j, moved, step, scale)
    assert np.sum(j * own, axis=1) == pytest.approx(moved)
    # along what the step has not moved (orthogonal to it, by the squares of each parameter) they say what they said
    still = np.array([9.0 * 2.0, -4.0 * 0.5])
    assert j[:2] @ still == pytest.approx(before[:2] @ still)


def test_a_configuration_that_has_not_moved_keeps_its_slopes() -> None:
    j = np.array([[1.0], [2.0]])
    of._secant(np.array([0, 1]), j, np.array([3.0, 5.0]), np.array([2.0, 0.0]), np.ones(2))
    assert j.tolist() == [[1.5], [2.0]]


def test_slopes_at_the_end_are_those_of_the_end() -> None:
    sim = replace(SIM)
    sim.y = sim.predict(0.8 * THETA, {"const_friction": {"w_l_n": 0.3}}) + noise(1)
    found = fit(sim, made().whiten, FRICTION, THETA, np.array([0.0]))
    exact = jacobian(sim, found.theta, found.free, found.values, found.prediction)
    off = np.linalg.norm(found.jacobian - exact, axis=0) / np.linalg.norm(exact, axis=0)
    assert found.values[0] == pytest.approx(0.3, abs=0.02)
    assert off.max() < 0.05


def slopes_and_steps(h, effects, start, careful=False):
    """Return how often a fit makes its slopes afresh, how many steps it tries, and what it ends with."""
    sim = replace(SIM)
    sim.y = sim.predict(0.8 * THETA, effects) + noise(1)
    calls, fresh, exact = counted(sim, "predict"), [], of.jacobian

    def slopes(*args):
        fresh.append(len(calls))
        return exact(*args)

    of.jacobian = slopes
    try:
        found = fit(sim, made().whiten, h, THETA, start, careful=careful)
    finally:
        of.jacobian = exact
    # slopes are simulated together, and not by it
    return len(fresh), len(calls) - 1, found


def test_a_fit_looks_at_the_model_less_often_than_its_slopes_would_ask() -> None:
    made_afresh, steps, found = slopes_and_steps(FRICTION, {"const_friction": {"w_l_n": 0.3}}, np.array([0.0]))
    every, tried, same = slopes_and_steps(FRICTION, {"const_friction": {"w_l_n": 0.3}}, np.array([0.0]), True)
    assert made_afresh < min(steps, every)
    assert every >= tried
    assert found.values == pytest.approx(same.values, abs=1e-3)
    assert found.cost == pytest.approx(same.cost, abs=0.1)


def test_what_acts_along_the_line_has_its_slopes_made_afresh_at_every_step() -> None:
    h = variants("viscous", ("act",))[0]
    start = np.array([f.parameter.neutral + 0.1 * f.width if not f.parameter.shape else f.parameter.neutral for f in h.free])
    made_afresh, steps, _ = slopes_and_steps(h, {"viscous": {"c_l_n_s_per_mm": 0.02}}, start)
    assert made_afresh >= steps - of.DAMPINGS


@pytest.mark.parametrize(
    ("costs", "begin", "asked"),
    [
        ((1.0, 2.0, 3.0, 4.0, 5.0), 0.0, [0.0, 0.01]),
        ((5.0, 4.0, 3.0, 3.5, 4.0), 0.0, [0.0, 0.01, 0.03, 0.1]),
        ((5.0, 4.0, 3.0, 2.0, 1.0), 0.3, [0.3, 0.1]),
        ((1.0, 2.0, 3.0, 4.0, 5.0), 0.1, [0.1, 0.3, 0.03, 0.01, 0.0]),
        ((3.0, 2.0, 1.0, 2.0, 3.0), 0.7, list(SHARES)),
    ],
)
def test_the_likeliest_share_is_climbed_to_from_the_last_one(costs, begin, asked) -> None:
    seen = []

    def judged(share):
        seen.append(share)
        return replace(made(), cost=costs[SHARES.index(share)], discrepancy=share)

    best = of._most_likely(judged, SHARES, begin)
    assert best.cost == min(costs)
    assert seen == asked


def test_a_settled_fit_is_the_best_that_it_has_been(monkeypatch) -> None:
    costs = iter((5.0, 2.0, 4.0))
    monkeypatch.setattr(of, "_judged", lambda sim, noise, f: replace(f, cost=next(costs)))
    assert settle(SIM, QUIET, made()).cost == 2.0


def test_what_was_judged_is_not_judged_again(monkeypatch) -> None:
    judged = []
    monkeypatch.setattr(of, "_judged", lambda sim, noise, f: judged.append(f) or f)
    settle(SIM, QUIET, made(), rounds=0, judged=True)
    assert not judged
    settle(SIM, QUIET, made(), rounds=0)
    assert len(judged) == 1


def test_the_noise_of_a_rig_without_known_scatter_is_made_once() -> None:
    sim = replace(SIM)
    first = sim.constants({}, QUIET)
    assert sim.constants({"channel_delay": {"tau_act_s": 0.1}}, QUIET) is first
    assert sim.constants({}, replace(QUIET)) is not first


def test_a_known_scatter_is_read_as_late_as_the_channel_reads() -> None:
    records = tuple(replace(r, misfit_n=np.linspace(0.1, 1.0, len(r)), misfit_s=1.0) for r in SIM.problem.records)
    sim = replace(SIM, problem=replace(SIM.problem, records=records))
    on_time, late = sim.constants({}, QUIET), sim.constants({"channel_delay": {"tau_act_s": 0.5}}, QUIET)
    assert late is not on_time
    assert not np.allclose(late.own.fresh, on_time.own.fresh)
    assert sim.constants({}, QUIET) is on_time


def test_the_base_is_settled_from_the_bends_of_what_contains_it_and_is_likelier() -> None:
    sim = replace(SIM)
    sim.y = sim.predict(0.8 * THETA, {}) + noise(2)
    # two fits that stopped short: the base far from its bends, a candidate on them with a strength of nothing
    base = settle(sim, QUIET, fit(sim, made().whiten, NOTHING, 1.4 * THETA, np.zeros(0), 0), 0)
    better = settle(sim, QUIET, fit(sim, made().whiten, FRICTION, 0.8 * THETA, np.zeros(1), 0), 0)
    assert better.cost < base.cost
    least = deepest(sim, QUIET, base, [better])
    assert least.cost < better.cost + 1.0
    assert least.hypothesis == NOTHING
    assert least.theta == pytest.approx(0.8 * THETA, abs=0.01)
    assert deepest(sim, QUIET, least, [base]) is not base


def test_jumps_scatter_by_what_jumps_not_by_what_stands_beside_them() -> None:
    left = 0.3 * np.sin(np.arange(len(SIM.y)))
    jumps = named("stribeck", "mean_ratio", "mean_mm_s")

    def judged(h, *values) -> float:
        return of._judged(SIM, QUIET, made(left, h, values)).cost

    # friction that does not fall with speed scatters nothing, however much the other part does
    assert judged(jumps.joined(FRICTION), 1.0, 1.0, 0.4) == pytest.approx(judged(jumps, 1.0, 1.0), rel=1e-3)
    assert judged(jumps.joined(FRICTION), 1.4, 1.0, 0.4) < 0.8 * judged(jumps.joined(FRICTION), 1.0, 1.0, 0.4)


def test_a_line_rests_between_jumps_only_where_its_output_is_seen_to_rest() -> None:
    jumps = named("stribeck", "mean_ratio", "mean_mm_s")
    f = made(0.0, jumps, (1.4, 1.0))
    sticks = replace(SIM, rests=True)
    assert of._judged(SIM, QUIET, f).whiten.place is None
    assert of._judged(sticks, QUIET, made(0.0, FRICTION, (0.4,))).whiten.place is None
    # more shares of what the mean loses are tried where the output is seen to rest
    left = replace(f, residual=5.0 * (f.prediction - SIM.predict(THETA, {})))
    assert of._judged(sticks, QUIET, left).whiten.place is not None
    assert of._judged(sticks, QUIET, left).discrepancy > max(JUMPS) >= of._judged(SIM, QUIET, left).discrepancy
