"""The balance of a step of elastic lines side by side, met by Newton's steps over a tridiagonal system.

Displacements, friction and slopes are rows of an array (see state), each a vector over lanes (see lanes).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.transmission.build_up import built_up
from sstl_cli.physics.transmission.lanes import exp, larger, log, put, row, select, size, some, wide
from sstl_cli.physics.transmission.state import (
    AFTER,
    DRAG,
    FIELDS,
    FORCE,
    FORCE_OLD,
    HOLD,
    INVERSE,
    LEFT,
    LOWER,
    MODE,
    OFFSET,
    PULL,
    RELEASE,
    RESIDUAL,
    RIGID,
    SHARE,
    SPEED,
    STAY,
    STEP,
    STIFF,
    U_OLD,
    VISCOUS,
    WENT,
    Kind,
    U,
)  # fmt: skip

Array = NDArray[np.float64]
MAX_ITERATIONS = 40
# a node changes between sticking and slipping only beyond this force: round-off must not make it chatter
MODE_TOLERANCE_N = 1e-9
# a line whose friction builds up smoothly is in balance to this force
BALANCE_N = 1e-5
# least force in proportion to which friction builds up, so that what hangs loose has a stiffness (N)
LEAST_N = 1e-4
# speed (mm/s) below which drag that grows with a power of the speed grows in proportion
LEAST_MM_S = 0.02


@njit(cache=True, error_model="numpy", nogil=True)
def set_out(state: Array, nodes: int, t_in: Any, dt: Any, longer: Any, bristle: Any, thinning: Any, kind: Kind) -> None:
    """Set the stiffness of what sticks and where a step begins; where friction is cut, also its first balance.

    That one has nothing moved yet, and trusts the modes of the step before.
    """
    often = 1.0 / dt
    t_left, inverse_left, u = t_in, wide(0.0), row(state, U)
    for j in range(nodes):
        at = j * FIELDS
        pull, release, hold = row(state, at + PULL), row(state, at + RELEASE), row(state, at + HOLD)
        pressing = select(bristle > 0.0, bristle, larger(row(state, at + LEFT), wide(0.0)))
        limit = 0.5 * (pull + release) * pressing + hold
        stiff, viscous = larger(limit, wide(LEAST_N)) * row(state, at + RIGID), row(state, at + DRAG) * often
        put(state, at + STIFF, stiff)
        if kind.thinning:
            # the speed is that of the step before: what goes with a power of it would not be linear
            viscous = viscous * exp(thinning * log(row(state, at + SPEED) + LEAST_MM_S))
        if kind.dragging:
            put(state, at + VISCOUS, viscous)
        if kind.smooth:
            # a smooth line goes on as it went
            put(state, at + U, row(state, at + U_OLD) + row(state, at + WENT) * longer)
        else:
            inverse, u_right, mode = row(state, at + INVERSE), row(state, at + FIELDS + U), row(state, at + MODE)
            t_right = (u - u_right - row(state, at + OFFSET)) * inverse
            up, down = mode > 0.0, mode < 0.0
            force = select(up, pull * t_left + hold, select(down, -release * t_left - hold, row(state, at + FORCE_OLD)))
            put(state, at + LOWER, select(up, 1.0 - pull, select(down, 1.0 + release, 1.0)) * inverse_left)
            put(state, at + STAY, select(up | down, 0.0, stiff) + viscous)
            put(state, at + RESIDUAL, t_left - t_right - force)
            t_left, inverse_left, u = t_right, inverse, u_right


@njit(cache=True, error_model="numpy", nogil=True)
def settle(state: Array, nodes: int, t_in: Any, tail: Any, busy: Any, kind: Kind) -> None:
    """Look for the balance of a step by Newton's steps, in the lanes that are ``busy``; one that has met it keeps still."""
    lacking = busy
    for iteration in range(MAX_ITERATIONS):
        if kind.smooth:
            lacking = lacking & _balance_smooth(state, nodes, t_in, tail, busy)
        elif iteration > 0:
            # given the modes the balance is linear: if they stay, the step before has solved it
            lacking = lacking & _balance(state, nodes, t_in)
        if not some(lacking):
            return
        _step(state, nodes, lacking)
        if kind.smooth:
            # from rest friction is concave, and Newton's steps stay short of the balance: none may pass through rest
            for j in range(nodes):
                at = j * FIELDS
                u, rest, mode = row(state, at + U), row(state, at + U_OLD), row(state, at + MODE)
                passed = lacking & ((u - rest) * mode < 0.0)
                put(state, at + U, select(passed, rest, u))
                put(state, at + MODE, select(passed, 0.0, mode))
    for j in range(nodes):
        at = j * FIELDS
        way = row(state, at + U) - row(state, at + FIELDS + U) - row(state, at + OFFSET)
        put(state, at + AFTER, way * row(state, at + INVERSE))


@njit(cache=True, error_model="numpy", nogil=True)
def _balance(state: Array, nodes: int, t_in: Any) -> Any:
    """Set what each node lacks of its balance, and its slopes; return the lanes in which a node changed its mode.

    A slipping node must stick before it slips the other way, so that modes cannot cycle.
    """
    t_left, inverse_left, u = t_in, wide(0.0), row(state, U)
    changed = u != u
    for j in range(nodes):
        at = j * FIELDS
        inverse, u_right = row(state, at + INVERSE), row(state, at + FIELDS + U)
        t_right = (u - u_right - row(state, at + OFFSET)) * inverse
        pull, release, hold = row(state, at + PULL), row(state, at + RELEASE), row(state, at + HOLD)
        high, low = pull * t_left + hold, -release * t_left - hold
        moved, stiff, viscous = u - row(state, at + U_OLD), row(state, at + STIFF), row(state, at + VISCOUS)
        trial, mode = row(state, at + FORCE_OLD) + stiff * moved, row(state, at + MODE)
        up, down = mode > 0.0, mode < 0.0
        sticks = (stiff > 0.0) & ~(up | down)
        off = (up & (trial < high - MODE_TOLERANCE_N)) | (down & (trial > low + MODE_TOLERANCE_N))
        on_up = sticks & (trial > high + MODE_TOLERANCE_N)
        on_down = sticks & (trial < low - MODE_TOLERANCE_N) & ~on_up
        changed = changed | off | on_up | on_down
        up, down = (up & ~off) | on_up, (down & ~off) | on_down
        force = select(up, high, select(down, low, trial))
        put(state, at + MODE, select(up, 1.0, select(down, -1.0, 0.0)))
        put(state, at + FORCE, force)
        put(state, at + LOWER, select(up, 1.0 - pull, select(down, 1.0 + release, 1.0)) * inverse_left)
        put(state, at + STAY, select(up | down, 0.0, stiff) + viscous)
        put(state, at + RESIDUAL, t_left - t_right - force - viscous * moved)
        put(state, at + AFTER, t_right)
        t_left, inverse_left, u = t_right, inverse, u_right
    return changed


@njit(cache=True, error_model="numpy", nogil=True)
def _balance_smooth(state: Array, nodes: int, t_in: Any, tail: Any, busy: Any) -> Any:
    """Set what each node lacks of its balance, and its slopes; return the lanes in which it is more than BALANCE_N."""
    t_left, inverse_left, u = t_in, wide(0.0), row(state, U)
    lacks = u != u
    for j in range(nodes):
        at = j * FIELDS
        inverse, u_right = row(state, at + INVERSE), row(state, at + FIELDS + U)
        t_right = (u - u_right - row(state, at + OFFSET)) * inverse
        pull, release, hold = row(state, at + PULL), row(state, at + RELEASE), row(state, at + HOLD)
        high, low = pull * t_left + hold, -release * t_left - hold
        moved, rigid, viscous = u - row(state, at + U_OLD), row(state, at + RIGID), row(state, at + VISCOUS)
        mode = row(state, at + MODE)
        force = stays = follows = wide(0.0)
        if some(rigid > 0.0):
            # what is at rest takes longer to tell, and a lane without a line rests
            way = select(busy, moved * rigid, 1.0)
            force, stays, follows = built_up(way, mode, row(state, at + FORCE_OLD), low, high, pull, release, tail)
        residual = t_left - t_right - force - viscous * moved
        lacks = lacks | (size(residual) > BALANCE_N)
        put(state, at + FORCE, force)
        put(state, at + LOWER, (1.0 - follows) * inverse_left)
        put(state, at + STAY, stays * rigid + viscous)
        put(state, at + RESIDUAL, residual)
        put(state, at + MODE, select(moved > 0.0, 1.0, select(moved < 0.0, -1.0, mode)))
        put(state, at + AFTER, t_right)
        t_left, inverse_left, u = t_right, inverse, u_right
    return lacks


@njit(cache=True, error_model="numpy", nogil=True)
def _step(state: Array, nodes: int, lacking: Any) -> None:
    """Add Newton's step to the displacements of lanes that are ``lacking``.

    Elimination from both ends to the middle: two chains of divisions that do not wait for one another.
    """
    middle = nodes // 2
    left = left_r = right = right_r = wide(0.0)
    for i in range(middle):
        at = i * FIELDS
        lower, inverse = row(state, at + LOWER), row(state, at + INVERSE)
        pivot = 1.0 / (lower * (1.0 - left) + inverse + row(state, at + STAY))
        left_r = (row(state, at + RESIDUAL) + lower * left_r) * pivot
        left = inverse * pivot
        put(state, at + SHARE, left)
        put(state, at + STEP, left_r)
        if nodes - 1 - i > middle:
            at = (nodes - 1 - i) * FIELDS
            lower, inverse = row(state, at + LOWER), row(state, at + INVERSE)
            pivot = 1.0 / (lower + inverse * (1.0 - right) + row(state, at + STAY))
            right_r = (row(state, at + RESIDUAL) + inverse * right_r) * pivot
            right = lower * pivot
            put(state, at + SHARE, right)
            put(state, at + STEP, right_r)
    at = middle * FIELDS
    lower, inverse = row(state, at + LOWER), row(state, at + INVERSE)
    pivot = lower * (1.0 - left) + inverse * (1.0 - right) + row(state, at + STAY)
    before = behind = (row(state, at + RESIDUAL) + lower * left_r + inverse * right_r) / pivot
    put(state, at + U, row(state, at + U) + select(lacking, before, 0.0))
    for i in range(1, middle + 1):
        at = (middle - i) * FIELDS
        before = row(state, at + STEP) + row(state, at + SHARE) * before
        put(state, at + U, row(state, at + U) + select(lacking, before, 0.0))
        if middle + i < nodes:
            at = (middle + i) * FIELDS
            behind = row(state, at + STEP) + row(state, at + SHARE) * behind
            put(state, at + U, row(state, at + U) + select(lacking, behind, 0.0))
