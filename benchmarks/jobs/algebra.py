"""The linear algebra of a diagnosis that is its own, against libraries that do the very same: first the numbers, then the time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.harness import Row, faster, paired
from benchmarks.peers import least_squares as plain
from benchmarks.peers import statespace
from sstl_cli.diagnosis.channels import _independent
from sstl_cli.diagnosis.constants import ENOUGH_NATS, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.fit import Array, Bounds, Fit, _bounded_step, _normal_equations, first_theta, fit, jacobian
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import CEILING_N, Simulator, _means
from sstl_cli.diagnosis.smoother import DIFFUSE, STATES, Reading, chain, costs, follow
from sstl_cli.diagnosis.starts import screen, starting
from sstl_cli.diagnosis.tries import costs_of
from sstl_cli.diagnosis.whitening import Noise, Sensor, whitener
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import simulate as step

# laws that both ways fit alike from each start that was tried; of the other eleven one or the other may stop on its way down
ALIKE = ("channel_delay", "channel_lowpass", "crosstalk", "gain_error", "pulley_friction", "sensor_nonlinearity", "viscous", "zero_drift")
EFFECT = {"pulley_friction": {"m_p": 0.08, "m_r": 0.06}}
SYSTEMS = ("act", "sstl")
TRIES = 5
# before so many samples the library has lost the error of the input to rounding: what is known there at first is 1e6 times as wide
LOST = 5


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare the filters, the smoother, normal equations, steps, fits and two sums."""
    del folder
    repeat = 1 if quick else 5
    samples, kept, rate = (2000, 1000, 10.0) if quick else (60_000, 12_000, 20.0)
    simulator = _simulator(rate)
    return [
        *_input(samples, repeat),
        *_output(simulator, repeat),
        *_normal(kept, repeat),
        *_steps(repeat),
        _fits(simulator, repeat),
        *_sums(simulator, samples, repeat),
    ]


def _row(name: str, job: str, against: str, own: Callable[[], object], peer: Callable[[], object], repeat: int, note: str = "") -> Row:
    ours, theirs = paired(own, peer, repeat)
    return Row(f"algebra/{name}", job, against, None, faster(ours, theirs), seconds={"ours": min(ours), "peer": min(theirs)}, note=note)


def _often(work: Callable[[], object], times: int) -> Callable[[], None]:
    """Return many calls as one: a single one is too short for the clock."""

    def calls() -> None:
        for _ in range(times):
            work()

    return calls


def _input(n: int, repeat: int) -> list[Row]:
    """Compare the likelihood and the smoother of the input."""
    rng = np.random.default_rng(0)
    y = 15.0 - 10.0 * np.cos(2.0 * np.pi * np.arange(n) / 6000.0) + 0.02 * rng.standard_normal(n)
    y, use, noise = y - y[0], rng.random(n) > 0.01, Reading(4e-4, 1e-4, 0.98)
    corners, bends = 10.0 ** rng.uniform(-10.0, -7.0, n), 10.0 ** rng.uniform(-13.0, -11.0, n)
    tries = [corners * f for f in np.geomspace(0.1, 10.0, TRIES)]
    peer, constant = statespace.Input(y, use, noise), 0.5 * float(use.sum()) * np.log(2.0 * np.pi)
    for mine, tried in zip(costs_of(y, use, noise, tries, [bends]), tries, strict=True):
        assert np.isclose(-mine - constant, peer.log_likelihood(tried, bends), rtol=1e-9)
    assert np.isclose(-costs(y, use, noise, corners, bends).sum() - constant, peer.log_likelihood(corners, bends), rtol=1e-9)
    _same_smoother(y, use, noise, corners, bends)
    job = f"smoother of the input, {n} samples"
    return [
        _row(
            "likelihood", f"{job}: likelihood", "statsmodels KalmanFilter.loglike, covariance of the steps varying in time",
            lambda: costs(y, use, noise, corners, bends), lambda: peer.log_likelihood(corners, bends), repeat,
        ),
        _row(
            "tries", f"{job}: {TRIES} likelihoods", f"the same, {TRIES} times", lambda: costs_of(y, use, noise, tries, [bends]),
            lambda: [peer.log_likelihood(tried, bends) for tried in tries], repeat,
        ),
        _row(
            "smoother", f"{job}: states and steps with errors", "statsmodels KalmanSmoother.smooth",
            lambda: follow(*chain(y, use, noise, corners, bends)), lambda: peer.smoothed(corners, bends), repeat,
            note=f"same numbers but for the errors of the first {LOST} samples, which the library loses to rounding",
        ),
        _row(
            "banded", f"{job}: states and steps with errors", "scipy.linalg.solveh_banded on all states at once, which has no errors",
            lambda: follow(*chain(y, use, noise, corners, bends)), lambda: plain.states(y, use, noise, (corners, bends), DIFFUSE), repeat,
        ),
    ]  # fmt: skip


def _same_smoother(y: Array, use: np.ndarray, noise: Reading, corners: Array, bends: Array) -> None:
    """Stop where states, errors, steps or the law of what stays unknown differ from those of the libraries."""
    law, drive = chain(y, use, noise, corners, bends)
    mean, variance, steps = follow(law, drive)
    found, (each, with_before) = (
        statespace.Input(y, use, noise).smoothed(corners, bends),
        statespace.Input(y, use, noise).across(corners, bends),
    )
    size = np.abs(mean).max(axis=0)
    assert np.all(np.abs(mean - found.mean)[LOST:] < 1e-9 * size) and np.all(np.abs(mean - found.mean)[:LOST] < 1e-6 * size)
    assert np.all(np.abs(mean - plain.states(y, use, noise, (corners, bends), DIFFUSE)).max(axis=0) < 1e-4 * size)
    assert np.allclose(variance[LOST:], found.variance[LOST:], rtol=1e-6) and np.allclose(variance[:LOST], found.variance[:LOST], rtol=0.02)
    assert np.all(np.abs(steps[1:] - found.steps).max(axis=0) < 1e-8 * np.abs(steps).max(axis=0))
    now = np.zeros((STATES, STATES))
    for k, row in enumerate(law):
        move, new = row[: STATES**2].reshape(STATES, STATES), np.zeros((STATES, STATES))
        new[np.triu_indices(STATES)] = row[STATES**2 :]
        across, before = move @ now, np.sqrt(np.diag(now))
        now = across @ move.T + new + np.triu(new, 1).T
        if k >= LOST:
            error = np.sqrt(np.diag(now))
            assert np.all(np.abs(now - each[k]) < 1e-6 * np.outer(error, error))
            assert np.all(np.abs(across - with_before[k - 1]) < 1e-6 * np.outer(error, before))


def _simulator(rate: float) -> Simulator:
    runs = list(step.run(load("default").model_copy(update={"sampling_hz": rate}), EFFECT, 1))
    return Simulator(prepare(runs), Scenario().rig.mechanics())


def _base(sim: Simulator) -> Fit:
    """Return the fit of theta alone, with the noise that the recording was made with or nearly so."""
    theta = first_theta(sim, np.full(len(sim.problem.configs), 0.53))
    sensors = dict.fromkeys(SYSTEMS, Sensor(0.02, 0.01, 0.1))
    noise = Noise(sensors, sensors, dict.fromkeys(SYSTEMS, 1.0))
    whiten = whitener(constants(sim.problem.records, noise), sim.where_noise_enters(theta, {}, noise))
    return fit(sim, whiten, Hypothesis((), ()), theta, np.zeros(0))


def _output(sim: Simulator, repeat: int) -> list[Row]:
    """Compare the filter of the output where phases are given: it is linear there."""
    sensors = dict.fromkeys(SYSTEMS, Sensor(0.02, 0.01, 0.1))
    noise = Noise(sensors, sensors, dict.fromkeys(SYSTEMS, 1.0))
    theta = first_theta(sim, np.full(len(sim.problem.configs), 0.53))
    phases, known = sim.where_noise_enters(theta, {}, noise), constants(sim.problem.records, noise)
    white_n = np.hypot(known.white_n, phases.slide * phases.gain * known.jitter_n)
    peer = statespace.Output(known.error_law, known.own.columns, phases.columns, (white_n, known.start, known.keep, known.first))
    residual = sim.y - sim.predict(theta, {})
    columns = np.column_stack((residual, np.random.default_rng(0).standard_normal((len(residual), 3))))
    whiten = whitener(known, phases)
    z = whiten(columns)
    assert np.allclose(z, peer.whitened(columns), rtol=0.0, atol=1e-10 * float(np.abs(z).max()))
    constant = 0.5 * float(known.keep.sum()) * np.log(2.0 * np.pi)
    assert np.isclose(-0.5 * (float(z[:, 0] @ z[:, 0]) + whiten.log_det) - constant, peer.log_likelihood(residual), rtol=1e-9)
    job = f"filter of the output at given phases, {len(residual)} samples"
    return [
        _row(
            "output", f"{job}: likelihood", "statsmodels KalmanFilter.loglike, all matrices varying in time",
            lambda: whitener(known, phases).left(residual), lambda: peer.log_likelihood(residual), repeat,
        ),
        _row(
            "columns", f"{job}: residual and {columns.shape[1] - 1} columns", "statsmodels KalmanFilter.filter, column by column",
            lambda: whitener(known, phases)(columns), lambda: peer.whitened(columns), repeat,
        ),
    ]  # fmt: skip


def _normal(kept: int, repeat: int) -> list[Row]:
    """Compare normal equations, of many configurations and parameters and of the few that are usual."""
    rows = []
    for name, n, configs, free, ways in (
        ("normal", kept, 10, 12, ("dense", "sparse", "blocks")),
        ("usual", min(8400, kept), 2, 2, ("dense", "sparse", "blocks")),
    ):
        rng = np.random.default_rng(1)
        config, j, r = np.sort(rng.integers(0, configs, n)), rng.standard_normal((n, 1 + free)), rng.standard_normal(n)
        own = _normal_equations(config, configs, j, r)
        for way in ways:
            peer = getattr(plain, way)
            assert all(np.allclose(a, b, rtol=1e-9, atol=1e-9) for a, b in zip(own, peer(config, configs, j, r), strict=True))
            against = {"dense": "numpy, dense", "sparse": "scipy.sparse", "blocks": "numpy block by block (bincount and BLAS)"}[way]
            rows.append(
                _row(
                    f"{name}-{way}", f"normal equations, {n} samples, {configs} configurations, {free} parameters", against,
                    _often(lambda c=config, k=configs, j=j, r=r: _normal_equations(c, k, j, r), 20),
                    _often(lambda f=peer, c=config, k=configs, j=j, r=r: f(c, k, j, r), 20), repeat,
                )
            )  # fmt: skip
    return rows


def _steps(repeat: int) -> list[Row]:
    """Compare a step that one bound holds back: where more are reached on the way, own steps are cut there and tried."""
    rows = []
    for configs, free in ((10, 12), (2, 2)):
        j = np.random.default_rng(2).standard_normal((200, configs + free))
        a, b = j.T @ j, np.ones(configs + free)
        # the last parameter stands on its bound and is pulled out of its range
        b[-1] = -50.0
        bounds, values = Bounds(np.zeros(free), np.full(free, 9.0)), np.full(free, 4.0)
        values[-1] = 0.0
        low = np.concatenate((np.full(configs, -np.inf), bounds.low - values))
        high = np.concatenate((np.full(configs, np.inf), bounds.high - values))
        given = (a, b, values, bounds, configs)
        assert np.allclose(_bounded_step(*given), plain.step(a, b, low, high), rtol=1e-8, atol=1e-12)
        rows.append(
            _row(
                f"step-{free}", f"bounded step, {configs} configurations, {free} parameters", "scipy.optimize.lsq_linear (bvls)",
                _often(lambda g=given: _bounded_step(*g), 50), _often(lambda a=a, b=b, lo=low, hi=high: plain.step(a, b, lo, hi), 50), repeat,
            )
        )  # fmt: skip
    return rows


def _fits(sim: Simulator, repeat: int) -> Row:
    """Compare whole fits with one whitener, from one start each."""
    base = _base(sim)
    jobs = [(h, screen(sim, base, h)[1]) for h in (starting(e, SYSTEMS)[0] for e in ALIKE)]

    def own() -> list[float]:
        return [fit(sim, base.whiten, h, base.theta, begin).cost for h, begin in jobs]

    def peer() -> list[float]:
        return [_scipy(sim, base, h, begin) for h, begin in jobs]

    # either ends where a step gains less than so much, so that each may be off its minimum by about that
    near = 2.0 * ENOUGH_NATS
    assert np.allclose(own(), peer(), rtol=0.0, atol=near)
    job = f"bounded fits of {len(jobs)} laws that end alike, {len(sim.y)} samples"
    return _row(
        "fit", job, "scipy.optimize.least_squares (trf), the same model, whitener and slopes", own, peer, repeat,
        note=f"costs are the same to {near:g} nats; most of both is the model",
    )  # fmt: skip


def _scipy(sim: Simulator, base: Fit, h: Hypothesis, begin: Array) -> float:
    """Return the cost (nats) at which scipy's fit ends."""
    configs, w = len(base.theta), base.whiten
    # both ask for the slopes where the residual has just been asked for
    last: dict[bytes, Array] = {}

    def predicted(x: Array) -> Array:
        key = x.tobytes()
        if key not in last:
            last.clear()
            last[key] = sim.predict(x[:configs], as_effects(h.free, x[configs:]))
        return last[key]

    def slopes(x: Array) -> Array:
        j = jacobian(sim, x[:configs], h.free, x[configs:], predicted(x))
        return -plain.spread(sim.config, configs, w(j))

    low = np.concatenate((np.full(configs, THETA_LOW), [f.parameter.least for f in h.free]))
    high = np.concatenate((np.full(configs, THETA_HIGH), [f.parameter.most for f in h.free]))
    # trf begins inside of its bounds
    start = np.clip(np.concatenate((base.theta, begin)), low + 1e-9, high - 1e-9)
    flat = 0.5 * ENOUGH_NATS / (base.cost - 0.5 * w.log_det)
    found = plain.fitted(lambda x: w.left(sim.y - predicted(x)), slopes, start, (low, high), flat)
    return float(found.cost) + 0.5 * w.log_det


def _sums(sim: Simulator, n: int, repeat: int) -> list[Row]:
    """Compare means of blocks and the count of independent samples."""
    fine = np.random.default_rng(3).standard_normal(n)
    share, runs, factor = np.full(n, 0.5), 20, 2
    edges, fine_edges = np.linspace(0, n // factor, runs + 1).astype(np.int64), np.linspace(0, n, runs + 1).astype(np.int64)
    factors, begins = np.full(runs, factor), np.arange(0, n, factor)
    own = _means(fine, share, fine_edges, edges, factors)
    assert np.allclose(own, plain.means(fine, share, begins, CEILING_N), rtol=1e-12)
    coloured = sim.y - sim.y.mean()
    assert np.isclose(_independent(coloured), plain.independent(coloured), rtol=1e-9)
    return [
        _row(
            "means", f"means of blocks, {n} samples", "numpy.add.reduceat",
            _often(lambda: _means(fine, share, fine_edges, edges, factors), 20),
            _often(lambda: plain.means(fine, share, begins, CEILING_N), 20), repeat,
        ),
        _row(
            "independent", f"independent samples by autocorrelation, {len(coloured)} samples", "statsmodels acf",
            _often(lambda: _independent(coloured), 5), _often(lambda: plain.independent(coloured), 5), repeat,
        ),
    ]  # fmt: skip
