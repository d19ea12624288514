"""Steps of a fit against dense least squares, and bounds that hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, NOTHING, THETA, made, noise, simulator

from sstl_cli.diagnosis.constants import THETA_HIGH
from sstl_cli.diagnosis.evidence import information, inverse, standard_errors
from sstl_cli.diagnosis.fit import fit, normal_equations, settle
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.filters import delayed


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
    assert standard_errors(f, information(simulator(), f)) == pytest.approx(np.sqrt(np.diag(np.linalg.inv(dense.T @ dense)))[2:], rel=1e-5)


def test_what_is_known_of_a_parameter_does_not_depend_on_its_unit():
    # two that half know one another, weighed in units twenty decades apart
    units = np.diag([1e10, 1e-10])
    a = units @ np.array([[4.0, 2.0], [2.0, 4.0]]) @ units
    assert inverse(a) == pytest.approx(np.linalg.inv(units) @ np.array([[1 / 3, -1 / 6], [-1 / 6, 1 / 3]]) @ np.linalg.inv(units), rel=1e-9)
    assert np.diag(inverse(np.diag([4.0, 0.0]))) == pytest.approx([0.25, 0.0])


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
    h = variants("const_friction", ("act",))[0]
    base = made()
    sim_y, sim.y = sim.y, sim.predict(0.9 * THETA, {})
    try:
        found = fit(sim, base.whiten, h, THETA, np.array([0.0]))
        assert h.free[0].parameter.least <= found.values[0] < 1e-6
        assert found.theta == pytest.approx(0.9 * THETA, abs=5e-3) and np.all(found.theta < THETA_HIGH)
    finally:
        sim.y = sim_y


def test_the_known_scatter_of_a_rig_is_late_where_its_output_is_read_late():
    """A rig is known to be off by 1 N in a tenth of every run; the delay is told by the rest, not by where it is off."""
    sim, late_s = simulator(), 0.3
    off = [np.where(np.arange(len(r)) % (len(r) // 2) < len(r) // 20, 1.0, 1e-3) for r in sim.problem.records]
    records = tuple(replace(r, misfit_n=sd, misfit_s=1.0) for r, sd in zip(sim.problem.records, off, strict=True))
    known = replace(sim, problem=replace(sim.problem, records=records))
    steps = late_s / (records[0].dt_s * records[0].factor)
    scatter = np.concatenate([delayed(sd * np.sin(np.arange(len(sd)) / 9.0), steps) for sd in off])
    h = next(v for v in variants("channel_delay", ("act",)) if [f.parameter.name for f in v.free] == ["tau_act_s"])
    sensor = Sensor(NOISE_N, 0.0, 0.1)
    noise_of = Noise({"act": Sensor(1e-4, 0.0, 0.1)}, {"act": sensor}, {"act": 1.0})
    known.y = known.predict(THETA, as_effects(h.free, np.array([late_s]))) + scatter + noise(3)
    start = fit(known, made().whiten, h, THETA, np.array([0.2]), 0)
    found = settle(known, noise_of, start)
    assert found.values[0] == pytest.approx(late_s, abs=0.01)
    # where the scatter was thought to be on time, its end would stand beyond the noise
    assert float(np.max(np.abs(found.whiten(found.residual)))) < 5.0
    (read, plain) = known.read_records(found.effects)[0], records[0]
    assert read.misfit_n == pytest.approx(delayed(plain.misfit_n, found.values[0] / (plain.dt_s * plain.factor)))
    assert known.read_records({}) == records
