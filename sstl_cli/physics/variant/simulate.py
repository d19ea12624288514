"""One run on the rig of law variants: build the line, march it, pass the truth through the sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sstl_cli.physics.given import NoiseSpec
from sstl_cli.physics.variant.build import build, empty_trial
from sstl_cli.physics.variant.cascade import Course, Recording, march
from sstl_cli.physics.variant.effects import choose, resolve_effects
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import ITERATIONS, LEAST, SUBSTEPPED, UNCONVERGED, WORK, Array, Laws
from sstl_cli.physics.variant.recorder import read
from sstl_cli.physics.variant.spec import VariantResult, VariantRun, VariantSpec

Effects = Mapping[str, Mapping[str, float]]
# steps in which the line is brought from rest to the first command, one a second
LEAD_IN_STEPS = 30


@dataclass(frozen=True)
class VariantTruth:
    """True tensions in and out (N) and position (mm) of a run, each (n,), and the health of the solution."""

    tension_in_n: Array
    tension_out_n: Array
    position_in_mm: Array
    unconverged: int
    substepped: int
    iterations: int
    dissipated_j: float
    min_step_dissipation_j: float
    node_tension: Array | None = None


def laws_of(spec: VariantSpec, seed: int = 0) -> dict[str, Chosen]:
    """Return the law of every effect on a rig; ValueError for one that is not known."""
    return choose(spec.laws, seed if spec.law_seed is None else spec.law_seed)


def march_variant(
    spec: VariantSpec, run: VariantRun, effects: Effects | None = None, seed: int = 0, keep_nodes: bool = False
) -> VariantTruth:
    """Return the true tensions and position of a run, without sensors; `seed` only draws laws left open.

    Raises
    ------
    ValueError
        An effect, a parameter, a law or the location is unknown, or a value is out of range.
    """
    v, laws = resolve_effects(effects or {}), laws_of(spec, seed)
    made = build(spec, run, v, laws, seed if spec.law_seed is None else spec.law_seed)
    law, line, t_in = Laws(made.rub, made.rate, made.spring), made.line, made.command
    size = t_in.size
    course = Course(
        run.time_s,
        t_in,
        np.zeros(0) if run.neighbour_n is None else run.neighbour_n,
        np.zeros(0) if run.friction is None else run.friction,
        np.linspace(spec.pretension_n, t_in[0], LEAD_IN_STEPS + 1),
    )
    coupled = law.rate.drag > 0.0 or law.rate.soft > 0.0 or law.spring.creep > 0.0
    limits = (spec.tolerance_n, spec.max_iterations, spec.max_substeps)
    out = Recording(np.empty(size), np.empty(size), np.empty((size if keep_nodes else 0, line.tension.size)))
    march(line, law, empty_trial(line), course, coupled, limits, out)
    levels = np.append(t_in, spec.pretension_n)
    beside = sum((travel(levels) for travel in made.travels), np.zeros(size + 1))
    tally = line.tally
    return VariantTruth(
        tension_in_n=t_in,
        tension_out_n=out.t_out,
        position_in_mm=out.travel + beside[:-1] - beside[-1],
        unconverged=int(tally[UNCONVERGED]),
        substepped=int(tally[SUBSTEPPED]),
        iterations=int(tally[ITERATIONS]),
        dissipated_j=1e-3 * float(tally[WORK]),
        min_step_dissipation_j=1e-3 * float(tally[LEAST]),
        node_tension=out.nodes if keep_nodes else None,
    )


def read_variant(
    spec: VariantSpec,
    run: VariantRun,
    truth: tuple[Array, Array, Array],
    effects: Effects | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
) -> tuple[Array, Array, Array, Array]:
    """Return time stamps (s), tensions in and out (N) and position (mm) that sensors and recorder make of the truth.

    Raises
    ------
    ValueError
        As `march_variant`.
    """
    v, laws = resolve_effects(effects or {}), laws_of(spec, seed)
    return read(run, truth, v, laws, noise or NoiseSpec(), seed)


def simulate_variant(
    spec: VariantSpec,
    run: VariantRun,
    effects: Effects | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
    keep_nodes: bool = False,
) -> VariantResult:
    """Record one run on the rig of law variants.

    The rig starts at rest at the pretension, is brought slowly to the first command and then follows it. Without
    effects it obeys the capstan equation with backlash, Eq. (3) and (5) of the paper.

    Parameters
    ----------
    spec : geometry, mechanics, laws and solver; runs of one rig share `law_seed` or `laws`.
    run : configuration and command, n samples.
    effects : effect id to {parameter: value}, see `effects`; what is missing is neutral.
    noise : sensor noise; by default 0.02 N white.
    seed : seed of noise and faults, and of the laws where `spec.law_seed` is None.
    keep_nodes : also return the tension of every segment.

    Raises
    ------
    ValueError
        An effect, a parameter, a law or the location is unknown, or a value is out of range.
    """
    truth = march_variant(spec, run, effects, seed, keep_nodes)
    arrays = (truth.tension_in_n, truth.tension_out_n, truth.position_in_mm)
    return VariantResult(
        *read_variant(spec, run, arrays, effects, noise, seed),
        *arrays,
        unconverged=truth.unconverged,
        substepped=truth.substepped,
        iterations=truth.iterations,
        dissipated_j=truth.dissipated_j,
        min_step_dissipation_j=truth.min_step_dissipation_j,
        node_tension=truth.node_tension,
        laws={e: laws.id for e, laws in laws_of(spec, seed).items() if e in (effects or {})},
    )
