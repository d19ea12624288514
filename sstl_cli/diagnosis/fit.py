"""Bounded Gauss-Newton fit of theta per configuration and the parameters of candidate effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.simulator import Free, Simulator, as_effects
from sstl_cli.diagnosis.whitening import Whitener

Array = NDArray[np.float64]
THETA_LOW, THETA_HIGH = 0.01, 3.0
MAX_ITERATIONS = 14
START_FACTORS = (1.0, 0.6, 1.6, 0.3, 0.1, 0.03)
TOLERANCE = 1e-4


@dataclass(frozen=True)
class Fit:
    """A fitted model: parameters, whitened cost (nats) and its compact Jacobian.

    ``jacobian`` has one column for the theta of the sample's own configuration, then one per free parameter.
    """

    ids: tuple[str, ...]
    free: tuple[Free, ...]
    theta: Array
    values: Array
    cost: float
    prediction: Array
    residual: Array
    jacobian: Array
    iterations: int

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        return as_effects(self.free, self.values)

    def at_bound(self, i: int) -> bool:
        """Whether free parameter ``i`` ended on a bound that is not its neutral value."""
        p, v = self.free[i].parameter, self.values[i]
        edge = 1e-3 * self.free[i].width
        return (v <= p.low + edge and p.low != p.neutral) or (v >= p.high - edge and p.high != p.neutral)


def jacobian(sim: Simulator, theta: Array, free: Sequence[Free], values: Array, base: Array) -> Array:
    """Return d prediction / d (own theta, free parameters), shape (samples, 1 + k), by one-sided differences.

    Runs of different configurations do not touch one another, so all thetas share one simulation.
    """
    columns = np.empty((len(base), 1 + len(free)))
    h = 1e-4
    columns[:, 0] = (sim.predict(theta + h, as_effects(free, values)) - base) / h
    for i, f in enumerate(free):
        h = 2e-3 * f.width
        if values[i] + h > f.parameter.high:
            h = -h
        moved = values.copy()
        moved[i] += h
        columns[:, 1 + i] = (sim.predict(theta, as_effects(free, moved)) - base) / h
    return columns


def first_theta(sim: Simulator, nominal: Array) -> Array:
    """Return for each configuration the start of theta that explains most: a fit that starts in an endless hold stays there.

    Parameters
    ----------
    nominal : ndarray, shape (configurations,)
    """
    tries = [np.clip(nominal * f, THETA_LOW, THETA_HIGH) for f in START_FACTORS]
    errors = []
    for theta in tries:
        r2 = sim.weight * (sim.y - sim.predict(theta, {})) ** 2
        errors.append(np.bincount(sim.config, r2, len(nominal)))
    best = np.argmin(np.array(errors), axis=0)
    return np.array(tries)[best, np.arange(len(nominal))]


def normal_equations(sim: Simulator, j: Array, r: Array) -> tuple[Array, Array]:
    """Return J'J and J'r with theta expanded to one column per configuration."""
    configs = len(sim.problem.configs)
    k = j.shape[1] - 1
    a = np.zeros((configs + k, configs + k))
    b = np.zeros(configs + k)
    diagonal = np.bincount(sim.config, j[:, 0] ** 2, configs)
    a[np.arange(configs), np.arange(configs)] = diagonal
    b[:configs] = np.bincount(sim.config, j[:, 0] * r, configs)
    for i in range(k):
        cross = np.bincount(sim.config, j[:, 0] * j[:, 1 + i], configs)
        a[:configs, configs + i] = cross
        a[configs + i, :configs] = cross
    a[configs:, configs:] = j[:, 1:].T @ j[:, 1:]
    b[configs:] = j[:, 1:].T @ r
    return a, b


def fit(
    sim: Simulator,
    whiten: Whitener,
    ids: Sequence[str],
    free: Sequence[Free],
    theta: Array,
    values: Array,
    iterations: int = MAX_ITERATIONS,
) -> Fit:
    """Return the bounded least-squares fit started at ``theta`` and ``values``.

    Parameters
    ----------
    theta : ndarray, shape (configurations,)
    values : ndarray, shape (k,)
        Start of the free parameters, in the order of ``free``.
    """
    low = np.array([f.parameter.low for f in free])
    high = np.array([f.parameter.high for f in free])
    configs = len(theta)
    prediction = sim.predict(theta, as_effects(free, values))
    r = whiten(sim.y - prediction)
    cost = 0.5 * float(r @ r)
    damping = 1e-3
    j = jacobian(sim, theta, free, values, prediction)
    done = 0
    while done < iterations:
        done += 1
        a, b = normal_equations(sim, whiten(j), r)
        scale = np.maximum(np.diag(a), 1e-9)
        improved = False
        for _ in range(6):
            step = _bounded_step(a + np.diag(damping * scale), b, values, low, high, configs)
            new_theta = np.clip(theta + step[:configs], THETA_LOW, THETA_HIGH)
            new_values = np.clip(values + step[configs:], low, high)
            new_prediction = sim.predict(new_theta, as_effects(free, new_values))
            new_r = whiten(sim.y - new_prediction)
            new_cost = 0.5 * float(new_r @ new_r)
            if new_cost < cost:
                improved = True
                break
            damping *= 8.0
        if not improved:
            break
        gain = cost - new_cost
        theta, values, prediction, r, cost = new_theta, new_values, new_prediction, new_r, new_cost
        damping = max(damping / 8.0, 1e-8)
        j = jacobian(sim, theta, free, values, prediction)
        if gain < TOLERANCE * cost and gain < 0.05:
            break
    return Fit(tuple(ids), tuple(free), theta, values, cost, prediction, sim.y - prediction, j, done)


def _bounded_step(a: Array, b: Array, values: Array, low: Array, high: Array, configs: int) -> Array:
    """Return the damped step, with parameters that would leave their bounds held on them."""
    step = np.zeros(len(b))
    active = np.ones(len(b), bool)
    for _ in range(len(values) + 1):
        index = np.flatnonzero(active)
        step[:] = 0.0
        step[index] = np.linalg.lstsq(a[np.ix_(index, index)], b[index], rcond=1e-12)[0]
        target = values + step[configs:]
        out = ((target < low - 1e-12) & (values <= low + 1e-12)) | ((target > high + 1e-12) & (values >= high - 1e-12))
        new = active.copy()
        new[configs:] &= ~out
        if (new == active).all():
            break
        active = new
    return step
