"""What holds are asked about corners, and when they decide, by hand."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import THETA, made, simulator

from sstl_cli.diagnosis import corners
from sstl_cli.diagnosis.corners import holds, likelier, passes

SIM = simulator()
NONE = np.zeros((0, 4))
BEYOND = np.array([1.0, -1.0, 1.0, -1.0])


def test_holds_decide_by_their_mean_square_at_49_to_1_of_as_many_as_are_free():
    # half a percent is left of four holds: 1 / 49^(2 / 4) would be a seventh
    off = 0.1 * np.array([1.0, 1.0, -1.0, -1.0])
    assert passes(BEYOND + off, BEYOND[None], NONE) == (0, pytest.approx(0.01))
    for free, slopes in ((4, NONE), (3, np.ones((1, 4)))):
        # what is off lies across what corners add: it is left of left squared by 1 - 1 / (1 + s^2)
        most = exp(-2.0 * log(49.0) / free)
        for share, decided in ((0.98 * most, True), (1.02 * most, False)):
            s = np.sqrt(share / (1.0 - share))
            found = passes(BEYOND + s * np.array([1.0, 1.0, -1.0, -1.0]), BEYOND[None], slopes)
            assert (found is not None) is decided
            assert found is None or found == (0, pytest.approx(min(s**2, 1.0 / 3.0)))


def test_as_many_slopes_as_holds_leave_nothing_to_decide_by():
    assert passes(BEYOND, BEYOND[None], np.eye(4)) is None and passes(BEYOND, np.zeros((1, 4)), NONE) is None
    # one that is free says so where nothing at all is left of it
    assert passes(BEYOND, BEYOND[None], np.eye(4)[:3]) == (0, 0.0)


@pytest.mark.parametrize(("share", "said"), [(0.74, True), (1.58, True), (0.71, False), (1.65, False), (-1.0, False)])
def test_corners_go_as_far_as_they_say(share, said):
    # a seventh of the square is left at most: up to 1 / sqrt(7) off what holds are
    assert (passes(BEYOND, np.stack([BEYOND / share]), NONE) is not None) is said
    # of several ways the nearest, whose size is that of sharp corners over what it leaves
    assert passes(0.5 * BEYOND, np.stack([BEYOND, 0.5 * BEYOND]), NONE) == (1, 0.0)


def test_a_hold_is_read_where_corners_reach_it_and_the_model_holds(monkeypatch):
    slide = np.ones(len(SIM.y))
    slide[[10, 11, 12, 20, 21, 2005, 2006, 4005]] = 0.0
    weight = np.ones(len(SIM.y))
    weight[11] = 0.0
    sim = SimpleNamespace(y=np.arange(8000.0), weight=weight, slices=SIM.slices, phases=lambda theta, effects: SimpleNamespace(slide=slide))
    base = SimpleNamespace(theta=None, prediction=np.full(8000, 1.0))
    first = np.where(np.arange(8000) < 4000, 0.5, 0.0)
    found = holds(sim, base, np.stack([first, 2.0 * np.arange(8000.0)]))
    # the masked sample parts a hold in two, and no corner reaches the third run
    assert found.tolist() == [[9.0, 11.0, 19.5, 2004.5], [0.5] * 4, [20.0, 24.0, 41.0, 4011.0]]
    slide[:] = 0.0011
    assert holds(sim, base, np.stack([first])).shape == (2, 0)


def looked(monkeypatch, answers, liked=(0.0, 0.0, 0.0, 0.0), cornered=True):
    """Return the simulator that is likelier by answers to what was asked, theta, and what was asked."""
    records = tuple(replace(r, rounds=np.array(liked) / 4.0, corner=r.corner if not cornered else object()) for r in SIM.problem.records)
    sim = replace(SIM, problem=replace(SIM.problem, records=records))
    asked, left = [], iter(answers)
    monkeypatch.setattr(corners, "passing", lambda problem, how: replace(problem, analysis_hz=("passes", how.lag_s, how.doubt)))
    monkeypatch.setattr(corners, "rounded", lambda problem, width: replace(problem, analysis_hz=("rounded", width)))
    monkeypatch.setattr(corners, "_base", lambda sim, nominal: SimpleNamespace(theta=nominal, prediction=made().prediction))
    monkeypatch.setattr(corners, "passes", lambda *args: next(left))

    def offered(sim, first, ways, slopes):
        asked.append(([w.analysis_hz for w in ways], slopes))
        return ()

    monkeypatch.setattr(corners, "_offered", offered)
    found, theta = likelier(sim, THETA)
    return found.problem.analysis_hz, theta, asked


def test_four_lags_are_asked_for_and_theta_is_moved_bend_by_bend(monkeypatch):
    how, theta, ((ways, slopes),) = looked(monkeypatch, [(2, 0.125)])
    dt = SIM.problem.records[0].dt_s
    assert ways == [("passes", k * dt, 1.0 / 3.0) for k in (0.0, 0.25, 0.5, 1.0)]
    assert how == ("passes", 0.5 * dt, 0.125) and theta.tolist() == THETA.tolist()
    base = SIM.predict(THETA, {})
    expected = [SIM.predict(THETA + 1e-4 * np.eye(2)[i], {}) - base for i in range(2)]
    assert slopes == pytest.approx(np.stack(expected)) and np.abs(slopes).max() < 0.1 and slopes.any(axis=1).all()


def test_where_no_lag_says_so_a_rounding_is_asked_for_and_the_samples_stand_where_neither_does(monkeypatch):
    how, _, asked = looked(monkeypatch, [None, (0, 0.1)])
    assert how == ("rounded", 1.0) and [a[0] for a in asked[1:]] == [[("rounded", 1.0)]]
    how, _, asked = looked(monkeypatch, [None, None])
    assert how == SIM.problem.analysis_hz and len(asked) == 2


@pytest.mark.parametrize(("nats", "how"), [(log(49.0) + 0.01, ("rounded", 4.0)), (log(49.0) - 0.01, None)])
def test_readings_that_like_a_rounding_decide_first(monkeypatch, nats, how):
    found, _, asked = looked(monkeypatch, [None, None], liked=(0.0, 1.0, nats, 1.0))
    assert found == (how or SIM.problem.analysis_hz) and len(asked) == (0 if how else 2)


def test_what_ways_add_is_the_difference_of_what_is_predicted(monkeypatch):
    first = SimpleNamespace(theta=THETA, prediction=SIM.predict(THETA, {}))
    raised = [replace(SIM.problem, records=tuple(replace(r, u=r.u + by) for r in SIM.problem.records)) for by in (0.1, 0.2)]
    seen = {}
    monkeypatch.setattr(corners, "holds", lambda sim, base, columns: seen.setdefault("columns", columns)[:, :3])
    slopes = np.stack([np.full(8000, 7.0), np.full(8000, 8.0)])
    left, added, by_theta = corners._offered(SIM, first, raised, slopes)
    expected = [replace(SIM, problem=p).predict(THETA, {}) - first.prediction for p in raised]
    assert seen["columns"] == pytest.approx(np.concatenate((expected, slopes)))
    assert left.shape == (3,) and added.shape == (2, 3) and by_theta.shape == (1, 3)
