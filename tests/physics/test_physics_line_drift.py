"""Friction that changes under a line that is held: what was pulled last gives way, as far as the line is elastic."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of

DT, THETA, START_N = 0.02, 0.6, 6.0
TIME = np.arange(0.0, 12.0, DT)
# pulled up, then let back: the output is held until the whole line has turned round
TENSION = np.interp(TIME, [0.0, 4.0, 12.0], [START_N, 24.0, 9.0])
HELD = TIME > 4.1
# a neighbour that straightens the tube lets go meanwhile
BESIDE_N = np.interp(TIME, [0.0, 4.0, 10.0], [40.0, 40.0, 0.0])
TUBE = {"tendon_crosstalk": {"c_bend_per_n": 0.008}}


def output(load_n_per_mm: float, effects: dict[str, dict[str, float]]) -> np.ndarray:
    drive = replace(drive_of("act", "CP", DT, TENSION, Mechanics(load_n_per_mm=load_n_per_mm)), neighbour_n=BESIDE_N)
    return np.asarray(predict(drive, THETA, activate(effects), START_N))


def moved(load_n_per_mm: float) -> float:
    """By how much (N) the output of a line that is held rises."""
    held = output(load_n_per_mm, TUBE)[HELD]
    return float(held[-1] - held[0])


@pytest.mark.parametrize("load_n_per_mm", [0.5, 8.0, 60.0])
def test_a_held_line_gives_way_as_that_of_the_rig(load_n_per_mm: float) -> None:
    """The rig solves the same balance by other code, with five times as many nodes."""
    run = RigRun("act", THETA, "CP", TIME, "tension", TENSION, BESIDE_N)
    rig = simulate_rig(RigSpec(load_k1_n_per_mm=load_n_per_mm, pretension_n=START_N), run, TUBE, NoiseSpec(0.0, 0.0, 1.0, 0.0), seed=1)
    held = rig.true_tension_out_n[HELD]
    found = output(load_n_per_mm, TUBE)[HELD]
    assert held[-1] - held[0] == pytest.approx(moved(load_n_per_mm), rel=0.1)
    assert found == pytest.approx(held, abs=0.02)


def test_the_softer_its_end_the_less_a_held_line_moves() -> None:
    """A play alone would not move at all."""
    assert moved(60.0) > 1.1 * moved(8.0) > 1.1 * 2.0 * moved(0.5) > 0.0


@pytest.mark.parametrize(
    "drifts", [{"d_mu_time": 0.3, "time_s": 6.0}, {"d_mu_heat_s_per_n2": -3e-3, "cooling_s": 10.0}], ids=["time", "heat"]
)
def test_friction_that_falls_with_time_or_heat_moves_a_held_line(drifts: dict[str, float]) -> None:
    held = output(8.0, {"friction_drift": drifts})[HELD]
    assert held[-1] - held[0] > 0.005


def test_friction_of_a_line_that_slides_leaves_a_held_one_alone() -> None:
    """The mean over jumps goes with the speed of a line that slides: a held one has none."""
    assert np.ptp(output(8.0, {"stribeck": {"mean_ratio": 1.3, "mean_mm_s": 2.0}})[HELD]) == 0.0


def test_what_changes_friction_along_a_held_line_says_so() -> None:
    """The load decides how far a held line gives way, so that it has to be free in a fit."""
    assert {e.id for e in catalogue().values() if e.along} == {"friction_drift", "tendon_crosstalk"}
