"""Steps, shares and slopes of a fit, on numbers whose answer is known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import fit as of
from sstl_cli.diagnosis.fit import Fit, _bounded_step, _most_likely, _normal_equations, _secant, held
from sstl_cli.diagnosis.free import Bounds


def test_a_step_beyond_a_bound_on_which_a_value_stands_is_held_there_and_the_others_go_on():
    a = np.array([[2.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 4.0]])
    free = np.linalg.solve(a, [1.0, 2.0, -3.0])
    wide = Bounds(np.array([-9.0, -9.0]), np.array([9.0, 9.0]))
    assert _bounded_step(a, np.array([1.0, 2.0, -3.0]), np.zeros(2), wide, 1) == pytest.approx(free)
    # the last one stands at its least value and would fall
    low = Bounds(np.array([-9.0, 0.0]), np.array([9.0, 9.0]))
    held_there = np.append(np.linalg.solve(a[:2, :2], [1.0, 2.0]), 0.0)
    assert _bounded_step(a, np.array([1.0, 2.0, -3.0]), np.zeros(2), low, 1) == pytest.approx(held_there)
    # one that is off its bound may go beyond it: that is cut off later
    assert _bounded_step(a, np.array([1.0, 2.0, -3.0]), np.array([0.0, 0.1]), low, 1) == pytest.approx(free)
    # at the highest one, and one after the other: the first is held, and then so is the second
    high = Bounds(np.array([-9.0, -9.0]), np.array([0.0, 9.0]))
    fixed = np.linalg.solve(a[np.ix_([0, 2], [0, 2])], [1.0, -3.0])
    assert _bounded_step(a, np.array([1.0, 2.0, -3.0]), np.zeros(2), high, 1) == pytest.approx([fixed[0], 0.0, fixed[1]])
    both = Bounds(np.array([-9.0, 0.0]), np.array([0.0, 9.0]))
    assert _bounded_step(a, np.array([1.0, 2.0, -3.0]), np.zeros(2), both, 1) == pytest.approx([0.5, 0.0, 0.0])


def looked(costs, begin):
    """Return the share that is taken of those with these costs, and those that were tried."""
    tried = []

    def judged(share):
        tried.append(share)
        return SimpleNamespace(cost=costs[share], discrepancy=share)

    return _most_likely(judged, sorted(costs), begin).discrepancy, tried


def test_a_share_is_sought_from_where_it_was_as_long_as_it_gets_likelier():
    costs = {0.0: 5.0, 0.01: 4.0, 0.03: 3.0, 0.1: 2.0, 0.3: 4.0}
    assert looked(costs, 0.01) == (0.1, [0.01, 0.03, 0.1, 0.3]) and looked(costs, 0.3) == (0.1, [0.3, 0.1, 0.03])
    # what is as likely is not likelier; then the other way is looked
    assert looked({**costs, 0.03: 4.0}, 0.01) == (0.01, [0.01, 0.03, 0.0]) and looked({0.0: 1.0, 0.1: 2.0, 0.3: 9.0}, 0.1) == (
        0.0,
        [0.1, 0.3, 0.0],
    )
    # of nowhere, or of a share that is none of them, all are tried
    assert looked(costs, None) == looked(costs, 0.5) == (0.1, [0.0, 0.01, 0.03, 0.1, 0.3])
    assert looked({0.2: 1.0}, 0.2) == (0.2, [0.2])


def test_a_turned_jacobian_says_what_a_step_has_done_and_parameters_share_what_it_said_wrong_by_how_they_moved():
    rng = np.random.default_rng(2)
    config, j = np.array([0, 1, 0, 1, 1]), rng.standard_normal((5, 3))
    step, scale, moved = np.array([0.3, 0.0, 0.5, -0.2]), np.array([2.0, 3.0, 4.0, 5.0]), rng.standard_normal(5)
    before = j.copy()
    _secant(config, j, moved, step, scale)
    for t in range(5):
        own = np.array([step[config[t]], *step[2:]])
        weight = np.array([scale[config[t]], *scale[2:]])
        assert j[t] @ own == pytest.approx(moved[t])
        wrong = moved[t] - before[t] @ own
        assert j[t] - before[t] == pytest.approx(wrong * weight * own / np.sum(weight * own**2))
    # who has not moved learns nothing
    still = before.copy()
    _secant(config, still, moved, np.zeros(4), scale)
    assert np.array_equal(still, before)


def test_normal_equations_have_a_column_for_each_theta():
    rng = np.random.default_rng(3)
    config, j, r = np.array([0, 2, 1, 2, 0, 1]), rng.standard_normal((6, 3)), rng.standard_normal(6)
    wide = np.zeros((6, 5))
    wide[np.arange(6), config], wide[:, 3:] = j[:, 0], j[:, 1:]
    a, b = _normal_equations(config, 3, j, r)
    assert a == pytest.approx(wide.T @ wide) and b == pytest.approx(wide.T @ r)


def test_what_is_moved_costs_its_square_beside_what_follows():
    rng = np.random.default_rng(4)
    root = rng.standard_normal((6, 4))
    a, off = root.T @ root, np.array([0.5, -1.0])
    cost, follow = held(a, np.array([1, 3]), off)
    left = np.linalg.lstsq(root[:, [0, 2]], root[:, [1, 3]] @ off, rcond=None)[0]
    assert follow == pytest.approx(left) and cost == pytest.approx(0.5 * np.sum((root[:, [1, 3]] @ off - root[:, [0, 2]] @ left) ** 2))


@pytest.mark.parametrize(
    ("value", "at_end"),
    # a thousandth of a range from -1 to 3 is 0.004
    [(-1.0, True), (-0.997, True), (-0.995, False), (0.0, False), (2.995, False), (2.997, True), (3.5, True)],
)
def test_a_parameter_within_a_thousandth_of_its_range_from_an_end_is_at_it(value, at_end):
    def fit(**more):
        p = SimpleNamespace(**{"low": -1.0, "high": 3.0, "neutral": 0.0, "most": 9.0, "shape": False, **more})
        free = SimpleNamespace(parameter=p, width=p.high - p.low)
        return Fit(SimpleNamespace(ids=(), free=(free,)), *(np.array([value]) for _ in range(2)), 0.0, *[np.zeros(0)] * 3, None)

    assert bool(fit().at_bound(0)) is at_end
    # an end that is neutral is none, nor is one that is all there is, but for a shape
    assert bool(fit(neutral=-1.0).at_bound(0)) is (at_end and value > 0.0)
    assert bool(fit(neutral=3.0).at_bound(0)) is (at_end and value < 0.0)
    assert bool(fit(most=3.0).at_bound(0)) is (at_end and value < 0.0) and bool(fit(most=3.0, shape=True).at_bound(0)) is at_end


def test_theta_begins_bend_by_bend_where_it_explains_most():
    tried = []

    def predict(theta, effects):
        tried.append(theta.tolist())
        return theta[[0, 0, 1]]

    sim = SimpleNamespace(weight=np.array([1.0, 1.0, 1.0]), y=np.array([1.5, 1.7, 0.05]), config=np.array([0, 0, 1]), predict=predict)
    assert of.first_theta(sim, np.array([1.0, 2.0])) == pytest.approx([1.6, 0.06])
    assert np.array(tried) == pytest.approx(np.outer([1.0, 0.6, 1.6, 0.3, 0.1, 0.03], [1.0, 2.0]))
    # weights count, and theta stays where anything moves
    sim.weight[1], sim.y[0] = 0.0, 0.32
    assert of.first_theta(sim, np.array([1.0, 9.0])) == pytest.approx([0.3, 0.27]) and max(t[1] for t in tried) == 5.0
