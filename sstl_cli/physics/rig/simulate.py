"""One run on the rig: build the chain, march it through the command, pass the truth through the sensors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.given import NoiseSpec, Recorded, Values
from sstl_cli.physics.rig.chain import Chain, Load, TensionLaw
from sstl_cli.physics.rig.drive import DRIVE_CODES, POSITION, TENSION, Motor
from sstl_cli.physics.rig.effect import FloatArray, Parts
from sstl_cli.physics.rig.effects import catalogue, resolve_effects
from sstl_cli.physics.rig.friction import Contact, ContactLaw, set_limits
from sstl_cli.physics.rig.march import (
    DISSIPATED,
    ITERATIONS,
    LEAST,
    PROBES,
    SUBSTEPPED,
    UNCONVERGED,
    Bench,
    Course,
    Recording,
    Setting,
    march,
)
from sstl_cli.physics.rig.sensors import record
from sstl_cli.physics.rig.spec import RigRun, RigSpec, bend_weights

# Steps in which the rig is brought from rest to the first command; one a second, slow enough for every rate effect.
LEAD_IN_STEPS = 40


def build_chain(spec: RigSpec, lengths: FloatArray) -> Chain:
    """Chain of springs of these lengths (M + 1,) at rest: every spring at the pretension, no friction mobilised."""
    nodes = lengths.size - 1

    def zeros(size: int) -> FloatArray:
        return np.zeros(size)

    return Chain(
        compliance=lengths / spec.ea_n,
        stiffness=spec.ea_n / lengths,
        offset=zeros(nodes + 1),
        creep=zeros(nodes + 1),
        u=zeros(nodes + 1),
        u_old=zeros(nodes + 1),
        force=zeros(nodes),
        force_old=zeros(nodes),
        stick_stiffness=zeros(nodes),
        breakaway=np.full(nodes, spec.stick_breakaway_mm),
        slope_pull=zeros(nodes),
        slope_release=zeros(nodes),
        bias_pull=zeros(nodes),
        bias_release=zeros(nodes),
        drag=zeros(nodes),
        mode=np.zeros(nodes, dtype=np.int64),
        mode_old=np.zeros(nodes, dtype=np.int64),
        tension=np.full(nodes + 1, spec.pretension_n),
        tension_old=np.full(nodes + 1, spec.pretension_n),
        sweep_g=zeros(nodes + 1),
        sweep_d=zeros(nodes + 1),
        play=zeros(2),
    )


def build_contact(theta: FloatArray, sheathed: NDArray[np.bool_]) -> Contact:
    """Contacts of nodes with this wrap angle (M,) times friction coefficient; those of the pulley never change."""
    nodes = theta.size
    return Contact(
        theta=theta,
        weight_n=np.zeros(nodes),
        fixed=np.where(sheathed, 0, 1).astype(np.int64),
        speed=np.zeros(nodes),
        peak=np.zeros(nodes),
        age_s=np.zeros(nodes),
        factor=np.ones(nodes),
        swollen=np.ones(1),
    )


def build(spec: RigSpec, run: RigRun, values: Values) -> Parts:
    """Rig at rest, with all effects built in; the march is told to leave out what these do not need."""
    theta = run.theta * bend_weights(spec, run.system, run.location)
    cell = spec.length_mm / spec.nodes
    one = np.full(spec.nodes + 1, cell)
    one[0] = one[-1] = 0.5 * cell
    lengths = np.tile(one, 1 if run.system == "act" else 2)
    sheathed = np.arange(theta.size) != (-1 if run.system == "act" else spec.nodes)
    rig = Parts(
        spec=spec,
        run=run,
        lengths=lengths,
        sheathed=sheathed,
        chain=build_chain(spec, lengths),
        contact=build_contact(theta, sheathed),
        load=Load(spec.load_k1_n_per_mm, spec.pretension_n / spec.load_k1_n_per_mm),
        tension_law=TensionLaw(),
        contact_law=ContactLaw(spec.friction_memory_s, spec.weakening_mm, spec.healing_mm),
        setting=Setting(spec.pretension_n, spec.tolerance_n, spec.max_iterations, spec.max_substeps),
        command=run.command,
        swell=np.empty(0),
    )
    for name, effect in catalogue().items():
        effect.build(rig, values[name])
    rig.chain.u[-1] = rig.chain.u_old[-1] = rig.load.y0
    law = rig.contact_law
    breakable = law.stick_ratio > 1.0 or law.dwell_b > 0.0
    remembering = breakable or law.stribeck_ratio > 1.0
    varying = remembering or law.drift != 0.0 or rig.swell.size > 0
    rig.setting = rig.setting._replace(varying=varying, remembering=remembering, breakable=breakable)
    set_limits(rig.chain, rig.contact, law, 0.0)
    rig.contact.fixed[theta == 0.0] = 1  # a straight node has nothing that could change during the run
    return rig


def simulate_rig(
    spec: RigSpec,
    run: RigRun,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
    keep_nodes: bool = False,
) -> Recorded:
    """Record one run on the elastic-chain rig.

    The rig starts at rest at the pretension, is brought slowly to the first command and then follows it. Without
    effects it obeys the capstan equation with backlash, Eq. (3) and (5):
    out = clip(out, exp(-n theta) in, exp(n theta) in), with out equal to the pretension before the first command.

    Parameters
    ----------
    spec : geometry, mechanics, drive and solver.
    run : configuration and command, n samples.
    effects : effect id to {parameter: value}, see `effects`; what is missing is neutral.
    noise : sensor noise; by default 0.02 N white.
    seed : seed of all random numbers; equal seeds give equal records.
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
    rig = build(spec, run, values)
    motor = Motor(spec.pid_kp_mm_per_n, spec.pid_ki_mm_per_n_s, spec.pid_kd_mm_s_per_n, spec.motor_lag_s)
    lead_drive = POSITION if run.drive == "position" else TENSION
    rest = rig.setting.gap if run.drive == "position" else spec.pretension_n
    lead_in = np.linspace(rest, rig.command[0], LEAD_IN_STEPS + 1)

    size = run.time_s.size
    out = Recording(np.empty(size), np.empty(size), np.empty(size), np.empty((size if keep_nodes else 0, rig.lengths.size)))
    probe = np.zeros(PROBES)
    bench = Bench(rig.chain, rig.load, rig.tension_law, rig.contact, rig.contact_law, motor, np.zeros(3), rig.setting, probe)
    march(bench, Course(run.time_s, rig.command, rig.swell, DRIVE_CODES[run.drive], lead_in, lead_drive), out)
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
