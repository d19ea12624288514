"""Noise of the tension sensors: measured where nothing else can move a reading, then made as likely as the record allows.

White noise shows in third differences. Coloured noise of the output shows in holds, where the play keeps the tension: each
hold gives a spread, and their median is not moved by holds that something else disturbs. Coloured noise of the input shows
hardly by itself, since an input moves: it is taken to be like the output's (the sensors of a rig are alike) unless the slides say
otherwise, and no more than where the input rests. What no model explains of the output is no noise of the input.
The slides are asked together with the flexible part of the model projected out (restricted likelihood, Patterson and
Thompson 1971), and the spreads stay near what was measured by log-normal priors, so that no wrong model can buy variance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sstl_cli.diagnosis.constants import (
    ALIKE,
    ALIKE_FROM,
    ALIKE_TO,
    AT_MOST,
    CORRELATIONS_S,
    CURVATURE_STEP,
    DECIDES_NATS,
    DIFFERENCE,
    ENOUGH,
    FLAT,
    LEAST_COLOUR,
    LEAST_GAP,
    LEVELS,
    MEASURED,
    RICH_RIDGE,
    SENSORS_S,
    SMOOTHER,
    TRIES,
    UNMEASURED,
    UNSEEN,
    WHITE,
)
from sstl_cli.diagnosis.holds import held_noise, moving, of_input
from sstl_cli.diagnosis.laid import constants, late_n, layout, scatter_rms_n
from sstl_cli.diagnosis.latent import Slow
from sstl_cli.diagnosis.recorder import white_beside
from sstl_cli.diagnosis.records import Record, content
from sstl_cli.diagnosis.rounding import with_rounding
from sstl_cli.diagnosis.white import averaged, least_white, spacing, typical, white_of, white_of_output
from sstl_cli.diagnosis.whitening import Noise, Phases, Sensor, step_of, whitener

Array = NDArray[np.float64]
# place of the input's coloured noise among the numbers that are fitted
ENTERING = 2
# and of how long that of the output lasts
LASTING = -2


def measured(records: Sequence[Record], slide: Array) -> Noise:
    """Return the noise of each system's sensors as holds and third differences show it.

    Parameters
    ----------
    slide : ndarray, shape (samples,)
        Share of a step in which the model slides (0 in holds), records laid end to end.
    """
    into: dict[str, Sensor] = {}
    out: dict[str, Sensor] = {}
    wide: dict[str, float] = {}
    loose: dict[str, float] = {}
    ends = np.cumsum([len(r) for r in records])
    for system in sorted({r.system for r in records}):
        mine = [(r, slide[e - len(r) : e]) for r, e in zip(records, ends, strict=True) if r.system == system]
        white_in = typical([white_of(r.raw.tension_in_n, r, "tension_in_n") for r, _ in mine])
        white_out, off = white_of_output(mine)
        levels = white_out * LEVELS
        held, white_held = held_noise([r for r, _ in mine], [s for _, s in mine], white_out, levels)
        wide[system] = held.spread
        # of the output it is that of means over a step, of the input that of readings
        alike = white_in / averaged([r for r, _ in mine])
        ratio = float(np.clip(alike / max(white_out, 1e-12), ALIKE_FROM, ALIKE_TO))
        if held.spread < UNMEASURED:
            # third differences take some of the slow noise for white: the quicker it is the more
            seen, slow = white_out, Slow(held.coloured_n, held.correlation_s)
            least_in, least_out = (typical([least_white(r, column) for r, _ in mine]) for column in ("tension_in_n", "tension_out_n"))
            white_out = max(white_beside(white_out, slow.sd_n, slow.kept(spacing([r for r, _ in mine], "tension_out_n"))), least_out)
            white_in = max(white_beside(white_in, ratio * slow.sd_n, slow.kept(spacing([r for r, _ in mine], "tension_in_n"))), least_in)
            held, white_held = held_noise([r for r, _ in mine], [s for _, s in mine], white_out, levels)
            # a difference is known as well as what was taken off; there is no more of it than was seen
            off = float(min(np.hypot(off, MEASURED * (seen**2 / white_out**2 - 1.0)), off + np.log(seen / white_out) / AT_MOST))
        loose[system] = off
        # an input need not rest as well as it is told to, so that this is a bound
        resting, _ = held_noise([of_input(r) for r, _ in mine], [moving(r, white_in) for r, _ in mine], white_in, white_in * LEVELS)
        slow_in = ratio * held.coloured_n if resting.spread >= UNMEASURED else min(ratio * held.coloured_n, resting.coloured_n)
        out[system] = with_rounding(Sensor(white_held, held.coloured_n, held.correlation_s), [r.faults_out for r, _ in mine])
        into[system] = with_rounding(Sensor(white_in, slow_in, held.correlation_s), [r.faults_in for r, _ in mine])
    return Noise(into, out, dict.fromkeys(out, 1.0), open=wide, loose=loose)


def of_readings(records: Sequence[Record], noise: Noise) -> Noise:
    """Return a noise whose white part of the output is that of one reading, not of the mean over a step of the simulation."""
    found = dict(noise.output)
    for system, s in found.items():
        found[system] = replace(s, white_n=s.white_n * averaged([r for r in records if r.system == system]))
    return replace(noise, output=found)


def white_only(noise: Noise) -> Noise:
    """Return a noise without what holds show: beside an accepted model all that is slow belongs to its known scatter."""
    into, out = (
        {k: Sensor(s.white_n, UNSEEN * s.white_n, s.correlation_s) for k, s in side.items()} for side in (noise.input, noise.output)
    )
    return Noise(into, out, dict(noise.smoother), dict(noise.spread))


def likely(records: Sequence[Record], phases: Phases, residual: Array, columns: Array, start: Noise) -> tuple[Noise, dict[str, float]]:
    """Return the most likely noise given what a rich model leaves, near the measured one, and its cost (nats) by system.

    Parameters
    ----------
    residual : ndarray, shape (samples,)
        Residual of the model (N).
    columns : ndarray, shape (samples, k)
        What the model could still change: projected out.
    """
    residual = residual - columns @ _step(records, phases, residual, columns, start)
    into, out, smoother = dict(start.input), dict(start.output), dict(start.smoother)
    spread: dict[str, dict[str, float]] = {}
    nats: dict[str, float] = {}
    wanders: dict[str, float] = {}
    ends = np.cumsum([len(r) for r in records])
    for system in sorted(out):
        part = some([(r, slice(e - len(r), e)) for r, e in zip(records, ends, strict=True) if r.system == system])
        rows = np.concatenate([np.arange(s.start, s.stop) for _, s in part])
        mine = [r for r, _ in part]
        own = phases.at(rows)
        stacked = np.concatenate((residual[rows, None], columns[rows]), axis=1)
        wide = start.open.get(system, MEASURED)
        near = (start.loose.get(system, WHITE), wide)
        fitted = _fitted(system, mine, own, stacked, into[system], out[system], near)
        entering, out[system], smoother[system], spread[system], nats[system], wanders[system] = fitted
        if any(r.told_n for r in mine):
            # of what the smoother was told these slides say nothing more
            spread[system] = {**spread[system], **{k: v for k, v in start.spread.get(system, {}).items() if k.startswith("input")}}
        else:
            into[system] = entering
    return Noise(into, out, smoother, spread, start.open, start.loose, wanders), nats


def _step(records: Sequence[Record], phases: Phases, residual: Array, columns: Array, noise: Noise) -> Array:
    """Return the most likely coefficients of columns given a noise, each within a hundred of its standard deviations, shape (k,)."""
    w = whitener(constants(records, noise), phases)
    j, r = w(columns), w(residual)
    gram = j.T @ j
    return np.asarray(np.linalg.lstsq(gram + RICH_RIDGE * np.diag(np.diag(gram) + 1e-12), j.T @ r, rcond=1e-10)[0])


def some(part: list[tuple[Record, slice]]) -> list[tuple[Record, slice]]:
    """Return runs, shortest first, until they hold enough samples for six numbers."""
    ordered = sorted(part, key=lambda x: content(x[0]))
    total = np.cumsum([len(r) for r, _ in ordered])
    return ordered[: int(np.searchsorted(total, ENOUGH)) + 1]


def _fitted(
    system: str, records: Sequence[Record], phases: Phases, stacked: Array, into: Sensor, out: Sensor, measured: tuple[float, float]
) -> tuple[Sensor, Sensor, float, dict[str, float], float, float]:
    centre, near = _prior(into, out, measured)
    laid = layout(records)
    shortest, longest = np.log(CORRELATIONS_S[0]), np.log(CORRELATIONS_S[-1])
    low = np.concatenate((centre - AT_MOST * near, np.full(2, shortest - 1.0)))
    high = np.concatenate((centre + AT_MOST * near, np.full(2, longest + 1.0)))

    def sensors(p: Array) -> tuple[Sensor, Sensor, float]:
        white, colour, entering, smoother, slow_out, slow_in = (float(v) for v in np.exp(np.clip(p, low, high)))
        return Sensor(into.white_n, entering, slow_in), Sensor(white, colour, slow_out), smoother

    def cost(p: Array) -> float:
        a, b, smoother = sensors(p)
        w = whitener(laid.constants(Noise({system: a}, {system: b}, {system: smoother})), phases)
        z = w(stacked)
        r, j = z[:, 0], z[:, 1:]
        gram = j.T @ j
        scale = np.sqrt(np.diag(gram)) + 1e-12
        # a hundred standard deviations of each at most: columns that nearly cancel one another fit the error of the input by far more
        gram = gram / np.outer(scale, scale) + RICH_RIDGE * np.eye(len(scale))
        lower = np.linalg.cholesky(gram)
        projected = np.linalg.solve(lower, (j.T @ r) / scale)
        rss = float(r @ r - projected @ projected)
        restricted = 2.0 * float(np.sum(np.log(np.diag(lower)) + np.log(scale)))
        slow = p[len(near) :]
        # correlation times outside of what sensors have are not forbidden, they cost
        outside = np.maximum(shortest - slow, 0.0) + np.maximum(slow - longest, 0.0)
        prior = float(np.sum(((p[: len(near)] - centre) / near) ** 2) + np.sum((outside / MEASURED) ** 2))
        return 0.5 * (rss + w.log_det + restricted + prior)

    first = np.concatenate((centre, np.log([out.correlation_s, into.correlation_s])))
    unit = np.array([*near, MEASURED, MEASURED])
    at, least = _least(cost, first, unit)
    names = ("output.white_n", "output.coloured_n", "input.coloured_n", "smoother", "output.correlation_s", "input.correlation_s")
    spread = {n: _spread(cost, at, i, least) for i, n in enumerate(names)}
    # what is believed of the input's sensor is no part of what the output says: where the smoother was told of it nobody pays it
    believed = ((at[ENTERING] - centre[ENTERING]) / ALIKE) ** 2
    outside = float(max(shortest - at[-1], 0.0, at[-1] - longest))
    # a model may leave a gap that is nobody's cause, and as much again: of that nobody speaks
    speaks = at[1] - at[0] > np.log(2.0 * LEAST_GAP * averaged(records))
    wanders = _wanders(cost, at, unit, least) if speaks else 0.0
    return *sensors(at), spread, least - 0.5 * float(believed + (outside / MEASURED) ** 2), wanders


def _least(cost: Callable[[Array], float], first: Array, unit: Array) -> tuple[Array, float]:
    """Return where a cost is least, sought from a first guess in given units, and the cost there; what has no unit stays."""
    options = {"eps": DIFFERENCE, "gtol": FLAT, "ftol": 0.0, "maxfun": TRIES}
    found = minimize(lambda z: cost(first + unit * z), np.zeros(len(first)), method="L-BFGS-B", options=options)
    return first + unit * np.asarray(found.x), float(found.fun)


def _wanders(cost: Callable[[Array], float], at: Array, unit: Array, least: float) -> float:
    """Return the evidence (nats) that what is slow in the output lasts longer than noise of a sensor, at most where that decides nothing."""
    longest = np.log(SENSORS_S)
    if at[LASTING] <= longest:
        return 0.0
    shorter, fixed = at.copy(), unit.copy()
    shorter[LASTING], fixed[LASTING] = longest, 0.0
    at_most = cost(shorter) - least
    # where that is a little less it is the search that ended early
    return max(at_most if at_most <= DECIDES_NATS else _least(cost, shorter, fixed)[1] - least, 0.0)


def _prior(into: Sensor, out: Sensor, measured: tuple[float, float]) -> tuple[Array, Array]:
    """Return the prior of white and coloured noise of the output, coloured of the input, and the smoother: logarithms, spreads."""
    floor = LEAST_COLOUR * out.white_n + 1e-9
    centre = np.log([out.white_n, max(out.coloured_n, floor), max(into.coloured_n, floor), 1.0])
    return centre, np.array([*measured, ALIKE, SMOOTHER])


def strain(found: Noise, measured: Noise) -> float:
    """Return the mean square by which noise had to leave what was measured, in spreads of the prior; of the system with most.

    About 1 where noise is all that is left; what no model explains pulls at it.
    """
    worst = 0.0
    for system, out in found.output.items():
        near = (measured.loose.get(system, WHITE), measured.open.get(system, MEASURED))
        centre, spread = _prior(measured.input[system], measured.output[system], near)
        # to less noise than was measured nothing pulls
        at = np.log(np.maximum([out.white_n, out.coloured_n, found.input[system].coloured_n, found.smoother[system]], 1e-12))
        worst = max(worst, float(np.mean(np.maximum((at - centre) / spread, 0.0) ** 2)))
    return worst


def _spread(cost: Callable[[Array], float], at: Array, i: int, least: float) -> float:
    """Return the standard error of one number from the curvature of the cost (nats), at most that of a flat prior."""
    step = np.zeros(len(at))
    step[i] = CURVATURE_STEP
    curvature = (cost(at + step) + cost(at - step) - 2.0 * least) / CURVATURE_STEP**2
    return float(1.0 / np.sqrt(max(curvature, 1.0)))


def variance(records: Sequence[Record], phases: Phases, noise: Noise) -> Array:
    """Return the variance (N^2, shape (samples,)) that a perfect model would leave: noise of both sensors where it enters."""
    parts, at = [], 0
    for r in records:
        gain, slide = phases.gain[at : at + len(r)], phases.slide[at : at + len(r)]
        into, out, at = noise.input[r.system], noise.output[r.system], at + len(r)
        entering = (noise.smoother[r.system] * r.error_n) ** 2 + (0.0 if r.told_n else into.coloured_n**2)
        slow = step_of(float(np.median(r.readings)), r.dt_s * r.factor / out.correlation_s).variance
        parts.append(
            gain**2 * (entering + (slide * late_n(r)) ** 2)
            + slow * (r.slower * out.coloured_n) ** 2
            + (r.louder * out.white_n) ** 2 / r.readings
        )
    return np.concatenate(parts)


def floor_n(records: Sequence[Record], phases: Phases, noise: Noise, scatter: bool = False) -> float:
    """Return the RMS (N) that a perfect model would leave at the analysis rate, with what is known to scatter if asked for."""
    weight = np.concatenate([r.weight for r in records])
    left = variance(records, phases, noise)
    if scatter:
        left = left + scatter_rms_n(records) ** 2
    return float(np.sqrt(np.sum(weight * left) / max(float(np.sum(weight)), 1.0)))
