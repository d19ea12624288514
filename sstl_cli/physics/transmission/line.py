"""A coarse elastic line, for effects that act along the tendon: presliding, drag, static friction.

Nodes sit in the bend; the straight parts only stretch (and drag). Without such effects the nodes are
a cascade of plays, which is one play; with them tension diffuses and friction turns round gradually.
Balance of node j, displacement u_j towards the drive:
T_(j-1) - T_j - F_j - c_j du_j/dt = 0, with the friction F_j between the exact capstan bounds
(exp(phi) - 1) T_(j-1) of releasing and (1 - exp(-phi)) T_(j-1) of pulling, built up elastically: in proportion to the way
and then cut, or ever more slowly (Dahl).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.effect import Law, Mechanics, Transition
from sstl_cli.physics.transmission.march import march_all
from sstl_cli.physics.transmission.state import (
    CREEP,
    DRAG,
    ELASTIC,
    FACTOR_NODES,
    GIVEN,
    HOLD,
    PHI_PULL,
    PHI_RELEASE,
    PULLEY_PULL,
    PULLEY_RELEASE,
    RIGID,
    TAIL,
    Input,
    Lines,
)  # fmt: skip

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
ARC_NODES = 6
# break-away distance of a contact that is meant to be rigid (mm)
RIGID_MM = 1e-5
# least compliance between two nodes, as a share of a pass
LEAST_COMPLIANCE = 1e-4
# the numbers of a transition that differ between runs; from the fifth on the march takes them as they are
SCALARS = attrgetter(
    "drag_n_s_mm", "drag_bend_n_s_mm", "drag_end_n_s_mm", "creep_fraction", "creep_s", "creep_spread", "static_ratio", "static_mm_s", "aging", "aging_s",
    "stribeck_ratio", "stribeck_mm_s", "tail", "bristle_n", "drag_power",
)  # fmt: skip


@dataclass(frozen=True)
class Geometry:
    """What the lines of several runs are made of, shape (runs, nodes), shorter lines filled up with zeros.

    ``bend`` counts a bend's nodes, ``share`` is the part of a pass, ``gap`` the compliance behind a node (mm/N) without the
    load's, ``pulley`` marks the node of the pulley; ``nodes`` is how many a line has.
    """

    nodes: Counts
    bend: Array
    share: Array
    gap: Array
    pulley: Array


def geometry(places: Sequence[tuple[str, str | None]], mechanics: Mechanics) -> Geometry:
    """Return the lines of runs given as (system, location)."""
    rows = [_nodes(system, location, mechanics) for system, location in places]
    longest = max(len(r[0]) for r in rows)
    filled = [np.array([np.pad(r[i], (0, longest - len(r[i]))) for r in rows]) for i in range(4)]
    return Geometry(np.array([len(r[0]) for r in rows], np.int64), *filled)


def elastic_lines(
    into: Input, places: Geometry, end_mm_per_n: Array, theta: Array, law: Law, transitions: Sequence[Transition], start_n: Array
) -> Lines:
    """Return the elastic lines of several runs, ready to be marched.

    Parameters
    ----------
    into : Input
        What goes into them, run by run.
    places : Geometry
        Lines of the runs.
    end_mm_per_n, theta, start_n : ndarray, shape (runs,)
        Compliance of what a line ends at, mu Phi of one pass (rad), and output tension before the first sample (N).
    transitions : sequence of Transition
        How each run moves between its envelopes.
    """
    runs = len(theta)
    bend = places.bend * (theta / ARC_NODES)[:, None]
    last = (np.arange(runs), places.nodes - 1)
    elastic = places.gap.copy()
    elastic[last] += end_mm_per_n
    scalars = np.array([SCALARS(t) for t in transitions], np.float64)
    # drag along the whole tendon, where the bend presses it against the sheath, and at its end
    drag = scalars[:, :1] * places.share + scalars[:, 1:2] * bend
    drag[last] += scalars[:, 2]
    top = np.maximum(np.maximum.reduceat(into.tension, into.edges[:-1]), 1.0)
    factor_step = 2.0 * top * np.exp(2.0 * theta) / (FACTOR_NODES - 1)
    factor = np.ones((runs, FACTOR_NODES))
    for f in law.factors:
        factor = factor * f(np.asarray(np.arange(FACTOR_NODES) * factor_step[:, None], np.float64))
    breakaway = np.ones_like(bend)
    known: dict[tuple[float, float, int], Array] = {}
    for i, (t, nodes) in enumerate(zip(transitions, places.nodes.tolist(), strict=True)):
        key = (t.breakaway_mm, t.spread, nodes)
        breakaway[i, :nodes] = known[key] if key in known else known.setdefault(key, _breakaway(t, nodes))
    given = np.empty((runs, GIVEN, bend.shape[1]))
    given[:, PHI_PULL], given[:, PHI_RELEASE] = bend * law.scale_pull, bend * law.scale_release
    given[:, HOLD] = law.constant_n * places.share + law.adhesion_n * bend + law.pulley_n * places.pulley
    given[:, HOLD, 0] += law.begin_n
    given[last[0], HOLD, last[1]] += law.end_n
    given[:, PULLEY_PULL], given[:, PULLEY_RELEASE] = law.pulley_pull * places.pulley, law.pulley_release * places.pulley
    given[:, DRAG], given[:, ELASTIC], given[:, CREEP] = drag, elastic, places.gap * scalars[:, 3:4]
    loose = (given[:, PHI_PULL] == 0.0) & (given[:, HOLD] + given[:, PULLEY_PULL] + given[:, PULLEY_RELEASE] == 0.0)
    given[:, RIGID] = np.where(loose, 0.0, 1.0 / breakaway)
    laws = np.column_stack((scalars[:, 4:], factor_step))
    return Lines(places.nodes, given, laws, factor, np.ascontiguousarray(start_n, np.float64))


def marched(cases: Sequence[tuple[Input, Lines]]) -> list[Array]:
    """Return the true output tensions (N, shape (n,) each) of elastic lines of several cases of the same runs, marched together."""
    into, lines = _joined([c[0] for c in cases]), Lines(*(np.concatenate(x) for x in zip(*(c[1] for c in cases), strict=True)))
    # those side by side have as many nodes and build up friction alike; the longest begin, so that few lanes are left over
    kind, length = 2 * lines.nodes + (lines.laws[:, TAIL] >= 0.0), np.diff(into.knot_edges)
    order = np.lexsort((-length, kind))
    groups = np.concatenate(([0], np.flatnonzero(np.diff(kind[order])) + 1, [len(order)]))
    return np.split(march_all(into, lines, order, groups), len(cases))


def _joined(inputs: Sequence[Input]) -> Input:
    """Return inputs of the same runs end to end."""
    first, times = inputs[0], len(inputs)
    if times == 1:
        return first
    n, m = first.tension.size, first.knots.size
    scale = first.scale
    if any(x.scale.size > 1 for x in inputs):
        scale = np.concatenate([np.broadcast_to(x.scale, n) for x in inputs])
    return Input(
        np.concatenate([x.tension for x in inputs]),
        np.concatenate((*(first.edges[:-1] + n * i for i in range(times)), [n * times])),
        np.tile(first.knots, times),
        np.concatenate((*(first.knot_edges[:-1] + m * i for i in range(times)), [m * times])),
        np.tile(first.steps, times),
        scale,
    )


def _nodes(system: str, location: str | None, m: Mechanics) -> tuple[Array, Array, Array, Array]:
    """Return per node: whether it is in the bend, share of a pass, compliance behind it (mm/N), whether it is the pulley."""
    before, behind = m.straight(location)
    arc = m.arc_fraction
    share = np.concatenate(([before], np.full(ARC_NODES, arc / ARC_NODES), [behind]))
    bend = np.concatenate(([0.0], np.ones(ARC_NODES), [0.0]))
    pulley = np.zeros(len(bend))
    if system == "sstl":
        pulley = np.concatenate((pulley, [1.0], pulley))
        share = np.concatenate((share, [0.0], share[::-1]))
        bend = np.concatenate((bend, [0.0], bend[::-1]))
    # friction of a stretch sits in its middle: half of its compliance lies behind it
    half = 0.5 * share * m.tendon_mm_per_n
    gap = half.copy()
    gap[:-1] += half[1:]
    # a bend that reaches the end of the tube leaves no tendon between two nodes, which the balance cannot have
    return bend, share, np.maximum(gap, LEAST_COMPLIANCE * m.tendon_mm_per_n), pulley


def _breakaway(transition: Transition, nodes: int) -> Array:
    """Return the break-away distance of each node (mm), spread evenly and shuffled by a fixed stride."""
    if transition.breakaway_mm <= 0.0:
        return np.full(nodes, RIGID_MM)
    order = (np.arange(nodes) * 5 + 2) % nodes if nodes % 5 else (np.arange(nodes) * 7 + 2) % nodes
    quantile = (order + 0.5) / nodes * 2.0 - 1.0
    return np.maximum(transition.breakaway_mm * (1.0 + transition.spread * quantile), 0.0) + RIGID_MM
