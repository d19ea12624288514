"""From an input tension to a predicted record: law, envelopes, transition, sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.physics.effect import Drive, Effect, Law, Mechanics, Sampling, Transition, Values
from sstl_cli.physics.effects import get
from sstl_cli.physics.transmission.envelope import Envelope, envelope
from sstl_cli.physics.transmission.line import elastic_line
from sstl_cli.physics.transmission.play import bounded_play, play_operator

Array = NDArray[np.float64]
MARCH_S = 0.02
TOP_STEP = 1.5
Lines = tuple[float, str, str | None, float, float, float]
ONE = np.ones(1)


@dataclass(frozen=True)
class Active:
    """Effects with their values, ready to simulate; built once and used for every run."""

    items: tuple[tuple[Effect, Values], ...]

    def of_hook(self, name: str) -> list[tuple[Effect, Values]]:
        """Return the effects that have the hook, in the order in which a signal meets them."""
        return [(e, v) for e, v in self.items if getattr(e, name) is not None]


def activate(effects: Mapping[str, Values]) -> Active:
    """Return the effects that are not neutral, checked against their bounds and in sensor order."""
    items = []
    for effect_id, values in effects.items():
        effect = get(effect_id)
        full = effect.complete(values)
        if effect.active(full):
            items.append((effect, full))
    return Active(tuple(sorted(items, key=lambda item: (item[0].order, item[0].id))))


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


def predict(
    drive: Drive, theta: float, active: Active, start_n: float = float("nan"), known: dict[Lines, Envelope] | None = None
) -> Array:
    """Return the true output tension (N, shape (n,)) for a true input tension.

    Parameters
    ----------
    theta : float
        mu Phi of one pass (rad).
    start_n : float
        Output tension before the first sample; NaN starts midway between the propagation lines.
    known : dict, optional
        Propagation lines of the same effects that were integrated before, kept between runs of one bend.
    """
    law = Law()
    for effect, values in active.of_hook("law"):
        effect.law(law, values)  # type: ignore[misc]
    transition = Transition()
    for effect, values in active.of_hook("transition"):
        effect.transition(transition, values, drive)  # type: ignore[misc]
    if transition == Transition() and law == Law() and drive.slip is None:
        n = drive.passes
        # a tendon cannot push: below zero the lines stay at zero, as they do with effects
        return play_operator(np.maximum(drive.tension_n, 0.0), np.exp(-n * theta), 0.0, np.exp(n * theta), 0.0, start_n)
    scale = ONE
    for friction in law.friction_scale:
        scale = scale * friction(drive)
    if transition != Transition():
        if drive.slip is not None:
            raise SstlError("effects of the transition need a run that is driven by its tension", code="E735")
        start = 0.5 * float(drive.tension_n[0]) if np.isnan(start_n) else start_n
        return elastic_line(drive, theta, law, transition, scale, start)
    low, high = float(scale.min()), float(scale.max())
    # runs of one bend share their table up to the next of a few tops
    top = float(TOP_STEP ** np.ceil(np.log(max(drive.tension_n.max(initial=1.0), 1.0)) / np.log(TOP_STEP)))
    key = (theta, drive.system, drive.location, top, low, high)
    lines = known.get(key) if known is not None else None
    if lines is None:
        lines = envelope(law, theta, drive.system, drive.location, drive.mechanics, top, (low, high))
        if known is not None:
            known[key] = lines

    def between(pull: Array, release: Array) -> Array:
        return bounded_play(
            drive.tension_n, pull, release, lines.tension_step_n, scale, lines.scale0, lines.scale_step, start_n
        )

    if drive.slip is None:
        return between(lines.pull, lines.release)
    return np.where(drive.slip > 0.0, between(lines.pull, lines.pull), between(lines.release, lines.release))


def knots(tension_n: Array, dt_s: float) -> NDArray[np.int64]:
    """Return a coarser grid of samples that keeps the extremes of every block."""
    factor = max(1, round(MARCH_S / dt_s))
    n = len(tension_n)
    if factor == 1 or n < 2 * factor:
        return np.arange(n)
    blocks = tension_n[: n // factor * factor].reshape(-1, factor)
    offset = np.arange(len(blocks)) * factor
    inner = np.concatenate((offset + blocks.argmax(axis=1), offset + blocks.argmin(axis=1)))
    turning = inner[(inner > 0) & (inner < n - 1)]
    left, here, right = tension_n[turning - 1], tension_n[turning], tension_n[turning + 1]
    turning = turning[(here - left) * (right - here) <= 0.0]
    return np.unique(np.concatenate((offset, turning, [n - 1])))


def measure(
    system: str, dt_s: float, true_in: Array, true_out: Array, active: Active, rng: np.random.Generator | None = None
) -> tuple[Array, Array]:
    """Return what the two sensors and the recorder make of the true tensions (N, shape (n,) each)."""
    run = Sampling(system, dt_s, len(true_in), rng)
    seen_in, seen_out = true_in, true_out
    for effect, values in active.items:
        before_in, before_out = seen_in, seen_out
        if effect.input is not None:
            seen_in = effect.input(before_in, before_out, run, values)
        if effect.output is not None:
            seen_out = effect.output(before_out, before_in, run, values)
    return seen_in, seen_out


def observed_output(system: str, dt_s: float, measured_in: Array, true_out: Array, active: Active) -> Array:
    """Return the output as the sensor shows it, given the measured input tension."""
    hooked = active.of_hook("output")
    if not hooked:
        return true_out
    run = Sampling(system, dt_s, len(true_out))
    for effect, values in hooked:
        true_out = effect.output(true_out, measured_in, run, values)  # type: ignore[misc]
    return true_out


def true_input(system: str, dt_s: float, measured_in: Array, measured_out: Array, active: Active) -> Array:
    """Return the true input tension behind a measured one, undoing the input sensor."""
    hooked = active.of_hook("input_inverse")
    if not hooked:
        return measured_in
    run = Sampling(system, dt_s, len(measured_in))
    for effect, values in reversed(hooked):
        measured_in = effect.input_inverse(measured_in, measured_out, run, values)  # type: ignore[misc]
    return measured_in
