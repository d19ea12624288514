"""The chain of tendon elements and one implicit step of it: mass, bristles and drag at every node, springs between.

Node i moves by u_i (towards the motor positive) under T_i - T_(i+1) - F_i - c_i v_i = m_i dv_i/dt, with v = (u -
u_old) / dt: backward Euler, stable for the stiff bristles, exact for the bristle state itself. The friction of a node
rises with its slip and bends off, from a kink at rest. Newton's method on such a curve runs from the kink to the
solution without overshoot; hence the one rule here: a node that would turn round stops at rest first.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.bristle.contact import Contact, ContactLaw, bristle_force, deflect

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A slack tendon pushes with this share of the load's stiffness: what its bending resists, and what stops its coasting.
SLACK_SHARE = 0.01


class Chain(NamedTuple):
    """State and work arrays; M nodes, the last entry of (M + 1,) being the load. Displacements mm, forces N."""

    compliance: FloatArray  # (M + 1,) mm/N of each spring, the first reaching from the drive to node 0
    stiffness: FloatArray  # (M + 1,) N/mm in this step, creep included
    offset: FloatArray  # (M + 1,) tension at zero stretch in this step
    kelvin: FloatArray  # (2, M + 1) mm, creep of the two Kelvin elements
    u: FloatArray  # (M + 1,) trial displacements
    u_old: FloatArray  # (M + 1,)
    speed: FloatArray  # (M + 1,) mm/s over the last step
    mass: FloatArray  # (M,) N s^2/mm
    tension: FloatArray  # (M + 1,) trial tension of each spring
    force: FloatArray  # (M,) trial friction
    back: FloatArray  # (M + 1,) tridiagonal sweep: coupling to the next node
    shift: FloatArray  # (M + 1,) tridiagonal sweep: right-hand side
    side: FloatArray  # (M + 1,) branch of the friction curve a node is on, 1 or -1
    joint: FloatArray  # (2,) place in the play of the load, -1..1: committed, trial


class Load(NamedTuple):
    """Load spring T = k1 sinh(q y) / q, y0 at rest, behind a joint with play that a small slip takes up."""

    k1: float
    y0: float
    q: float = 0.0
    half_play: float = 0.0
    play_slip: float = 1.0


@njit(cache=True)
def load_tension(load: Load, y: float) -> tuple[float, float]:
    """Tension (N) and stiffness (N/mm) of the load at displacement y (mm); sinh hardens as k1 (y + q^2 y^3 / 6)."""
    stretch = load.y0 + y
    if stretch < 0.0:
        return SLACK_SHARE * load.k1 * stretch, SLACK_SHARE * load.k1
    if load.q == 0.0:
        return load.k1 * stretch, load.k1
    return load.k1 * np.sinh(load.q * stretch) / load.q, load.k1 * np.cosh(load.q * stretch)


@njit(cache=True)
def prepare(chain: Chain, pretension: float, fraction: float, fades: tuple[float, float]) -> None:
    """Stiffness and offset of the springs in this step; `fades` is exp(-dt / tau) of the two creeping elements."""
    grown = 1.0 + 0.5 * fraction * (2.0 - fades[0] - fades[1])
    for j in range(chain.u.size):
        chain.stiffness[j] = 1.0 / (chain.compliance[j] * grown)
        kept = chain.kelvin[0, j] * fades[0] + chain.kelvin[1, j] * fades[1]
        chain.offset[j] = pretension - chain.stiffness[j] * kept


@njit(cache=True)
def _joint(chain: Chain, load: Load, t_left: float) -> tuple[float, float]:
    """Place in the play of the load joint, and mm of play per mm of load travel."""
    end = chain.u.size - 1
    travel = chain.u[end] - chain.u_old[end]
    side = chain.side[end]
    if travel != 0.0:
        side = 1.0 if travel > 0.0 else -1.0
    else:
        side = 1.0 if t_left > load_tension(load, chain.u[end])[0] else -1.0
    chain.side[end] = side
    place, slope = deflect(chain.joint[0], 1.0, side, side * travel, load.play_slip)
    chain.joint[1] = place
    return load.half_play * place, load.half_play * slope


@njit(cache=True)
def _grip(
    law: ContactLaw, pull: float, release: float, bias: float, delta: float, level: float, before: float, step: float,
    push: float, behind: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Deflection after a step (mm), the side it goes to, friction (N), and its derivatives by step and tension.

    A node at rest is on the side to which it is pushed (N, friction not counted).
    """
    side = 1.0 if step > 0.0 else -1.0
    if step == 0.0:
        held, _, _ = bristle_force(pull, release, bias, law, before, behind)
        side = 1.0 if push > held else -1.0
    zeta, slope = deflect(before, level, side, side * step, delta)
    friction, by_zeta, skew = bristle_force(pull, release, bias, law, zeta, behind)
    return zeta, side, friction, by_zeta * slope, skew


@njit(cache=True)
def solve(
    chain: Chain, contact: Contact, load: Load, law: ContactLaw, swell: float, drive: tuple[float, float], dt: float,
    tolerance: float, limit: int,
) -> int:  # fmt: skip
    """Solve one step with T_0 = drive[0] - drive[1] u_0; returns the iterations used, or -1 if `limit` was not enough.

    The trial state (u, tension, force, contact.trial) is left for the caller to commit or to throw away.
    """
    u, old, speed, sides = chain.u, chain.u_old, chain.speed, chain.side
    offset, stiffness = chain.offset, chain.stiffness
    mass, tension, force, backs, shifts = chain.mass, chain.tension, chain.force, chain.back, chain.shift
    grips, drag, level, zeta_old, trial = contact.grips, contact.drag, contact.level, contact.zeta, contact.trial
    pulls, releases, bias, delta = contact.theta_pull, contact.theta_release, contact.bias, contact.delta
    last = grips.size
    play, through = load.half_play * chain.joint[0], 1.0
    for j in range(last + 1):
        u[j] = old[j] + dt * speed[j]
    for iteration in range(limit + 1):
        if load.half_play > 0.0:
            play, slope = _joint(chain, load, stiffness[last] * (u[last - 1] - u[last] - play) + offset[last])
            through = 1.0 + slope
        worst, back, shift = 0.0, 0.0, 0.0
        k_left, t_left = drive[1], drive[0] - drive[1] * u[0]
        tension[0] = t_left
        for i in range(last):
            k_right = stiffness[i + 1]
            t_right = k_right * (u[i] - u[i + 1]) + offset[i + 1]
            if i + 1 == last:
                t_right -= k_right * play
            tension[i + 1] = t_right
            step = u[i] - old[i]
            friction, stiff, skew = 0.0, 0.0, 0.0
            if grips[i] == 1:
                pull, release = swell * pulls[i], swell * releases[i]
                push = t_left - t_right + mass[i] / dt * speed[i]
                trial[i], sides[i], friction, stiff, skew = _grip(
                    law, pull, release, bias[i], delta[i], level[i], zeta_old[i], step, push, t_right
                )
            force[i] = friction
            inertia = mass[i] / dt
            residual = t_left - t_right - friction - drag[i] * step / dt - inertia * (step / dt - speed[i])
            worst = max(abs(residual), worst)
            right = k_right * (1.0 + skew)
            pivot = k_left * (1.0 - back) + right + stiff + (drag[i] + inertia) / dt
            shift = (residual + k_left * shift) / pivot
            back = (right * through if i + 1 == last else right) / pivot
            backs[i], shifts[i] = back, shift
            t_left, k_left = t_right, k_right
        t_load, k_load = load_tension(load, u[last])
        residual = t_left - t_load
        if max(worst, abs(residual)) < tolerance:
            return iteration
        if not isfinite(worst + residual):
            return -1
        move = (residual + k_left * shift) / (k_left * (through - back) + k_load)
        u[last] = _moved(u[last], move, old[last], sides[last], load.half_play > 0.0)
        for i in range(last - 1, -1, -1):
            move = shifts[i] + backs[i] * move
            u[i] = _moved(u[i], move, old[i], sides[i], grips[i] == 1)
    return -1


@njit(cache=True)
def _moved(u: float, move: float, old: float, side: float, bent: bool) -> float:
    """Place of a node after the Newton step; with a kink of its friction at rest it stops there before it turns."""
    there = u + move
    return old if bent and (there - old) * side < 0.0 else there


@njit(cache=True)
def dissipation(chain: Chain, contact: Contact, law: ContactLaw, swell: float, dt: float) -> float:
    """Energy (N mm) that bristles and drag take out in the trial step: work of friction less what bristles store."""
    lost = 0.0
    for i in range(contact.grips.size):
        step = chain.u[i] - chain.u_old[i]
        lost += contact.drag[i] / dt * step * step
        if contact.grips[i] == 1:
            before, after = contact.zeta[i], contact.trial[i]
            behind, bias = chain.tension[i + 1], contact.bias[i]
            pull, release = swell * contact.theta_pull[i], swell * contact.theta_release[i]
            first, _, _ = bristle_force(pull, release, bias, law, before, behind)
            middle, _, _ = bristle_force(pull, release, bias, law, 0.5 * (before + after), behind)
            stored = contact.delta[i] * (after - before) * (first + 4.0 * middle + chain.force[i]) / 6.0
            lost += chain.force[i] * step - stored
    return lost


@njit(cache=True)
def commit(chain: Chain, contact: Contact, dt: float, pretension: float, fraction: float, fades: tuple[float, float]) -> None:
    """Accept the trial state and let the Kelvin elements of the springs creep on."""
    for i in range(contact.grips.size):
        if contact.grips[i] == 1:
            contact.zeta[i] = contact.trial[i]
    for j in range(chain.u.size):
        chain.speed[j] = (chain.u[j] - chain.u_old[j]) / dt
        chain.u_old[j] = chain.u[j]
        if fraction > 0.0:
            goal = 0.5 * fraction * chain.compliance[j] * (chain.tension[j] - pretension)
            chain.kelvin[0, j] += (goal - chain.kelvin[0, j]) * (1.0 - fades[0])
            chain.kelvin[1, j] += (goal - chain.kelvin[1, j]) * (1.0 - fades[1])
    chain.joint[0] = chain.joint[1]
