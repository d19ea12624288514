"""From an input tension to a predicted record: law, envelopes, transition, sensors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.effect import NOMINAL_THETA, Drive, Effect, Mechanics, Sampling, Values
from sstl_cli.physics.transmission.active import Active, activate
from sstl_cli.physics.transmission.batch import Case, laid, predict_runs

__all__ = ["Active", "activate", "drive_of", "knots", "measure", "observed_output", "predict", "sensed", "true_input", "unsensed"]

Array = NDArray[np.float64]
Hooked = Sequence[tuple[Effect, Values]]
# a line is marched at least so often (s), and after so much of the input's span; samples about a turn; turns that are noise
MARCH_S, MARCH_SHARE = 0.02, 0.005
AROUND = np.arange(-2, 9)
MOST_TURNS = 0.05


def drive_of(
    system: str,
    location: str | None,
    dt_s: float,
    tension_n: Array,
    mechanics: Mechanics,
    rate_n_s: Array | None = None,
    marched: NDArray[np.int64] | None = None,
) -> Drive:
    """Return the drive of a run from its true input tension (N), equally spaced by ``dt_s``.

    ``marched`` are the samples for an elastic line where they are known already.
    """
    rate = np.gradient(tension_n, dt_s) if rate_n_s is None and len(tension_n) > 1 else rate_n_s
    path = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(tension_n)))))
    time = np.asarray(np.arange(len(tension_n)) * dt_s, np.float64)
    return Drive(
        system,
        location,
        dt_s,
        time,
        tension_n,
        np.zeros_like(tension_n) if rate is None else rate,
        path,
        mechanics,
        knots(tension_n, dt_s) if marched is None else marched,
    )


def predict(drive: Drive, theta: float, active: Active, start_n: float = float("nan")) -> Array:
    """Return the true output tension (N, shape (n,)) for a true input tension.

    Parameters
    ----------
    theta : float
        mu Phi of one pass (rad).
    start_n : float
        Output tension before the first sample; NaN starts midway between the propagation lines.
    """
    return predict_runs(laid((drive,)), [Case(np.array([theta]), active, np.array([start_n]))])[0]


def knots(tension_n: Array, dt_s: float) -> NDArray[np.int64]:
    """Return the samples at which a line is marched: close where the input moves, all around its turns and at both ends.

    One after every two hundredth of its span that the input has moved, and every MARCH_S besides.
    """
    n = len(tension_n)
    if n < 3 or dt_s >= MARCH_S:
        return np.arange(n)
    step = np.diff(tension_n)
    passed = np.concatenate(([0.0], np.cumsum(np.abs(step)))) / max(MARCH_SHARE * float(np.ptp(tension_n)), 1e-12)
    inner = np.flatnonzero(np.diff(np.floor(passed + np.arange(n) * (dt_s / MARCH_S)))) + 1
    sign = np.sign(step)
    moving = np.flatnonzero(sign)
    turns = moving[1:][np.diff(sign[moving]) != 0.0]
    if len(turns) < MOST_TURNS * n:
        # what the line does right after a turn is fast
        turns = (turns[:, None] + AROUND).ravel()
    ends = np.arange(len(AROUND))
    return np.unique(np.concatenate((inner, turns, ends, n - 1 - ends)).clip(0, n - 1))


def measure(
    system: str,
    dt_s: float,
    true_in: Array,
    true_out: Array,
    active: Active,
    rng: np.random.Generator | None = None,
    theta: float = NOMINAL_THETA,
    zero_n: float = 0.0,
) -> tuple[Array, Array]:
    """Return what the two sensors and the recorder make of the true tensions (N, shape (n,) each); the output reads nothing at ``zero_n`` (N)."""
    run = Sampling(system, dt_s, len(true_in), rng, theta=theta, zero_n=zero_n)
    seen_in, seen_out = true_in, true_out
    for effect, values in active.items:
        before_in, before_out = seen_in, seen_out
        if effect.input is not None:
            seen_in = effect.input(before_in, before_out, run, values)
        if effect.output is not None:
            seen_out = effect.output(before_out, before_in, run, values)
    return seen_in, seen_out


def observed_output(system: str, dt_s: float, measured_in: Array, true_out: Array, active: Active, theta: float = NOMINAL_THETA) -> Array:
    """Return the output as the sensor shows it, given the measured input tension."""
    return sensed(active.of_hook("output"), Sampling(system, dt_s, len(true_out), theta=theta), measured_in, true_out)


def sensed(hooked: Hooked, run: Sampling, measured_in: Array, true_out: Array) -> Array:
    """Return the output as the sensor shows it, given the effects that change it."""
    for effect, values in hooked:
        true_out = effect.output(true_out, measured_in, run, values)  # type: ignore[misc]
    return true_out


def true_input(system: str, dt_s: float, measured_in: Array, measured_out: Array, active: Active, theta: float = NOMINAL_THETA) -> Array:
    """Return the true input tension behind a measured one, undoing the input sensor."""
    return unsensed(active.of_hook("input_inverse"), Sampling(system, dt_s, len(measured_in), theta=theta), measured_in, measured_out)


def unsensed(hooked: Hooked, run: Sampling, measured_in: Array, measured_out: Array) -> Array:
    """Return the true input tension behind a measured one, given the effects to undo."""
    for effect, values in reversed(hooked):
        measured_in = effect.input_inverse(measured_in, measured_out, run, values)  # type: ignore[misc]
    return measured_in
