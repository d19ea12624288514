"""From parameters to a line at rest: stations, segments, and the laws as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from math import log
from zlib import crc32

import numpy as np

from sstl_cli.core.rng import log_uniform
from sstl_cli.physics.given import Values
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import REFERENCE_N, Array, Laws, Line, Rate, Rub, Spring, Trial
from sstl_cli.physics.variant.spec import VariantRun, VariantSpec

# hidden numbers of a contact, drawn once a rig: memory of the sliding speed (Hess, Soom 1990: 2-9 ms), slip that breaks
# a contact (Rabinowicz 1951: 1-100 um), and the age in slips at which a contact has healed
MEMORY_S, WEAKENING_MM, HEALED_SLIPS = (0.002, 0.009), (0.003, 0.05), (3.0, 15.0)


def build_laws(v: Values, chosen: Mapping[str, Chosen], load_k1: float, seed: int) -> Laws:
    """Return the strengths and codes of all laws; hidden numbers are drawn from the seed."""
    return Laws(_rub(v, chosen), _rate(v, chosen, seed), _spring(v, chosen, load_k1))


def _rub(v: Values, chosen: Mapping[str, Chosen]) -> Rub:
    """Return how friction depends on tension and direction."""
    return Rub(
        pulley_pull=v["pulley_friction"]["m_p"],
        pulley_release=v["pulley_friction"]["m_r"],
        pulley_n=v["pulley_friction"]["f0_n"],
        pulley_code=chosen["pulley_friction"].code,
        pulley_power=chosen["pulley_friction"].shape,
        load=v["load_dependent_friction"]["alpha"],
        load_code=chosen["load_dependent_friction"].code,
        load_shape=chosen["load_dependent_friction"].shape,
        sheath=v["sheath_compliance"]["c_t_per_n"],
        sheath_code=chosen["sheath_compliance"].code,
        sheath_shape=chosen["sheath_compliance"].shape,
        lean=v["asymmetric_friction"]["a"],
        lean_code=chosen["asymmetric_friction"].code,
        lean_shape=chosen["asymmetric_friction"].shape,
    )


def _rate(v: Values, chosen: Mapping[str, Chosen], seed: int) -> Rate:
    """Return how friction depends on time, path and speed."""
    rng = np.random.default_rng([seed, crc32(b"contact")])
    memory, weakening, healed = (log_uniform(rng, low, high) for low, high in (MEMORY_S, WEAKENING_MM, HEALED_SLIPS))
    return Rate(
        drift=v["friction_drift"]["d_mu"],
        drift_code=chosen["friction_drift"].code,
        drift_path=v["friction_drift"]["path_n"],
        drift_shape=chosen["friction_drift"].shape,
        beside=v["tendon_crosstalk"]["c_bend_per_n"],
        beside_code=chosen["tendon_crosstalk"].code,
        speed=v["stribeck"]["ratio"] - 1.0,
        speed_mm_s=v["stribeck"]["v_s_mm_s"],
        speed_code=chosen["stribeck"].code,
        speed_shape=chosen["stribeck"].shape,
        drag=v["viscous"]["c_l_n_s_per_mm"],
        drag_code=chosen["viscous"].code,
        drag_shape=chosen["viscous"].shape,
        soft=v["presliding"]["breakaway_mm"],
        soft_code=chosen["presliding"].code,
        heal=v["stick_slip"]["ratio"] - 1.0,
        heal_s=healed * weakening / v["stick_slip"]["v_c_mm_s"],
        heal_code=chosen["stick_slip"].code,
        heal_shape=chosen["stick_slip"].shape,
        dwell=v["dwell_aging"]["b"],
        dwell_s=v["dwell_aging"]["t0_s"],
        dwell_code=chosen["dwell_aging"].code,
        dwell_shape=chosen["dwell_aging"].shape,
        memory_s=memory,
        weakening_mm=weakening,
    )


def _spring(v: Values, chosen: Mapping[str, Chosen], load_k1: float) -> Spring:
    """Return the load, the rope and its creep."""
    steeper = log(1.0 + 27.0 * v["load_spring"]["k3_per_mm2"])
    fung = chosen["load_spring"].code == 0
    play, rope, creep = v["load_spring"]["play_mm"], v["tendon_elasticity"]["compliance_per_kn"], v["viscoelastic_creep"]["fraction"]
    return Spring(
        plain=steeper == 0.0 and play == 0.0 and rope == 0.0 and creep == 0.0,
        creep=creep,
        load_k1=load_k1,
        fung=steeper / 3.0 if fung else 0.0,
        joint_share=0.0 if fung else steeper,
        joint_n=1.5,
        play=play,
        play_n=chosen["load_spring"].shape,
        rope=rope,
        rope_code=chosen["tendon_elasticity"].code,
        rope_shape=chosen["tendon_elasticity"].shape,
    )


def one_pass(spec: VariantSpec, location: str | None) -> tuple[Array, Array]:
    """Return length and share of the bend of every cell of a pass, in shares of the pass; half of the cells are bent.

    Raises
    ------
    ValueError
        The location is not one of `spec.bend_centres`.
    """
    key = "CP" if location is None else location
    if key not in spec.bend_centres:
        raise ValueError(f"variant: location = {location!r} must be None or one of {', '.join(spec.bend_centres)}")
    arc = spec.bend_arc_fraction
    # a bend cannot hang over the end of the sheath
    start = min(max(spec.bend_centres[key] - 0.5 * arc, 0.0), 1.0 - arc)
    straight = (start, 1.0 - arc - start)
    bent = spec.nodes if arc > 1.0 - 1e-9 else max(2, spec.nodes // 2)
    cells: list[float] = []
    for place, share in ((0, straight[0]), (1, arc), (2, straight[1])):
        if share > 1e-9:
            count = bent if place == 1 else max(1, round((spec.nodes - bent) * share / (1.0 - arc)))
            cells += [share / count] * count
    length = np.array(cells)
    middle = np.cumsum(length) - 0.5 * length
    inside = (middle > start) & (middle < start + arc)
    return length, inside / inside.sum()


def build_line(spec: VariantSpec, run: VariantRun, v: Values, chosen: Mapping[str, Chosen]) -> Line:
    """Return the line at rest: every segment at the pretension, no friction mobilised."""
    length, bend = one_pass(spec, run.location)
    terminal = np.zeros(length.size)
    terminal[0] += 0.5
    terminal[-1] += 0.5
    rough = bend if chosen["const_friction"].id == "adhesive" else terminal
    wet = bend if chosen["viscous"].id == "curvature" else length
    pulley = np.zeros(length.size, np.int64)
    if run.system == "sstl":
        pulley = np.concatenate((pulley, [1], pulley))
        length, bend, rough, wet = (np.concatenate((a, [0.0], a[::-1])) for a in (length, bend, rough, wet))
    per_kn = v["tendon_elasticity"]["compliance_per_kn"]
    per_pass = spec.length_mm * (per_kn / 1000.0 if per_kn > 0.0 else 1.0 / spec.ea_n)
    half = 0.5 * per_pass * length
    compliance = np.concatenate((half, [0.0])) + np.concatenate(([0.0], half))
    angle, weight = run.theta * bend, v["const_friction"]["w_l_n"] * rough
    sliding = v["presliding"]
    # break-away distances cover z (1 +- spread) evenly over the rubbing stations, in the order of van der Corput
    rank = np.cumsum(angle + weight > 0.0).tolist()
    place = np.array([int(f"{i:010b}"[::-1], 2) / 512.0 - 1.0 for i in rank])
    # half of it is the distance of an exponential that lags as much as a straight rise over all of it
    mean = 0.5 * sliding["breakaway_mm"]
    breakaway = np.maximum(mean * (1.0 + sliding["spread"] * place), 0.02 * mean)
    taus, shares = creep_spectrum(v["viscoelastic_creep"]["tau_s"], chosen["viscoelastic_creep"])
    at_rest = v["viscoelastic_creep"]["fraction"] * spec.pretension_n * np.outer(compliance, shares)
    path = v["friction_drift"]["path_n"] * 0.5 * (0.5 * per_pass + 1.0 / spec.load_k1_n_per_mm)
    return Line(
        angle=angle,
        weight=weight,
        drag=v["viscous"]["c_l_n_s_per_mm"] * wet,
        breakaway=np.where(angle + weight > 0.0, breakaway, 0.0),
        pulley=pulley,
        compliance=compliance,
        tension=np.full(compliance.size, spec.pretension_n),
        crept=at_rest,
        creep_share=shares,
        creep_s=taus,
        rope=np.zeros(compliance.size),
        joint=np.array([0.0, 0.5]),
        drop=np.zeros(angle.size),
        speed=np.zeros(angle.size),
        rest=np.zeros(angle.size),
        wear=np.zeros(angle.size),
        wear_n_mm=(angle * REFERENCE_N + weight) * path,
        slow=np.array([0.0, 0.0, 0.0, 1.0]),
        tally=np.zeros(5),
    )


def creep_spectrum(tau_s: float, law: Chosen) -> tuple[Array, Array]:
    """Return the time constants (s) and shares of the Kelvin elements of a creep law."""
    if law.id == "two_times":
        return np.array([tau_s / law.shape, tau_s * law.shape]), np.array([0.5, 0.5])
    ratio = 10.0 ** np.arange(-2.0, 2.5, 0.5)
    share = ratio**law.shape
    # as far after tau as a standard linear solid
    share *= (1.0 - np.exp(-1.0)) / np.sum(share * (1.0 - np.exp(-1.0 / ratio)))
    return tau_s * ratio, share


def empty_trial(line: Line) -> Trial:
    """Return the work arrays of a step."""
    size = line.angle.size

    def zeros() -> Array:
        return np.zeros(size)

    return Trial(
        tension=line.tension.copy(),
        move=zeros(),
        angle=zeros(),
        weight=zeros(),
        share=np.ones(size),
        offset=zeros(),
        tangent=zeros(),
        force=zeros(),
        slope=zeros(),
        gain=zeros(),
        moved=zeros(),
        stuck=np.ones(size, np.int64),
        flow=np.zeros(size + 1),
        give=np.zeros(size + 1),
    )
