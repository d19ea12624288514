"""One run on the bristle simulator: build chain and contacts, march them, pass the truth through the sensors."""

from __future__ import annotations

from collections.abc import Mapping
from math import asinh, exp, sqrt

import numpy as np
from numba import njit

from sstl_cli.physics.bristle.catalogue import resolve_effects
from sstl_cli.physics.bristle.chain import Chain, Load
from sstl_cli.physics.bristle.contact import Contact, ContactLaw
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
from sstl_cli.physics.bristle.sensors import FloatArray, Values, record
from sstl_cli.physics.bristle.spec import BristleResult, BristleRun, BristleSpec, bend_weights
from sstl_cli.physics.given import NoiseSpec

DRIVE_CODES = {"tension": TENSION, "position": POSITION, "loop": LOOP}
# From rest to the first command in so many steps of so many seconds: slow enough for every rate effect.
LEAD_STEPS, LEAD_STEP_S = 50, 0.8
# Travel of the load end (mm) in which the play of its joint is taken up.
PLAY_SLIP_MM = 1.5e-3
# The two Kelvin elements of a creeping tendon have half the strength each, one so much faster, one so much slower.
CREEP_SPREAD = 3.0


def build_load(spec: BristleSpec, values: Values) -> Load:
    """Load spring at rest under the pretension; sinh has the cubic term of k1 (y + k3 y^3) for q^2 = 6 k3."""
    spring = values["load_spring"]
    k1, q = spec.load_k1_n_per_mm, sqrt(6.0 * spring["k3_per_mm2"])
    y0 = asinh(spec.pretension_n * q / k1) / q if q > 0.0 else spec.pretension_n / k1
    return Load(k1, q, y0, 0.5 * spring["play_mm"], PLAY_SLIP_MM)


def build_chain(spec: BristleSpec, system: str, values: Values) -> Chain:
    """Chain at rest: every spring at the pretension, bristles upright."""
    passes = 1 if system == "act" else 2
    cell = spec.length_mm / spec.nodes
    one = np.full(spec.nodes + 1, cell)
    one[0] = one[-1] = 0.5 * cell
    lengths = np.concatenate([one] * passes)
    last = lengths.size - 1
    per_kn = values["tendon_elasticity"]["compliance_per_kn"]
    compliance = lengths * (1e-3 * per_kn if per_kn > 0.0 else 1.0 / spec.ea_n)
    # g/m is 1e-6 kg/mm, and 1 kg is 1e-3 N s^2/mm
    mass = 1e-9 * spec.line_density_g_per_m * 0.5 * (lengths[:-1] + lengths[1:])
    ends, inner = [np.zeros(last + 1) for _ in range(7)], np.zeros(last)
    return Chain(
        compliance=compliance, stiffness=1.0 / compliance, offset=np.full(last + 1, spec.pretension_n),
        kelvin=np.zeros((2, last + 1)), u=ends[0], u_old=ends[1], speed=ends[2], mass=mass,
        tension=np.full(last + 1, spec.pretension_n), force=inner, back=ends[3], shift=ends[4], side=ends[5] + 1.0,
        joint=np.zeros(2),
    )  # fmt: skip


def scattered(size: int) -> FloatArray:
    """Numbers evenly in -1..1 in an order without trend (van der Corput, base 2)."""
    place = np.zeros(size)
    index, unit = np.arange(1, size + 1), 0.5
    while np.any(index):
        place += unit * (index % 2)
        index, unit = index // 2, 0.5 * unit
    return 2.0 * place - 1.0


def build_contact(spec: BristleSpec, run: BristleRun, values: Values) -> Contact:
    """Contacts of all nodes, pulley included, fresh."""
    weights = bend_weights(spec, run.system, run.location)
    size, middle = weights.size, spec.nodes
    a, slide = values["asymmetric_friction"]["a"], values["presliding"]
    pull, release = run.theta * weights * (1.0 + a), run.theta * weights * (1.0 - a)
    bias = np.full(size, values["const_friction"]["w_l_n"] / spec.nodes)
    delta = spec.bristle_mm + slide["breakaway_mm"] * (1.0 + slide["spread"] * scattered(size))
    living = np.ones(size, dtype=np.int64)
    if run.system == "sstl":
        pulley = values["pulley_friction"]
        pull[middle], release[middle], bias[middle] = pulley["m_p"], pulley["m_r"], pulley["f0_n"]
        living[middle], delta[middle] = 0, spec.bristle_mm
    start = np.where(living == 1, 1.0 + values["friction_drift"]["d_mu"], 1.0)
    return Contact(
        grips=((pull > 0.0) | (release > 0.0) | (bias > 0.0)).astype(np.int64), living=living, theta_pull=pull,
        theta_release=release, bias=bias, delta=delta, drag=values["viscous"]["c_l_n_s_per_mm"] * weights,
        level=start, zeta=np.zeros(size), trial=np.zeros(size), film_age=np.zeros(size), age=np.zeros(size),
    )  # fmt: skip


def build_law(spec: BristleSpec, run: BristleRun, values: Values) -> ContactLaw:
    """Parameters of the contact laws; a drift given by the path of the input tension goes by the mean time it takes."""
    drift, film, stick, dwell = (values[key] for key in ("friction_drift", "stribeck", "stick_slip", "dwell_aging"))
    per_unit = spec.load_k1_n_per_mm if run.drive == "position" else 1.0
    rate = per_unit * float(np.abs(np.diff(run.command)).sum()) / float(run.time_s[-1] - run.time_s[0])
    return ContactLaw(
        alpha=values["load_dependent_friction"]["alpha"],
        c_t=values["sheath_compliance"]["c_t_per_n"],
        drift=drift["d_mu"],
        drift_s=drift["path_n"] / max(rate, 1e-9),
        stribeck_ratio=film["ratio"],
        stribeck_speed=film["v_s_mm_s"],
        stick_ratio=stick["ratio"],
        stick_s=spec.healing_mm / stick["v_c_mm_s"],
        dwell_b=dwell["b"],
        dwell_t0=dwell["t0_s"],
        renewal_mm=spec.renewal_mm,
        film_mm=spec.film_mm,
    )


def build_setting(spec: BristleSpec, values: Values, law: ContactLaw) -> Setting:
    """Settings of the stepping; flags switch off what the effects at hand do not need."""
    creep = values["viscoelastic_creep"]
    remembering = law.stribeck_ratio > 1.0 or law.stick_ratio > 1.0 or law.dwell_b > 0.0
    return Setting(
        pretension=spec.pretension_n,
        sheath_compliance=values["sheath_compliance"]["k_sh_mm_per_n"],
        gap=values["slack"]["gap_mm"],
        creep_fraction=creep["fraction"],
        creep_s=(creep["tau_s"] / CREEP_SPREAD, creep["tau_s"] * CREEP_SPREAD),
        changing=remembering or law.drift != 0.0,
        remembering=remembering,
        finest_s=spec.finest_step_s,
        tolerance=spec.tolerance_n,
        limit=spec.max_iterations + 2 * spec.nodes,  # a front of slip may pass one node an iteration
    )


@njit(cache=True)
def late_command(time: FloatArray, command: FloatArray, tau: float, inverse_slew: float) -> FloatArray:
    """What a sluggish tension loop makes of its command (N): a first-order lag, its rate cut at the slew limit."""
    reached = command.copy()
    for n in range(1, command.size):
        dt = time[n] - time[n - 1]
        keep = exp(-dt / tau) if tau > 0.0 else 0.0
        change = (1.0 - keep) * (command[n] - reached[n - 1])
        if inverse_slew > 0.0:
            change = max(-dt / inverse_slew, min(dt / inverse_slew, change))
        reached[n] = reached[n - 1] + change
    return reached


def build_inputs(run: BristleRun, values: Values) -> tuple[FloatArray, FloatArray]:
    """Command that the drive follows, and wrap angle over that without other tendons, one value a sample."""
    command, lag, bending = run.command, values["tension_loop_lag"], values["tendon_crosstalk"]["c_bend_per_n"]
    if run.drive != "position" and (lag["tau_s"] > 0.0 or lag["inverse_slew_s_per_n"] > 0.0):
        command = late_command(run.time_s, command, lag["tau_s"], lag["inverse_slew_s_per_n"])
    if run.neighbour_n is None:
        return command, np.ones(command.size)
    # Neighbours bend the tube by a share a newton, less and less as it stiffens.
    return command, np.exp(2.0 * np.tanh(0.5 * bending * run.neighbour_n))


def simulate_bristle(
    spec: BristleSpec,
    run: BristleRun,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    noise: NoiseSpec | None = None,
    seed: int = 0,
    keep_nodes: bool = False,
) -> BristleResult:
    """Record one run on the bristle simulator.

    It starts at rest at the pretension, is brought slowly to the first command and then follows it. Without effects and
    in the limit of short bristles it obeys the capstan equation with backlash, Eq. (3) and (5):
    out = clip(out, exp(-n theta) in, exp(n theta) in), with out equal to the pretension before the first command.

    Parameters
    ----------
    spec : geometry, mechanics, contact, drive and solver.
    run : configuration and command, n samples.
    effects : effect id to {parameter: value}, see `catalogue.EFFECTS`; what is missing is neutral.
    noise : sensor noise; by default 0.02 N white.
    seed : seed of all random numbers, >= 0; equal seeds give equal records.
    keep_nodes : also return the tension of every spring.

    Returns
    -------
    BristleResult, arrays of shape (n,).

    Raises
    ------
    ValueError
        An effect, a parameter or the location is unknown, or a value is out of range.
    """
    values = resolve_effects(effects or {})
    law = build_law(spec, run, values)
    setting = build_setting(spec, values, law)
    calm = setting._replace(changing=False, remembering=False)
    motor = Motor(spec.pid_kp_mm_per_n, spec.pid_ki_mm_per_n_s, spec.pid_kd_mm_s_per_n, spec.motor_lag_s)
    probe = np.zeros(PROBES)
    chain, contact = build_chain(spec, run.system, values), build_contact(spec, run, values)
    bench = Bench(chain, contact, build_load(spec, values), law, motor, setting, probe)

    size = run.time_s.size
    command, swell = build_inputs(run, values)
    rest = setting.gap if run.drive == "position" else spec.pretension_n
    path = np.linspace(rest, command[0], LEAD_STEPS + 1)
    # Nothing rests or wears while the run is being set up, so that contacts are fresh at its first sample.
    lead_in(bench._replace(setting=calm), POSITION if run.drive == "position" else TENSION, path, swell[0], LEAD_STEP_S)
    out = Recording(np.empty(size), np.empty(size), np.empty(size), np.empty((size if keep_nodes else 0, chain.tension.size)))
    march(bench, run.time_s, command, swell, DRIVE_CODES[run.drive], out)

    truth = (out.t_in, out.t_out, out.x_in)
    seen = record(run.time_s, truth, values, run.system, noise or NoiseSpec(), seed)
    return _result(seen, out, probe, keep_nodes)


def _result(
    seen: tuple[FloatArray, FloatArray, FloatArray, FloatArray], out: Recording, probe: FloatArray, keep_nodes: bool
) -> BristleResult:
    """Return what sensors saw (time, tensions, position), beside the truth and what the solver did."""
    stamps, seen_in, seen_out, seen_x = seen
    return BristleResult(
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
