"""A coarse elastic line, for effects that act along the tendon: presliding, drag, static friction.

Nodes sit in the bend; the straight parts only stretch (and drag). Without such effects the nodes are
a cascade of plays, which is one play; with them tension diffuses and friction turns round gradually.
Balance of node j, displacement u_j towards the drive:
T_(j-1) - T_j - F_j - c_j du_j/dt = 0, with the friction F_j between the exact capstan bounds
(exp(phi) - 1) T_(j-1) of releasing and (1 - exp(-phi)) T_(j-1) of pulling, built up elastically: in proportion to the way
and then cut, or ever more slowly (Dahl).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.effect import Law, Mechanics, Transition
from sstl_cli.physics.transmission.build_up import built_up

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
ARC_NODES = 6
# break-away distance of a contact that is meant to be rigid (mm)
RIGID_MM = 1e-5
# slip that wears off a contact's static excess and travel in which it heals (mm); memory of the sliding speed (s)
RENEWAL_MM = 0.02
HEALING_MM = 0.5
SPEED_MEMORY_S = 0.005
MAX_ITERATIONS = 40
# a node changes between sticking and slipping only beyond this force: round-off must not make it chatter
MODE_TOLERANCE_N = 1e-9
# a line whose friction builds up smoothly is in balance to this force
BALANCE_N = 1e-5
FACTOR_NODES = 64
# speeds over that of a Stribeck curve at which exp(-v v) is below the rounding of one
NOTHING_LEFT = 6.1
# least compliance between two nodes, as a share of a pass
LEAST_COMPLIANCE = 1e-4
# the numbers of a transition that differ between runs; from the fourth on the march takes them as they are
SCALARS = attrgetter(
    "drag_n_s_mm", "drag_bend_n_s_mm", "creep_fraction", "creep_s", "static_ratio", "static_mm_s", "aging", "aging_s",
    "stribeck_ratio", "stribeck_mm_s", "tail",
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
    tension_n: Array,
    edges: Counts,
    knots: Counts,
    knot_edges: Counts,
    steps_s: Array,
    places: Geometry,
    load_mm_per_n: float,
    theta: Array,
    law: Law,
    transitions: Sequence[Transition],
    scale: Array,
    start_n: Array,
) -> Array:
    """Return the true output tensions (N, shape (n,)) of the elastic lines of several runs.

    Parameters
    ----------
    tension_n : ndarray, shape (n,)
        Input tensions of the runs, end to end; run i is ``edges[i]`` to ``edges[i + 1]``.
    knots : ndarray of int, shape (m,)
        Samples of each run, counted from its start, at which its line is marched, ``steps_s`` after one another (s).
    places : Geometry
        Lines of the runs.
    theta, start_n : ndarray, shape (runs,)
        mu Phi of one pass (rad), and output tension before the first sample (N).
    transitions : sequence of Transition
        How each run moves between its envelopes.
    scale : ndarray, shape (n,) or (1,)
        Time-varying factor on mu.
    """
    runs = len(theta)
    bend = places.bend * (theta / ARC_NODES)[:, None]
    last = (np.arange(runs), places.nodes - 1)
    elastic = places.gap.copy()
    elastic[last] += load_mm_per_n
    scalars = np.array([SCALARS(t) for t in transitions], np.float64)
    # drag along the whole tendon, and drag where the bend presses it against the sheath
    drag = scalars[:, :1] * places.share + scalars[:, 1:2] * bend
    top = np.maximum(np.maximum.reduceat(tension_n, edges[:-1]), 1.0)
    factor_step = 2.0 * top * np.exp(2.0 * theta) / (FACTOR_NODES - 1)
    factor = np.ones((runs, FACTOR_NODES))
    for f in law.factors:
        factor = factor * f(np.asarray(np.arange(FACTOR_NODES) * factor_step[:, None], np.float64))
    breakaway = np.ones_like(bend)
    known: dict[tuple[float, float, int], Array] = {}
    for i, (t, nodes) in enumerate(zip(transitions, places.nodes.tolist(), strict=True)):
        key = (t.breakaway_mm, t.spread, nodes)
        breakaway[i, :nodes] = known[key] if key in known else known.setdefault(key, _breakaway(t, nodes))
    pulley = places.pulley[:, :, None] * np.array([law.pulley_pull, law.pulley_release, law.pulley_n])
    return _march_all(
        tension_n, edges, knots, knot_edges, steps_s, places.nodes, bend * law.scale_pull, bend * law.scale_release,
        law.constant_n * places.share, drag, elastic, places.gap * scalars[:, 2:3], pulley, breakaway, scale,
        factor, factor_step, np.ascontiguousarray(start_n, np.float64),
        np.ascontiguousarray(scalars[:, 3:]),
    )  # fmt: skip


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


@njit(cache=True, error_model="numpy", nogil=True)
def _march_all(
    tension: Array,
    edges: Counts,
    knots: Counts,
    knot_edges: Counts,
    steps: Array,
    nodes: Counts,
    phi_pull: Array,
    phi_release: Array,
    constant: Array,
    drag: Array,
    elastic: Array,
    creep: Array,
    pulley: Array,
    breakaway: Array,
    scale: Array,
    factor: Array,
    factor_step: Array,
    start: Array,
    scalars: Array,
) -> Array:
    """March the line of each run through its knots; between them the output is a straight line."""
    out = np.empty(tension.size)
    for i in range(nodes.size):
        a, b, c, d, m = edges[i], edges[i + 1], knot_edges[i], knot_edges[i + 1], nodes[i]
        at = knots[c:d]
        mine = tension[a:b]
        met = _march(
            mine[at], steps[c:d], phi_pull[i, :m], phi_release[i, :m], constant[i, :m], drag[i, :m], elastic[i, :m],
            creep[i, :m], pulley[i, :m], breakaway[i, :m], scale[a:b][at] if scale.size > 1 else scale, factor[i],
            factor_step[i], start[i], scalars[i],
        )  # fmt: skip
        _between_knots(mine, at, met, out[a:b])
    return out


@njit(cache=True, error_model="numpy", nogil=True)
def _between_knots(tension: Array, at: Counts, met: Array, out: Array) -> None:
    """Write the output between the samples at which a line was marched: straight over the input, or bent once.

    Where a hold ends between two of them the output has a corner there: the lines that lead into the stretch and out of it
    meet inside it. Where the input rests the output is straight over time.
    """
    last = at.size - 1
    for k in range(last):
        u, dy = tension[at[k]], met[k + 1] - met[k]
        du, steps = tension[at[k + 1]] - u, at[k + 1] - at[k]
        corner = into = away = 0.0
        if steps > 1 and 0 < k < last - 1:
            before, behind = u - tension[at[k - 1]], tension[at[k + 2]] - tension[at[k + 1]]
            if before * du > 0.0 and behind * du > 0.0:
                into, away = (met[k] - met[k - 1]) / before, (met[k + 2] - met[k + 1]) / behind
                corner = (dy - away * du) / ((into - away) * du) if into != away else 0.0
                bent = into * corner * du
                # a corner outside of what was met at both ends is none
                if bent * (dy - bent) < 0.0:
                    corner = 0.0
        for x in range(at[k], at[k + 1]):
            come = tension[x] - u
            share = come / du if du != 0.0 else (x - at[k]) / steps
            if 0.0 < corner < 1.0:
                out[x] = met[k] + into * come if share < corner else met[k + 1] + away * (come - du)
            else:
                out[x] = met[k] + dy * min(max(share, 0.0), 1.0)
    out[at[last] :] = met[last]


@njit(cache=True, error_model="numpy", nogil=True)
def _march(
    tension: Array,
    steps: Array,
    phi_pull: Array,
    phi_release: Array,
    constant: Array,
    drag: Array,
    elastic: Array,
    creep: Array,
    pulley: Array,
    breakaway: Array,
    scale: Array,
    factor: Array,
    factor_step: float,
    start: float,
    scalars: Array,
) -> Array:
    """March one line through the input tensions, one implicit step each."""
    creep_s, static_ratio, static_speed, aging = scalars[0], scalars[1], scalars[2], scalars[3]
    aging_s, stribeck_ratio, stribeck_speed, tail = scalars[4], scalars[5], scalars[6], scalars[7]
    smooth = tail >= 0.0
    n, nodes = tension.size, elastic.size
    offset, crept = np.zeros(nodes), np.zeros(nodes)
    inverse = 1.0 / elastic
    creeping, dragging = creep.max() > 0.0, drag.max() > 0.0
    out = np.empty(n)
    u, u_old = np.zeros(nodes + 1), np.zeros(nodes + 1)
    force, force_old = np.zeros(nodes), np.zeros(nodes)
    pull, release = np.empty(nodes), np.empty(nodes)
    stiff, mode = np.empty(nodes), np.zeros(nodes, np.int64)
    lower, stay, viscous = np.empty(nodes), np.empty(nodes), np.zeros(nodes)
    residual, share, rhs, middle = np.empty(nodes), np.empty(nodes), np.empty(nodes), nodes // 2
    left_old, after = np.empty(nodes), np.empty(nodes)
    speed, excess, age, went = np.zeros(nodes), np.full(nodes, 0.0), np.zeros(nodes), np.zeros(nodes)
    hold = constant + pulley[:, 2]
    loose = (phi_pull == 0.0) & (constant == 0.0) & (pulley[:, 0] + pulley[:, 1] + pulley[:, 2] == 0.0)
    rigid = np.where(loose, 0.0, 1.0 / breakaway)
    # the start: a line at rest at its output tension, whose input then moved to the first sample
    t = tension[0]
    for j in range(nodes):
        left_old[j] = t
        if tension[0] >= start:
            right = min(max(t * math.exp(-phi_pull[j] * scale[0] - pulley[j, 0]) - hold[j], start), t)
        else:
            right = max(min(t * math.exp(phi_release[j] * scale[0] + pulley[j, 1]) + hold[j], start), t)
        force_old[j] = t - right
        t = right
    for j in range(nodes - 1, -1, -1):
        t = left_old[j] - force_old[j]
        # before the first sample the line has rested: its creep is complete
        crept[j] = creep[j] * t
        u_old[j] = u_old[j + 1] + elastic[j] * t + crept[j]
    nonlinear = False
    for x in factor:
        if x != 1.0:
            nonlinear = True
    sticky = static_ratio > 1.0 or aging > 0.0
    moving = stribeck_ratio > 1.0
    changing = nonlinear or sticky or moving or scale.size > 1
    for k in range(n):
        dt = steps[k]
        mu = scale[k] if scale.size > 1 else scale[0]
        if creeping:
            # standard linear solid, implicit: the creep strain relaxes to creep * T
            r = dt / creep_s
            for j in range(nodes):
                inverse[j] = 1.0 / (elastic[j] + creep[j] * r / (1.0 + r))
                offset[j] = crept[j] / (1.0 + r)
        if changing or k == 0:
            for j in range(nodes):
                if loose[j] and k > 0:
                    continue
                s = mu
                if nonlinear:
                    x = min(left_old[j] / factor_step, factor.size - 1.001)
                    i = max(int(x), 0)
                    s *= factor[i] + (x - i) * (factor[i + 1] - factor[i])
                if moving:
                    v = speed[j] / stribeck_speed
                    if v < NOTHING_LEFT:
                        s *= 1.0 + (stribeck_ratio - 1.0) * math.exp(-v * v)
                if sticky:
                    s *= 1.0 + excess[j]
                    if aging > 0.0:
                        s *= 1.0 + aging * math.log(1.0 + age[j] / aging_s)
                a, b = phi_pull[j] * s, phi_release[j] * s
                pull[j] = a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a / 24.0))) + pulley[j, 0] * (1.0 - 0.5 * pulley[j, 0])
                release[j] = b * (1.0 + b * (0.5 + b * (1.0 / 6.0 + b / 24.0))) + pulley[j, 1] * (1.0 + 0.5 * pulley[j, 1])
        for j in range(nodes):
            limit = 0.5 * (pull[j] + release[j]) * max(left_old[j], 0.0) + hold[j]
            stiff[j] = max(limit, 1e-4) * rigid[j]
            # a smooth line goes on as it went; the modes of the other kind are those of the step before
            u[j] = u_old[j] + (went[j] * dt / steps[k - 1] if smooth and k > 0 else 0.0)
        if dragging:
            for j in range(nodes):
                viscous[j] = drag[j] / dt
        settled = False
        for iteration in range(MAX_ITERATIONS):
            changed = False
            t_left, inverse_left = tension[k], 0.0
            for j in range(nodes):
                t_right = (u[j] - u[j + 1] - offset[j]) * inverse[j]
                high = pull[j] * t_left + hold[j]
                low = -release[j] * t_left - hold[j]
                moved = u[j] - u_old[j]
                if smooth:
                    force[j], stays, follows = built_up(moved * rigid[j], mode[j], force_old[j], low, high, pull[j], release[j], tail)
                    lower[j], stay[j] = (1.0 - follows) * inverse_left, stays * rigid[j] + viscous[j]
                    residual[j] = t_left - t_right - force[j] - viscous[j] * moved
                    changed = changed or abs(residual[j]) > BALANCE_N
                    if moved != 0.0:
                        mode[j] = 1 if moved > 0.0 else -1
                    after[j] = t_right
                    t_left, inverse_left = t_right, inverse[j]
                    continue
                trial = force_old[j] + stiff[j] * moved
                # a slipping node must stick before it slips the other way, so that modes cannot cycle; the first
                # pass trusts the modes of the step before
                new = mode[j]
                if iteration > 0:
                    if (new == 1 and trial < high - MODE_TOLERANCE_N) or (new == -1 and trial > low + MODE_TOLERANCE_N):
                        new = 0
                    elif new == 0 and trial > high + MODE_TOLERANCE_N and stiff[j] > 0.0:
                        new = 1
                    elif new == 0 and trial < low - MODE_TOLERANCE_N and stiff[j] > 0.0:
                        new = -1
                    if new != mode[j]:
                        changed = True
                        mode[j] = new
                if new == 1:
                    force[j], lower[j], stay[j] = high, (1.0 - pull[j]) * inverse_left, viscous[j]
                elif new == -1:
                    force[j], lower[j], stay[j] = low, (1.0 + release[j]) * inverse_left, viscous[j]
                else:
                    force[j], lower[j], stay[j] = trial, inverse_left, stiff[j] + viscous[j]
                residual[j] = t_left - t_right - force[j] - viscous[j] * moved
                after[j] = t_right
                t_left, inverse_left = t_right, inverse[j]
            # given the modes the balance is linear: if they stay, the step before has solved it
            if (iteration > 0 or smooth) and not changed:
                settled = True
                break
            # elimination from both ends to the middle: two chains of divisions that do not wait for one another
            left, left_r, right, right_r = 0.0, 0.0, 0.0, 0.0
            for i in range(middle):
                pivot = 1.0 / (lower[i] * (1.0 - left) + inverse[i] + stay[i])
                left_r = (residual[i] + lower[i] * left_r) * pivot
                left = inverse[i] * pivot
                share[i], rhs[i] = left, left_r
                j = nodes - 1 - i
                if j > middle:
                    pivot = 1.0 / (lower[j] + inverse[j] * (1.0 - right) + stay[j])
                    right_r = (residual[j] + inverse[j] * right_r) * pivot
                    right = lower[j] * pivot
                    share[j], rhs[j] = right, right_r
            j = middle
            pivot = lower[j] * (1.0 - left) + inverse[j] * (1.0 - right) + stay[j]
            before = behind = (residual[j] + lower[j] * left_r + inverse[j] * right_r) / pivot
            u[j] += before
            for i in range(1, middle + 1):
                before = rhs[middle - i] + share[middle - i] * before
                u[middle - i] += before
                if middle + i < nodes:
                    behind = rhs[middle + i] + share[middle + i] * behind
                    u[middle + i] += behind
            if smooth:
                # from rest friction is concave, and Newton's steps stay short of the balance: none may pass through rest
                for j in range(nodes):
                    if (u[j] - u_old[j]) * mode[j] < 0.0:
                        u[j], mode[j] = u_old[j], 0
        if not settled:
            for j in range(nodes):
                after[j] = (u[j] - u[j + 1] - offset[j]) * inverse[j]
        if moving:
            fresh = 1.0 - math.exp(-dt / SPEED_MEMORY_S)
            for j in range(nodes):
                speed[j] += (abs(u[j] - u_old[j]) / dt - speed[j]) * fresh
        if sticky:
            healed = static_speed * dt / HEALING_MM
            rested = math.exp(-healed)
            for j in range(nodes):
                if loose[j]:
                    continue
                worn = abs(u[j] - u_old[j] - (force[j] - force_old[j]) / stiff[j]) / RENEWAL_MM
                wear = math.exp(-worn) if worn > 1e-15 else 1.0
                if static_ratio > 1.0:
                    goal = (static_ratio - 1.0) * healed / (healed + worn)
                    excess[j] = goal + (excess[j] - goal) * rested * wear
                if aging > 0.0:
                    age[j] = age[j] * wear + dt * ((1.0 - wear) / worn if worn > 1e-9 else 1.0)
        for j in range(nodes):
            force_old[j] = force[j]
            went[j] = u[j] - u_old[j]
            u_old[j] = u[j]
        left_old[0] = tension[k]
        left_old[1:] = after[:-1]
        out[k] = max(after[nodes - 1], 0.0)
        if creeping:
            r = dt / creep_s
            for j in range(nodes):
                crept[j] = offset[j] + creep[j] * after[j] * r / (1.0 + r)
    return out
