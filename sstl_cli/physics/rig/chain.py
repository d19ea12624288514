"""The elastic chain and its implicit quasi-static solver: one call balances every node for one step.

Node i carries friction F_i; spring i joins node i - 1 to node i, spring M joins the last node to the load spring.
Balance of node i (displacement u positive towards the motor): T_i - T_(i+1) - F_i - c (u_i - u_i_old) / dt = 0.
Friction is elastic-plastic (return mapping, Simo and Hughes 1998, ch. 1): F = F_old + k_t (u - u_old), cut at the
capstan limit L(T) of the new tension. For a fixed set of sticking and slipping nodes the balance is a tridiagonal
system, linear under Coulomb friction: the semi-smooth Newton iteration ends exactly once the set stops changing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A node changes between sticking and slipping only beyond this force error (N): round-off must not make it chatter.
MODE_TOLERANCE_N = 1e-9
# Floor of the contact force that sets the stick stiffness (N), so that an unloaded node is not left without any.
CONTACT_FLOOR_N = 1e-4
# The same for the play of the load joint, as a share of its half-width.
PLAY_TOLERANCE = 1e-9


class Chain(NamedTuple):
    """State and work arrays; M nodes, displacements in mm, forces in N, stiffnesses in N/mm."""

    compliance: FloatArray  # (M + 1,) mm/N of each spring, the first reaching from the drive to node 0
    stiffness: FloatArray  # (M + 1,) of this step, creep included
    offset: FloatArray  # (M + 1,) tension of each spring at zero stretch
    creep: FloatArray  # (M + 1,) mm
    u: FloatArray  # (M + 1,) trial displacements; the last entry is the stretch of the load spring
    u_old: FloatArray  # (M + 1,)
    force: FloatArray  # (M,) trial friction
    force_old: FloatArray  # (M,)
    stick_stiffness: FloatArray  # (M,)
    breakaway: FloatArray  # (M,) mm
    slope_pull: FloatArray  # (M,) friction limit per tension, pulling
    slope_release: FloatArray  # (M,)
    bias_pull: FloatArray  # (M,) friction limit at zero tension, N
    bias_release: FloatArray  # (M,)
    drag: FloatArray  # (M,) viscous drag, N s/mm
    mode: IntArray  # (M,) 1 slips towards the motor, -1 away from it, 0 sticks
    mode_old: IntArray  # (M,)
    tension: FloatArray  # (M + 1,) trial tension of each spring
    tension_old: FloatArray  # (M + 1,)
    sweep_g: FloatArray  # (M + 1,) Thomas algorithm
    sweep_d: FloatArray  # (M + 1,)
    play: FloatArray  # (2,) position in the play of the load, -1..1: committed, trial


class Load(NamedTuple):
    """Load spring T = k1 (y + k3 y^3), stretched by y0 at rest, behind a joint with play."""

    k1: float
    y0: float
    k3: float = 0.0
    half_play: float = 0.0
    play_width: float = 1.0


class TensionLaw(NamedTuple):
    """How mu depends on the local tension: (T / 10 N)^-alpha * (1 + c_t T)."""

    alpha: float = 0.0
    c_t: float = 0.0


REFERENCE_TENSION_N = 10.0
TENSION_FLOOR_N = 0.05


@njit(cache=True)
def load_tension(load: Load, y: float) -> tuple[float, float]:
    """Tension (N) and stiffness (N/mm) of the load spring at stretch y (mm); it cannot push."""
    if y < 0.0:
        return 1e-6 * load.k1 * y, 1e-6 * load.k1
    return load.k1 * (y + load.k3 * y * y * y), load.k1 * (1.0 + 3.0 * load.k3 * y * y)


@njit(cache=True)
def friction_limit(law: TensionLaw, slope: float, bias: float, mean: float) -> tuple[float, float]:
    """Friction limit (N) of a node at its mean tension (N), and its derivative with respect to that tension."""
    if mean <= 0.0:
        return bias, 0.0
    if law.alpha == 0.0 and law.c_t == 0.0:
        return slope * mean + bias, slope
    tension = max(mean, TENSION_FLOOR_N)
    power = 1.0
    if law.alpha != 0.0:
        power = (tension / REFERENCE_TENSION_N) ** (-law.alpha)
    linear = 1.0 + law.c_t * mean
    derivative = slope * power * ((1.0 - law.alpha) * linear + law.c_t * mean)
    if mean < TENSION_FLOOR_N:
        derivative = slope * power * (linear + law.c_t * mean)
    return slope * power * linear * mean + bias, derivative


@njit(cache=True)
def prepare_step(chain: Chain, law: TensionLaw, pretension: float, creep_fraction: float, creep_ratio: float) -> None:
    """Set spring stiffness with creep (`creep_ratio` = dt / tau or 0) and stick stiffness from the last tensions."""
    nodes = chain.force.size
    for j in range(nodes + 1):
        growth = creep_fraction * creep_ratio / (1.0 + creep_ratio)
        chain.stiffness[j] = 1.0 / (chain.compliance[j] * (1.0 + growth))
        chain.offset[j] = pretension - chain.stiffness[j] * chain.creep[j] / (1.0 + creep_ratio)
    for i in range(nodes):
        if chain.slope_pull[i] + chain.slope_release[i] + chain.bias_pull[i] + chain.bias_release[i] > 0.0:
            mean = 0.5 * (chain.tension_old[i] + chain.tension_old[i + 1])
            pull, _ = friction_limit(law, chain.slope_pull[i], chain.bias_pull[i], mean)
            release, _ = friction_limit(law, chain.slope_release[i], chain.bias_release[i], mean)
            chain.stick_stiffness[i] = max(0.5 * (pull + release), CONTACT_FLOOR_N) / chain.breakaway[i]
        else:
            chain.stick_stiffness[i] = 0.0


@njit(cache=True)
def _mode(mode: int, trial: float, bound: float) -> int:
    """Mode of a node after the iteration, by its trial friction and the limit on the side it is on (N).

    A slipping node must stick before it may slip the other way: the slip front then advances monotonically and the
    iteration cannot cycle between the two directions.
    """
    if mode == 1:
        return 0 if trial < bound - MODE_TOLERANCE_N else 1
    if mode == -1:
        return 0 if trial > -bound + MODE_TOLERANCE_N else -1
    if trial > 0.0:
        return 1 if trial > bound + MODE_TOLERANCE_N else 0
    return -1 if trial < -bound - MODE_TOLERANCE_N else 0


@njit(cache=True)
def _side(side: int, play: float) -> int:
    """Side on which the gap of the load joint is closed (1, -1), or 0 if it is open, by the place in its play."""
    if side != 0:
        return 0 if side * play < 1.0 - PLAY_TOLERANCE else side
    if abs(play) > 1.0 + PLAY_TOLERANCE:
        return 1 if play > 0.0 else -1
    return 0


@njit(cache=True)
def _begin(chain: Chain) -> int:
    """Set the trial state to the last one; returns the side on which the gap of the load joint is closed."""
    nodes = chain.force.size
    for i in range(nodes):
        chain.mode[i] = chain.mode_old[i]
        chain.u[i] = chain.u_old[i]
    chain.u[nodes] = chain.u_old[nodes]
    return 1 if chain.play[0] >= 1.0 else (-1 if chain.play[0] <= -1.0 else 0)


@njit(cache=True)
def _joint(load: Load, play_old: float, moved: float, gap_side: int, first: bool) -> tuple[float, float, int]:
    """Free play of the load joint whose end has `moved` (mm): place in the play, its slope, and the side that is closed.

    The play is passed over a short stretch of the spring, so that it stays well posed. Open or closed gap is a mode of
    the same kind as stick and slip, and changes by the same rule.
    """
    if load.half_play <= 0.0:
        return play_old, 0.0, gap_side
    play = play_old + moved / load.play_width
    if not first:
        gap_side = _side(gap_side, play)
    if gap_side == 0:
        return play, load.half_play / load.play_width, gap_side
    return float(gap_side), 0.0, gap_side


@njit(cache=True)
def _contact(mode: int, first: bool, trial: float, bound: float, slope: float, stick: float) -> tuple[int, float, float, float]:
    """Mode of a node, its friction (N), and what that changes by with the mean tension (halved) and with displacement."""
    if not first:
        mode = _mode(mode, trial, bound)
    if mode == 0:
        return mode, trial, 0.0, stick
    return mode, mode * bound, 0.5 * mode * slope, 0.0


@njit(cache=True)
def _follow(u: FloatArray, sweep_g: FloatArray, sweep_d: FloatArray, delta: float) -> None:
    """Move the end by `delta` and every node by what the elimination made of it."""
    nodes = u.size - 1
    u[nodes] += delta
    for i in range(nodes - 1, -1, -1):
        delta = sweep_d[i] + sweep_g[i] * delta
        u[i] += delta


@njit(cache=True)
def balance(chain: Chain, load: Load, law: TensionLaw, drive_k: float, drive_o: float, dt: float, tolerance: float, limit: int) -> int:
    """Solve one step with T_0 = drive_o - drive_k u_0; returns the iterations used, or -1 if `limit` was not enough.

    Newton's method; its matrix is tridiagonal, and eliminated node by node. The trial state (u, force, tension, mode)
    is left for the caller to commit or to throw away.
    """
    nodes, u, play_old = chain.force.size, chain.u, chain.play[0]
    gap_side = _begin(chain)
    for iteration in range(limit + 1):
        first = iteration == 0
        k_left, t_left = drive_k, drive_o - drive_k * u[0]
        chain.tension[0] = t_left
        play, play_slope, side = _joint(load, play_old, u[nodes] - chain.u_old[nodes], gap_side, first)
        worst, changed = 0.0, side != gap_side
        gap_side, chain.play[1] = side, play
        g_left = d_left = 0.0
        for i in range(nodes):
            k_right = chain.stiffness[i + 1]
            if i + 1 < nodes:
                t_right, through = k_right * (u[i] - u[i + 1]) + chain.offset[i + 1], 1.0
            else:
                t_right = k_right * (u[i] - (u[nodes] - load.y0) - load.half_play * play) + chain.offset[nodes]
                through = 1.0 + play_slope
            chain.tension[i + 1] = t_right
            step = u[i] - chain.u_old[i]
            trial, was = chain.force_old[i] + chain.stick_stiffness[i] * step, chain.mode[i]
            if was == 1 or (was == 0 and trial > 0.0):
                bound, slope = friction_limit(law, chain.slope_pull[i], chain.bias_pull[i], 0.5 * (t_left + t_right))
            else:
                bound, slope = friction_limit(law, chain.slope_release[i], chain.bias_release[i], 0.5 * (t_left + t_right))
            mode, friction, skew, stick = _contact(was, first, trial, bound, slope, chain.stick_stiffness[i])
            changed = changed or mode != was
            chain.mode[i], chain.force[i] = mode, friction
            viscous = chain.drag[i] / dt
            residual = t_left - t_right - friction - viscous * step
            worst = max(worst, abs(residual))
            lower, upper = k_left * (1.0 - skew), k_right * (1.0 + skew)
            pivot = lower + upper + stick + viscous - lower * g_left
            g_left, d_left = upper * through / pivot, (residual + lower * d_left) / pivot
            chain.sweep_g[i], chain.sweep_d[i] = g_left, d_left
            t_left, k_left = t_right, k_right
        t_load, k_load = load_tension(load, u[nodes])
        residual = t_left - t_load
        worst = max(worst, abs(residual))
        if not first and not changed and worst < tolerance:
            return iteration
        pivot = k_left * (1.0 + play_slope) + k_load - k_left * g_left
        _follow(u, chain.sweep_g, chain.sweep_d, (residual + k_left * d_left) / pivot)
    return -1


@njit(cache=True)
def commit(chain: Chain, dt: float, creep_fraction: float, creep_ratio: float, pretension: float) -> float:
    """Accept the trial state and return the energy that slip and drag dissipated in this step (N mm)."""
    nodes = chain.force.size
    dissipated = 0.0
    for i in range(nodes):
        step = chain.u[i] - chain.u_old[i]
        if chain.mode[i] != 0:
            slip = step - (chain.force[i] - chain.force_old[i]) / chain.stick_stiffness[i]
            dissipated += chain.force[i] * slip
        dissipated += chain.drag[i] / dt * step * step
        chain.force_old[i] = chain.force[i]
        chain.mode_old[i] = chain.mode[i]
        chain.u_old[i] = chain.u[i]
    chain.u_old[nodes] = chain.u[nodes]
    chain.play[0] = chain.play[1]
    for j in range(nodes + 1):
        chain.tension_old[j] = chain.tension[j]
        if creep_fraction > 0.0:
            stretch = creep_fraction * chain.compliance[j] * (chain.tension[j] - pretension)
            chain.creep[j] = (chain.creep[j] + creep_ratio * stretch) / (1.0 + creep_ratio)
    return dissipated
