"""A coarse elastic line, for effects that act along the tendon: presliding, drag, static friction.

Nodes sit in the bend; the straight parts only stretch (and drag). Without such effects the nodes are
a cascade of plays, which is one play; with them tension diffuses and friction turns round gradually.
Balance of node j, displacement u_j towards the drive:
T_(j-1) - T_j - F_j - c_j du_j/dt = 0, with the friction F_j between the exact capstan bounds
(exp(phi) - 1) T_(j-1) of releasing and (1 - exp(-phi)) T_(j-1) of pulling, built up elastically.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.effect import Drive, Law, Transition

Array = NDArray[np.float64]
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
FACTOR_NODES = 64
# least compliance between two nodes, as a share of a pass
LEAST_COMPLIANCE = 1e-4


def elastic_line(drive: Drive, theta: float, law: Law, transition: Transition, scale: Array, start_n: float) -> Array:
    """Return the true output tension (N, shape (n,)) of the elastic line.

    Parameters
    ----------
    scale : ndarray, shape (n,) or (1,)
        Time-varying factor on mu.
    start_n : float
        Output tension before the first sample (N).
    """
    phi, constant, drag, gap, stretch, pulley = _nodes(drive, theta, law, transition)
    knots = drive.knots
    top = max(float(drive.tension_n.max(initial=1.0)), 1.0)
    factor_step = 2.0 * top * math.exp(2.0 * theta) / (FACTOR_NODES - 1)
    factor = np.ones(FACTOR_NODES)
    for f in law.factors:
        factor = factor * f(np.asarray(np.arange(FACTOR_NODES) * factor_step, np.float64))
    breakaway = _breakaway(transition, len(phi))
    out = _march(
        drive.tension_n[knots],
        np.diff(drive.time_s[knots], prepend=drive.time_s[knots[0]] - drive.dt_s),
        phi * law.scale_pull,
        phi * law.scale_release,
        constant,
        drag,
        gap,
        stretch * transition.creep_fraction,
        transition.creep_s,
        pulley,
        breakaway,
        scale[knots] if scale.size > 1 else scale,
        factor,
        factor_step,
        start_n,
        transition.static_ratio,
        transition.static_mm_s,
        transition.aging,
        transition.aging_s,
        transition.stribeck_ratio,
        transition.stribeck_mm_s,
    )
    return np.interp(np.arange(len(drive.tension_n)), knots, out)


def _nodes(
    drive: Drive, theta: float, law: Law, transition: Transition
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return per node: bend friction, constant friction (N), drag (N s/mm), compliance behind it (mm/N), of which tendon, pulley."""
    m = drive.mechanics
    before, behind = m.straight(drive.location)
    arc = m.arc_fraction
    share = np.concatenate(([before], np.full(ARC_NODES, arc / ARC_NODES), [behind]))
    bend = np.concatenate(([0.0], np.full(ARC_NODES, theta / ARC_NODES), [0.0]))
    none = np.zeros((len(bend), 3))
    if drive.system == "sstl":
        share = np.concatenate((share, [0.0], share[::-1]))
        pulley = np.zeros((len(share), 3))
        pulley[len(bend)] = (law.pulley_pull, law.pulley_release, law.pulley_n)
        bend = np.concatenate((bend, [0.0], bend[::-1]))
    else:
        pulley = none
    # friction of a stretch sits in its middle: half of its compliance lies behind it
    half = 0.5 * share * m.tendon_mm_per_n
    gap = half.copy()
    gap[:-1] += half[1:]
    # a bend that reaches the end of the tube leaves no tendon between two nodes, which the balance cannot have
    gap = np.maximum(gap, LEAST_COMPLIANCE * m.tendon_mm_per_n)
    stretch = gap.copy()
    gap[-1] += m.load_mm_per_n
    # drag along the whole tendon, and drag where the bend presses it against the sheath
    drag = transition.drag_n_s_mm * share + transition.drag_bend_n_s_mm * bend
    return bend, law.constant_n * share, drag, gap, stretch, pulley


def _breakaway(transition: Transition, nodes: int) -> Array:
    """Return the break-away distance of each node (mm), spread evenly and shuffled by a fixed stride."""
    if transition.breakaway_mm <= 0.0:
        return np.full(nodes, RIGID_MM)
    order = (np.arange(nodes) * 5 + 2) % nodes if nodes % 5 else (np.arange(nodes) * 7 + 2) % nodes
    quantile = (order + 0.5) / nodes * 2.0 - 1.0
    return np.maximum(transition.breakaway_mm * (1.0 + transition.spread * quantile), 0.0) + RIGID_MM


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
    creep_s: float,
    pulley: Array,
    breakaway: Array,
    scale: Array,
    factor: Array,
    factor_step: float,
    start: float,
    static_ratio: float,
    static_speed: float,
    aging: float,
    aging_s: float,
    stribeck_ratio: float,
    stribeck_speed: float,
) -> Array:
    """March the line through the input tensions, one implicit step each."""
    n, nodes = tension.size, elastic.size
    gap, offset, crept = elastic.copy(), np.zeros(nodes), np.zeros(nodes)
    creeping = creep.max() > 0.0
    out = np.empty(n)
    u, u_old = np.zeros(nodes + 1), np.zeros(nodes + 1)
    force, force_old = np.zeros(nodes), np.zeros(nodes)
    pull, release = np.empty(nodes), np.empty(nodes)
    stiff, mode = np.empty(nodes), np.zeros(nodes, np.int64)
    upper, rhs = np.empty(nodes), np.empty(nodes)
    left_old = np.empty(nodes)
    speed, excess, age = np.zeros(nodes), np.full(nodes, 0.0), np.zeros(nodes)
    # the start: a line at rest at its output tension, whose input then moved to the first sample
    t = tension[0]
    for j in range(nodes):
        left_old[j] = t
        c = constant[j] + pulley[j, 2]
        if tension[0] >= start:
            right = min(max(t * math.exp(-phi_pull[j] * scale[0] - pulley[j, 0]) - c, start), t)
        else:
            right = max(min(t * math.exp(phi_release[j] * scale[0] + pulley[j, 1]) + c, start), t)
        force_old[j] = t - right
        t = right
    u_old[nodes] = 0.0
    for j in range(nodes - 1, -1, -1):
        t = left_old[j] - force_old[j]
        # before the first sample the line has rested: its creep is complete
        crept[j] = creep[j] * t
        u_old[j] = u_old[j + 1] + gap[j] * t + crept[j]
    nonlinear = False
    for x in factor:
        if x != 1.0:
            nonlinear = True
    sticky = static_ratio > 1.0 or aging > 0.0
    moving = stribeck_ratio > 1.0
    for k in range(n):
        dt = steps[k]
        mu = scale[k] if scale.size > 1 else scale[0]
        if creeping:
            # standard linear solid, implicit: the creep strain relaxes to creep * T
            r = dt / creep_s
            for j in range(nodes):
                gap[j] = elastic[j] + creep[j] * r / (1.0 + r)
                offset[j] = crept[j] / (1.0 + r)
        for j in range(nodes):
            s = mu
            if nonlinear:
                x = min(left_old[j] / factor_step, factor.size - 1.001)
                i = max(int(x), 0)
                s *= factor[i] + (x - i) * (factor[i + 1] - factor[i])
            if moving:
                v = speed[j] / stribeck_speed
                s *= 1.0 + (stribeck_ratio - 1.0) * math.exp(-v * v)
            if sticky:
                s *= (1.0 + excess[j]) * (1.0 + aging * math.log(1.0 + age[j] / aging_s))
            a, b = phi_pull[j] * s, phi_release[j] * s
            pull[j] = a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a / 24.0))) + pulley[j, 0] * (1.0 - 0.5 * pulley[j, 0])
            release[j] = b * (1.0 + b * (0.5 + b * (1.0 / 6.0 + b / 24.0))) + pulley[j, 1] * (1.0 + 0.5 * pulley[j, 1])
            limit = 0.5 * (pull[j] + release[j]) * max(left_old[j], 0.0) + constant[j] + pulley[j, 2]
            stiff[j] = max(limit, 1e-4) / breakaway[j]
            if phi_pull[j] == 0.0 and constant[j] == 0.0 and pulley[j, 0] + pulley[j, 1] + pulley[j, 2] == 0.0:
                stiff[j] = 0.0
            u[j] = u_old[j]
        t_in = tension[k]
        for iteration in range(MAX_ITERATIONS):
            changed = False
            t_left = t_in
            carry = 0.0
            carry_r = 0.0
            for j in range(nodes):
                inverse_left = 1.0 / gap[j - 1] if j else 0.0
                if j:
                    t_left = (u[j - 1] - u[j] - offset[j - 1]) * inverse_left
                inverse_right = 1.0 / gap[j]
                t_right = (u[j] - u[j + 1] - offset[j]) * inverse_right
                c = constant[j] + pulley[j, 2]
                high = pull[j] * t_left + c
                low = -release[j] * t_left - c
                trial = force_old[j] + stiff[j] * (u[j] - u_old[j])
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
                slope, tangent = 0.0, 0.0
                if new == 1:
                    friction, slope = high, pull[j]
                elif new == -1:
                    friction, slope = low, -release[j]
                else:
                    friction, tangent = trial, stiff[j]
                viscous = drag[j] / dt
                residual = t_left - t_right - friction - viscous * (u[j] - u_old[j])
                force[j] = friction
                lower = (1.0 - slope) * inverse_left
                diagonal = -(1.0 - slope) * inverse_left - inverse_right - tangent - viscous
                # Thomas algorithm, forward sweep fused with the assembly
                pivot = diagonal - lower * carry
                carry = inverse_right / pivot
                carry_r = (-residual - lower * carry_r) / pivot
                upper[j] = carry
                rhs[j] = carry_r
            du = 0.0
            for j in range(nodes - 1, -1, -1):
                du = rhs[j] - upper[j] * du
                u[j] += du
            if iteration > 0 and not changed:
                break
        t_left = t_in
        for j in range(nodes):
            if j:
                t_left = (u[j - 1] - u[j] - offset[j - 1]) / gap[j - 1]
            slip = abs(u[j] - u_old[j] - ((force[j] - force_old[j]) / stiff[j] if stiff[j] > 0.0 else 0.0))
            if moving:
                speed[j] += (abs(u[j] - u_old[j]) / dt - speed[j]) * (1.0 - math.exp(-dt / SPEED_MEMORY_S))
            if sticky:
                worn = slip / RENEWAL_MM
                if static_ratio > 1.0:
                    healed = static_speed * dt / HEALING_MM
                    goal = (static_ratio - 1.0) * healed / (healed + worn)
                    excess[j] = goal + (excess[j] - goal) * math.exp(-(healed + worn))
                wear = math.exp(-worn)
                age[j] = age[j] * wear + dt * ((1.0 - wear) / worn if worn > 1e-9 else 1.0)
            left_old[j] = t_left
            force_old[j] = force[j]
            u_old[j] = u[j]
        out[k] = max((u[nodes - 1] - offset[nodes - 1]) / gap[nodes - 1], 0.0)
        if creeping:
            r = dt / creep_s
            for j in range(nodes):
                t = (u[j] - u[j + 1] - offset[j]) / gap[j]
                crept[j] = offset[j] + creep[j] * t * r / (1.0 + r)
    return out
