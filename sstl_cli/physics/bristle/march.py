"""Carries the chain through the samples of a run: drive, friction levels, implicit steps, finer ones where it jumps."""

from __future__ import annotations

from math import exp, isfinite
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.physics.bristle.chain import Chain, Load, commit, dissipation, load_tension, prepare, solve
from sstl_cli.physics.bristle.contact import Contact, ContactLaw, aged, level

FloatArray = NDArray[np.float64]

TENSION, POSITION, LOOP = 0, 1, 2
# Entries of the probe: what the last step left at the input end and in the loop, the clock, the counters of the run.
T_IN, X_IN, INTEGRAL, ERROR, ELAPSED, DISSIPATED, LEAST, UNCONVERGED, SUBSTEPPED, ITERATIONS = range(10)
PROBES = 10
# While contacts remember, a step may change a friction level by this share and set free this inertial force (N):
# then a jump is followed through, elsewhere one step does for a sample.
LEVEL_CHANGE = 0.01
INERTIA_N = 0.03


class Motor(NamedTuple):
    """PID gains (mm/N, mm/(N s), mm s/N) and motor time constant (s)."""

    kp: float
    ki: float
    kd: float
    lag_s: float


class Setting(NamedTuple):
    """Everything else a step needs: units mm, N, s."""

    pretension: float
    finest_s: float
    tolerance: float
    limit: int
    sheath_compliance: float = 0.0
    gap: float = 0.0
    creep_fraction: float = 0.0
    creep_s: tuple[float, float] = (1.0, 1.0)
    changing: bool = False  # levels change from step to step
    remembering: bool = False  # and depend on the age of the contacts


class Bench(NamedTuple):
    """The whole simulator as the stepping sees it."""

    chain: Chain
    contact: Contact
    load: Load
    law: ContactLaw
    motor: Motor
    setting: Setting
    probe: FloatArray  # (PROBES,)


@njit(cache=True)
def slipped(chain: Chain, contact: Contact, i: int) -> float:
    """Slip of node i in the trial step (mm) that renews its contacts: what only bends the bristles does not."""
    bent = abs(contact.trial[i] - contact.zeta[i]) * contact.delta[i]
    slip: float = max(abs(chain.u[i] - chain.u_old[i]) - bent, 0.0)
    return slip


@njit(cache=True)
def too_coarse(bench: Bench, dt: float) -> bool:
    """Whether the trial step changes a level, or the momentum of the tendon, by more than one step should."""
    chain, contact, law = bench.chain, bench.contact, bench.law
    moving = 0.0
    for i in range(contact.grips.size):
        moving += chain.mass[i] * abs((chain.u[i] - chain.u_old[i]) / dt - chain.speed[i]) / dt
        if contact.grips[i] == 1 and contact.living[i] == 1:
            slip = slipped(chain, contact, i)
            film, age = aged(contact.film_age[i], slip, law.film_mm, dt), aged(contact.age[i], slip, law.renewal_mm, dt)
            found = level(law, bench.probe[ELAPSED] + dt, film, age)
            if abs(found - contact.level[i]) > LEVEL_CHANGE * contact.level[i]:
                return True
    return moving > INERTIA_N


@njit(cache=True)
def drive_line(bench: Bench, drive: int, command: float, dt: float, crept: float) -> tuple[float, float, float, float]:
    """T_0 = first - second u_0 of this step, and the motor position = third - fourth T_0.

    PID, motor and the series of first spring and sheath are all taken at the end of the step: a digital loop that
    were a step late would not be stable on a stuck tendon.
    """
    setting, motor, probe = bench.setting, bench.motor, bench.probe
    if drive == TENSION:
        return max(command, 0.0), 0.0, 0.0, 0.0
    goal, per_n = command, 0.0
    if drive == LOOP:
        share = dt / (motor.lag_s + dt)
        per_n = share * (motor.kp + motor.ki * dt + motor.kd / dt)
        goal = (1.0 - share) * probe[X_IN] + share * (probe[INTEGRAL] - motor.kd / dt * probe[ERROR]) + per_n * command
    series = 1.0 / bench.chain.stiffness[0] + setting.sheath_compliance
    stiffness = 1.0 / (series + per_n)
    return stiffness * (series * setting.pretension - crept + goal - setting.gap), stiffness, goal, per_n


@njit(cache=True)
def attempt(bench: Bench, drive: int, command: float, swell: float, dt: float, insist: bool) -> bool:
    """Solve and commit one step; False (nothing committed) if it fails or is too coarse, unless `insist`."""
    chain, contact, law, setting, probe = bench.chain, bench.contact, bench.law, bench.setting, bench.probe
    fades = (1.0, 1.0)
    if setting.creep_fraction > 0.0:
        fades = (exp(-dt / setting.creep_s[0]), exp(-dt / setting.creep_s[1]))
    prepare(chain, setting.pretension, setting.creep_fraction, fades)
    crept = chain.kelvin[0, 0] * fades[0] + chain.kelvin[1, 0] * fades[1]
    if setting.changing:
        for i in range(contact.grips.size):
            if contact.living[i] == 1:
                contact.level[i] = level(law, probe[ELAPSED] + dt, contact.film_age[i], contact.age[i])
    first, second, goal, per_n = drive_line(bench, drive, command, dt, crept)
    for _ in range(2):
        used = solve(chain, contact, bench.load, law, swell, (first, second), dt, setting.tolerance, setting.limit)
        if used < 0 or drive == TENSION or chain.tension[0] >= 0.0:
            break
        # A tendon cannot push: it goes slack and its end stays where friction leaves it.
        first, second = 0.0, 0.0
    if not insist and (used < 0 or (setting.remembering and too_coarse(bench, dt))):
        return False
    if used < 0:
        probe[UNCONVERGED] += 1.0
        if not isfinite(chain.u[0]):
            return True
    probe[ITERATIONS] += abs(used)
    tension = max(chain.tension[0], 0.0)
    if drive == TENSION:
        spring = (tension - setting.pretension) / chain.stiffness[0] + crept
        slack = setting.gap if tension > 1e-9 else 0.0
        probe[X_IN] = chain.u[0] + spring + setting.sheath_compliance * (tension - setting.pretension) + slack
    else:
        probe[X_IN] = goal - per_n * tension
        probe[ERROR] = command - tension
        probe[INTEGRAL] += bench.motor.ki * dt * probe[ERROR] if drive == LOOP else 0.0
    probe[T_IN] = tension
    if setting.remembering:
        for i in range(contact.grips.size):
            if contact.grips[i] == 1:
                slip = slipped(chain, contact, i)
                contact.film_age[i] = aged(contact.film_age[i], slip, law.film_mm, dt)
                contact.age[i] = aged(contact.age[i], slip, law.renewal_mm, dt)
    lost = dissipation(chain, contact, law, swell, dt)
    probe[DISSIPATED] += lost
    probe[LEAST] = min(probe[LEAST], lost)
    probe[ELAPSED] += dt
    commit(chain, contact, dt, setting.pretension, setting.creep_fraction, fades)
    return True


@njit(cache=True)
def advance(bench: Bench, drive: int, before: float, after: float, swell: float, dt: float, guess: float) -> float:
    """Carry the chain over one sample, from `guess` (s) on in steps as fine as needed; returns the step to try next."""
    finest = min(bench.setting.finest_s, dt)
    done, step = 0.0, min(guess, dt)
    divided = step < dt
    while done < dt:
        left = dt - done
        if step >= left:
            step = left
        elif step > 0.5 * left:
            # two halves rather than a sliver at the end, whose inertia would be rounding alone
            step = 0.5 * left
        target = before + (after - before) * (done + step) / dt
        if attempt(bench, drive, target, swell, step, step <= finest * 1.000001):
            done = dt if step == left else done + step
            step *= 2.0
        else:
            step = max(0.4 * step, finest)
            divided = True
    if divided:
        bench.probe[SUBSTEPPED] += 1.0
    return max(step, finest)


class Recording(NamedTuple):
    """True position (mm) and tensions (N), a value a sample; those of the nodes where it has a row for each sample."""

    x_in: FloatArray
    t_in: FloatArray
    t_out: FloatArray
    nodes: FloatArray


@njit(cache=True)
def march(bench: Bench, time: FloatArray, command: FloatArray, swell: FloatArray, drive: int, out: Recording) -> None:
    """Record every sample; `swell` is the wrap angle over that without other tendons, one value a sample."""
    chain, probe = bench.chain, bench.probe
    last = chain.u.size - 1
    step = np.inf
    for n in range(time.size):
        if n > 0:
            step = advance(bench, drive, command[n - 1], command[n], swell[n], time[n] - time[n - 1], step)
        out.t_in[n] = probe[T_IN]
        out.t_out[n] = max(load_tension(bench.load, chain.u_old[last])[0], 0.0)
        out.x_in[n] = probe[X_IN]
        if out.nodes.shape[0] == time.size:
            out.nodes[n] = chain.tension


@njit(cache=True)
def lead_in(bench: Bench, drive: int, path: FloatArray, swell: float, dt: float) -> None:
    """Bring the chain from rest along `path`, one entry every `dt` seconds; forget what that wore, warmed or rested."""
    probe, contact = bench.probe, bench.contact
    probe[T_IN] = bench.setting.pretension
    for n in range(1, path.size):
        advance(bench, drive, path[n - 1], path[n], swell, dt, dt)
    probe[INTEGRAL] = probe[X_IN]
    for entry in (ERROR, ELAPSED, DISSIPATED, UNCONVERGED, SUBSTEPPED, ITERATIONS):
        probe[entry] = 0.0
    probe[LEAST] = np.inf
    contact.film_age[:] = 0.0
    contact.age[:] = 0.0
