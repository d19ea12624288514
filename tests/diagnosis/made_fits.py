"""Small records made by the fast model itself, with the residual that a test wants."""

from __future__ import annotations

from functools import cache

import numpy as np

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.fit import Fit, jacobian
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import Hypothesis, variants
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.scenario import Scenario

NOISE_N, THETA = 0.02, np.array([0.5, 0.6])
NOTHING = Hypothesis((), ())


@cache
def simulator() -> Simulator:
    """Return four runs of 40 s at 50 Hz, two configurations; their output is never read."""
    t = np.arange(0.0, 40.0, 0.02)
    rng = np.random.default_rng(7)
    runs = []
    for i, period in enumerate((7.0, 11.0, 9.0, 13.0)):
        u = 12.0 + 9.0 * np.sin(2.0 * np.pi * t / period + i)
        noise = 0.01 * rng.standard_normal((2, len(t)))
        runs.append(Run(f"run{i}", "act", t, u + noise[0], 0.6 * u + noise[1], config_id="ab"[i % 2]))
    return Simulator(prepare(runs), Scenario().rig.mechanics())


def made(left: np.ndarray | float = 0.0, h: Hypothesis = NOTHING, values: tuple[float, ...] = (), noise_n: float = NOISE_N) -> Fit:
    """Return the fit that left the given residual (N, shape (samples,))."""
    sim, at = simulator(), np.array(values)
    prediction = sim.predict(THETA, as_effects(h.free, at))
    whiten = white(noise_n, sim.weight, [s.start for s in sim.slices()])
    residual = np.broadcast_to(np.asarray(left, float), prediction.shape)
    z = whiten(np.array(residual))
    cost = 0.5 * float(z @ z) + 0.5 * whiten.log_det
    return Fit(h, THETA, at, cost, prediction, np.array(residual), jacobian(sim, THETA, h.free, at, prediction), whiten)


def noise(seed: int = 0) -> np.ndarray:
    return NOISE_N * np.random.default_rng(seed).standard_normal(len(simulator().y))


def named(effect_id: str, *names: str) -> Hypothesis:
    """Return the hypothesis of an effect that has just these parameters free."""
    return next(h for h in variants(effect_id, ("act",)) if [f.parameter.name for f in h.free] == list(names))


def thetas(f: Fit) -> np.ndarray:
    """Return the whitened columns of one theta a configuration, shape (samples, 2)."""
    sim = simulator()
    own = np.zeros((len(sim.y), 2))
    own[np.arange(len(sim.y)), sim.config] = f.jacobian[:, 0]
    return f.whiten(own)


def gained(columns: np.ndarray, others: np.ndarray, x: np.ndarray) -> float:
    """Return by how much columns lower half the square of ``x`` beside others."""

    def left(j: np.ndarray) -> float:
        return 0.5 * float(np.sum((x - j @ np.linalg.lstsq(j, x, rcond=None)[0]) ** 2))

    return left(others) - left(np.column_stack((others, columns)))
