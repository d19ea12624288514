"""Where fits of an effect begin: strengths a little off neutral, shapes on a grid, the likeliest of them to first order."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import DECADES, FACTORS, SHAPE_GRID, START_FACTORS, STRENGTHS, WIDTHS
from sstl_cli.diagnosis.fit import Fit, first_theta, normal_equations, partial
from sstl_cli.diagnosis.free import Free, as_effects
from sstl_cli.diagnosis.hypotheses import GAIN, Hypothesis, full, laws, variants
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise
from sstl_cli.physics.effect import INSTRUMENT, NOMINAL_THETA, TRANSITION
from sstl_cli.physics.effects import get

Array = NDArray[np.float64]


def starting(effect_id: str, systems: Sequence[str]) -> list[Hypothesis]:
    """Return the hypotheses that are fitted from the start; subsets of a full one are derived from its fit."""
    effect = get(effect_id)
    usual = [full(effect_id, systems)] if effect.fitted else []
    found = variants(effect_id, systems) if effect.variants else [*usual, *laws(effect_id, systems)]
    return [h for h in found if h.strengths]


def grid(free: Sequence[Free]) -> list[Array]:
    """Return starting values: strengths a little off neutral, shapes on a grid (logarithmic where they span decades)."""
    axes: list[list[float]] = []
    offsets = STRENGTHS if any(f.effect.stage == TRANSITION for f in free) else STRENGTHS[-1:]
    for f in free:
        p = f.parameter
        if p.name == "load_mm_per_n":
            axes.append([p.neutral])
        elif p.start is not None:
            axes.append([p.start])
        elif p.shape:
            log = p.low > 0 and p.high / p.low > DECADES
            axes.append([float(p.low * (p.high / p.low) ** g) if log else p.low + g * (p.high - p.low) for g in SHAPE_GRID])
        elif p.low > 0.0:
            # a factor may be anything: a wrong unit is far from a calibration
            axes.append([k * p.neutral for k in FACTORS])
        elif p.low < p.neutral < p.high:
            axes.append([p.neutral + (STRENGTHS[0] * f.width if any(x.parameter.shape for x in free) else 0.0)])
        else:
            reach = p.high - p.neutral if p.high > p.neutral else p.low - p.neutral
            axes.append([p.neutral + o * reach for o in offsets])
    return [np.array(v) for v in itertools.product(*axes)]


def widths(sim: Simulator, noise: Noise, f: Fit) -> list[Array]:
    """Return the values of a fit with one of its plays in several widths, from the noise to half of what the output spans."""
    plays = [i for i, x in enumerate(f.free) if x.parameter.name in x.effect.plays]
    if not plays:
        return []
    narrow, span = min(s.white_n for s in noise.output.values()), float(np.ptp(sim.y[sim.weight > 0]))
    tried = []
    for i, width in itertools.product(plays, np.geomspace(narrow, max(0.5 * span, narrow), WIDTHS)):
        values = f.values.copy()
        values[i] = np.clip(width, f.free[i].parameter.least, f.free[i].parameter.most)
        tried.append(values)
    return tried


def speeds(f: Fit) -> list[Array]:
    """Return the values of a fit with its means over jumps a little off nothing, at each speed of their grid; none without such means.

    Where a line rests says how high it jumps, and at which speeds; its mean alone does not.
    """
    at = [i for i, x in enumerate(f.free) if x.parameter.name in x.effect.averaged]
    tried = []
    for values, offset in itertools.product(grid(f.free) if at else (), STRENGTHS):
        if all(values[i] == f.free[i].parameter.neutral for i in at):
            begin = values.copy()
            begin[at] += [offset * f.free[i].width for i in at]
            tried.append(begin)
    return tried


def by_gain(sim: Simulator, h: Hypothesis) -> tuple[Array, Array] | None:
    """Return theta (shape (configurations,)) and gains from which what is read is nearest to what is predicted, None for other effects.

    A gain is linear: it is read off at each theta that is tried. Beside a wrong one the base ends where its friction hides it, and from there
    the right theta is not found.
    """
    if h.ids != GAIN:
        return None
    nominal = np.full(len(sim.problem.configs), NOMINAL_THETA)
    own = [np.array([r.system == f.parameter.system for r in sim.problem.records])[sim.run] * sim.weight for f in h.free]
    tried = []
    for factor in START_FACTORS:
        p = sim.predict(factor * nominal, {})
        gains = np.array([float(np.sum(w * p * sim.y)) / max(float(np.sum(w * p * p)), np.finfo(float).tiny) for w in own])
        gains = np.clip(gains, [f.parameter.least for f in h.free], [f.parameter.most for f in h.free])
        left = sim.y - p + sum((w > 0.0) * (1.0 - g) * p for w, g in zip(own, gains, strict=True))
        tried.append((float(np.sum(sim.weight * left**2)), gains))
    gains = min(tried, key=lambda x: x[0])[1]
    return first_theta(sim, nominal, as_effects(h.free, gains)), gains


def screen(sim: Simulator, around: Fit, h: Hypothesis) -> tuple[float, Array]:
    """Return the linearised gain (nats) of adding a hypothesis to a fit, and the start that gives it.

    What a sensor does goes with its strengths: they begin where the step leads, since beside one that is hardly there a shape is anything.
    """
    joined = around.hypothesis.joined(h)
    free = joined.free[len(around.free) :]
    starts = grid(free)
    linear = [f.effect.stage == INSTRUMENT and f.effect.late_s is None and not f.parameter.shape for f in free]
    whiten, known_columns = around.whiten, around.whiten(around.jacobian)
    zero = around.cost - 0.5 * whiten.log_det
    best = (-np.inf, np.zeros(len(free)))
    for start in starts:
        values = np.concatenate((around.values, start))
        prediction = sim.predict(around.theta, as_effects(joined.free, values))
        # what the fit has already answers nearly as it did without the newcomer, which is weak at its start
        fresh = partial(sim, around.theta, joined.free, values, prediction, range(len(around.free), len(joined.free)))
        fresh = whiten.beside(sim.y - prediction, fresh)
        j, r = np.concatenate((known_columns, fresh[:, 1:]), axis=1), fresh[:, 0]
        a, b = normal_equations(sim, j, r)
        step = np.linalg.lstsq(a + 1e-6 * np.diag(np.diag(a) + 1e-9), b, rcond=1e-10)[0]
        step = _inside(np.asarray(step, np.float64), values, joined.free, len(around.theta))
        gain = zero - (0.5 * float(r @ r) - float(b @ step) + 0.5 * float(step @ a @ step))
        if gain > best[0]:
            best = (gain, np.where(linear, (values + step[len(around.theta) :])[len(around.free) :], start))
    return best


def _inside(step: Array, values: Array, free: Sequence[Free], configs: int) -> Array:
    low = np.array([f.parameter.least for f in free])
    high = np.array([f.parameter.most for f in free])
    step = step.copy()
    step[configs:] = np.clip(values + step[configs:], low, high) - values
    return step
