"""The fast model applied to every record of a problem, and its derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.diagnosis.whitening import Phases
from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Mechanics, Parameter
from sstl_cli.physics.effects import get
from sstl_cli.physics.transmission import predict
from sstl_cli.physics.transmission.envelope import Envelope
from sstl_cli.physics.transmission.model import Active, Lines, activate, drive_of, observed_output, true_input

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]
# a shift of the input (N) that shows the slope of a line; no friction makes a line steeper than that
SHIFT_N = 1e-2
STEEPEST = 50.0
CEILING_N = 1e6


# The stiffness of the load is not known from tensions; effects that act along the line need it.
LINE = Effect(
    id="line",
    title="Compliance of the load",
    stage=TRANSITION,
    equation="x = T / k",
    source="Section II-B",
    parameters=(Parameter("load_mm_per_n", "mm/N", 0.125, 0.02, 1.0, "compliance of the load spring", shape=True),),
    excitation="",
)


@dataclass(frozen=True)
class Free:
    """One free parameter of a candidate effect."""

    effect: Effect
    parameter: Parameter

    @property
    def width(self) -> float:
        return self.parameter.high - self.parameter.low


@dataclass
class Simulator:
    """Predicts the measured output of every record; records are concatenated in order.

    ``fixed`` effects are those the user's own simulator already contains; the same effect as a candidate is a change of
    its strengths.
    """

    problem: Problem
    mechanics: Mechanics
    fixed: Effects = field(default_factory=dict)
    _drives: list[Drive] = field(default_factory=list)

    def __post_init__(self) -> None:
        p = self.problem
        self._drives = [self._drive(r, r.u, r.rate) for r in p.records]
        lengths = [len(r) for r in p.records]
        self.edges = np.concatenate(([0], np.cumsum(lengths)))
        self.y = np.concatenate([r.y for r in p.records])
        self.weight = np.concatenate([r.weight for r in p.records])
        self.config = np.concatenate([np.full(len(r), r.config) for r in p.records])
        self.run = np.concatenate([np.full(len(r), i) for i, r in enumerate(p.records)])

    def _drive(self, r: Record, u: Array, rate: Array) -> Drive:
        return replace(drive_of(r.system, r.location, r.dt_s, u, self.mechanics, rate), slip=r.slip, neighbour_n=neighbour_of(r))

    def changed(self, effect_id: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return the values of an effect; where the user's simulator contains it, they change what is there."""
        there = self.fixed.get(effect_id)
        if there is None:
            return dict(values)
        total = get(effect_id).complete(there)
        for p in get(effect_id).parameters:
            if not p.shape and p.name in values:
                total[p.name] = min(max(total[p.name] + values[p.name] - p.neutral, p.least), p.most)
        return total

    def slices(self) -> list[slice]:
        """Return the slice of each record in the concatenated arrays."""
        return [slice(a, b) for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]

    def predict(self, theta: Array, effects: Effects) -> Array:
        """Return the predicted measured output (N, shape (samples,)) for one theta per configuration."""
        fine = self.predict_fine(theta, effects)
        return np.concatenate([block_mean(x, r.factor) for x, r in zip(fine, self.problem.records, strict=True)])

    def phases(self, theta: Array, effects: Effects) -> Phases:
        """Return where the model slides and how steeply, from its answer to the latent input and to one that is shifted."""
        here, moved = self.predict_fine(theta, effects), self.predict_fine(theta, effects, SHIFT_N)
        slide, gain = [], []
        for r, a, b in zip(self.problem.records, here, moved, strict=True):
            slope = np.clip((b - a) / SHIFT_N, 0.0, STEEPEST)
            gain.append(block_mean(slope, r.factor))
            if r.slip is not None:
                # a line that a motion drives slides all the time
                slide.append(np.ones(len(r)))
                continue
            done = block_mean(np.abs(np.diff(a, prepend=a[:1])), r.factor)
            due = block_mean(slope * np.abs(np.diff(r.u, prepend=r.u[:1])), r.factor)
            slide.append(np.clip(done / np.maximum(due, 1e-12), 0.0, 1.0) * (due > 1e-12))
        return Phases(np.concatenate(slide), np.concatenate(gain))

    def predict_fine(self, theta: Array, effects: Effects, shift_n: float = 0.0) -> list[Array]:
        """Return the prediction of each record at the rate of its simulation (N, shape (n * factor,)).

        ``shift_n`` is added to the input.
        """
        drives = self._drives
        if shift_n != 0.0:
            drives = [replace(d, tension_n=d.tension_n + shift_n) for d in drives]
        line = effects.get("line")
        if line is not None:
            effects = {k: v for k, v in effects.items() if k != "line"}
            mechanics = replace(self.mechanics, load_n_per_mm=1.0 / line["load_mm_per_n"])
            drives = [replace(d, mechanics=mechanics) for d in drives]
        active = activate({**self.fixed, **{k: self.changed(k, v) for k, v in effects.items()}})
        undo = bool(active.of_hook("input_inverse"))
        known: dict[Lines, Envelope] = {}
        parts = []
        for r, drive in zip(self.problem.records, drives, strict=True):
            start = _true_start(r, active)
            if undo:
                u = true_input(r.system, r.dt_s, r.u + shift_n, r.y_smooth, active)
                drive = replace(drive, tension_n=u)
            out = predict(drive, float(theta[r.config]), active, start, known)
            seen = observed_output(r.system, r.dt_s, r.u + shift_n, out, active)
            # a fit may ask for the absurd; it must only stay a number
            parts.append(np.clip(np.nan_to_num(seen, nan=CEILING_N), -CEILING_N, CEILING_N))
        return parts


def neighbour_of(r: Record) -> Array | None:
    """Return the tension (N, shape (n * factor,)) of the tendons recorded beside, None where that is not known."""
    beside = r.raw.extra.get("neighbour_n")
    return None if beside is None else block_mean(beside, max(1, round(r.dt_s / r.raw.dt_s)))[: len(r.u)]


def _true_start(r: Record, active: Active) -> float:
    """Return the true output before the first sample: the measured one less what the sensor adds."""
    if not active.of_hook("output"):
        return r.start_n
    seen = observed_output(r.system, r.dt_s, r.u[:2], np.full(2, r.start_n), active)
    return 2.0 * r.start_n - float(seen[0])


def free_parameters(ids: Sequence[str], systems: Sequence[str]) -> list[Free]:
    """Return the parameters of effects that the recorded systems can show."""
    found: list[Free] = []
    for effect_id in ids:
        effect = get(effect_id)
        found += [Free(effect, p) for p in effect.parameters if p.system is None or p.system in systems]
        if effect.stage == TRANSITION:
            found.append(Free(LINE, LINE.parameters[0]))
    return found


def as_effects(free: Sequence[Free], values: Array) -> dict[str, dict[str, float]]:
    """Return values in the order of ``free`` as effects with named parameters."""
    out: dict[str, dict[str, float]] = {}
    for f, value in zip(free, values, strict=True):
        out.setdefault(f.effect.id, {})[f.parameter.name] = float(min(max(value, f.parameter.least), f.parameter.most))
    return out
