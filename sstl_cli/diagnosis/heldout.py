"""Held-out errors: whole configurations or trajectory kinds are left out, parameters come from the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import ALL_COUNT, BLOCK_S, DAMPING, DAMPING_FACTOR, DAMPINGS, MAX_FOLDS, PARTS, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.records import Problem
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Folds:
    """Which fold each sample belongs to, what was held out, and whether that is new excitation."""

    of_sample: NDArray[np.int64]
    count: int
    kind: str
    honest: bool


def make_folds(sim: Simulator) -> Folds:
    """Return folds of other trajectories where there are several, else configurations, runs or halves.

    Holding out repeats of one excitation protects against nothing, so it is said (``honest`` False).
    """
    p: Problem = sim.problem
    trajectories = sorted({r.trajectory for r in p.records})
    if len(trajectories) > 1:
        label = [trajectories.index(r.trajectory) for r in p.records]
        kind, honest = "trajectory", True
    elif len(p.configs) > 1:
        label = [r.config for r in p.records]
        kind, honest = "configuration", True
    elif len(p.records) > 1:
        label = list(range(len(p.records)))
        kind, honest = "run", False
    else:
        half = (np.arange(len(sim.y)) * PARTS // len(sim.y)).astype(np.int64)
        return Folds(half, PARTS, "part of the only run", False)
    fold = np.array(label, np.int64) % MAX_FOLDS
    return Folds(fold[sim.run], int(fold.max()) + 1, kind, honest)


def held_out_residual(sim: Simulator, f: Fit, folds: Folds) -> Array:
    """Return the residual (N, shape (samples,)) with each fold predicted from the others.

    Parameters move by one Gauss-Newton step from the fit of all data to that of the training part, beside which all data count a
    little (a power prior, Ibrahim and Chen 2000): what a training part does not tell at all it does not foretell wrongly. The
    theta of a configuration that is held out as a whole is fitted to it, for base and candidates alike, and so is what is a
    run's own.
    Where the training part holds a parameter so loosely that it does not fit better for the step when simulated,
    the step is damped as in any fit, and what it predicts is simulated, too.
    """
    if not f.hypothesis.foretold:
        return f.residual
    whitened = (f.whiten(f.jacobian), f.whiten.left(f.residual))
    beforehand = ALL_COUNT * normal_equations(sim, *whitened)[0]
    raw = f.residual.copy()
    for fold in range(folds.count):
        out = folds.of_sample == fold
        if not out.any():
            continue
        loose = _step(sim, f, whitened, beforehand, out)
        if _training(f, _moved(sim, f, loose), out) <= float(np.sum(whitened[1][~out] ** 2)):
            configs = len(f.theta)
            raw[out] -= f.jacobian[out, 1:] @ loose[configs:] + f.jacobian[out, 0] * loose[:configs][sim.config[out]]
            continue
        tries = [
            f.residual,
            *(_moved(sim, f, _step(sim, f, whitened, beforehand, out, d)) for d in DAMPING * DAMPING_FACTOR ** np.arange(DAMPINGS)),
        ]
        raw[out] = min(tries, key=lambda left: _training(f, left, out))[out]
    return raw


def predicted_nats(sim: Simulator, f: Fit, folds: Folds) -> float:
    """Return the cost (minus log likelihood, nats) of every fold as the others foretell it, parameters as uncertain as they leave them.

    Linear around the fit; beforehand a parameter is normal about nothing with its usual range as standard deviation, theta
    anything. What the others do not tell of a parameter costs what it costs where nothing is held out.
    """
    j, r = f.whiten(f.jacobian), f.whiten.left(f.residual)
    configs = len(f.theta)
    # in units of what is expected of each beforehand, where the others tell nothing the information is none and not below
    usual = np.concatenate((np.full(configs, THETA_HIGH - THETA_LOW), [x.width for x in f.free]))
    pull = np.concatenate((np.zeros(configs), f.values - [x.parameter.neutral for x in f.free])) / usual

    def cost(samples: Mask) -> float:
        a, b = normal_equations(sim, j * samples[:, None], r)
        told, way = np.linalg.eigh(usual[:, None] * a * usual)
        # as in the rank of a matrix: what rounding makes of nothing is nothing
        known = 1.0 + np.where(told > len(told) * np.finfo(float).eps * told[-1], told, 0.0)
        along = (usual * b - pull) @ way
        return 0.5 * float(r[samples] @ r[samples] - np.sum(along**2 / known) + np.sum(np.log(known)))

    whole = cost(np.ones(len(r), bool))
    parts = [folds.of_sample == k for k in range(folds.count)]
    return 0.5 * f.whiten.log_det + sum(whole - cost(~out) for out in parts if out.any())


class HeldOut:
    """Held-out residuals of the models of one search: what the verdict asks for and what the document shows is worked out once."""

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self.folds = make_folds(sim)
        # with the fit itself, so that no other one can take its place in memory
        self._known: dict[int, tuple[Fit, Array]] = {}

    def residual(self, f: Fit) -> Array:
        """Return the residual (N, shape (samples,)) of a fit with each fold predicted from the others."""
        if id(f) not in self._known:
            self._known[id(f)] = (f, held_out_residual(self._sim, f, self.folds))
        return self._known[id(f)][1]

    def nats(self, f: Fit) -> float:
        """Return the cost (nats) of every fold as the others foretell it."""
        return predicted_nats(self._sim, f, self.folds)


def _training(f: Fit, residual: Array, out: Mask) -> float:
    """Return the squared whitened residual of what is not held out."""
    return float(np.sum(f.whiten.left(residual)[~out] ** 2))


def _moved(sim: Simulator, f: Fit, step: Array) -> Array:
    """Return the residual (N) of a fit whose parameters move by a step, as simulated."""
    theta = np.clip(f.theta + step[: len(f.theta)], THETA_LOW, THETA_HIGH)
    return np.asarray(f.residual + f.prediction - sim.predict(theta, as_effects(f.free, f.values + step[len(f.theta) :])))


def _step(sim: Simulator, f: Fit, whitened: tuple[Array, Array], beforehand: Array, out: Mask, damping: float = 1e-9) -> Array:
    """Return the step of theta and parameters to the fit of what is not held out, with the information there is beforehand."""
    (jw, rw), configs = whitened, len(f.theta)
    low = np.array([x.parameter.least for x in f.free])
    high = np.array([x.parameter.most for x in f.free])
    a, b = normal_equations(sim, jw * ~out[:, None], rw)
    seen = np.diag(a)[:configs] > 1e-9
    a = a + beforehand
    index = np.concatenate((np.flatnonzero(seen), np.arange(configs, len(b))))
    step = np.zeros(len(b))
    inner = a[np.ix_(index, index)]
    step[index] = np.linalg.lstsq(inner + damping * np.diag(np.diag(inner) + 1e-12), b[index], rcond=1e-10)[0]
    step[configs:] = np.clip(f.values + step[configs:], low, high) - f.values
    for c in np.flatnonzero(~seen):
        rows = np.flatnonzero(out)[sim.config[out] == c]
        if len(rows):
            column = jw[rows, 0]
            local = rw[rows] - jw[rows, 1:] @ step[configs:]
            step[c] = float(column @ local) / max(float(column @ column), 1e-12)
    return step


def blocks(sim: Simulator) -> NDArray[np.int64]:
    """Return the index of the time block (about 5 s, within one run) of each sample."""
    parts, offset = [], 0
    for r in sim.problem.records:
        parts.append(offset + np.arange(len(r)) // max(1, round(BLOCK_S / (r.dt_s * r.factor))))
        offset = int(parts[-1][-1]) + 1 if len(r) else offset
    return np.concatenate(parts)
