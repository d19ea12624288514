"""Marches the chain through the samples of a run: drive, friction, balance, and smaller steps where one fails."""

from __future__ import annotations

from math import ceil, isfinite
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.rig.chain import Chain, Load, TensionLaw, balance, commit, load_tension, prepare_step
from sstl_cli.physics.rig.drive import LOOP, MOTOR_MM, TENSION, Motor, loop_commit, loop_line
from sstl_cli.physics.rig.friction import Contact, ContactLaw, begin_contact, set_limits, update_contact, weaken

FloatArray = NDArray[np.float64]

# Entries of the probe array: what the last step left at the input end, and the counters of the whole run.
T_IN, X_IN, PATH, DISSIPATED, LEAST, UNCONVERGED, SUBSTEPPED, ITERATIONS = range(8)
PROBES = 8
# A break-away that is not over after so many passes goes on in the next step.
MAX_PASSES = 8
FACTOR_TOLERANCE = 2e-3


class Setting(NamedTuple):
    """Everything else a step needs: units mm, N, s."""

    pretension: float
    tolerance: float
    max_iterations: int
    max_substeps: int
    sheath_compliance: float = 0.0
    gap: float = 0.0
    creep_fraction: float = 0.0
    creep_tau: float = 1.0
    varying: bool = False  # limits change from step to step
    remembering: bool = False  # limits depend on sliding speed or on the age of the contacts
    breakable: bool = False  # static friction above kinetic


class Bench(NamedTuple):
    """The whole rig as the marching code sees it."""

    chain: Chain
    load: Load
    law: TensionLaw
    contact: Contact
    contact_law: ContactLaw
    motor: Motor
    motor_state: FloatArray  # (3,)
    setting: Setting
    probe: FloatArray  # (PROBES,)


class Course(NamedTuple):
    """What drives a run, a value a sample; `swell` is the bend angle over that without other tendons, or empty.

    `lead_in` brings the rig from rest to its first sample, one entry a second.
    """

    time: FloatArray
    command: FloatArray
    swell: FloatArray
    drive: int
    lead_in: FloatArray
    lead_drive: int


class Recording(NamedTuple):
    """True tensions (N) and position (mm), a value a sample; those of the nodes where it has a row for each sample."""

    t_in: FloatArray
    t_out: FloatArray
    x_in: FloatArray
    nodes: FloatArray


@njit(cache=True)
def try_step(bench: Bench, drive: int, command: float, dt: float, insist: bool) -> bool:
    """Solve and commit one step; False (nothing committed) if it does not converge, unless `insist`."""
    chain, contact, setting, probe = bench.chain, bench.contact, bench.setting, bench.probe
    if setting.breakable:
        begin_contact(contact, bench.contact_law, dt)
    if setting.varying:
        set_limits(chain, contact, bench.contact_law, probe[PATH])
    creep_ratio = dt / setting.creep_tau if setting.creep_fraction > 0.0 else 0.0
    prepare_step(chain, bench.law, setting.pretension, setting.creep_fraction, creep_ratio)
    series = 1.0 / chain.stiffness[0] + setting.sheath_compliance
    crept = chain.creep[0] / (1.0 + creep_ratio)
    a, g = command, 0.0
    if drive == LOOP:
        a, g = loop_line(bench.motor, bench.motor_state, command, dt)
    drive_k, drive_o = 0.0, max(command, 0.0)
    if drive != TENSION:
        drive_k = 1.0 / (series + g)
        drive_o = drive_k * (series * setting.pretension - crept + a - setting.gap)
    used = 0
    for _ in range(MAX_PASSES):
        count = balance(chain, bench.load, bench.law, drive_k, drive_o, dt, setting.tolerance, setting.max_iterations)
        if drive != TENSION and chain.tension[0] < 0.0 and count >= 0:
            # A tendon cannot push: it goes slack and its end stays where friction leaves it.
            count = balance(chain, bench.load, bench.law, 0.0, 0.0, dt, setting.tolerance, setting.max_iterations)
        if count < 0:
            used = -1
            break
        used += count
        if not setting.breakable or weaken(chain, contact, bench.contact_law, dt) < FACTOR_TOLERANCE:
            break
        set_limits(chain, contact, bench.contact_law, probe[PATH])
    if used < 0:
        if not insist:
            return False
        probe[UNCONVERGED] += 1.0
        if not isfinite(chain.u[0]):
            return True
    else:
        probe[ITERATIONS] += used
    tension = max(chain.tension[0], 0.0)
    if drive == TENSION:
        position = chain.u[0] + series * (tension - setting.pretension) + crept
        if tension > 1e-9:
            position += setting.gap
    elif drive == LOOP:
        position = a - g * tension
        loop_commit(bench.motor, bench.motor_state, command, tension, position, dt)
    else:
        position = command
    if setting.remembering:
        update_contact(chain, contact, bench.contact_law, dt)
    energy = commit(chain, dt, setting.creep_fraction, creep_ratio, setting.pretension)
    probe[DISSIPATED] += energy
    probe[LEAST] = min(probe[LEAST], energy)
    probe[PATH] += abs(tension - probe[T_IN])
    probe[T_IN] = tension
    probe[X_IN] = position
    return True


@njit(cache=True)
def advance(bench: Bench, drive: int, before: float, after: float, dt: float) -> None:
    """Carry the chain over one sample, in one step if that converges and in ever smaller ones if not."""
    smallest = 1.0 / bench.setting.max_substeps
    share = 1.0
    if bench.contact_law.stribeck_ratio > 1.0:
        # Rate-dependent friction follows with a lag that the step has to resolve.
        share = 1.0 / min(ceil(dt / bench.contact_law.memory_s), bench.setting.max_substeps)
    done = 0.0
    divided = False
    while done < 1.0 - 1e-9:
        share = min(share, 1.0 - done)
        target = before + (after - before) * (done + share)
        insist = share <= smallest * 1.000001
        if try_step(bench, drive, target, dt * share, insist):
            done += share
        else:
            share *= 0.5
            divided = True
    if divided:
        bench.probe[SUBSTEPPED] += 1.0


@njit(cache=True)
def march(bench: Bench, course: Course, out: Recording) -> None:
    """Bring the rig from rest along the lead-in, then record every sample."""
    chain, probe = bench.chain, bench.probe
    time, command, swell, lead_in = course.time, course.command, course.swell, course.lead_in
    probe[T_IN] = bench.setting.pretension
    if swell.size > 0:
        bench.contact.swollen[0] = swell[0]
    for n in range(1, lead_in.size):
        advance(bench, course.lead_drive, lead_in[n - 1], lead_in[n], 1.0)
    # Nothing that the lead-in wore, warmed or rested may count towards the run.
    probe[PATH] = 0.0
    probe[DISSIPATED] = 0.0
    probe[LEAST] = np.inf
    probe[ITERATIONS] = 0.0
    bench.contact.age_s[:] = 0.0
    bench.motor_state[MOTOR_MM] = probe[X_IN]
    bench.motor_state[MOTOR_MM + 1] = probe[X_IN]
    nodes = chain.force.size
    for n in range(time.size):
        if swell.size > 0:
            bench.contact.swollen[0] = swell[n]
        if n > 0:
            advance(bench, course.drive, command[n - 1], command[n], time[n] - time[n - 1])
        out.t_in[n] = probe[T_IN]
        out.t_out[n] = max(load_tension(bench.load, chain.u_old[nodes])[0], 0.0)
        out.x_in[n] = probe[X_IN]
        if out.nodes.shape[0] == time.size:
            for j in range(nodes + 1):
                out.nodes[n, j] = chain.tension_old[j]
