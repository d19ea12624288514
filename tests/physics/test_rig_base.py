"""The bare rig: an elastic chain with Coulomb friction has to behave as the capstan equation with backlash."""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from sstl_cli.physics import rig
from sstl_cli.physics.rig import QUIET, RigRun, RigSpec, simulate_rig

THETA = 0.53
PASSES = {"act": 1, "sstl": 2}
SPEC = RigSpec()


def play(t_in, gamma_pull, gamma_release, start):
    """Play operator, written out: Eq. (3) and (5)."""
    out = np.empty_like(t_in)
    held = start
    for k, value in enumerate(t_in):
        held = min(max(held, gamma_pull * value), gamma_release * value)
        out[k] = held
    return out


def rich_command(size=4000, dt=0.02):
    """Large loops, inner loops, holds and a fast chirp, 3..32 N."""
    time = np.arange(size) * dt
    loops = np.interp(time, [0, 8, 16, 22, 26, 32, 40], [5, 32, 3, 25, 12, 20, 20])
    tail = 17 + 8 * np.sin(2 * np.pi * (0.05 + 0.02 * (time - 40)) * (time - 40)) + 3 * (time - 40) / 40
    return time, np.where(time < 40, loops, tail)


def sweep(system, high=40.0, low=2.0, spec=SPEC, drive="tension", theta=THETA, location="CP", **options):
    """One slow rise and fall."""
    time = np.linspace(0.0, 60.0, 3001)
    command = np.interp(time, [0, 30, 60], [low, high, low])
    return simulate_rig(spec, RigRun(system, theta, location, time, drive, command), noise=QUIET, **options)


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize("location", ["NP", "CP", "ND"])
@pytest.mark.parametrize("drive", ["tension", "position", "loop"])
def test_base_is_the_play_operator(system, location, drive):
    time, command = rich_command()
    if drive == "position":
        command = (command - 5.0) * (0.3 if system == "act" else 0.5)
    result = simulate_rig(SPEC, RigRun(system, THETA, location, time, drive, command), noise=QUIET)
    n = PASSES[system]
    expected = play(result.true_tension_in_n, np.exp(-n * THETA), np.exp(n * THETA), SPEC.pretension_n)
    assert np.sqrt(np.mean((result.true_tension_out_n - expected) ** 2)) < 0.002
    assert np.max(np.abs(result.true_tension_out_n - expected)) < 0.02
    assert result.unconverged == 0
    assert result.true_tension_in_n.max() > 20.0


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize("theta", [0.1, 0.53, 0.7])
def test_slopes_are_the_capstan_slopes(system, theta):
    result = sweep(system, theta=theta)
    ratio = result.true_tension_out_n / result.true_tension_in_n
    n = PASSES[system]
    assert ratio[1500] == pytest.approx(np.exp(-n * theta), rel=1e-3)
    assert ratio[-1] == pytest.approx(np.exp(n * theta), rel=1e-3)
    # A law linear in tension and equal in both directions always gives a product of one.
    assert ratio[1500] * ratio[-1] == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_imposed_tension_is_exact_and_runs_repeat(system):
    time, command = rich_command(1000)
    run = RigRun(system, THETA, None, time, "tension", command)
    first, second = simulate_rig(SPEC, run, seed=4), simulate_rig(SPEC, run, seed=4)
    assert np.array_equal(first.true_tension_in_n, command)
    assert np.array_equal(first.tension_out_n, second.tension_out_n)
    assert not np.array_equal(first.tension_out_n, simulate_rig(SPEC, run, seed=5).tension_out_n)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_loop_follows_its_command(system):
    time, command = rich_command(2000)
    result = simulate_rig(SPEC, RigRun(system, THETA, "CP", time, "loop", command), noise=QUIET)
    error = result.true_tension_in_n - command
    assert 0.01 < np.sqrt(np.mean(error**2)) < 1.0
    assert abs(error[-1]) < 0.3


@pytest.mark.parametrize("system", ["act", "sstl"])
@pytest.mark.parametrize("effects", [{}, {"presliding": {"breakaway_mm": 0.3}}, {"viscous": {"c_l_n_s_per_mm": 0.05}}])
def test_energy_balance(system, effects):
    time = np.linspace(0.0, 80.0, 8001)
    command = 5.0 + 4.0 * np.sin(2 * np.pi * time / 20.0) ** 2
    result = simulate_rig(SPEC, RigRun(system, THETA, "CP", time, "position", command), effects, QUIET)
    assert result.min_step_dissipation_j > -1e-12
    assert result.unconverged == 0
    # Over the last closed cycles the work done by the motor is what friction ate: springs give back what they took.
    half = time.size // 2
    whole = 1e-3 * np.trapezoid(result.true_tension_in_n, command)
    first = simulate_rig(SPEC, RigRun(system, THETA, "CP", time[: half + 1], "position", command[: half + 1]), effects, QUIET)
    work = whole - 1e-3 * np.trapezoid(first.true_tension_in_n, command[: half + 1])
    assert work == pytest.approx(result.dissipated_j - first.dissipated_j, rel=0.02)


@pytest.mark.parametrize("effects", [{}, {"presliding": {"breakaway_mm": 0.4, "spread": 0.0}}])
def test_node_refinement_converges(effects):
    time, command = rich_command()
    outs = []
    for nodes in (10, 20, 40, 80):
        run = RigRun("act", THETA, "CP", time, "tension", command)
        outs.append(simulate_rig(RigSpec(nodes=nodes), run, effects, QUIET).true_tension_out_n)
    gaps = [np.sqrt(np.mean((out - outs[-1]) ** 2)) for out in outs[:-1]]
    assert gaps[2] < max(0.5 * gaps[0], 0.001)
    assert gaps[2] < 0.02


def dead_zone(system, location):
    """Motor travel after the reversal at 20 N until the output starts to fall, mm."""
    result = sweep(system, high=20.0, low=1.5, location=location)
    out, x = result.true_tension_out_n[1500:], result.true_position_in_mm[1500:]
    return x[0] - x[np.argmax(out < out[0] - 0.02)]


def test_dead_zone_depends_on_the_location_of_the_bend():
    near, centre, far = (dead_zone("act", location) for location in ("NP", "CP", "ND"))
    assert near < centre < far
    assert near == pytest.approx(0.85, abs=0.35)
    assert centre == pytest.approx(1.79, abs=0.35)
    assert far == pytest.approx(2.67, abs=0.35)
    both = [dead_zone("sstl", location) for location in ("NP", "CP", "ND")]
    assert max(both) / min(both) < 1.25 < far / near


def test_node_tensions_fall_along_the_tendon_when_pulling():
    result = sweep("sstl", keep_nodes=True)
    profile = result.node_tension[1500]
    assert profile.shape == (2 * SPEC.nodes + 2,)
    assert np.all(np.diff(profile) <= 1e-9)
    assert profile[0] == pytest.approx(result.true_tension_in_n[1500])
    assert profile[-1] == pytest.approx(result.true_tension_out_n[1500], abs=1e-6)


def test_slack_tendon_never_pushes():
    time = np.linspace(0.0, 20.0, 1001)
    command = np.interp(time, [0, 5, 10, 20], [0.0, 5.0, -6.0, 5.0])
    result = simulate_rig(SPEC, RigRun("act", THETA, "CP", time, "position", command), noise=QUIET)
    assert result.true_tension_in_n.min() == 0.0
    assert result.true_tension_out_n.min() >= 0.0
    assert np.mean(result.true_tension_in_n == 0.0) > 0.1
    assert result.unconverged == 0


def test_clear_errors():
    time = np.linspace(0.0, 1.0, 11)
    for bad in (
        dict(system="tube"),
        dict(drive="torque"),
        dict(theta=-1.0),
        dict(theta=np.nan),
        dict(command=np.zeros(4)),
        dict(command=np.full(11, np.inf)),
        dict(time_s=time[::-1]),
    ):
        fields = dict(system="act", theta=0.5, location=None, time_s=time, drive="tension", command=time + 5) | bad
        with pytest.raises(ValueError, match=next(iter(bad))):
            RigRun(**fields)
    with pytest.raises(ValueError, match="location"):
        simulate_rig(SPEC, RigRun("act", 0.5, "XX", time, "tension", time + 5))
    with pytest.raises(ValueError, match="ea_n"):
        RigSpec(ea_n=-1.0)


def test_rig_is_independent_of_the_fast_model():
    folder = Path(rig.__file__).parent
    # how a rig is described and how noisy its sensors are, which is no law
    allowed = ("numpy", "numba", "scipy", "sstl_cli.core", "sstl_cli.physics.rig", "sstl_cli.physics.given")
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                assert name.startswith(allowed) or name.split(".")[0] in sys.stdlib_module_names, (path.name, name)


def test_speed():
    time, command = rich_command(20_000, 0.004)
    run = RigRun("act", THETA, "CP", time, "tension", command)
    best = np.inf
    for _ in range(3):
        start = process_time()
        simulate_rig(SPEC, run)
        best = min(best, process_time() - start)
    assert time.size / best > 100_000
