"""The solution: tension marched along the tube from station to station, its load seen through an impedance.

Without rate effects a station is stuck as long as the tension behind it stays within its limits, so one sweep from
the drive to the load solves a step exactly. With drag, presliding or creep the far line matters: a sweep from the load
to the drive (invariant imbedding: Bellman, Wing, An Introduction to Invariant Imbedding, 1975) gives for each station
how far it moves for a tension behind it, move = offset + tangent x, and the sweep back solves one monotone scalar
equation a station. Both together are Newton's method, exact as soon as the laws are linear in a step.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.variant.contact import behind, drag_force, grip, strengths
from sstl_cli.physics.variant.elastic import foresee_creep, load_stretch, settle, stretch
from sstl_cli.physics.variant.line import (
    BESIDE,
    CLOCK,
    FACTOR,
    ITERATIONS,
    LEAST,
    SUBSTEPPED,
    UNCONVERGED,
    WARMTH,
    WORK,
    Laws,
    Line,
    Rate,
    Spring,
    Trial,
)

Array = NDArray[np.float64]
# a break-away that is not over after so many sweeps goes on in the next step
MAX_SWEEPS = 12
SHARE_TOLERANCE = 1e-3
SCALAR_ITERATIONS = 40
# drag relaxes within some milliseconds, which steps must resolve
DRAG_STEP_S = 0.005


@njit(cache=True)
def sweep_plain(line: Line, law: Laws, trial: Trial) -> None:
    """Solve a step in which a station that does not slide keeps the tension behind it."""
    # arrays by themselves: a tuple of arrays passed to a function costs more than a station
    tension, before, angle, weight = trial.tension, line.tension, trial.angle, trial.weight
    pulley, speed, rub = line.pulley, line.speed, law.rub
    t = tension[0]
    for j in range(angle.size):
        x = before[j + 1]
        # friction takes tension away while pulling and adds it while releasing
        if x < t:
            x = max(x, behind(rub, pulley[j], t, angle[j], weight[j], speed[j], 1.0))
        elif x > t:
            x = min(x, behind(rub, pulley[j], t, angle[j], weight[j], speed[j], -1.0))
        tension[j + 1] = x
        t = x
    _moves(line, law.spring, trial)


@njit(cache=True)
def _moves(line: Line, law: Spring, trial: Trial) -> None:
    after, before, compliance = trial.tension, line.tension, line.compliance
    rope, flow, give, moves = line.rope, trial.flow, trial.give, trial.move
    last = moves.size
    move = load_stretch(law, before[last], after[last], line.joint[0], line.joint[1])[0]
    for k in range(last, 0, -1):
        move += stretch(law, compliance[k], before[k], after[k], rope[k], flow[k], give[k])[0]
        moves[k - 1] = move


@njit(cache=True)
def look_back(line: Line, law: Spring, trial: Trial) -> None:
    """Write offset and tangent of every station, from the load to the drive, about the iterate."""
    after, before, compliance = trial.tension, line.tension, line.compliance
    rope, flow, give, stuck = line.rope, trial.flow, trial.give, trial.stuck
    slopes, gains, forces, moved = trial.slope, trial.gain, trial.force, trial.moved
    offsets, tangents = trial.offset, trial.tangent
    last = offsets.size
    move, slope = load_stretch(law, before[last], after[last], line.joint[0], line.joint[1])
    offset, tangent = move - slope * after[last], slope
    for j in range(last - 1, -1, -1):
        k = j + 1
        move, slope = stretch(law, compliance[k], before[k], after[k], rope[k], flow[k], give[k])
        offset += move - slope * after[k]
        tangent += slope
        offsets[j], tangents[j] = offset, tangent
        if stuck[j] == 1:
            offset, tangent = 0.0, 0.0
        else:
            a, p = slopes[j], gains[j]
            below = 1.0 + a * tangent
            alpha = -(forces[j] - a * moved[j] - p * after[j] + a * offset) / below
            offset, tangent = offset + tangent * alpha, tangent * (1.0 - p) / below


@njit(cache=True)
def slide(
    law: Laws, pulley: int, t: float, angle: float, weight: float, speed: float, rest: float, k: float, drag: float, dt: float
) -> tuple[float, float, float, float]:
    """Return tension behind a rigid contact, its move (0: stuck), and the slopes of its force by move and tension.

    `rest` is the tension behind at which it would not move, `k` the tangent (mm/N).
    """
    sign = 1.0
    edge = behind(law.rub, pulley, t, angle, weight, speed, 1.0)
    if rest >= edge:
        sign = -1.0
        edge = behind(law.rub, pulley, t, angle, weight, speed, -1.0)
        if rest <= edge:
            return rest, 0.0, 0.0, 0.0
    gap = abs(edge - rest)
    y, slope = gap, 0.0
    if drag > 0.0:
        low, high = 0.0, gap
        for _ in range(SCALAR_ITERATIONS):
            g, slope = drag_force(law.rate, drag, k * y / dt)
            miss = y + g - gap
            if miss > 0.0:
                high = y
            else:
                low = y
            if abs(miss) < 1e-12 + 1e-10 * gap:
                break
            y -= miss / (1.0 + slope * k / dt)
            if not low < y < high:
                y = 0.5 * (low + high)
    h = 1e-4 * (1.0 + abs(t))
    gain = 1.0 - (behind(law.rub, pulley, t + h, angle, weight, speed, sign) - edge) / h
    return rest + sign * y, sign * k * y, slope / dt, gain


@njit(cache=True)
def yielding(
    rate: Rate, t: float, pull: float, release: float, old: float, z: float, rest: float, k: float, drag: float, dt: float
) -> tuple[float, float, float, float]:
    """Return the same as `slide` for a contact that gives way over z (mm) before it breaks away at -release or pull."""
    held = min(max(old, -release), pull)
    miss = t - rest - held
    low, high = min(0.0, k * miss), max(0.0, k * miss)
    move, force, slope = 0.0, held, 0.0
    for _ in range(SCALAR_ITERATIONS):
        f, rise = grip(rate, held, pull, release, z, move)
        g, rub = drag_force(rate, drag, move / dt)
        force, slope = f + g, rise + rub / dt
        miss = t - rest - move / k - force
        if miss > 0.0:
            low = move
        else:
            high = move
        if abs(miss) < 1e-11:
            break
        move += miss / (1.0 / k + slope)
        if not low <= move <= high:
            move = 0.5 * (low + high)
    limit = pull if move >= 0.0 else -release
    return t - force, move, slope, limit / max(t, 1e-6) * (1.0 - np.exp(-abs(move) / z))


@njit(cache=True)
def look_ahead(line: Line, law: Laws, trial: Trial, dt: float) -> float:
    """Solve every station from the drive to the load; return the largest change of a tension (N)."""
    tension, angle, weight, pulley = trial.tension, trial.angle, trial.weight, line.pulley
    speed, drag, breakaway, drop = line.speed, line.drag, line.breakaway, line.drop
    offsets, tangents, stuck = trial.offset, trial.tangent, trial.stuck
    t, worst = tension[0], 0.0
    for j in range(angle.size):
        k, z = tangents[j], breakaway[j]
        rest = -offsets[j] / k
        if z > 0.0:
            pull = max(t - behind(law.rub, pulley[j], t, angle[j], weight[j], speed[j], 1.0), 0.0)
            release = max(behind(law.rub, pulley[j], t, angle[j], weight[j], speed[j], -1.0) - t, 0.0)
            x, move, slope, gain = yielding(law.rate, t, pull, release, drop[j], z, rest, k, drag[j], dt)
            stuck[j] = 0
        else:
            x, move, slope, gain = slide(law, pulley[j], t, angle[j], weight[j], speed[j], rest, k, drag[j], dt)
            stuck[j] = 1 if move == 0.0 else 0
        trial.moved[j], trial.slope[j], trial.gain[j], trial.force[j] = move, slope, gain, t - x
        x = max(x, 0.0)
        worst = max(worst, abs(x - tension[j + 1]))
        tension[j + 1] = x
        t = x
    return worst


@njit(cache=True)
def sweep_coupled(line: Line, law: Laws, trial: Trial, dt: float, tolerance: float, limit: int) -> int:
    """Solve a step in which all stations depend on one another; return the sweeps used, or -1."""
    trial.tension[1:] = line.tension[1:]
    if law.spring.creep > 0.0:
        foresee_creep(line, law.spring, trial, dt)
    used = -1
    for sweep in range(limit):
        look_back(line, law.spring, trial)
        if look_ahead(line, law, trial, dt) < tolerance and sweep > 0:
            used = sweep + 1
            break
    _moves(line, law.spring, trial)
    return used


@njit(cache=True)
def weaken(law: Rate, trial: Trial) -> float:
    """Let the static excess fall with the slip of the trial (linearly: Ida 1972); return the largest change."""
    change = 0.0
    for j in range(trial.move.size):
        share = max(0.0, 1.0 - abs(trial.move[j]) / law.weakening_mm)
        # once broken a contact does not heal within the step
        share = min(share, trial.share[j])
        change = max(change, trial.share[j] - share)
        trial.share[j] = share
    return change


@njit(cache=True)
def accept(line: Line, law: Laws, trial: Trial, dt: float) -> tuple[float, float]:
    """Carry the line over the step just solved; return the displacement of its end and the work of friction (N mm)."""
    first = stretch(law.spring, line.compliance[0], line.tension[0], trial.tension[0], line.rope[0], trial.flow[0], trial.give[0])
    end = trial.move[0] + first[0]
    settle(line, law.spring, dt, trial.tension)
    rate, work = law.rate, 0.0
    forget = 1.0 - np.exp(-dt / rate.memory_s)
    ageing = rate.heal != 0.0 or rate.dwell != 0.0
    for j in range(trial.move.size):
        move = trial.move[j]
        line.drop[j] = trial.tension[j] - trial.tension[j + 1]
        done = line.drop[j] * move
        work += done
        line.speed[j] += (abs(move) / dt - line.speed[j]) * forget
        if ageing:
            line.rest[j] = (line.rest[j] + dt) * max(0.0, 1.0 - abs(move) / rate.weakening_mm)
        if rate.drift != 0.0 and line.wear_n_mm[j] > 0.0:
            line.wear[j] += abs(done) / line.wear_n_mm[j]
    if rate.drift != 0.0 and rate.drift_code == 1:
        rubbed = abs(trial.tension[0] - line.tension[0]) / rate.drift_path
        h = line.slow[WARMTH]
        line.slow[WARMTH] = (h + rubbed) / (1.0 + rubbed + dt / rate.drift_shape)
    line.slow[CLOCK] += dt
    line.tension[:] = trial.tension
    line.tally[WORK] += work
    line.tally[LEAST] = min(line.tally[LEAST], work)
    return end, work


@njit(cache=True)
def step(line: Line, law: Laws, trial: Trial, command: float, dt: float, coupled: bool, tolerance: float, limit: int) -> bool:
    """Solve a step, with its break-aways, but do not accept it; False if it did not converge."""
    trial.share[:] = 1.0
    for _ in range(MAX_SWEEPS):
        strengths(line, law.rate, trial, dt)
        trial.tension[0] = max(command, 0.0)
        if coupled:
            used = sweep_coupled(line, law, trial, dt, tolerance, limit)
            if used < 0:
                return False
            line.tally[ITERATIONS] += used
        else:
            sweep_plain(line, law, trial)
            line.tally[ITERATIONS] += 1
        if (law.rate.heal == 0.0 and law.rate.dwell == 0.0) or weaken(law.rate, trial) < SHARE_TOLERANCE:
            break
    return True


@njit(cache=True)
def advance(
    line: Line, law: Laws, trial: Trial, start: float, end: float, dt: float, coupled: bool, limits: tuple[float, int, int]
) -> float:
    """Carry the line over one sample, divided where it must be; return the displacement of its end (mm)."""
    tolerance, iterations, parts = limits
    share = 1.0
    longest = 0.5 * law.rate.memory_s if law.rate.speed != 0.0 else dt
    if law.rate.drag > 0.0:
        longest = min(longest, DRAG_STEP_S)
    if dt > 1.001 * longest:
        share = 1.0 / min(ceil(dt / longest - 0.001), parts)
    done, moved, divided = 0.0, 0.0, False
    while done < 1.0 - 1e-9:
        share = min(share, 1.0 - done)
        goal = start + (end - start) * (done + share)
        solved = step(line, law, trial, goal, dt * share, coupled, tolerance, iterations)
        if solved or share * parts <= 1.000001:
            if not solved:
                line.tally[UNCONVERGED] += 1.0
            moved += accept(line, law, trial, dt * share)[0]
            done += share
        else:
            share *= 0.5
            divided = True
    if divided:
        line.tally[SUBSTEPPED] += 1.0
    return moved


class Course(NamedTuple):
    """What drives a run, a value a sample: time (s), tension (N), and that of the neighbours and a factor on friction, or empty.

    `lead_in` brings the line from rest to its first sample, one entry a second.
    """

    time: Array
    command: Array
    beside: Array
    factor: Array
    lead_in: Array


class Recording(NamedTuple):
    """True output (N) and travel (mm), a value a sample; tensions of the nodes where it has a row for each sample."""

    t_out: Array
    travel: Array
    nodes: Array


@njit(cache=True)
def march(line: Line, law: Laws, trial: Trial, course: Course, coupled: bool, limits: tuple[float, int, int], out: Recording) -> None:
    """Bring the line from rest along the lead-in, then record every sample."""
    time, command, beside, factor, lead_in = course.time, course.command, course.beside, course.factor, course.lead_in
    last = line.tension.size - 1
    u = 0.0
    if beside.size > 0:
        line.slow[BESIDE] = beside[0]
    if factor.size > 0:
        line.slow[FACTOR] = factor[0]
    for n in range(1, lead_in.size):
        u += advance(line, law, trial, lead_in[n - 1], lead_in[n], 1.0, coupled, limits)
    # nothing that the lead-in wore, warmed or rested may count towards the run
    line.slow[CLOCK], line.slow[WARMTH] = 0.0, 0.0
    line.wear[:], line.rest[:], line.speed[:] = 0.0, 0.0, 0.0
    line.tally[:] = 0.0
    line.tally[LEAST] = np.inf
    for n in range(time.size):
        if n > 0:
            if beside.size > 0:
                line.slow[BESIDE] = beside[n]
            if factor.size > 0:
                line.slow[FACTOR] = factor[n]
            u += advance(line, law, trial, command[n - 1], command[n], time[n] - time[n - 1], coupled, limits)
        out.t_out[n] = line.tension[last]
        out.travel[n] = u
        if out.nodes.shape[0] == time.size:
            out.nodes[n, :] = line.tension
