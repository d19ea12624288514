"""Laplace evidence of a fitted model: what it gains, less what its freedom would gain by chance.

A priori the size of an effect's response, in standard deviations of the noise, is anything from a tenth to a hundred
alike in every decade, and its direction among the effect's parameters is uniform. Over the posterior normal distribution
this leaves, for k strengths and a response of D, the charge k ln D + ln(S_k L / (2 pi)^(k/2)), where S_k is the surface of
the unit sphere and L the logarithm of the range; several effects are charged for looking alike as well. It knows neither units nor ranges of the parameters, so that two
effects that explain the same are charged the same. Shapes (time constants, exponents) are uniform over their own range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from sstl_cli.diagnosis.constants import LOG_RANGE, START_FACTORS, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.fit import Fit, held, normal_equations
from sstl_cli.diagnosis.free import Free
from sstl_cli.diagnosis.hypotheses import GAIN
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import NOMINAL_THETA

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Weighed:
    """A fit with its gain over the base and its evidence (nats, base 0)."""

    fit: Fit
    gain: float
    evidence: float

    @property
    def ids(self) -> tuple[str, ...]:
        return self.fit.ids


def strengths_charge(k: int, d2: float) -> float:
    """Return what k strengths with a response of squared size ``d2`` cost (nats)."""
    if k == 0:
        return 0.0
    surface = np.log(2.0) + 0.5 * k * np.log(np.pi) - gammaln(0.5 * k)
    return float(0.5 * k * np.log(max(d2, 1.0)) + surface + np.log(LOG_RANGE) - 0.5 * k * np.log(2.0 * np.pi))


def shape_charge(free: Free, value: float, se: float) -> float:
    """Return what a shape costs (nats): its range over the width in which the data hold it, on its natural scale."""
    p = free.parameter
    if p.low > 0.0:
        width, spread = float(np.log(p.high / p.low)), se / max(abs(value), 1e-12)
    else:
        width, spread = p.high - p.low, se
    return float(max(np.log(width / max(np.sqrt(2.0 * np.pi) * spread, 1e-6 * width)), 0.0)) if spread > 0.0 else 0.0


def information(sim: Simulator, f: Fit) -> Array:
    """Return the information on theta and the free parameters, shape (k, k)."""
    a, _ = normal_equations(sim, f.whiten(f.jacobian), np.zeros(len(sim.y)))
    # a direction without information has no limit: a ridge far below the others keeps the inverse finite
    return np.asarray(a + 1e-10 * np.diag(np.diag(a)) + 1e-12 * np.eye(len(a)))


def inverse(a: Array, ridge: float = 0.0) -> Array:
    """Return the inverse of an information matrix, shape (k, k), each parameter in a unit of its own size and a ridge (a share of it) beside it.

    Weights of parameters differ by twenty decades as they stand (N s/mm beside rad), and what rounding then cuts off would look
    as if it were known exactly.
    """
    a = a + ridge * np.diag(np.diag(a) + 1e-12)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(a), np.finfo(float).tiny))
    both = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(a * both, hermitian=True) * both)


def standard_errors(f: Fit, known: Array) -> Array:
    """Return the standard errors of the free parameters, theta free as well, by the information."""
    return np.asarray(np.sqrt(np.maximum(np.diag(inverse(known)), 0.0))[len(f.theta) :])


def likeness_charge(known: Array, parts: Sequence[Sequence[int]]) -> float:
    """Return what the strengths of several effects cost because they look alike (nats): (sum of ln |I_i| - ln |I|) / 2.

    The size of each is charged as beside the others, where it is known less well than alone; the volume in which the data hold all of
    them together is smaller than the product of those.

    Parameters
    ----------
    known : ndarray, shape (k, k)
        Information on all parameters.
    parts : sequence of sequences of int
        Which of them are the strengths of each effect; the others are integrated out.
    """
    if sum(len(part) > 0 for part in parts) < 2:
        return 0.0
    strengths = [i for part in parts for i in part]
    rest = [i for i in range(len(known)) if i not in set(strengths)]
    across = known[np.ix_(strengths, rest)]
    own = known[np.ix_(strengths, strengths)] - across @ inverse(known[np.ix_(rest, rest)]) @ across.T
    places = np.split(np.arange(len(strengths)), np.cumsum([len(part) for part in parts])[:-1])
    apart = sum(float(np.linalg.slogdet(own[np.ix_(i, i)])[1]) for i in places)
    charge = 0.5 * (apart - float(np.linalg.slogdet(own)[1]))
    return max(charge, 0.0) if np.isfinite(charge) else 0.0


def discounted(nats: float, share: float, explained: float) -> float:
    """Return what a difference of evidence is worth where laws are off by a share of what they explain (nats)."""
    return nats / (1.0 + 2.0 * share * share * explained)


def weigh(sim: Simulator, f: Fit, base: Fit, parts: Sequence[Weighed] = ()) -> Weighed:
    """Return a fit with its evidence over the base.

    Parameters
    ----------
    parts : sequence of Weighed
        The models that lack one of several effects each: the size of an effect's own response is what it adds to them.
    """
    gain, known = base.cost - f.cost, information(sim, f)
    se = standard_errors(f, known)
    charge = sum(shape_charge(x, float(v), float(s)) for x, v, s in zip(f.free, f.values, se, strict=True) if x.parameter.shape)
    lacking = {next(iter(set(f.ids) - set(p.ids))): p.gain for p in parts if len(set(f.ids) - set(p.ids)) == 1}
    strengths = {e: [len(f.theta) + i for i, x in enumerate(f.free) if not x.parameter.shape and x.effect.id == e] for e in f.ids}
    for effect_id, places in strengths.items():
        charge += strengths_charge(len(places), 2.0 * (gain - lacking.get(effect_id, 0.0)))
    charge += likeness_charge(known, list(strengths.values()))
    evidence = gain - charge
    back = _moved_again(sim, f, base, known)
    return Weighed(f, gain, evidence if back == 0.0 else max(evidence - back, min(evidence, 0.0)))


def _moved_again(sim: Simulator, f: Fit, base: Fit, known: Array) -> float:
    """Return what it costs (nats, to second order) to have in every bend a line that moves and rubs, where the base has one.

    A theta that leaves its range has stopped the line or its friction: such a model explains by not propagating, as far as it needs
    to. Where the bend had no friction when the rig was modelled, or the base is as still, it may. Beside a gain the friction of the base is
    what the wrong gain has made of it: the least of which fits begin is enough.
    """
    before = [base.theta] if sim.accepted is None else [sim.accepted, base.theta]
    still = np.flatnonzero(_out(f.theta) & ~np.any([_out(theta) for theta in before], axis=0))
    if not len(still):
        return 0.0
    rubs = before[0][still]
    if sim.accepted is None and GAIN[0] in f.ids:
        rubs = np.where(f.theta[still] <= THETA_LOW, np.minimum(rubs, min(START_FACTORS) * NOMINAL_THETA), rubs)
    return held(known, still, rubs - f.theta[still])[0]


def _out(theta: Array) -> NDArray[np.bool_]:
    """Return which bends have no friction that a tendon moves through."""
    return np.asarray((theta <= THETA_LOW) | (theta >= THETA_HIGH))
