"""The march along elastic lines: one implicit step from knot to knot, several lines side by side (see lanes).

A line that has ended makes place for the next one. The balances of lines side by side are solved together, and one that is met
keeps still while others are not: no line's result depends on what goes beside it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.transmission.balance import set_out, settle
from sstl_cli.physics.transmission.lanes import WIDTH, exp, log, put, row, rows, select, size, some, wide
from sstl_cli.physics.transmission.state import (
    AFTER,
    AGE,
    AGING,
    AGING_S,
    BRISTLE_N,
    BUSY,
    CREEP,
    CREEP_S,
    CREEP_SPREAD,
    CREPT,
    CREPT_FAST,
    CREPT_SLOW,
    DRAG,
    ELASTIC,
    EXCESS,
    FACTOR,
    FACTOR_NODES,
    FACTOR_STEP,
    FIELDS,
    FORCE,
    FORCE_OLD,
    GIVEN,
    HOLD,
    INVERSE,
    LAWS,
    LEFT,
    OFFSET,
    PHI_PULL,
    PHI_RELEASE,
    PULL,
    PULLEY_PULL,
    PULLEY_RELEASE,
    RELEASE,
    RIGID,
    SPEED,
    STATIC,
    STATIC_SPEED,
    STEP_OLD,
    STIFF,
    STRIBECK,
    STRIBECK_SPEED,
    TAIL,
    THINNING,
    U_OLD,
    WENT,
    Input,
    Kind,
    Lines,
    U,
)  # fmt: skip

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
# slip that wears off a contact's static excess and travel in which it heals (mm); memory of the sliding speed (s)
RENEWAL_MM = 0.02
HEALING_MM = 0.5
SPEED_MEMORY_S = 0.005
# Kelvin elements of a creep whose times are spread
ELEMENTS = 3
# knots that are marched at once, so that what goes in and out of them stays near the processor
BLOCK = 128


@njit(cache=True, error_model="numpy", nogil=True)
def march_all(into: Input, lines: Lines, order: Counts, groups: Counts) -> Array:
    """March lines through their knots; between them the output is a straight line.

    Parameters
    ----------
    order : ndarray of int, shape (lines,)
        Lines as their turn comes: those ``groups[g]`` to ``groups[g + 1]`` are of one kind and have as many nodes.

    Returns
    -------
    ndarray, shape (n,)
        True output tensions (N).
    """
    met = np.empty(into.knots.size)
    for g in range(groups.size - 1):
        _march_group(into, lines, order[groups[g] : groups[g + 1]], met)
    out = np.empty(into.tension.size)
    for i in range(order.size):
        a, b, c, d = into.edges[i], into.edges[i + 1], into.knot_edges[i], into.knot_edges[i + 1]
        _between_knots(into.tension[a:b], into.knots[c:d], met[c:d], out[a:b])
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
def _kind(into: Input, lines: Lines, order: Counts) -> Kind:
    """Return what is at work in any of some lines."""
    creeping = dragging = nonlinear = static = aging = moving = thinning = spread = False
    for i in order:
        creeping = creeping or lines.given[i, CREEP].max() > 0.0
        spread = spread or lines.laws[i, CREEP_SPREAD] != 1.0
        dragging = dragging or lines.given[i, DRAG].max() > 0.0
        static = static or lines.laws[i, STATIC] > 1.0
        aging = aging or lines.laws[i, AGING] > 0.0
        moving = moving or lines.laws[i, STRIBECK] > 1.0
        thinning = thinning or lines.laws[i, THINNING] != 1.0
        for x in lines.factors[i]:
            nonlinear = nonlinear or x != 1.0
    changing = nonlinear or static or aging or moving or into.scale.size > 1
    smooth = lines.laws[order[0], TAIL] >= 0.0
    return Kind(creeping, dragging, nonlinear, static, aging, moving, changing, smooth, dragging and thinning, creeping and spread)


@njit(cache=True, error_model="numpy", nogil=True)
def _march_group(into: Input, lines: Lines, order: Counts, met: Array) -> None:
    """March lines of one kind, each in the lane that is free when its turn comes, and write their outputs at the knots (N)."""
    kind, nodes = _kind(into, lines, order), lines.nodes[order[0]]
    state, laws, table = rows((nodes + 1) * FIELDS), rows(LAWS + 2), np.ones((WIDTH, FACTOR_NODES))
    busy = laws[BUSY]
    tension, steps, scale, out = rows(BLOCK), rows(BLOCK), rows(BLOCK), rows(BLOCK)
    line, at, end, waiting = np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64), 0
    while True:
        count = BLOCK + 1
        for lane in range(WIDTH):
            if at[lane] == end[lane] and waiting < order.size:
                i = order[waiting]
                waiting += 1
                line[lane], at[lane], end[lane] = i, into.knot_edges[i], into.knot_edges[i + 1]
                first = into.edges[i]
                mu = into.scale[first] if into.scale.size > 1 else into.scale[0]
                _begin(lines, i, into.tension[first + into.knots[at[lane]]], mu, state[:, lane], laws[:, lane], kind.spread)
                table[lane] = lines.factors[i]
            busy[lane] = 1.0 if at[lane] < end[lane] else 0.0
            if at[lane] < end[lane]:
                count = min(count, end[lane] - at[lane])
        if count > BLOCK and not busy.any():
            return
        count = min(count, BLOCK)
        for lane in range(WIDTH):
            if busy[lane] > 0.0:
                first = into.edges[line[lane]]
                for k in range(count):
                    x = first + into.knots[at[lane] + k]
                    tension[k, lane], steps[k, lane] = into.tension[x], into.steps[at[lane] + k]
                    scale[k, lane] = into.scale[x] if into.scale.size > 1 else into.scale[0]
        _march(state, laws, table, tension[:count], steps, scale, out, kind)
        for lane in range(WIDTH):
            if busy[lane] > 0.0:
                met[at[lane] : at[lane] + count] = out[:count, lane]
                at[lane] += count


@njit(cache=True, error_model="numpy", nogil=True)
def _begin(lines: Lines, i: int, tension: float, scale: float, state: Array, laws: Array, spread: bool) -> None:
    """Set a lane to the start of a line: at rest at its output tension, whose input then moved to the first sample."""
    nodes, start = lines.nodes[i], lines.start[i]
    state[:] = 0.0
    laws[:LAWS], laws[STEP_OLD] = lines.laws[i], 1.0
    t = tension
    for j in range(nodes):
        node, given = state[j * FIELDS : (j + 1) * FIELDS], lines.given[i, :, j]
        node[:GIVEN] = given
        node[INVERSE], node[LEFT] = 1.0 / given[ELASTIC], t
        if tension >= start:
            right = min(max(t * math.exp(-given[PHI_PULL] * scale - given[PULLEY_PULL]) - given[HOLD], start), t)
        else:
            right = max(min(t * math.exp(given[PHI_RELEASE] * scale + given[PULLEY_RELEASE]) + given[HOLD], start), t)
        node[FORCE_OLD], node[AFTER] = t - right, right
        t = right
    for j in range(nodes - 1, -1, -1):
        node = state[j * FIELDS : (j + 1) * FIELDS]
        # before the first sample the line has rested: its creep is complete
        crept = node[CREEP] * node[AFTER]
        node[CREPT] = crept / ELEMENTS if spread else crept
        if spread:
            node[CREPT_FAST] = node[CREPT_SLOW] = node[CREPT]
        node[U_OLD] = state[(j + 1) * FIELDS + U_OLD] + node[ELASTIC] * node[AFTER] + crept
        node[U] = node[U_OLD]


@njit(cache=True, error_model="numpy", nogil=True)
def _march(state: Array, laws: Array, table: Array, tension: Array, steps: Array, scale: Array, out: Array, kind: Kind) -> None:
    """March the lanes through a block of input tensions, one implicit step each."""
    nodes = state.shape[0] // FIELDS - 1
    gone = fast = slow = wide(0.0)
    for k in range(tension.shape[0]):
        dt, t_in = row(steps, k), row(tension, k)
        if kind.spread:
            fast, gone, slow = _relax_spread(state, nodes, dt / row(laws, CREEP_S), row(laws, CREEP_SPREAD))
        elif kind.creeping:
            gone = _relax(state, nodes, dt / row(laws, CREEP_S))
        if kind.changing or k == 0:
            _limits(state, laws, table, nodes, row(scale, k), kind)
        set_out(state, nodes, t_in, dt, dt / row(laws, STEP_OLD), row(laws, BRISTLE_N), row(laws, THINNING) - 1.0, kind)
        settle(state, nodes, t_in, row(laws, TAIL), row(laws, BUSY) > 0.0, kind)
        if kind.moving or kind.thinning:
            _quicken(state, nodes, dt)
        if kind.static or kind.aging:
            _wear(state, laws, nodes, dt, kind)
        t_left = t_in
        for j in range(nodes):
            at = j * FIELDS
            u = row(state, at + U)
            if kind.smooth:
                put(state, at + WENT, u - row(state, at + U_OLD))
            put(state, at + FORCE_OLD, row(state, at + FORCE))
            put(state, at + U_OLD, u)
            put(state, at + LEFT, t_left)
            t_left = row(state, at + AFTER)
            if kind.spread:
                part = row(state, at + CREEP) * t_left * (1.0 / ELEMENTS)
                _follow(state, at + CREPT_FAST, part, fast)
                _follow(state, at + CREPT_SLOW, part, slow)
                _follow(state, at + CREPT, part, gone)
            elif kind.creeping:
                put(state, at + CREPT, row(state, at + OFFSET) + row(state, at + CREEP) * t_left * gone)
        put(laws, STEP_OLD, dt)
        put(out, k, select(t_left < 0.0, 0.0, t_left))


@njit(cache=True, error_model="numpy", nogil=True)
def _follow(state: Array, at: int, goal: Any, gone: Any) -> None:
    """Bring a row nearer to a goal by a part of its distance."""
    here = row(state, at)
    put(state, at, here + (goal - here) * gone)


@njit(cache=True, error_model="numpy", nogil=True)
def _relax(state: Array, nodes: int, r: Any) -> Any:
    """Set the compliances of a standard linear solid, implicit: its creep strain relaxes to creep * T in 1/r steps.

    Return by which part it does so in this step.
    """
    kept = 1.0 / (1.0 + r)
    gone = r * kept
    for j in range(nodes):
        at = j * FIELDS
        put(state, at + INVERSE, 1.0 / (row(state, at + ELASTIC) + row(state, at + CREEP) * gone))
        put(state, at + OFFSET, row(state, at + CREPT) * kept)
    return gone


@njit(cache=True, error_model="numpy", nogil=True)
def _relax_spread(state: Array, nodes: int, r: Any, spread: Any) -> tuple[Any, Any, Any]:
    """Set the compliances of three Kelvin elements in a row, implicit: times one over, and times, a spread apart.

    Return by which part each relaxes in this step.
    """
    fast, gone, slow = r * spread / (1.0 + r * spread), r / (1.0 + r), r / (spread + r)
    part = (fast + gone + slow) * (1.0 / ELEMENTS)
    for j in range(nodes):
        at = j * FIELDS
        put(state, at + INVERSE, 1.0 / (row(state, at + ELASTIC) + row(state, at + CREEP) * part))
        kept = row(state, at + CREPT) * (1.0 - gone) + row(state, at + CREPT_FAST) * (1.0 - fast)
        put(state, at + OFFSET, kept + row(state, at + CREPT_SLOW) * (1.0 - slow))
    return fast, gone, slow


@njit(cache=True, error_model="numpy", nogil=True)
def _limits(state: Array, laws: Array, table: Array, nodes: int, mu: Any, kind: Kind) -> None:
    """Set at which share of the tension before it a node slips, by its laws and what they remember."""
    per_speed, per_age = 1.0 / row(laws, STRIBECK_SPEED), 1.0 / row(laws, AGING_S)
    for j in range(nodes):
        at = j * FIELDS
        if not some(row(state, at + RIGID) > 0.0):
            continue
        s = mu
        if kind.nonlinear:
            _look_up(state[at : at + FIELDS], table, laws[FACTOR_STEP])
            s = s * row(state, at + FACTOR)
        if kind.moving:
            v = row(state, at + SPEED) * per_speed
            s = s * (1.0 + (row(laws, STRIBECK) - 1.0) * exp(-(v * v)))
        if kind.static or kind.aging:
            s = s * (1.0 + row(state, at + EXCESS))
        if kind.aging:
            s = s * (1.0 + row(laws, AGING) * log(1.0 + row(state, at + AGE) * per_age))
        a, b = row(state, at + PHI_PULL) * s, row(state, at + PHI_RELEASE) * s
        c, d = row(state, at + PULLEY_PULL), row(state, at + PULLEY_RELEASE)
        put(state, at + PULL, a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a * (1.0 / 24.0)))) + c * (1.0 - 0.5 * c))
        put(state, at + RELEASE, b * (1.0 + b * (0.5 + b * (1.0 / 6.0 + b * (1.0 / 24.0)))) + d * (1.0 + 0.5 * d))


@njit(cache=True, error_model="numpy", nogil=True)
def _look_up(node: Array, table: Array, step: Array) -> None:
    """Set the factor on mu at the tension before a node, between two entries of each lane's table."""
    for lane in range(WIDTH):
        x = min(node[LEFT, lane] / step[lane], FACTOR_NODES - 1.001)
        i = max(int(x), 0)
        node[FACTOR, lane] = table[lane, i] + (x - i) * (table[lane, i + 1] - table[lane, i])


@njit(cache=True, error_model="numpy", nogil=True)
def _quicken(state: Array, nodes: int, dt: Any) -> None:
    """Follow the sliding speed (mm/s)."""
    fresh, often = 1.0 - exp(-dt / SPEED_MEMORY_S), 1.0 / dt
    for j in range(nodes):
        at = j * FIELDS
        speed = row(state, at + SPEED)
        put(state, at + SPEED, speed + (size(row(state, at + U) - row(state, at + U_OLD)) * often - speed) * fresh)


@njit(cache=True, error_model="numpy", nogil=True)
def _wear(state: Array, laws: Array, nodes: int, dt: Any, kind: Kind) -> None:
    """Wear off a contact's static excess and its age by its slip, and let it heal and grow older."""
    healed = row(laws, STATIC_SPEED) * dt / HEALING_MM
    rested, most = exp(-healed), row(laws, STATIC) - 1.0
    for j in range(nodes):
        at = j * FIELDS
        stiff = row(state, at + STIFF)
        if not some(stiff > 0.0):
            continue
        built = row(state, at + FORCE) - row(state, at + FORCE_OLD)
        worn = size(row(state, at + U) - row(state, at + U_OLD) - built / stiff) * (1.0 / RENEWAL_MM)
        # nothing slips where nothing rubs
        worn = select(stiff > 0.0, worn, 0.0)
        wear = select(worn > 1e-15, exp(-worn), 1.0)
        if kind.static:
            goal = most * healed / (healed + worn)
            put(state, at + EXCESS, goal + (row(state, at + EXCESS) - goal) * rested * wear)
        if kind.aging:
            put(state, at + AGE, row(state, at + AGE) * wear + dt * select(worn > 1e-9, (1.0 - wear) / worn, 1.0))
