"""The fast model applied to every record of a problem, and its derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.diagnosis.smoothing import block_mean
from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Mechanics, Parameter
from sstl_cli.physics.effects import get
from sstl_cli.physics.transmission import predict
from sstl_cli.physics.transmission.model import Active, activate, drive_of, observed_output, true_input

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]


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

    ``fixed`` effects are those the user's own simulator already contains. ``push`` is the mean push of
    input noise on the prediction (N, shape (samples,)); adding it to the measured output takes it out.
    """

    problem: Problem
    mechanics: Mechanics
    fixed: Effects = field(default_factory=dict)
    push: Array | None = None
    _drives: list[Drive] = field(default_factory=list)

    def __post_init__(self) -> None:
        p = self.problem
        self._drives = [self._drive(r, r.u, r.rate) for r in p.records]
        lengths = [len(r) for r in p.records]
        self.edges = np.concatenate(([0], np.cumsum(lengths)))
        self.y = np.concatenate([r.y for r in p.records])
        if self.push is not None:
            self.y = self.y + self.push
        self.weight = np.concatenate([r.weight for r in p.records])
        self.config = np.concatenate([np.full(len(r), r.config) for r in p.records])
        self.run = np.concatenate([np.full(len(r), i) for i, r in enumerate(p.records)])

    def _drive(self, r: Record, u: Array, rate: Array) -> Drive:
        return replace(drive_of(r.system, r.location, r.dt_s, u, self.mechanics, rate), slip=r.slip, neighbour_n=neighbour_of(r))

    def with_inputs(self, inputs: list[Array]) -> Simulator:
        """Return a simulator of the same records with other input tensions (N)."""
        records = tuple(replace(r, u=u) for r, u in zip(self.problem.records, inputs, strict=True))
        return Simulator(replace(self.problem, records=records), self.mechanics, self.fixed)

    def slices(self) -> list[slice]:
        """Return the slice of each record in the concatenated arrays."""
        return [slice(a, b) for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]

    def predict(self, theta: Array, effects: Effects) -> Array:
        """Return the predicted measured output (N, shape (samples,)) for one theta per configuration."""
        fine = self.predict_fine(theta, effects)
        return np.concatenate([block_mean(x, r.factor) for x, r in zip(fine, self.problem.records, strict=True)])

    def predict_fine(self, theta: Array, effects: Effects) -> list[Array]:
        """Return the prediction of each record at the rate of its simulation (N, shape (n * factor,))."""
        drives = self._drives
        line = effects.get("line")
        if line is not None:
            effects = {k: v for k, v in effects.items() if k != "line"}
            mechanics = replace(self.mechanics, load_n_per_mm=1.0 / line["load_mm_per_n"])
            drives = [replace(d, mechanics=mechanics) for d in drives]
        active = activate({**self.fixed, **effects})
        undo = bool(active.of_hook("input_inverse"))
        parts = []
        for r, drive in zip(self.problem.records, drives, strict=True):
            start = _true_start(r, active)
            if undo:
                u = true_input(r.system, r.dt_s, r.u, r.y_smooth, active)
                drive = replace(drive, tension_n=u)
            out = predict(drive, float(theta[r.config]), active, start)
            parts.append(observed_output(r.system, r.dt_s, r.u, out, active))
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
        out.setdefault(f.effect.id, {})[f.parameter.name] = float(min(max(value, f.parameter.low), f.parameter.high))
    return out
