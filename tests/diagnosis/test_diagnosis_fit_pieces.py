"""Starts, slopes, steps and bounds of a fit, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, NOTHING, THETA, made, noise, simulator

from sstl_cli.diagnosis.constants import EDGE, PARAMETER_STEP, SHARES, START_FACTORS, THETA_HIGH, THETA_LOW, THETA_STEP
from sstl_cli.diagnosis.fit import _bounded_step, first_theta, fit, jacobian, partial, settle
from sstl_cli.diagnosis.free import Bounds, as_effects
from sstl_cli.diagnosis.hypotheses import full, laws, variants
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
FRICTION, GAIN = variants("const_friction", ("act",))[0], full("gain_error", ("act",))
QUIET = Noise({"act": Sensor(1e-4, 1e-6, 0.1)}, {"act": Sensor(NOISE_N, 1e-4, 0.1)}, {"act": 1.0})


def read(y):
    sim = replace(SIM)
    sim.y = y
    return sim


def test_a_start_is_the_best_of_a_few_for_each_bend_by_itself():
    truth = np.array([0.5 * START_FACTORS[2], 0.5 * START_FACTORS[4]])
    assert first_theta(read(SIM.predict(truth, {})), np.array([0.5, 0.5])) == pytest.approx(truth)
    # within what anything moves through; what has no weight does not count
    assert first_theta(read(SIM.predict(np.array([THETA_HIGH, THETA_HIGH]), {})), np.array([99.0, 99.0])) == pytest.approx([THETA_HIGH] * 2)
    sim = read(SIM.predict(np.array([0.5, 0.5]), {}))
    sim.weight = (SIM.config == 0).astype(float)
    sim.y = np.where(SIM.config == 0, sim.y, 1e6)
    assert first_theta(sim, np.array([0.5, 0.5]))[0] == pytest.approx(0.5)


def test_slopes_are_differences_forward_but_at_the_end_of_a_range():
    base = SIM.predict(THETA, as_effects(GAIN.free, np.array([1.0])))
    j = jacobian(SIM, THETA, GAIN.free, np.array([1.0]), base)
    assert j[:, 0] == pytest.approx((SIM.predict(THETA + THETA_STEP, {}) - base) / THETA_STEP)
    h = PARAMETER_STEP * 0.3
    assert j[:, 1] == pytest.approx((SIM.predict(THETA, {"gain_error": {"g_act": 1.0 + h}}) - base) / h)
    drop = full("asymmetric_friction", ("act",)).free
    top = SIM.predict(THETA, {"asymmetric_friction": {"a": 0.9}})
    h = PARAMETER_STEP * 0.4
    found = partial(SIM, THETA, drop, np.array([0.9]), top, [0])
    assert found[:, 0] == pytest.approx((SIM.predict(THETA, {"asymmetric_friction": {"a": 0.9 - h}}) - top) / -h) and np.any(found)
    assert partial(SIM, THETA, drop, np.array([0.9]), top, []).shape == (8000, 0)


@pytest.mark.parametrize(
    ("value", "there"),
    [
        (0.85, True),
        (0.85 + 0.9 * EDGE * 0.3, True),
        (0.85 + 1.1 * EDGE * 0.3, False),
        (1.15, True),
        (1.15 - 1.1 * EDGE * 0.3, False),
        (2.0, True),
    ],
)
def test_a_parameter_is_at_its_bound_within_a_thousandth_of_its_range(value, there):
    assert bool(made(0.0, GAIN, (value,)).at_bound(0)) is there


def test_neutral_is_no_bound():
    assert not made(0.0, FRICTION, (0.0,)).at_bound(0) and made(0.0, FRICTION, (0.5,)).at_bound(0)
    down = full("saturation", ("act",))
    assert not made(0.0, down, (1000.0, 1000.0)).at_bound(1)
    # more than all of it cannot be there
    soft = made(0.0, laws("saturation", ("act",))[0], (1.0, 9.0, 2.0))
    assert not soft.at_bound(0) and not soft.at_bound(1) and soft.at_bound(2)


def test_a_step_is_that_of_the_free_ones_where_others_are_held_on_their_bounds():
    a = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    b = np.array([1.0, -9.0, 2.0])
    bounds = Bounds(np.array([0.0, 0.0]), np.array([9.0, 9.0]))
    # one theta and two parameters; the first of these would fall below 0, where it stands
    step = _bounded_step(a, b, np.array([0.0, 1.0]), bounds, 1)
    assert step[1] == 0.0 and step[[0, 2]] == pytest.approx(np.linalg.solve(a[np.ix_([0, 2], [0, 2])], b[[0, 2]]))
    # away from its bound it may go there, and upwards from it as well
    assert _bounded_step(a, b, np.array([1.0, 1.0]), bounds, 1) == pytest.approx(np.linalg.solve(a, b))
    assert _bounded_step(a, -b, np.array([0.0, 9.0]), bounds, 1) == pytest.approx(np.linalg.solve(a, -b))
    assert _bounded_step(a, b, np.array([9.0, 9.0]), bounds, 1)[2] == 0.0
    # without any parameter it is theta's own
    assert _bounded_step(a[:1, :1], b[:1], np.zeros(0), Bounds(np.zeros(0), np.zeros(0)), 1) == pytest.approx([0.25])


def test_a_fit_of_no_iterations_is_its_start_and_its_cost_that_of_the_residual():
    sim = read(made().prediction + noise(1))
    whiten = made().whiten
    f = fit(sim, whiten, GAIN, THETA, np.array([1.05]), 0)
    z = whiten(sim.y - SIM.predict(THETA, {"gain_error": {"g_act": 1.05}}))
    assert (
        f.cost == pytest.approx(0.5 * float(z @ z) + 0.5 * whiten.log_det)
        and f.values.tolist() == [1.05]
        and np.array_equal(f.theta, THETA)
    )
    assert np.array_equal(f.residual, sim.y - f.prediction) and f.jacobian.shape == (8000, 2) and f.discrepancy == 0.0
    # each iteration lowers it, and known ones need not be made again
    costs = [fit(sim, whiten, GAIN, THETA, np.array([1.05]), k).cost for k in (1, 2, 3)]
    assert f.cost > costs[0] > costs[1] >= costs[2]
    assert fit(sim, whiten, GAIN, THETA, np.array([1.05]), 1, f).cost == costs[0]


def test_a_fit_ends_at_the_dense_least_squares():
    sim = read(SIM.predict(THETA, {"gain_error": {"g_act": 1.04}}) + noise(2))
    f = fit(sim, made().whiten, GAIN, 0.9 * THETA, np.array([1.0]))
    j = np.column_stack((f.jacobian[:, :1] * (SIM.config[:, None] == np.arange(2)), f.jacobian[:, 1]))
    step = np.linalg.lstsq(j, f.residual, rcond=None)[0]
    # what is left asks for no further step, within a tenth of a nat
    assert (
        np.sum((j @ step) ** 2) / NOISE_N**2 < 0.2
        and f.values[0] == pytest.approx(1.04, abs=2e-3)
        and f.theta == pytest.approx(THETA, abs=2e-3)
    )
    assert np.all((f.theta >= THETA_LOW) & (f.theta <= THETA_HIGH))


def test_a_law_that_is_exact_has_no_discrepancy_and_one_that_is_off_by_a_tenth_of_itself_has():
    response = SIM.predict(THETA, {"const_friction": {"w_l_n": 0.4}}) - SIM.predict(THETA, {})
    exact = read(SIM.predict(THETA, {}) + response + noise(3))
    off = read(exact.y + 0.1 * response * np.random.default_rng(4).standard_normal(8000))
    found = [settle(sim, QUIET, fit(sim, made().whiten, FRICTION, THETA, np.array([0.4]), 0)) for sim in (exact, off)]
    assert [f.discrepancy for f in found] == [0.0, 0.1] and set(SHARES) >= {0.0, 0.1}
    z = [f.whiten.left(f.residual) for f in found]
    assert all(f.cost == pytest.approx(0.5 * float(x @ x) + 0.5 * f.whiten.log_det) for f, x in zip(found, z, strict=True))
    assert all(np.mean(x**2) == pytest.approx(1.0, abs=0.1) for x in z)
    # the base states none
    assert settle(exact, QUIET, fit(exact, made().whiten, NOTHING, THETA, np.zeros(0), 0)).discrepancy == 0.0


def test_a_law_of_jumps_is_off_by_a_share_of_them_wherever_it_slides():
    slow = next(h for h in variants("stick_slip", ("act",)) if [f.parameter.name for f in h.free] == ["mean_ratio", "mean_mm_s"])
    sim = read(SIM.predict(THETA, as_effects(slow.free, np.array([1.3, 2.0]))) + noise(5))
    f = settle(sim, QUIET, fit(sim, made().whiten, slow, THETA, np.array([1.3, 2.0]), 0), 1, 2)
    # even where it is exact, which no such law is
    assert f.discrepancy == 0.2
