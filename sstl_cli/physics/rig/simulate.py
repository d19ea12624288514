"""One run on the rig: build the chain, march it through the command, pass the truth through the sensors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.optimize import brentq

from sstl_cli.physics.given import NoiseSpec
from sstl_cli.physics.rig.catalogue import resolve_effects
from sstl_cli.physics.rig.chain import Chain, FloatArray, Load, TensionLaw
from sstl_cli.physics.rig.drive import DRIVE_CODES, POSITION, TENSION, Motor, shape_command
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
from sstl_cli.physics.rig.sensors import Values, record
from sstl_cli.physics.rig.spec import RigResult, RigRun, RigSpec, bend_weights

# Steps in which the rig is brought from rest to the first command; one a second, slow enough for every rate effect.
LEAD_IN_STEPS = 40
# Stretch of the load spring (mm) over which the play of its joint is passed.
PLAY_WIDTH_MM = 2e-3
GOLDEN = 0.6180339887498949


def build_load(spec: RigSpec, values: Values) -> Load:
    """Load spring whose stretch at rest carries the pretension; raises nothing."""
    k3 = values["load_spring"]["k3_per_mm2"]
    k1 = spec.load_k1_n_per_mm
    y0 = spec.pretension_n / k1
    if k3 > 0.0 and y0 > 0.0:
        y0 = float(brentq(lambda y: k1 * (y + k3 * y**3) - spec.pretension_n, 0.0, y0, xtol=1e-15))
    return Load(k1, k3, y0, 0.5 * values["load_spring"]["play_mm"], PLAY_WIDTH_MM)


def build_chain(spec: RigSpec, system: str, values: Values, load: Load) -> Chain:
    """Chain at rest: every spring at the pretension, no friction mobilised."""
    passes = 1 if system == "act" else 2
    nodes = spec.nodes * passes + (passes - 1)
    per_kn = values["tendon_elasticity"]["compliance_per_kn"]
    ea = 1000.0 / per_kn if per_kn > 0.0 else spec.ea_n
    cell = spec.length_mm / spec.nodes
    lengths = np.full(nodes + 1, cell)
    lengths[0] = lengths[-1] = 0.5 * cell
    if passes == 2:
        lengths[spec.nodes : spec.nodes + 2] = 0.5 * cell
    sliding = values["presliding"]
    # Break-away distances cover breakaway * (1 +- spread) evenly, in an order without trend along the tendon.
    place = 2.0 * np.mod(GOLDEN * (np.arange(nodes) + 0.5), 1.0) - 1.0
    breakaway = spec.stick_breakaway_mm + sliding["breakaway_mm"] * (1.0 + sliding["spread"] * place)
    drag = np.full(nodes, values["viscous"]["c_l_n_s_per_mm"] / spec.nodes)
    if passes == 2:
        breakaway[spec.nodes] = spec.stick_breakaway_mm
        drag[spec.nodes] = 0.0

    displacement = np.zeros(nodes + 1)
    displacement[-1] = load.y0

    def zeros(size: int) -> FloatArray:
        return np.zeros(size)

    return Chain(
        compliance=lengths / ea,
        stiffness=ea / lengths,
        offset=zeros(nodes + 1),
        creep=zeros(nodes + 1),
        u=displacement.copy(),
        u_old=displacement,
        force=zeros(nodes),
        force_old=zeros(nodes),
        stick_stiffness=zeros(nodes),
        breakaway=breakaway,
        slope_pull=zeros(nodes),
        slope_release=zeros(nodes),
        bias_pull=zeros(nodes),
        bias_release=zeros(nodes),
        drag=drag,
        mode=np.zeros(nodes, dtype=np.int64),
        mode_old=np.zeros(nodes, dtype=np.int64),
        tension=np.full(nodes + 1, spec.pretension_n),
        tension_old=np.full(nodes + 1, spec.pretension_n),
        sweep_g=zeros(nodes + 1),
        sweep_d=zeros(nodes + 1),
        play=zeros(2),
    )


def build_contact(spec: RigSpec, run: RigRun, values: Values, chain: Chain) -> Contact:
    """Contacts of all nodes; writes the constant limits of the pulley node into `chain`."""
    theta = run.theta * bend_weights(spec, run.system, run.location)
    nodes = theta.size
    weight = np.full(nodes, values["const_friction"]["w_l_n"] / spec.nodes)
    fixed = np.zeros(nodes, dtype=np.int64)
    if run.system == "sstl":
        middle = spec.nodes
        fixed[middle], weight[middle] = 1, 0.0
        pulley = values["pulley_friction"]
        # Chosen so that across the node T+ = T- exp(-+m) -+ f0 holds exactly.
        pull, release = np.tanh(0.5 * pulley["m_p"]), np.tanh(0.5 * pulley["m_r"])
        chain.slope_pull[middle], chain.bias_pull[middle] = 2.0 * pull, pulley["f0_n"] * (1.0 + pull)
        chain.slope_release[middle], chain.bias_release[middle] = 2.0 * release, pulley["f0_n"] * (1.0 - release)
    return Contact(
        theta=theta,
        weight_n=weight,
        fixed=fixed,
        speed=np.zeros(nodes),
        peak=np.zeros(nodes),
        age_s=np.zeros(nodes),
        factor=np.ones(nodes),
        swollen=np.ones(1),
    )


def build_contact_law(spec: RigSpec, values: Values) -> ContactLaw:
    """Parameters of the contact laws, gathered from the effects."""
    drift, rate, stick, dwell = (values[key] for key in ("friction_drift", "stribeck", "stick_slip", "dwell_aging"))
    return ContactLaw(
        asymmetry=values["asymmetric_friction"]["a"],
        drift=drift["d_mu"],
        drift_path_n=drift["path_n"],
        stribeck_ratio=rate["ratio"],
        stribeck_speed=rate["v_s_mm_s"],
        stick_ratio=stick["ratio"],
        stick_speed=stick["v_c_mm_s"],
        dwell_b=dwell["b"],
        dwell_t0=dwell["t0_s"],
        memory_s=spec.friction_memory_s,
        weakening_mm=spec.weakening_mm,
        healing_mm=spec.healing_mm,
    )


def build_swell(run: RigRun, values: Values) -> FloatArray:
    """How far the tensions of the other tendons open or close the bend, per sample; empty where they do not."""
    per_n = values["tendon_crosstalk"]["c_bend_per_n"]
    if per_n == 0.0 or run.neighbour_n is None:
        return np.empty(0)
    # A bend pulled straight and beyond would rub on the other wall: it never quite vanishes.
    return np.clip(1.0 + per_n * run.neighbour_n, 0.05, None)


def build_setting(spec: RigSpec, values: Values, law: ContactLaw, bent: bool = False) -> Setting:
    """Settings of the march; flags switch off what the effects at hand do not need."""
    breakable = law.stick_ratio > 1.0 or law.dwell_b > 0.0
    remembering = breakable or law.stribeck_ratio > 1.0
    creep = values["viscoelastic_creep"]
    return Setting(
        pretension=spec.pretension_n,
        sheath_compliance=values["sheath_compliance"]["k_sh_mm_per_n"],
        gap=values["slack"]["gap_mm"],
        creep_fraction=creep["fraction"],
        creep_tau=creep["tau_s"],
        varying=remembering or law.drift != 0.0 or bent,
        remembering=remembering,
        breakable=breakable,
        tolerance=spec.tolerance_n,
        max_iterations=spec.max_iterations,
        max_substeps=spec.max_substeps,
    )


def simulate_rig(
    spec: RigSpec,
    run: RigRun,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
    keep_nodes: bool = False,
) -> RigResult:
    """Record one run on the elastic-chain rig.

    The rig starts at rest at the pretension, is brought slowly to the first command and then follows it. Without
    effects it obeys the capstan equation with backlash, Eq. (3) and (5):
    out = clip(out, exp(-n theta) in, exp(n theta) in), with out equal to the pretension before the first command.

    Parameters
    ----------
    spec : geometry, mechanics, drive and solver.
    run : configuration and command, n samples.
    effects : effect id to {parameter: value}, see `catalogue.EFFECTS`; what is missing is neutral.
    noise : sensor noise; by default 0.02 N white.
    seed : seed of all random numbers; equal seeds give equal records.
    keep_nodes : also return the tension of every spring.

    Returns
    -------
    RigResult, arrays of shape (n,).

    Raises
    ------
    ValueError
        An effect, a parameter or the location is unknown, or a value is out of range.
    """
    values = resolve_effects(effects or {})
    load = build_load(spec, values)
    chain = build_chain(spec, run.system, values, load)
    contact = build_contact(spec, run, values, chain)
    contact_law = build_contact_law(spec, values)
    swell = build_swell(run, values)
    setting = build_setting(spec, values, contact_law, swell.size > 0)
    law = TensionLaw(values["load_dependent_friction"]["alpha"], values["sheath_compliance"]["c_t_per_n"])
    motor = Motor(spec.pid_kp_mm_per_n, spec.pid_ki_mm_per_n_s, spec.pid_kd_mm_s_per_n, spec.motor_lag_s)
    set_limits(chain, contact, contact_law, 0.0)
    contact.fixed[contact.theta == 0.0] = 1  # a straight node has nothing that could change during the run

    lag = values["tension_loop_lag"]
    command = run.command
    if run.drive != "position":
        command = shape_command(run.time_s, command, lag["tau_s"], lag["inverse_slew_s_per_n"])
    lead_drive = POSITION if run.drive == "position" else TENSION
    rest = setting.gap if run.drive == "position" else spec.pretension_n
    lead_in = np.linspace(rest, command[0], LEAD_IN_STEPS + 1)

    size = run.time_s.size
    out = Recording(np.empty(size), np.empty(size), np.empty(size), np.empty((size if keep_nodes else 0, chain.tension.size)))
    probe = np.zeros(PROBES)
    bench = Bench(chain, load, law, contact, contact_law, motor, np.zeros(3), setting, probe)
    march(bench, Course(run.time_s, command, swell, DRIVE_CODES[run.drive], lead_in, lead_drive), out)
    truth = (out.t_in, out.t_out, out.x_in)
    seen = record(run.time_s, truth, values, run.system, noise or NoiseSpec(), seed)
    return _result(seen, out, probe, keep_nodes)


def _result(seen: tuple[FloatArray, FloatArray, FloatArray, FloatArray], out: Recording, probe: FloatArray, keep_nodes: bool) -> RigResult:
    """Return what sensors saw (time, tensions, position), beside the truth and what the solver did."""
    stamps, seen_in, seen_out, seen_x = seen
    return RigResult(
        time_s=stamps,
        tension_in_n=seen_in,
        tension_out_n=seen_out,
        position_in_mm=seen_x,
        true_tension_in_n=out.t_in,
        true_tension_out_n=out.t_out,
        true_position_in_mm=out.x_in,
        unconverged=int(probe[UNCONVERGED]),
        substepped=int(probe[SUBSTEPPED]),
        iterations=int(probe[ITERATIONS]),
        dissipated_j=1e-3 * float(probe[DISSIPATED]),
        min_step_dissipation_j=1e-3 * float(probe[LEAST]),
        node_tension=out.nodes if keep_nodes else None,
    )
