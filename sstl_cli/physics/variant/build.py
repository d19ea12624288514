"""From parameters to a line at rest: stations, segments, and the laws as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from zlib import crc32

import numpy as np

from sstl_cli.core.rng import log_uniform
from sstl_cli.physics.given import Values
from sstl_cli.physics.variant.effect import Parts
from sstl_cli.physics.variant.effects import catalogue
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array, Ints, Line, Rate, Rub, Spring, Trial
from sstl_cli.physics.variant.spec import VariantRun, VariantSpec

# hidden numbers of a contact, drawn once a rig: memory of the sliding speed (Hess, Soom 1990: 2-9 ms), slip that breaks
# a contact (Rabinowicz 1951: 1-100 um), and the age in slips at which a contact has healed
MEMORY_S, WEAKENING_MM, HEALED_SLIPS = (0.002, 0.009), (0.003, 0.05), (3.0, 15.0)


def one_pass(spec: VariantSpec, location: str | None) -> tuple[Array, Array]:
    """Return length and share of the bend of every cell of a pass, in shares of the pass; half of the cells are bent.

    Raises
    ------
    ValueError
        The location is not one of `spec.bend_centres`.
    """
    key = "CP" if location is None else location
    if key not in spec.bend_centres:
        raise ValueError(f"variant: location = {location!r} must be None or one of {', '.join(spec.bend_centres)}")
    arc = spec.bend_arc_fraction
    # a bend cannot hang over the end of the sheath
    start = min(max(spec.bend_centres[key] - 0.5 * arc, 0.0), 1.0 - arc)
    straight = (start, 1.0 - arc - start)
    bent = spec.nodes if arc > 1.0 - 1e-9 else max(2, spec.nodes // 2)
    cells: list[float] = []
    for place, share in ((0, straight[0]), (1, arc), (2, straight[1])):
        if share > 1e-9:
            count = bent if place == 1 else max(1, round((spec.nodes - bent) * share / (1.0 - arc)))
            cells += [share / count] * count
    length = np.array(cells)
    middle = np.cumsum(length) - 0.5 * length
    inside = (middle > start) & (middle < start + arc)
    return length, inside / inside.sum()


def build(spec: VariantSpec, run: VariantRun, v: Values, chosen: Mapping[str, Chosen], seed: int) -> Parts:
    """Return the line at rest with all effects built in; hidden numbers are drawn from the seed."""
    length, bend = one_pass(spec, run.location)
    ends = np.zeros(length.size)
    ends[0] += 0.5
    ends[-1] += 0.5
    pulley = np.zeros(length.size, np.int64)
    if run.system == "sstl":
        pulley = np.concatenate((pulley, [1], pulley))
        length, bend, ends = (np.concatenate((a, [0.0], a[::-1])) for a in (length, bend, ends))
    rng = np.random.default_rng([seed, crc32(b"contact")])
    memory, weakening, healed = (log_uniform(rng, low, high) for low, high in (MEMORY_S, WEAKENING_MM, HEALED_SLIPS))
    made = Parts(
        spec=spec,
        run=run,
        length=length,
        bend=bend,
        ends=ends,
        line=_at_rest(run.theta * bend, pulley, spec.pretension_n),
        rub=Rub(),
        rate=Rate(memory, weakening),
        spring=Spring(spec.load_k1_n_per_mm),
        healing_mm=healed * weakening,
        command=run.command,
    )
    made.soften(spec.length_mm * (1.0 / spec.ea_n))
    for name, effect in catalogue().items():
        effect.build(made, v[name], chosen[name])
    s = made.spring
    made.spring = s._replace(plain=s.fung == 0.0 and s.joint_share == 0.0 and s.play == 0.0 and s.rope == 0.0 and s.creep == 0.0)
    made.command = np.maximum(made.command, 0.0)
    return made


def _at_rest(angle: Array, pulley: Ints, pretension_n: float) -> Line:
    """Return a line of such stations: every segment at the pretension, no friction mobilised."""
    size = angle.size
    return Line(
        angle=angle,
        weight=np.zeros(size),
        drag=np.zeros(size),
        breakaway=np.zeros(size),
        pulley=pulley,
        compliance=np.zeros(size + 1),
        tension=np.full(size + 1, pretension_n),
        crept=np.zeros((size + 1, 1)),
        creep_share=np.ones(1),
        creep_s=np.ones(1),
        rope=np.zeros(size + 1),
        joint=np.array([0.0, 0.5]),
        drop=np.zeros(size),
        speed=np.zeros(size),
        rest=np.zeros(size),
        wear=np.zeros(size),
        wear_n_mm=np.zeros(size),
        slow=np.array([0.0, 0.0, 0.0, 1.0]),
        tally=np.zeros(5),
    )


def empty_trial(line: Line) -> Trial:
    """Return the work arrays of a step."""
    size = line.angle.size

    def zeros() -> Array:
        return np.zeros(size)

    return Trial(
        tension=line.tension.copy(),
        move=zeros(),
        angle=zeros(),
        weight=zeros(),
        share=np.ones(size),
        offset=zeros(),
        tangent=zeros(),
        force=zeros(),
        slope=zeros(),
        gain=zeros(),
        moved=zeros(),
        stuck=np.ones(size, np.int64),
        flow=np.zeros(size + 1),
        give=np.zeros(size + 1),
    )
