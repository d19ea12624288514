"""Disturbances from no list: a random function of a random carrier, put in at a random place of line or sensor.

A disturbance is a carrier (what it goes along with) x a random function of it x an action x a place. Both the function
and its numbers are drawn, so that there is no closed set of kinds that a diagnosis could be written against.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import log_uniform
from sstl_cli.physics.random_function import RandomFunction, draw_function

Array = NDArray[np.float64]
# what a disturbance goes along with, and the stretch of it over which a random function varies (low, high)
CARRIERS = {"time_s": (0.3, 40.0), "position_mm": (0.15, 3.0), "load_n": (1.0, 10.0), "since_reversal_s": (0.2, 4.0), "run": (0.7, 3.0)}
READINGS = ("input reading", "output reading")
LINE = ("before friction", "friction", "after friction")
ADD, MULTIPLY, HOLD, BLANK = "add", "multiply", "hold", "blank"
# amplitude 1: what is added (N), the share of what is multiplied, the share of time of a reading that sticks
FULL_N, FULL_SHARE, FULL_HELD = 5.0, 0.8, 0.6
LEAST_FRICTION = 0.05
NEIGHBOUR_PER_N = 0.02
TRIES, TOLERANCE = 12, 0.03


@dataclass(frozen=True)
class Scene:
    """One run without disturbance: labels, its place in the session, and true channels of shape (n,)."""

    system: str
    order: int
    time_s: Array
    tension_in_n: Array
    tension_out_n: Array
    position_in_mm: Array


@dataclass(frozen=True)
class Disturbance:
    """What was drawn: a random function of each carrier (two are multiplied), the action and the place.

    `systems` tells whose sensor it is; a disturbance of the line is in both. `seed` draws the events of each run.
    """

    place: str
    action: str
    carriers: tuple[str, ...]
    functions: tuple[RandomFunction, ...]
    systems: tuple[str, ...]
    seed: int
    event_s: float = 1.0
    level: float = 0.0

    @property
    def in_line(self) -> bool:
        """Whether it acts on the line, so that the mechanics must be simulated with it."""
        return self.place in LINE

    @property
    def sticks(self) -> bool:
        """Whether it is a reading that stands still or drops out at times: what a catalogue of faults calls one of the recorder."""
        return self.action in (HOLD, BLANK)

    @property
    def listed(self) -> tuple[str, ...]:
        """What a catalogue of effects calls it all the same: a fault of the recorder, or friction that differs from run to run."""
        if self.sticks:
            return ("acquisition_faults",)
        return ("friction_drift",) if self.place == "friction" and self.carriers == ("run",) else ()

    @property
    def description(self) -> str:
        """One sentence that says what it is."""
        who = "" if len(self.systems) == 2 else f" ({self.systems[0]} only)"
        if self.sticks:
            what = "sticks" if self.action == HOLD else f"falls to {self.level:.1f} N"
            return f"{self.place}{who} {what} at random for about {self.event_s:.2g} s"
        terms = " times ".join(f"{f.description} over {c}" for f, c in zip(self.functions, self.carriers, strict=True))
        return f"{self.place}{who}, {'added' if self.action == ADD else 'multiplied'}: {terms}"


# (command in N, factor on friction or None) to true output (N) and position (mm) of one run, all of shape (n,)
Simulate = Callable[[Scene, Array, Array | None], tuple[Array, Array]]


def draw(rng: np.random.Generator) -> Disturbance:
    """Return a random disturbance; equal generators give equal ones.

    Examples
    --------
    >>> draw(np.random.default_rng(1)) == draw(np.random.default_rng(1))
    True
    """
    place = str(rng.choice((*READINGS, *LINE), p=[0.15, 0.3, 0.15, 0.3, 0.1]))
    systems: tuple[str, ...] = ("act", "sstl")
    if place in READINGS and rng.random() < 0.5:
        systems = (str(rng.choice(("act", "sstl"))),)
    seed = int(rng.integers(2**32))
    if place in READINGS and rng.random() < 0.25:
        action = str(rng.choice((HOLD, BLANK), p=[0.7, 0.3]))
        event_s = log_uniform(rng, 0.02, 3.0)
        return Disturbance(place, action, (), (), systems, seed, event_s, float(rng.choice((0.0, rng.uniform(1.0, 30.0)))))
    # the same bend throughout a run shows as friction only
    names = [c for c in CARRIERS if c != "run" or place in ("friction", "before friction")]
    carriers = tuple(str(c) for c in rng.choice(names, 2 if rng.random() < 0.2 else 1, replace=False))
    functions = tuple(draw_function(rng, *CARRIERS[c]) for c in carriers)
    action = MULTIPLY if place == "friction" else (ADD if place == "after friction" else str(rng.choice((ADD, MULTIPLY))))
    return Disturbance(place, action, carriers, functions, systems, seed)


def signal(disturbance: Disturbance, scene: Scene) -> Array:
    """Return the disturbance of a run at amplitude 1, about unit size, shape (n,)."""
    out = np.ones(scene.time_s.size)
    for carrier, function in zip(disturbance.carriers, disturbance.functions, strict=True):
        out = out * function(_coordinate(carrier, scene))
    return out


def _coordinate(carrier: str, scene: Scene) -> Array:
    if carrier == "position_mm":
        return scene.position_in_mm
    if carrier == "load_n":
        return scene.tension_in_n
    if carrier == "run":
        return np.full(scene.time_s.size, float(scene.order))
    elapsed: Array = scene.time_s - scene.time_s[0]
    if carrier == "since_reversal_s":
        way = np.sign(np.diff(scene.tension_in_n, prepend=scene.tension_in_n[0]))
        moving = np.flatnonzero(way)
        turned = moving[1:][way[moving[1:]] != way[moving[:-1]]]
        last = np.zeros(elapsed.size, np.int64)
        last[turned] = turned
        return np.asarray(elapsed - elapsed[np.maximum.accumulate(last)])
    # runs follow one another: each sees its own part of a wander
    return elapsed + 1.3 * scene.order * float(elapsed[-1])


def in_line(disturbance: Disturbance, amplitude: float, scene: Scene, simulate: Simulate) -> tuple[Array, Array, Array]:
    """Return true tensions in and out (N) and position (mm) of a run whose line is disturbed; else those of the scene.

    The input sensor sits before what enters "before friction", so it does not see it. A change of the load ("after
    friction") is felt while the line is held; once it slides, friction alone sets the output.
    """
    if not disturbance.in_line or amplitude == 0.0:
        return scene.tension_in_n, scene.tension_out_n, scene.position_in_mm
    size = amplitude * signal(disturbance, scene)
    if disturbance.place == "friction":
        factor = np.maximum(1.0 + FULL_SHARE * size, LEAST_FRICTION)
        out, x = simulate(scene, scene.tension_in_n, factor)
    elif disturbance.place == "before friction":
        out, x = simulate(scene, np.maximum(_acted(disturbance, scene.tension_in_n, size), 0.0), None)
    else:
        out, x = _load_changed(scene, FULL_N * size), scene.position_in_mm
    return scene.tension_in_n, out, x


def _acted(disturbance: Disturbance, tension: Array, size: Array) -> Array:
    if disturbance.action == ADD:
        return np.asarray(tension + FULL_N * size)
    return np.asarray(tension * (1.0 + FULL_SHARE * size))


def _load_changed(scene: Scene, pull: Array) -> Array:
    step_in = np.diff(scene.tension_in_n, prepend=scene.tension_in_n[0])
    step_out = np.diff(scene.tension_out_n, prepend=scene.tension_out_n[0])
    # a line that slides follows its input at a slope of e^-1.4 at least
    slides = np.abs(step_out) > 0.1 * np.abs(step_in) + 1e-9
    since = np.maximum.accumulate(np.where(slides, np.arange(pull.size), 0))
    return np.asarray(np.maximum(scene.tension_out_n + pull - pull[since], 0.0))


def in_reading(disturbance: Disturbance, amplitude: float, scene: Scene, tension_in: Array, tension_out: Array) -> tuple[Array, Array]:
    """Return the readings (N, noise included) of a run whose sensor is disturbed; else the readings themselves."""
    if disturbance.in_line or amplitude == 0.0 or scene.system not in disturbance.systems:
        return tension_in, tension_out
    first = disturbance.place == READINGS[0]
    reading = tension_in if first else tension_out
    if disturbance.sticks:
        stuck = _events(disturbance, min(FULL_HELD * amplitude, 0.95), scene)
        if disturbance.action == BLANK:
            reading = np.where(stuck, disturbance.level, reading)
        else:
            reading = reading[np.maximum.accumulate(np.where(stuck, 0, np.arange(stuck.size)))]
    else:
        reading = _acted(disturbance, reading, amplitude * signal(disturbance, scene))
    return (reading, tension_out) if first else (tension_in, reading)


def _events(disturbance: Disturbance, share: float, scene: Scene) -> NDArray[np.bool_]:
    """Return which samples lie in random events that cover about a share of the run; more of them as it grows."""
    rng = np.random.default_rng([disturbance.seed, scene.order])
    length_s = scene.time_s[-1] - scene.time_s[0]
    count = max(1, int(np.ceil(3.0 * length_s / disturbance.event_s)))
    starts = scene.time_s[0] + rng.random(count) * length_s
    lasts, ranks = rng.exponential(disturbance.event_s, count), rng.random(count)
    # of three times the record in events, those up to the share: coverage 1 - exp(-3 rank)
    chosen = ranks < -np.log1p(-share) / 3.0
    if share > 0.0 and not chosen.any():
        chosen = ranks == ranks.min()
    edges = np.zeros(scene.time_s.size + 1, np.int64)
    np.add.at(edges, np.searchsorted(scene.time_s, starts[chosen]), 1)
    np.add.at(edges, np.searchsorted(scene.time_s, (starts + lasts)[chosen]), -1)
    stuck = np.cumsum(edges[:-1]) > 0
    stuck[0] = False
    return np.asarray(stuck)


def rms_n(disturbance: Disturbance, amplitude: float, scenes: Sequence[Scene], simulate: Simulate) -> float:
    """Return the RMS change of both readings (N), of all runs together and without noise."""
    total, count = 0.0, 0
    for scene in scenes:
        t_in, t_out, _ = in_line(disturbance, amplitude, scene, simulate)
        t_in, t_out = in_reading(disturbance, amplitude, scene, t_in, t_out)
        total += float(np.sum((t_in - scene.tension_in_n) ** 2) + np.sum((t_out - scene.tension_out_n) ** 2))
        count += t_out.size
    return float(np.sqrt(total / max(count, 1)))


def draw_at(rng: np.random.Generator, asked_n: float, gap: Callable[[Disturbance, float], float]) -> tuple[Disturbance, float, float]:
    """Return a random disturbance that reaches an asked gap (N) within a quarter, its amplitude, and its gap.

    Raises
    ------
    SstlError
        If none of 60 drawn ones reaches it on these runs.
    """
    for _ in range(60):
        drawn = draw(rng)
        amplitude, reached = amplitude_for(partial(gap, drawn), asked_n)
        if abs(np.log(reached / asked_n)) < np.log(1.25):
            return drawn, amplitude, reached
    raise SstlError(f"no disturbance reaches {asked_n:g} N on these runs", fix="ask for less", code="E722")


def as_neighbour(factor: Array, simulator: str) -> Array:
    """Return the neighbours' tension (N) by which a simulator multiplies friction by a factor, at c_bend_per_n = 0.02.

    For the simulators whose run has no factor of its own: ``rig`` (1 + c T) and ``bristle`` (exp(2 tanh(c T / 2))).
    """
    if simulator == "rig":
        return np.asarray((factor - 1.0) / NEIGHBOUR_PER_N)
    return np.asarray(2.0 * np.arctanh(np.clip(0.5 * np.log(factor), -0.999, 0.999)) / NEIGHBOUR_PER_N)


def amplitude_for(gap: Callable[[float], float], asked_n: float, start: float = 0.1) -> tuple[float, float]:
    """Return the amplitude (0..1) whose gap (N) comes nearest to the asked one, and that gap.

    `gap` is `rms_n` of a set of runs, or what a re-tuned model leaves of it. It grows with the amplitude, by about a
    power of it: a secant in logarithms, kept in its bracket.
    """
    known: list[tuple[float, float]] = []
    amplitude = start
    for _ in range(TRIES):
        known.append((amplitude, max(gap(amplitude), 1e-9)))
        below = max((k for k in known if k[1] < asked_n), default=None)
        above = min((k for k in known if k[1] >= asked_n), default=None)
        if min(abs(np.log(g / asked_n)) for _, g in known) < TOLERANCE or (below is not None and below[0] >= 1.0):
            break
        if below is not None and above is not None and below[0] < above[0]:
            share = np.log(asked_n / below[1]) / np.log(above[1] / below[1])
            amplitude = float(below[0] * (above[0] / below[0]) ** np.clip(share, 0.1, 0.9))
        else:
            amplitude = float(np.clip(amplitude * np.clip(asked_n / known[-1][1], 0.05, 20.0), 1e-5, 1.0))
    return min(known, key=lambda k: abs(np.log(k[1] / asked_n)))
