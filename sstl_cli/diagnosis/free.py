"""What a fit may vary: parameters of the catalogue's effects, and those of a rig that stand beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import LOAD_MM_PER_N, LOOP_APART, LOOP_LIMITS, RUNS_APART
from sstl_cli.physics.effect import FRICTION_LAW, TRANSITION, Effect, Parameter
from sstl_cli.physics.effects import get

Array = NDArray[np.float64]

# The stiffness of the load is not known from tensions; effects that act along the line need it. The sensing loop need not end at one as stiff.
LINE = Effect(
    id="line",
    title="Compliance of the load",
    stage=TRANSITION,
    equation="x = T / k",
    source="Section II-B",
    parameters=(
        Parameter("load_mm_per_n", "mm/N", *LOAD_MM_PER_N, "compliance of the load spring", shape=True),
        Parameter("loop_load_mm_per_n", "mm/N", *LOAD_MM_PER_N, "compliance of what the sensing loop ends at", shape=True, system="sstl"),
    ),
    excitation="",
)


# What nobody can foretell of a run is no part of any simulation: it is fitted to what the run shows.
RUNS = Effect(
    id="runs",
    title="What differs from run to run",
    stage=FRICTION_LAW,
    equation="theta of a run = theta (1 + d), or a zero z of a sensor; d or z normal about 0",
    source="Mixed model (Harville 1977)",
    parameters=(
        Parameter("d_run", "1", 0.0, 0.0, RUNS_APART, "relative spread of friction from run to run"),
        Parameter("z_run_out_n", "N", 0.0, 0.0, 1.0, "spread of the output sensor's zero from run to run"),
        Parameter("z_run_in_n", "N", 0.0, 0.0, 1.0, "spread of the input sensor's zero from run to run"),
    ),
    excitation="",
)
# What the catalogue has no name for, and its pulley or a gain look like: the two tendons need not rub alike.
LOOP = Effect(
    id="loop_friction",
    title="Friction of the sensing loop that is not that of the actuation tendon",
    stage=FRICTION_LAW,
    equation="theta of the sensing loop = theta (1 + d)",
    source="Catalogue entry of pulley_friction: what it is mistaken for",
    parameters=(Parameter("d", "1", 0.0, -LOOP_APART, LOOP_APART, "relative difference of friction", system="sstl", limits=LOOP_LIMITS),),
    excitation="",
)
# ids of what stands beside the catalogue
ASIDE = (LINE.id, RUNS.id, LOOP.id)


@dataclass(frozen=True)
class Free:
    """One free parameter of a candidate effect."""

    effect: Effect
    parameter: Parameter

    @property
    def width(self) -> float:
        return self.parameter.high - self.parameter.low


class Bounds(NamedTuple):
    """Where free parameters may lie, shapes (k,)."""

    low: Array
    high: Array


def bounds_of(free: Sequence[Free], read_n: tuple[float, float]) -> Bounds:
    """Return where parameters may lie: a knee where readings (N) are on either side of it, since beyond it would be a gain or nothing."""
    found = [(f.parameter.least, f.parameter.most) for f in free]
    found = [tuple(np.clip(read_n, *x)) if f.parameter.name in f.effect.knees else x for f, x in zip(free, found, strict=True)]
    return Bounds(*np.array(found).reshape(-1, 2).T)


def free_parameters(ids: Sequence[str], systems: Sequence[str]) -> list[Free]:
    """Return the parameters of effects that the recorded systems can show."""
    found: list[Free] = []
    for effect_id in ids:
        effect = get(effect_id)
        found += [Free(effect, p) for p in effect.parameters if p.system is None or p.system in systems]
        if effect.stretches:
            found.append(Free(LINE, LINE.parameters[0]))
    return found


def as_effects(free: Sequence[Free], values: Array) -> dict[str, dict[str, float]]:
    """Return values in the order of ``free`` as effects with named parameters."""
    out: dict[str, dict[str, float]] = {}
    for f, value in zip(free, values, strict=True):
        out.setdefault(f.effect.id, {})[f.parameter.name] = float(min(max(value, f.parameter.least), f.parameter.most))
    return out
