"""The march of one elastic line, plain and slow: a node is an object, a step's balance a dense system of equations."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from sstl_cli.physics.transmission import march, state
from sstl_cli.physics.transmission.balance import LEAST_MM_S, LEAST_N, MAX_ITERATIONS, MODE_TOLERANCE_N

# a smooth line is followed closer than the compiled march follows it
BALANCE_N = 1e-9


def marched(tension, steps, scale, lines, i):
    """Return the outputs (N) of line ``i`` of Lines for inputs (N), times of steps (s) and factors on mu, one a knot."""
    law = SimpleNamespace(**{k: lines.laws[i, getattr(state, k.upper())] for k in (
        "creep_s", "creep_spread", "static", "static_speed", "aging", "aging_s", "stribeck", "stribeck_speed", "tail", "bristle_n", "thinning", "factor_step",
    )}, factors=lines.factors[i], smooth=lines.laws[i, state.TAIL] >= 0.0)  # fmt: skip
    nodes = [_node(lines.given[i, :, j]) for j in range(lines.nodes[i])]
    _rest(nodes, tension[0], scale[0], lines.start[i])
    out, dt_old = [], 1.0
    for t, dt, mu in zip(tension, steps, scale, strict=True):
        for node in nodes:
            _prepare(node, dt, mu, dt / dt_old, law)
        _balance(nodes, t, dt, law)
        left = t
        for node in nodes:
            _remember(node, dt, left, law)
            left = node.after
        out.append(max(left, 0.0))
        dt_old = dt
    return np.array(out)


def _node(given):
    names = ("phi_pull", "phi_release", "hold", "drag", "elastic", "creep", "pulley_pull", "pulley_release", "rigid")
    return SimpleNamespace(**dict(zip(names, given, strict=True)), mode=0, went=0.0, speed=0.0, excess=0.0, age=0.0)


def _rest(nodes, tension, scale, start):
    """Put a line to rest at its output tension; its input then moved to the first sample."""
    t = tension
    for node in nodes:
        node.left = t
        pulled = t * math.exp(-node.phi_pull * scale - node.pulley_pull) - node.hold
        released = t * math.exp(node.phi_release * scale + node.pulley_release) + node.hold
        node.after = min(max(pulled, start), t) if tension >= start else max(min(released, start), t)
        node.force_old = t - node.after
        t = node.after
    u = 0.0
    for node in reversed(nodes):
        # three elements, a third of the creep each
        node.crept = np.full(3, node.creep * node.after / 3.0)
        u += node.elastic * node.after + node.crept.sum()
        node.u = node.u_old = u


def _prepare(node, dt, mu, longer, law):
    """Set what stays as it is during a step: limits, stiffness, creep."""
    r = dt / (law.creep_s * law.creep_spread ** np.array([-1.0, 0.0, 1.0]))
    node.compliance = node.elastic + node.creep * np.mean(r / (1.0 + r))
    node.kept = node.crept / (1.0 + r)
    node.offset = node.kept.sum()
    at = np.arange(state.FACTOR_NODES) * law.factor_step
    s = mu * float(np.interp(node.left, at, law.factors))
    s *= 1.0 + (law.stribeck - 1.0) * math.exp(-min((node.speed / law.stribeck_speed) ** 2, 700.0))
    s *= (1.0 + node.excess) * (1.0 + law.aging * math.log(1.0 + node.age / law.aging_s))
    a, b, c, d = node.phi_pull * s, node.phi_release * s, node.pulley_pull, node.pulley_release
    node.pull = sum(-((-a) ** k) / math.factorial(k) for k in range(1, 5)) + c - c * c / 2.0
    node.release = sum(b**k / math.factorial(k) for k in range(1, 5)) + d + d * d / 2.0
    limit = 0.5 * (node.pull + node.release) * (law.bristle_n or max(node.left, 0.0)) + node.hold
    node.stiff, node.viscous = max(limit, LEAST_N) * node.rigid, node.drag / dt * (node.speed + LEAST_MM_S) ** (law.thinning - 1.0)
    if law.smooth:
        node.u = node.u_old + node.went * longer


def _balance(nodes, tension, dt, law):
    """Move the nodes until all forces balance."""
    for iteration in range(MAX_ITERATIONS):
        left, before, n = tension, 0.0, len(nodes)
        a, lacks, changed = np.zeros((n, n)), np.zeros(n), False
        for j, node in enumerate(nodes):
            right = nodes[j + 1].u if j + 1 < n else 0.0
            node.after = (node.u - right - node.offset) / node.compliance
            moved, high, low = node.u - node.u_old, node.pull * left + node.hold, -node.release * left - node.hold
            if law.smooth:
                force, stays, follows = built_up(
                    moved * node.rigid, node.mode, node.force_old, low, high, node.pull, node.release, law.tail
                )
                stays *= node.rigid
                node.mode = int(np.sign(moved)) or node.mode
            else:
                trial = node.force_old + node.stiff * moved
                if iteration:
                    mode = _mode(node, trial, low, high)
                    changed, node.mode = changed or mode != node.mode, mode
                force, stays, follows = {1: (high, 0.0, node.pull), -1: (low, 0.0, -node.release), 0: (trial, node.stiff, 0.0)}[node.mode]
            node.force = force
            lacks[j] = left - node.after - force - node.viscous * moved
            # d lacks / d u, with the tension before it as it depends on its own displacement and that of the node before
            a[j, j] += 1.0 / node.compliance + stays + node.viscous + (1.0 - follows) * before
            if j:
                a[j, j - 1] -= (1.0 - follows) * before
            if j + 1 < n:
                a[j, j + 1] -= 1.0 / node.compliance
            left, before = node.after, 1.0 / node.compliance
        if (np.abs(lacks).max() <= BALANCE_N) if law.smooth else (iteration > 0 and not changed):
            return
        for node, step in zip(nodes, np.linalg.solve(a, lacks), strict=True):
            node.u += step
            if law.smooth and (node.u - node.u_old) * node.mode < 0.0:
                node.u, node.mode = node.u_old, 0
    for j, node in enumerate(nodes):
        node.after = (node.u - (nodes[j + 1].u if j + 1 < n else 0.0) - node.offset) / node.compliance


def _mode(node, trial, low, high):
    """Return whether a node sticks (0) or slips one way (1) or the other (-1); it sticks before it slips the other way."""
    if node.mode == 1:
        return 0 if trial < high - MODE_TOLERANCE_N else 1
    if node.mode == -1:
        return 0 if trial > low + MODE_TOLERANCE_N else -1
    if node.stiff == 0.0:
        return 0
    return 1 if trial > high + MODE_TOLERANCE_N else -1 if trial < low - MODE_TOLERANCE_N else 0


def _remember(node, dt, left, law):
    """Carry over to the next step what laws depend on."""
    node.went = node.u - node.u_old
    node.speed += (abs(node.went) / dt - node.speed) * (1.0 - math.exp(-dt / march.SPEED_MEMORY_S))
    if node.stiff > 0.0:
        healed = law.static_speed * dt / march.HEALING_MM
        worn = abs(node.went - (node.force - node.force_old) / node.stiff) / march.RENEWAL_MM
        wear = math.exp(-worn)
        goal = (law.static - 1.0) * healed / (healed + worn)
        node.excess = goal + (node.excess - goal) * math.exp(-healed) * wear
        node.age = node.age * wear + dt * ((1.0 - wear) / worn if worn > 1e-9 else 1.0)
    r = dt / (law.creep_s * law.creep_spread ** np.array([-1.0, 0.0, 1.0]))
    node.crept = node.kept + node.creep / 3.0 * node.after * r / (1.0 + r)
    node.force_old, node.u_old, node.left = node.force, node.u, left


def built_up(way, towards, force_old, low, high, pull, release, tail):
    """Return friction that builds up ever more slowly, and its slopes over the way and over the tension before."""
    kept, keeps = force_old, 0.0
    if kept > high:
        kept, keeps = high, pull
    elif kept < low:
        kept, keeps = low, -release

    def steep(missing):
        return (1.0 - tail) * math.sqrt(missing) + tail * missing

    if way == 0.0:
        up = high * steep(max(1.0 - kept / high, 0.0)) if high > 0.0 and towards >= 0 else 0.0
        down = -low * steep(max(1.0 - kept / low, 0.0)) if low < 0.0 and towards <= 0 else 0.0
        return kept, max(up, down), keeps
    limit, follows = (high, pull) if way > 0.0 else (low, -release)
    missing = 1.0 - kept / limit if limit != 0.0 else 0.0
    if missing <= 1e-12:
        return limit, 0.0, follows
    root, half = math.sqrt(missing), 0.5 * abs(way)
    end = (1.0 - tail) / tail if tail > 0.0 else 0.0
    root = (root + end) * math.exp(-tail * half) - end if tail > 0.0 else root - half
    left = max(root, 0.0) ** 2
    remembers = steep(left) / steep(missing)
    return limit * (1.0 - left), abs(limit) * steep(left), follows * (1.0 - left - (1.0 - missing) * remembers) + keeps * remembers
