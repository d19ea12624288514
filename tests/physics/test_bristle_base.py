"""The bare bristle simulator: limits, energy, convergence, and another program's solution of its equations."""

from __future__ import annotations

from dataclasses import fields
from time import process_time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sstl_cli.physics import rig
from sstl_cli.physics.bristle import QUIET, BristleRun, BristleSpec, bend_weights, simulate_bristle

THETA = 0.53
PASSES = {"act": 1, "sstl": 2}
SPEC = BristleSpec()


def play(t_in, gamma_pull, gamma_release, start):
    """Play operator, written out: Eq. (3) and (5)."""
    out = np.empty_like(t_in)
    held = start
    for k, value in enumerate(t_in):
        held = min(max(held, gamma_pull * value), gamma_release * value)
        out[k] = held
    return out


def rich_command(size=3000, dt=0.02):
    """Large loops, inner loops, a hold and a chirp, 3..32 N."""
    time = np.arange(size) * dt
    loops = np.interp(time, [0, 8, 16, 22, 26, 32, 40], [5, 32, 3, 25, 12, 20, 20])
    tail = 20 + 8 * np.sin(2 * np.pi * (0.05 + 0.02 * (time - 40)) * (time - 40))
    return time, np.where(time < 40, loops, tail)


def run(system="act", effects=None, command=None, time=None, drive="tension", spec=SPEC, theta=THETA, location="CP"):
    if command is None:
        time, command = rich_command()
    return simulate_bristle(spec, BristleRun(system, theta, location, time, drive, command), effects or {}, QUIET)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize("location", ["NP", "CP", "ND"])
@pytest.mark.parametrize("drive", ["tension", "position", "loop"])
def test_short_bristles_are_the_play_operator(system, location, drive):
    time, command = rich_command()
    if drive == "position":
        command = (command - 5.0) * (0.3 if system == "act" else 0.5)
    done = run(system, {}, command, time, drive, location=location)
    n = PASSES[system]
    off = done.true_tension_out_n - play(done.true_tension_in_n, np.exp(-n * THETA), np.exp(n * THETA), SPEC.pretension_n)
    assert rms(off) < 0.002 and np.abs(off).max() < 0.006
    assert done.unconverged == 0 and done.true_tension_in_n.max() > 20.0


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize("theta", [0.1, 0.7, 3.0])
@pytest.mark.parametrize("nodes", [6, 30])
def test_slopes_are_the_capstan_slopes_for_any_number_of_nodes(system, theta, nodes):
    time = np.linspace(0.0, 60.0, 1201)
    command = np.interp(time, [0, 30, 60], [2.0, 40.0, 0.05])
    done = run(system, {}, command, time, theta=theta, spec=BristleSpec(nodes=nodes, pretension_n=0.05))
    n = PASSES[system]
    assert done.true_tension_out_n[600] == pytest.approx(40.0 * np.exp(-n * theta), rel=2e-3)
    if theta < 1.0:
        assert done.true_tension_out_n[-1] == pytest.approx(0.05 * np.exp(n * theta), rel=1e-2)


def test_the_shorter_the_bristles_the_nearer_to_coulomb():
    _, command = rich_command()
    coulomb = play(command, np.exp(-THETA), np.exp(THETA), SPEC.pretension_n)
    off = [rms(run(spec=BristleSpec(bristle_mm=b)).true_tension_out_n - coulomb) for b in (0.01, 0.001, 0.0001)]
    assert off[1] < 0.2 * off[0] and off[2] < 0.2 * off[1]


def test_imposed_tension_is_exact_and_runs_repeat():
    time, command = rich_command(500)
    asked = BristleRun("sstl", THETA, None, time, "tension", command)
    first, second, other = (simulate_bristle(SPEC, asked, seed=s) for s in (4, 4, 5))
    assert np.array_equal(first.true_tension_in_n, command)
    assert np.array_equal(first.tension_out_n, second.tension_out_n)
    assert not np.array_equal(first.tension_out_n, other.tension_out_n)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_the_loop_follows_its_command(system):
    time, command = rich_command(1500)
    error = run(system, {}, command, time, "loop").true_tension_in_n - command
    assert 0.01 < rms(error) < 1.0 and abs(error[-1]) < 0.3


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"presliding": {"breakaway_mm": 0.1}},
        {"viscous": {"c_l_n_s_per_mm": 0.05}},
        {"asymmetric_friction": {"a": 0.2}},
        {"load_dependent_friction": {"alpha": 0.3}},
        {"const_friction": {"w_l_n": 0.5}},
        {"stribeck": {"ratio": 1.2, "v_s_mm_s": 10.0}},
    ],
    ids=lambda e: next(iter(e), "none"),
)
def test_friction_never_creates_energy_and_takes_all_that_the_motor_gives(system, effects):
    time = np.linspace(0.0, 80.0, 8001)
    travel = 5.0 + 4.0 * np.sin(2 * np.pi * time / 20.0) ** 2
    whole = run(system, effects, travel, time, "position")
    half = run(system, effects, travel[:4001], time[:4001], "position")
    assert whole.min_step_dissipation_j > -1e-12 and whole.unconverged == 0
    # over closed cycles springs and masses give back what they took
    work = 1e-3 * np.trapezoid(whole.true_tension_in_n[4000:], travel[4000:])
    assert work > 0.01
    assert work == pytest.approx(whole.dissipated_j - half.dissipated_j, rel=0.02)


@pytest.mark.parametrize(
    ("effects", "allowed"),
    [
        ({}, 0.0005),
        ({"viscous": {"c_l_n_s_per_mm": 0.05}}, 0.002),
        ({"presliding": {"breakaway_mm": 0.3}}, 0.04),
        ({"viscoelastic_creep": {"fraction": 0.3}}, 0.001),
    ],
    ids=lambda e: next(iter(e), "none") if isinstance(e, dict) else "",
)
def test_convergence_in_nodes_and_in_step(effects, allowed):
    fine = run(effects=effects, spec=BristleSpec(nodes=120)).true_tension_out_n
    off = [rms(run(effects=effects, spec=BristleSpec(nodes=n)).true_tension_out_n - fine) for n in (8, 30)]
    assert off[1] < allowed and off[1] < 0.6 * off[0] + 1e-4
    time, _ = rich_command()
    by_step = []
    for divide in (16, 2, 1):
        instants = np.linspace(0.0, time[-1], divide * (time.size - 1) + 1)
        own = np.interp(instants, *rich_command())
        by_step.append(run(effects=effects, command=own, time=instants).true_tension_out_n[::divide])
    off = [rms(found - by_step[0]) for found in by_step[1:]]
    assert off[0] < 0.75 * off[1] + 1e-4 and off[1] < 0.01


def test_jumps_converge_in_the_finest_step():
    time = np.arange(0.0, 14.0, 0.01)
    command = np.interp(time, [0.0, 14.0], [5.0, 22.5])
    outs = []
    for finest in (4e-5, 1e-5, 2.5e-6):
        spec = BristleSpec(finest_step_s=finest)
        outs.append(run(effects={"stick_slip": {"ratio": 1.2}}, command=command, time=time, spec=spec).true_tension_out_n)
    first = [int(np.argmax(np.diff(out) > 0.1)) for out in outs]
    assert max(first) - min(first) <= 1 and first[0] > 10
    # height of the first jump, which inertia carries past the kinetic line
    heights = [np.ptp(out[k - 5 : k + 6]) for out, k in zip(outs, first, strict=True)]
    assert heights[2] > 0.3
    assert abs(heights[1] - heights[2]) < 0.5 * abs(heights[0] - heights[2]) and heights[1] == pytest.approx(heights[2], rel=0.05)


def rising(t):
    """Input tension that starts at the pretension, so that the lead-in leaves the bristles upright, N."""
    return 5.0 + 4.0 * t + 2.5 * np.sin(5.0 * t) ** 2


def reference(time, nodes, theta, delta, drag, mass_per_mm, ratio, v_s):
    """The same chain as differential equations, solved by scipy: elasto-plastic LuGre with Tustin's g and a film."""
    cell, film = SPEC.length_mm / nodes, SPEC.film_mm
    stiff = SPEC.ea_n / np.r_[np.full(nodes - 1, cell), 0.5 * cell]
    weight = bend_weights(BristleSpec(nodes=nodes, bend_arc_fraction=1.0), "act", "CP")

    def rates(t, state):
        u, v, z, age = state.reshape(4, nodes)
        end = 1.0 / (1.0 / stiff[-1] + 1.0 / SPEC.load_k1_n_per_mm)
        behind = SPEC.pretension_n + np.r_[stiff[:-1] * (u[:-1] - u[1:]), end * u[-1]]
        before = np.r_[rising(t), behind[:-1]]
        g = 1.0 + (ratio - 1.0) * np.exp(-film / (np.maximum(age, 1e-6) * v_s))
        zeta = z / delta
        friction = behind * np.expm1(zeta * theta * weight)
        # bristles only bend below half of their level, and on the way back
        dz = v * (1.0 - np.where(np.sign(v) * zeta > 0.5 * g, np.sign(v) * zeta / g, 0.0))
        force = before - behind - friction - drag * weight * v
        return np.concatenate([v, force / (mass_per_mm * cell), dz, 1.0 - np.abs(v - dz) * age / film])

    start = np.zeros(4 * nodes)
    found = solve_ivp(rates, (time[0], time[-1]), start, "Radau", time, rtol=1e-6, atol=1e-8)
    assert found.success
    end = 1.0 / (1.0 / stiff[-1] + 1.0 / SPEC.load_k1_n_per_mm)
    return SPEC.pretension_n + end * found.y[nodes - 1]


@pytest.mark.parametrize("ratio", [1.0, 1.3])
def test_the_same_as_another_program_makes_of_the_equations(ratio):
    time = np.arange(0.0, 1.5, 0.001)
    nodes, delta, drag = 4, 0.05, 0.05
    spec = BristleSpec(nodes=nodes, bend_arc_fraction=1.0, bristle_mm=delta, line_density_g_per_m=20.0, finest_step_s=1e-4)
    effects = {"viscous": {"c_l_n_s_per_mm": drag}, "stribeck": {"ratio": ratio, "v_s_mm_s": 8.0}}
    own = run("act", effects, rising(time), time, spec=spec).true_tension_out_n
    other = reference(time, nodes, THETA, delta, drag, 20e-9, ratio, 8.0)
    assert np.ptp(other) > 1.5
    assert rms(own - other) < 0.004


def test_dead_zone_depends_on_the_location_of_the_bend():
    time = np.linspace(0.0, 60.0, 3001)
    command = np.interp(time, [0, 30, 60], [1.5, 20.0, 1.5])

    def dead_zone(system, location):
        """Motor travel after the reversal at 20 N until the output starts to fall, mm."""
        done = run(system, {}, command, time, location=location)
        out, x = done.true_tension_out_n[1500:], done.true_position_in_mm[1500:]
        return x[0] - x[np.argmax(out < out[0] - 0.02)]

    found = [dead_zone("act", place) for place in ("NP", "CP", "ND")]
    assert found == pytest.approx([0.85, 1.79, 2.67], abs=0.35)
    both = [dead_zone("sstl", place) for place in ("NP", "CP", "ND")]
    assert max(both) / min(both) < 1.25 < found[2] / found[0]


def test_slack_tendon_never_pushes_and_does_not_coast_away():
    time = np.linspace(0.0, 20.0, 1001)
    pulled = run(command=np.interp(time, [0, 5, 10, 20], [0.0, 5.0, -6.0, 5.0]), time=time, drive="position")
    assert pulled.true_tension_in_n.min() == 0.0 <= pulled.true_tension_out_n.min()
    assert np.mean(pulled.true_tension_in_n == 0.0) > 0.1 and pulled.unconverged == 0
    dropped = run(command=np.interp(time, [0, 1, 1.2, 20], [5.0, 30.0, 0.0, 0.0]), time=time)
    assert np.ptp(dropped.true_position_in_mm[200:]) < 0.2


def test_node_tensions_fall_along_the_tendon_when_pulling():
    time, command = rich_command(401)
    asked = BristleRun("sstl", THETA, "CP", time, "tension", command)
    done = simulate_bristle(SPEC, asked, noise=QUIET, keep_nodes=True)
    profile = done.node_tension[400]
    assert done.node_tension.shape == (401, 2 * SPEC.nodes + 2)
    assert np.all(np.diff(profile) <= 1e-7) and profile[0] == command[400]
    assert profile[-1] == pytest.approx(done.true_tension_out_n[400], abs=1e-6)


def test_whoever_can_call_the_rig_can_call_this():
    shared = {"length_mm", "ea_n", "nodes", "bend_arc_fraction", "bend_centres", "load_k1_n_per_mm", "pretension_n"}
    assert shared <= {f.name for f in fields(BristleSpec)} & {f.name for f in fields(rig.RigSpec)}
    assert [f.name for f in fields(BristleRun)] == [f.name for f in fields(rig.RigRun)]


@pytest.mark.parametrize(
    "bad",
    [
        dict(system="tube"), dict(drive="torque"), dict(theta=-1.0), dict(theta=np.nan), dict(command=np.zeros(4)),
        dict(command=np.full(11, np.inf)), dict(time_s=np.linspace(1.0, 0.0, 11)), dict(neighbour_n=np.zeros(3)),
    ],
    ids=lambda bad: next(iter(bad)),
)  # fmt: skip
def test_bad_runs_are_refused_by_name(bad):
    time = np.linspace(0.0, 1.0, 11)
    given = dict(system="act", theta=0.5, location=None, time_s=time, drive="tension", command=time + 5) | bad
    with pytest.raises(ValueError, match=next(iter(bad))):
        BristleRun(**given)


def test_bad_rigs_and_places_are_refused_by_name():
    time = np.linspace(0.0, 1.0, 11)
    with pytest.raises(ValueError, match="location"):
        simulate_bristle(SPEC, BristleRun("act", 0.5, "XX", time, "tension", time + 5))
    for name, value in (("ea_n", -1.0), ("nodes", 3), ("pretension_n", np.nan), ("bend_arc_fraction", 0.0), ("bristle_mm", 0.0)):
        with pytest.raises(ValueError, match=name):
            BristleSpec(**{name: value})


def test_speed():
    time, command = rich_command(20_000, 0.004)
    asked = BristleRun("act", THETA, "CP", time, "tension", command)
    simulate_bristle(SPEC, asked)
    best = np.inf
    for _ in range(4):
        # processor time: another process on the machine is not the matter here
        start = process_time()
        simulate_bristle(SPEC, asked)
        best = min(best, process_time() - start)
    assert time.size / best > 100_000
