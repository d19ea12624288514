"""Steps of a fit against dense least squares, and bounds that hold."""

from __future__ import annotations

import numpy as np
import pytest
from made_fits import NOTHING, THETA, made, noise, simulator

from sstl_cli.diagnosis.constants import THETA_HIGH
from sstl_cli.diagnosis.evidence import standard_errors
from sstl_cli.diagnosis.fit import fit, normal_equations
from sstl_cli.diagnosis.hypotheses import full


def expanded(sim, j):
    """Jacobian with one column of theta for each configuration."""
    own = (sim.config[:, None] == np.arange(len(sim.problem.configs))) * j[:, :1]
    return np.concatenate((own, j[:, 1:]), axis=1)


def test_normal_equations_are_those_of_the_expanded_jacobian():
    sim, rng = simulator(), np.random.default_rng(1)
    j, r = rng.standard_normal((len(sim.y), 4)), rng.standard_normal(len(sim.y))
    a, b = normal_equations(sim, j, r)
    dense = expanded(sim, j)
    assert a == pytest.approx(dense.T @ dense) and b == pytest.approx(dense.T @ r)


def test_standard_errors_are_the_root_of_the_inverse():
    f = made(noise(), full("gain_error", ["act"]), (1.02,))
    dense = expanded(simulator(), f.whiten(f.jacobian))
    assert standard_errors(simulator(), f) == pytest.approx(np.sqrt(np.diag(np.linalg.inv(dense.T @ dense)))[2:], rel=1e-5)


def test_theta_of_a_noise_free_record_comes_back_and_another_start_does_not_matter():
    sim, f = simulator(), made()
    sim_y, sim.y = sim.y, f.prediction.copy()
    try:
        for start in (0.8 * THETA, 1.3 * THETA):
            found = fit(sim, f.whiten, NOTHING, start, np.zeros(0))
            assert found.theta == pytest.approx(THETA, abs=2e-3)
    finally:
        sim.y = sim_y


def test_a_parameter_at_its_end_stays_there_and_the_others_move():
    sim = simulator()
    h = full("const_friction", ["act"])
    base = made()
    sim_y, sim.y = sim.y, sim.predict(0.9 * THETA, {})
    try:
        found = fit(sim, base.whiten, h, THETA, np.array([0.0]))
        assert h.free[0].parameter.least <= found.values[0] < 1e-6
        assert found.theta == pytest.approx(0.9 * THETA, abs=5e-3) and np.all(found.theta < THETA_HIGH)
    finally:
        sim.y = sim_y
