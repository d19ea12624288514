"""One run on the bristle simulator: build chain and contacts, march them, pass the truth through the sensors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.bristle.chain import Chain, Load
from sstl_cli.physics.bristle.contact import Contact, ContactLaw
from sstl_cli.physics.bristle.effect import FloatArray, Parts
from sstl_cli.physics.bristle.effects import catalogue, resolve_effects
from sstl_cli.physics.bristle.march import (
    DISSIPATED,
    ITERATIONS,
    LEAST,
    LOOP,
    POSITION,
    PROBES,
    SUBSTEPPED,
    TENSION,
    UNCONVERGED,
    Bench,
    Motor,
    Recording,
    Setting,
    lead_in,
    march,
)
from sstl_cli.physics.bristle.sensors import record
from sstl_cli.physics.bristle.spec import BristleRun, BristleSpec, bend_weights
from sstl_cli.physics.given import NoiseSpec, Recorded, Values

DRIVE_CODES = {"tension": TENSION, "position": POSITION, "loop": LOOP}
# From rest to the first command in so many steps of so many seconds: slow enough for every rate effect.
LEAD_STEPS, LEAD_STEP_S = 50, 0.8


def build_chain(spec: BristleSpec, lengths: FloatArray) -> Chain:
    """Chain of springs of these lengths (M + 1,) at rest: every spring at the pretension."""
    last = lengths.size - 1
    # g/m is 1e-6 kg/mm, and 1 kg is 1e-3 N s^2/mm
    mass = 1e-9 * spec.line_density_g_per_m * 0.5 * (lengths[:-1] + lengths[1:])
    ends, inner = [np.zeros(last + 1) for _ in range(7)], np.zeros(last)
    return Chain(
        compliance=lengths * (1.0 / spec.ea_n), stiffness=ends[6], offset=np.full(last + 1, spec.pretension_n),
        kelvin=np.zeros((2, last + 1)), u=ends[0], u_old=ends[1], speed=ends[2], mass=mass,
        tension=np.full(last + 1, spec.pretension_n), force=inner, back=ends[3], shift=ends[4], side=ends[5] + 1.0,
        joint=np.zeros(2),
    )  # fmt: skip


def build_contact(spec: BristleSpec, theta: FloatArray, sheathed: NDArray[np.bool_]) -> Contact:
    """Fresh contacts of nodes with these capstan exponents (M,), bristles upright; the level of the pulley never changes."""
    size = theta.size
    return Contact(
        grips=np.zeros(size, dtype=np.int64), living=sheathed.astype(np.int64), theta_pull=theta,
        theta_release=theta.copy(), bias=np.zeros(size), delta=np.full(size, spec.bristle_mm), drag=np.zeros(size),
        level=np.ones(size), zeta=np.zeros(size), trial=np.zeros(size), film_age=np.zeros(size), age=np.zeros(size),
    )  # fmt: skip


def build(spec: BristleSpec, run: BristleRun, values: Values) -> Parts:
    """Simulator at rest, with all effects built in; the stepping is told to leave out what these do not need."""
    weights = bend_weights(spec, run.system, run.location)
    cell = spec.length_mm / spec.nodes
    one = np.full(spec.nodes + 1, cell)
    one[0] = one[-1] = 0.5 * cell
    lengths = np.tile(one, 1 if run.system == "act" else 2)
    sheathed = np.arange(weights.size) != (-1 if run.system == "act" else spec.nodes)
    limit = spec.max_iterations + 2 * spec.nodes  # a front of slip may pass one node an iteration
    made = Parts(
        spec=spec,
        run=run,
        lengths=lengths,
        weights=weights,
        sheathed=sheathed,
        chain=build_chain(spec, lengths),
        contact=build_contact(spec, run.theta * weights, sheathed),
        load=Load(spec.load_k1_n_per_mm, spec.pretension_n / spec.load_k1_n_per_mm),
        law=ContactLaw(spec.renewal_mm, spec.film_mm),
        setting=Setting(spec.pretension_n, spec.finest_step_s, spec.tolerance_n, limit),
        command=run.command,
        swell=np.ones(run.command.size),
    )
    for name, effect in catalogue().items():
        effect.build(made, values[name])
    chain, contact, law = made.chain, made.contact, made.law
    chain.stiffness[:] = 1.0 / chain.compliance
    contact.grips[:] = (contact.theta_pull > 0.0) | (contact.theta_release > 0.0) | (contact.bias > 0.0)
    remembering = law.stribeck_ratio > 1.0 or law.stick_ratio > 1.0 or law.dwell_b > 0.0
    made.setting = made.setting._replace(changing=remembering or law.drift != 0.0, remembering=remembering)
    return made


def simulate_bristle(
    spec: BristleSpec,
    run: BristleRun,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
    keep_nodes: bool = False,
) -> Recorded:
    """Record one run on the bristle simulator.

    It starts at rest at the pretension, is brought slowly to the first command and then follows it. Without effects and
    in the limit of short bristles it obeys the capstan equation with backlash, Eq. (3) and (5):
    out = clip(out, exp(-n theta) in, exp(n theta) in), with out equal to the pretension before the first command.

    Parameters
    ----------
    spec : geometry, mechanics, contact, drive and solver.
    run : configuration and command, n samples.
    effects : effect id to {parameter: value}, see `effects`; what is missing is neutral.
    noise : sensor noise; by default 0.02 N white.
    seed : seed of all random numbers, >= 0; equal seeds give equal records.
    keep_nodes : also return the tension of every spring.

    Returns
    -------
    Recorded, arrays of shape (n,).

    Raises
    ------
    ValueError
        An effect, a parameter or the location is unknown, or a value is out of range.
    """
    values = resolve_effects(effects or {})
    made = build(spec, run, values)
    calm = made.setting._replace(changing=False, remembering=False)
    motor = Motor(spec.pid_kp_mm_per_n, spec.pid_ki_mm_per_n_s, spec.pid_kd_mm_s_per_n, spec.motor_lag_s)
    probe = np.zeros(PROBES)
    bench = Bench(made.chain, made.contact, made.load, made.law, motor, made.setting, probe)

    size = run.time_s.size
    command, swell = made.command, made.swell
    rest = made.setting.gap if run.drive == "position" else spec.pretension_n
    path = np.linspace(rest, command[0], LEAD_STEPS + 1)
    # Nothing rests or wears while the run is being set up, so that contacts are fresh at its first sample.
    lead_in(bench._replace(setting=calm), POSITION if run.drive == "position" else TENSION, path, swell[0], LEAD_STEP_S)
    out = Recording(np.empty(size), np.empty(size), np.empty(size), np.empty((size if keep_nodes else 0, made.lengths.size)))
    march(bench, run.time_s, command, swell, DRIVE_CODES[run.drive], out)

    truth = (out.t_in, out.t_out, out.x_in)
    return Recorded(
        *record(run.time_s, truth, values, run.system, noise or NoiseSpec(), seed),
        *truth,
        unconverged=int(probe[UNCONVERGED]),
        substepped=int(probe[SUBSTEPPED]),
        iterations=int(probe[ITERATIONS]),
        dissipated_j=1e-3 * float(probe[DISSIPATED]),
        min_step_dissipation_j=1e-3 * float(probe[LEAST]),
        node_tension=out.nodes if keep_nodes else None,
    )
