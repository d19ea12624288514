"""What a straight line from input to output leaves, and a model that leaves more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.gap import Errors
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simple import line_n
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory
from sstl_cli.steps import diagnose, simulate

NOISE_N = 0.02


def line(name, system, slope, zero):
    """Return 40 s of an output that is a straight line of its input beside noise."""
    t = np.arange(0.0, 40.0, 0.02)
    u = 12.0 + 9.0 * np.sin(2.0 * np.pi * t / (5.0 + slope))
    noise = NOISE_N * np.random.default_rng(int(10 * slope)).standard_normal(len(t))
    return Run(name, system, t, u, slope * u + zero + noise, config_id="a")


def left(runs, known=0.0):
    sim = Simulator(prepare(runs), Mechanics())
    z = np.zeros(len(sim.y))
    return line_n(sim, Errors(z, z, 0.0, sim.weight, z + known)), sim


def test_each_system_has_a_line_of_its_own_and_its_runs_share_it():
    found, sim = left([line("a", "act", 0.6, 2.0), line("b", "sstl", 0.3, -1.0)])
    # several readings are one sample of the analysis
    assert 0.0 < found < 1.5 * NOISE_N / np.sqrt(sim.problem.records[0].thin * sim.problem.records[0].factor)
    shared, _ = left([line("a", "act", 0.6, 2.0), line("b", "act", 0.3, -1.0)])
    assert shared > 1.0


def test_what_the_simulator_is_known_to_leave_is_a_part_of_the_output():
    runs = [line("a", "act", 0.6, 2.0)]
    _, sim = left(runs)
    known = 0.5 * (-1.0) ** np.arange(len(sim.y))
    assert left(runs, known)[0] == pytest.approx(0.5, rel=0.02)


def test_a_model_that_a_line_beats_is_said_to_be_none():
    """An input with the wrong sign was fitted with an error as large as the output itself, and nothing said so."""
    move = Trajectory(kind="trapezoid", duration_s=12.0, cycles=2, drive="tension", systems=("act",))
    bends = (Configuration(id="a", theta=0.1), Configuration(id="b", theta=0.15))
    plan = Scenario(sampling_hz=50.0, noise=NoiseSection(white_n=NOISE_N), configurations=bends, trajectories=(move,))
    log = list(simulate.run(plan, {}, 1))
    options = diagnose.DiagnoseOptions(effects=("zero_offset",), max_effects=1, physics=False)

    def said(runs):
        return [n for n in diagnose.run(runs, options).body.notes if "straight line" in n]

    assert said(log) == []
    wrong = [replace(r, tension_in_n=-r.tension_in_n) for r in log]
    (note,) = said(wrong)
    assert note.startswith("the model leaves ") and note.endswith(
        "it is no model of this rig; check units, signs and which channel is which"
    )
    # in the unit of the recording
    (large,) = said([replace(r, tension_in_n=50.0 * r.tension_in_n, tension_out_n=50.0 * r.tension_out_n) for r in wrong])
    (here, beside), (there, by) = ([float(w) for w in n.split() if w[0].isdigit()] for n in (note, large))
    assert there == pytest.approx(50.0 * here, rel=0.2) and by == pytest.approx(50.0 * beside, rel=0.1) and beside < here
