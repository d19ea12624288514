"""Bounded Gauss-Newton fit of theta per configuration and the parameters of candidate effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import (
    DAMPING,
    DAMPING_FACTOR,
    DAMPINGS,
    EDGE,
    ENOUGH_NATS,
    JUMPS,
    KEPT_PROMISE,
    MAX_ITERATIONS,
    PARAMETER_STEP,
    SHARES,
    START_FACTORS,
    THETA_HIGH,
    THETA_LOW,
    THETA_STEP,
)
from sstl_cli.diagnosis.free import Bounds, Free, as_effects, bounds_of
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.simulator import Effects, Simulator
from sstl_cli.diagnosis.whitening import Noise, Whitener, whitener
from sstl_cli.physics.effect import TRANSITION

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


class _Place(NamedTuple):
    """Parameters, what is predicted there (N), what that leaves (whitened), and the part of the cost that depends on them (nats)."""

    theta: Array
    values: Array
    prediction: Array
    left: Array
    cost: float


@dataclass(frozen=True)
class Fit:
    """A fitted model: parameters, cost (minus log likelihood, nats) and its compact Jacobian.

    ``jacobian`` has one column for the theta of the sample's own configuration, then one per free parameter;
    ``discrepancy`` is the share of its own response by which the law may be off.
    """

    hypothesis: Hypothesis
    theta: Array
    values: Array
    cost: float
    prediction: Array
    residual: Array
    jacobian: Array
    whiten: Whitener
    discrepancy: float = 0.0

    @property
    def ids(self) -> tuple[str, ...]:
        return self.hypothesis.ids

    @property
    def free(self) -> tuple[Free, ...]:
        return self.hypothesis.free

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        return as_effects(self.free, self.values)

    def nats(self, residual: Array) -> float:
        """Return the cost (minus log likelihood, nats) of a residual (N) of this model."""
        z = self.whiten.left(residual)
        return 0.5 * float(z @ z) + 0.5 * self.whiten.log_det

    def at_bound(self, i: int) -> bool:
        """Whether free parameter ``i`` lies on or outside the range in which it is usually found; a strength that is all there is does not."""
        p, v = self.free[i].parameter, self.values[i]
        edge = EDGE * self.free[i].width
        whole = not p.shape and p.high == p.most
        return (v <= p.low + edge and p.low != p.neutral) or (v >= p.high - edge and p.high != p.neutral and not whole)


def jacobian(sim: Simulator, theta: Array, free: Sequence[Free], values: Array, base: Array) -> Array:
    """Return d prediction / d (own theta, free parameters), shape (samples, 1 + k), by one-sided differences.

    Runs of different configurations do not touch one another, so all thetas share one simulation.
    """
    return _slopes(sim, theta, free, values, base, range(len(free)), THETA_STEP)


def partial(sim: Simulator, theta: Array, free: Sequence[Free], values: Array, base: Array, which: Sequence[int]) -> Array:
    """Return d prediction / d (some of the free parameters), shape (samples, len(which))."""
    return _slopes(sim, theta, free, values, base, which)


def _slopes(
    sim: Simulator, theta: Array, free: Sequence[Free], values: Array, base: Array, which: Sequence[int], own: float = 0.0
) -> Array:
    """Return one-sided differences over a step ``own`` of all thetas, where there is one, then over those of free parameters.

    All that is moved is simulated at once: side by side lines cost little more than one.
    """
    steps, models = [], []
    if own:
        steps.append(own)
        models.append((theta + own, as_effects(free, values)))
    for k in which:
        h = PARAMETER_STEP * free[k].width
        if values[k] + h > free[k].parameter.most:
            h = -h
        moved = values.copy()
        moved[k] += h
        steps.append(h)
        models.append((theta, as_effects(free, moved)))
    columns = np.empty((len(base), len(steps)))
    for i, (h, moved) in enumerate(zip(steps, sim.predict_each(models), strict=True)):
        columns[:, i] = (moved - base) / h
    return columns


def first_theta(sim: Simulator, nominal: Array, effects: Effects = MappingProxyType({})) -> Array:
    """Return for each configuration the start of theta that explains most: a fit that starts in an endless hold stays there.

    Parameters
    ----------
    nominal : ndarray, shape (configurations,)
    effects : mapping, optional
        What the model has beside theta.
    """
    tries = [np.clip(nominal * f, THETA_LOW, THETA_HIGH) for f in START_FACTORS]
    errors = []
    for theta in tries:
        r2 = sim.weight * (sim.y - sim.predict(theta, effects)) ** 2
        errors.append(np.bincount(sim.config, r2, len(nominal)))
    best = np.argmin(np.array(errors), axis=0)
    first: Array = np.array(tries)[best, np.arange(len(nominal))]
    return first


def normal_equations(sim: Simulator, j: Array, r: Array) -> tuple[Array, Array]:
    """Return J'J and J'r with theta expanded to one column per configuration."""
    return _normal_equations(sim.config, len(sim.problem.configs), np.ascontiguousarray(j), r)


def held(a: Array, fixed: NDArray[np.int64], off: Array) -> tuple[float, Array]:
    """Return what it costs (nats, to second order) to move some parameters of a fit, and by how much the others then go the other way.

    Parameters
    ----------
    a : ndarray, shape (k, k)
        Curvature of the cost (see :func:`normal_equations`).
    fixed : ndarray of int, shape (m,)
        Which are moved.
    off : ndarray, shape (m,)
        By how much.

    Returns
    -------
    float and ndarray, shape (k - m,)
    """
    loose = np.setdiff1d(np.arange(len(a)), fixed)
    cross = np.asarray(np.linalg.solve(a[np.ix_(loose, loose)], a[np.ix_(loose, fixed)] @ off), np.float64)
    return 0.5 * float(off @ (a[np.ix_(fixed, fixed)] @ off - a[np.ix_(fixed, loose)] @ cross)), cross


@njit(cache=True, nogil=True)
def _normal_equations(config: Counts, configs: int, j: Array, r: Array) -> tuple[Array, Array]:
    free = j.shape[1] - 1
    a, b = np.zeros((configs + free, configs + free)), np.zeros(configs + free)
    for t in range(r.size):
        c, own = config[t], j[t, 0]
        a[c, c] += own * own
        b[c] += own * r[t]
        for k in range(free):
            x, at = j[t, 1 + k], configs + k
            a[at, c] += x * own
            b[at] += x * r[t]
            for i in range(k + 1):
                a[at, configs + i] += x * j[t, 1 + i]
    for k in range(1, configs + free):
        for i in range(k):
            a[i, k] = a[k, i]
    return a, b


def fit(
    sim: Simulator,
    whiten: Whitener,
    hypothesis: Hypothesis,
    theta: Array,
    values: Array,
    iterations: int = MAX_ITERATIONS,
    known: Fit | None = None,
    careful: bool = False,
) -> Fit:
    """Return the bounded least-squares fit started at ``theta`` and ``values``, with one whitener.

    Parameters
    ----------
    theta : ndarray, shape (configurations,)
    values : ndarray, shape (k,)
        Start of the free parameters, in the order of the hypothesis.
    known : Fit, optional
        A fit of the same hypothesis that stands at the start, whose prediction and Jacobian then need not be made again.
    careful : bool
        Whether slopes are made afresh at every step: few steps from a poor start lead further by them.
    """
    free = hypothesis.free
    bounds = bounds_of(free, sim.read_n)
    at = _place(
        sim, whiten, free, theta, values if known else np.clip(values, bounds.low, bounds.high), known.prediction if known else None
    )
    damping = DAMPING
    # what acts along the line answers by jerks: what a step has done there says little of the next one
    careful = careful or any(x.effect.stage == TRANSITION for x in free)
    j = known.jacobian.copy() if known else jacobian(sim, theta, free, values, at.prediction)
    fresh = True
    for _ in range(iterations):
        a, b = normal_equations(sim, whiten(j), at.left)
        scale = np.maximum(np.diag(a), 1e-9)
        new, promised, damping = _step(sim, whiten, free, at, (a, b, scale), bounds, damping)
        gain = at.cost - new.cost
        told = not careful and gain >= KEPT_PROMISE * promised
        if gain > 0.0:
            moved = np.concatenate((new.theta - at.theta, new.values - at.values))
            if gain >= ENOUGH_NATS and told:
                _secant(sim.config, j, new.prediction - at.prediction, moved, scale)
            at = new
            damping = max(damping / DAMPING_FACTOR, 1e-8)
        if gain >= ENOUGH_NATS and told:
            fresh = False
        elif fresh and gain < ENOUGH_NATS:
            # slopes are those of a place less than ENOUGH_NATS away
            break
        else:
            damping = damping if gain > 0.0 else DAMPING
            j, fresh = jacobian(sim, at.theta, free, at.values, at.prediction), True
    if not fresh:
        j = jacobian(sim, at.theta, free, at.values, at.prediction)
    return Fit(hypothesis, at.theta, at.values, at.cost + 0.5 * whiten.log_det, at.prediction, sim.y - at.prediction, j, whiten)


def _place(sim: Simulator, whiten: Whitener, free: Sequence[Free], theta: Array, values: Array, prediction: Array | None = None) -> _Place:
    """Return what the simulator predicts at parameters, if that is not known, and what it leaves."""
    prediction = sim.predict(theta, as_effects(free, values)) if prediction is None else prediction
    left = whiten.left(sim.y - prediction)
    return _Place(theta, values, prediction, left, 0.5 * float(left @ left))


def _step(
    sim: Simulator, whiten: Whitener, free: Sequence[Free], at: _Place, normal: tuple[Array, Array, Array], bounds: Bounds, damping: float
) -> tuple[_Place, float, float]:
    """Return where the first damped step leads that gains, what it promised (nats), and its damping; the same place where none does."""
    a, b, scale = normal
    configs, promised = len(at.theta), 0.0
    for attempt in range(DAMPINGS):
        step = _bounded_step(a + np.diag(damping * scale), b, at.values, bounds, configs)
        promised = float(b @ step - 0.5 * step @ a @ step)
        # a shorter step that promises next to nothing is not worth a look
        if attempt and promised < ENOUGH_NATS:
            break
        theta = np.clip(at.theta + step[:configs], THETA_LOW, THETA_HIGH)
        new = _place(sim, whiten, free, theta, np.clip(at.values + step[configs:], bounds.low, bounds.high))
        if new.cost < at.cost:
            return new, promised, damping
        damping *= DAMPING_FACTOR
    return at, promised, damping


@njit(cache=True, nogil=True)
def _secant(config: Counts, j: Array, moved_n: Array, step: Array, scale: Array) -> None:
    """Turn a Jacobian, in place, so that it says what a step has done (Broyden 1965), each configuration by its own step.

    What it said wrong is put down to parameters as they have moved the answer, ``scale`` times the square of their step.
    """
    n, free = moved_n.size, j.shape[1] - 1
    configs = step.size - free
    total = 0.0
    for k in range(configs, step.size):
        total += scale[k] * step[k] * step[k]
    for t in range(n):
        c = config[t]
        whole = total + scale[c] * step[c] * step[c]
        if whole <= 0.0:
            continue
        off = moved_n[t] - j[t, 0] * step[c]
        for k in range(free):
            off -= j[t, 1 + k] * step[configs + k]
        off /= whole
        j[t, 0] += off * scale[c] * step[c]
        for k in range(free):
            j[t, 1 + k] += off * scale[configs + k] * step[configs + k]


def settle(sim: Simulator, noise: Noise, start: Fit, rounds: int = 2, iterations: int = MAX_ITERATIONS, judged: bool = False) -> Fit:
    """Return a fit whose noise follows its own phases and its own discrepancy: whitened by them, fitted, and again.

    No law is exact: what an effect adds to the base may be off by a share of itself (Kennedy and O'Hagan 2001). The share is
    the most likely of a few; a large one costs as much as it makes the noise larger. A ``judged`` start has been settled before.
    """
    found = best = start if judged else _judged(sim, noise, start)
    for _ in range(rounds):
        before = found.cost
        moved = fit(sim, found.whiten, found.hypothesis, found.theta, found.values, iterations, found)
        found = _judged(sim, noise, moved)
        # phases of its own may make a better fit less likely than it was by those it was fitted with
        best = min(best, found, key=lambda f: f.cost)
        if abs(before - found.cost) < ENOUGH_NATS:
            break
    return best


def jumping(f: Fit) -> set[str]:
    """Return the effects of a fit that predict a mean over jumps."""
    return {x.effect.id for x in f.free if x.parameter.name in x.effect.averaged}


def own_response(sim: Simulator, f: Fit) -> Array:
    """Return how far (N, shape (samples,)) the effects of a fit, or those of them that jump, move what it predicts."""
    jumps = jumping(f)
    rest = {k: v for k, v in f.effects.items() if k not in jumps} if jumps else {}
    return np.abs(f.prediction - sim.predict(f.theta, rest)) if f.free else np.zeros(len(f.residual))


def _judged(sim: Simulator, noise: Noise, f: Fit) -> Fit:
    """Return a fit with its own whitener and cost; its share is sought from the one it has."""
    phases = sim.where_noise_enters(f.theta, f.effects, noise)
    known = sim.constants(f.effects, noise)
    jumps = jumping(f)
    added = own_response(sim, f)

    def judged(share: float) -> Fit:
        if jumps:
            # a jump is as new at every step of a slide, and in a hold what the last one left; what stands beside does not jump
            own = whitener(known, phases.jumping(share * added), residual=f.residual, output=sim.y if sim.rests else None)
        else:
            own = whitener(known, phases, share * added if f.free else None, residual=f.residual)
        tried = replace(f, whiten=sim.jerky(own, f.residual), discrepancy=share)
        return replace(tried, cost=tried.nats(f.residual))

    if jumps and sim.rests:
        # a line that is seen to jump may do so about its mean, and jump by far more than that loses
        return _most_likely(judged, sorted({*JUMPS, *(share / JUMPS[0] for share in JUMPS)}), None)
    return _most_likely(judged, JUMPS if jumps else SHARES if f.free else SHARES[:1], f.discrepancy)


def _most_likely(judged: Callable[[float], Fit], shares: Sequence[float], begin: float | None) -> Fit:
    """Return the fit with the most likely share: of all, or from one on as long as its neighbours are more likely."""
    if begin is None or begin not in shares:
        return min((judged(share) for share in shares), key=lambda f: f.cost)
    at = shares.index(begin)
    best = judged(begin)
    for step in (1, -1):
        place = at
        while 0 <= (place := place + step) < len(shares):
            tried = judged(shares[place])
            if tried.cost >= best.cost:
                break
            best = tried
        if best.discrepancy != begin:
            break
    return best


def _bounded_step(a: Array, b: Array, values: Array, bounds: Bounds, configs: int) -> Array:
    """Return the damped step, with parameters that would leave their bounds held on them."""
    step = np.zeros(len(b))
    active = np.ones(len(b), bool)
    low, high = bounds
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
