"""Effects that no catalogue holds: friction that ripples with position, a tube that moves half-way, mains hum."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.blind.bench import PlannedRun
from sstl_cli.physics.rig import RigSpec, resolve_effects
from sstl_cli.physics.rig.chain import TensionLaw, load_tension
from sstl_cli.physics.rig.drive import TENSION, Motor
from sstl_cli.physics.rig.friction import set_limits
from sstl_cli.physics.rig.march import PROBES, T_IN, UNCONVERGED, X_IN, Bench, Setting, advance
from sstl_cli.physics.rig.simulate import (
    LEAD_IN_STEPS,
    build_chain,
    build_contact,
    build_contact_law,
    build_load,
    build_setting,
)
from sstl_cli.physics.rig.spec import RigRun

Array = NDArray[np.float64]
UNLISTED = ("position_ripple", "moved_tube", "mains_hum")
MOVE_S = 0.5


@njit(cache=True)
def _march(
    bench: Bench,
    time: Array,
    command: Array,
    lead_in: Array,
    ripple: float,
    wave_mm: float,
    jump: Array,
    out: Array,
    travel: Array,
) -> None:
    """Record the output while theta follows the travel of the tendon and a given course in time."""
    base = bench.contact.theta.copy()
    bench.probe[T_IN] = bench.setting.pretension
    for n in range(1, lead_in.size):
        advance(bench, TENSION, lead_in[n - 1], lead_in[n], 1.0)
    last = bench.chain.force.size
    for n in range(time.size):
        factor = 1.0 + jump[n]
        for i in range(base.size):
            # each contact passes its own ripple: a strand of the rope, a turn of the sheath's coil
            local = ripple * np.sin(2.0 * np.pi * bench.chain.u_old[i] / wave_mm) if ripple > 0.0 else 0.0
            bench.contact.theta[i] = base[i] * (factor + local)
        set_limits(bench.chain, bench.contact, bench.contact_law, 0.0)
        if n > 0:
            advance(bench, TENSION, command[n - 1], command[n], time[n] - time[n - 1])
        out[n] = max(load_tension(bench.load, bench.chain.u_old[last])[0], 0.0)
        travel[n] = bench.probe[X_IN]


def march(
    spec: RigSpec, run: PlannedRun, theta: float, location: str, values: Mapping[str, float]
) -> tuple[Array, Array]:
    """Return true output tension (N) and travel (mm) of a rig whose friction ripples or jumps; neutral is the plain rig.

    Parameters
    ----------
    values : mapping
        ``ripple`` (share of theta), ``wave_mm``, and ``jump`` (share of theta) from ``at`` (share of the run) on.

    Raises
    ------
    ValueError
        If the rig does not converge.
    """
    neutral = resolve_effects({})
    load = build_load(spec, neutral)
    rig_run = RigRun(run.system, theta, location, run.time_s, "tension", run.command_n)
    chain = build_chain(spec, run.system, neutral, load)
    contact = build_contact(spec, rig_run, neutral, chain)
    law = build_contact_law(spec, neutral)
    # limits that change from step to step, but remember nothing
    setting = Setting(**{**build_setting(spec, neutral, law)._asdict(), "varying": True})
    motor = Motor(spec.pid_kp_mm_per_n, spec.pid_ki_mm_per_n_s, spec.pid_kd_mm_s_per_n, spec.motor_lag_s)
    set_limits(chain, contact, law, 0.0)
    contact.fixed[contact.theta == 0.0] = 1
    probe = np.zeros(PROBES)
    bench = Bench(chain, load, TensionLaw(0.0, 0.0), contact, law, motor, np.zeros(3), setting, probe)
    elapsed = run.time_s - run.time_s[0]
    middle = values.get("at", 0.5) * elapsed[-1]
    jump = values.get("jump", 0.0) * np.clip((elapsed - middle) / MOVE_S, 0.0, 1.0)
    out, travel = np.empty(run.time_s.size), np.empty(run.time_s.size)
    lead_in = np.linspace(spec.pretension_n, run.command_n[0], LEAD_IN_STEPS + 1)
    ripple, wave_mm = values.get("ripple", 0.0), values.get("wave_mm", 1.0)
    _march(bench, run.time_s, run.command_n, lead_in, ripple, wave_mm, jump, out, travel)
    if probe[UNCONVERGED] > max(1, out.size // 100_000):
        raise ValueError(f"rig: {int(probe[UNCONVERGED])} of {out.size} steps did not converge")
    return out, travel


def hum(time_s: Array, amplitude_n: float, phase: float, mains_hz: float) -> Array:
    """Return mains hum as a recorder without an anti-alias filter samples it (N)."""
    return amplitude_n * np.sin(2.0 * np.pi * mains_hz * time_s + phase)
