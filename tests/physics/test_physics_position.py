"""The fast model's position against the rig's, which shares no code with it, and against hand-worked stretches."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.rig import QUIET, RigRun, RigSpec, simulate_rig
from sstl_cli.physics.transmission import activate, predict, predict_position
from sstl_cli.physics.transmission.model import drive_of

DT, THETA = 0.01, 0.53
TIME = np.arange(6000) * DT
# full strokes, a hold and slack; the rig comes from its pretension of 5 N
PATH = np.interp(TIME, [0, 10, 20, 30, 40, 45, 50, 60], [5, 30, 1, 15, 15, 0, 0, 10])
AS_BUILT = {"tendon_elasticity": {"compliance_per_kn": 0.125}}


def fast(system, location, effects, path=PATH):
    active = activate({**AS_BUILT, **effects})
    drive = drive_of(system, location, DT, path, Mechanics())
    return predict_position(drive, THETA, active, predict(drive, THETA, active, float(path[0])))


def rig(system, location, effects):
    return simulate_rig(RigSpec(), RigRun(system, THETA, location, TIME, "tension", PATH), effects, QUIET).position_in_mm


def apart(a, b):
    return float(np.std(a - b))


@pytest.mark.parametrize("location", ["NP", "CP", "ND"])
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_stretch_depends_on_where_the_bend_sits(system, location):
    assert apart(fast(system, location, {}), rig(system, location, {})) < 0.001


# mm; creep: how far it has come at the first sample differs, play: so does the side of the joint, slack: threshold
TOLERANCE = {
    "soft tendon": ({"tendon_elasticity": {"compliance_per_kn": 0.3}}, 0.002),
    "stiffening load": ({"load_spring": {"k3_per_mm2": 0.1}}, 0.001),
    "play of the load": ({"load_spring": {"play_mm": 2.0}}, 0.04),
    "soft sheath": ({"sheath_compliance": {"k_sh_mm_per_n": 0.1}}, 0.001),
    "slack": ({"slack": {"gap_mm": 3.0}}, 0.12),
    "creep": ({"viscoelastic_creep": {"fraction": 0.3, "tau_s": 10.0}}, 0.08),
    "pulley": ({"pulley_friction": {"m_p": 0.1, "m_r": 0.06, "f0_n": 0.2}}, 0.002),
    "constant friction": ({"const_friction": {"w_l_n": 0.4}}, 0.002),
    "direction": ({"asymmetric_friction": {"a": 0.1}}, 0.002),
}


@pytest.mark.parametrize("case", sorted(TOLERANCE))
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_position_follows_the_rig(case, system):
    effects, tolerance = TOLERANCE[case]
    base, found = rig(system, "CP", {}), rig(system, "CP", effects)
    left = apart(fast(system, "CP", effects), found)
    assert left < tolerance
    moved = apart(found, base)
    assert left < 0.5 * moved or (moved < 1e-9 and system == "act" and case == "pulley")


def test_dead_zone_of_the_actuation_line_orders_by_location():
    # after a pull to 20 N the input falls to 20 exp(-2 theta) before the output moves: the stretch given up by hand is
    # C (b + m) 20 (1 - exp(-2 theta)), the bend's own part m between none and its whole length
    path = np.concatenate([np.linspace(1, 20, 4000), np.linspace(20, 20 * np.exp(-2 * THETA), 4000)])
    zone = {}
    for location, before in (("NP", 0.075), ("CP", 0.375), ("ND", 0.675)):
        x = fast("act", location, {}, path)
        zone[location] = x[3999] - x[-1]
        whole = 0.25 * 20 * (1 - np.exp(-2 * THETA))
        assert before * whole < zone[location] < (before + 0.25) * whole
    assert zone["NP"] < zone["CP"] < zone["ND"]


def test_a_straight_tube_is_one_spring():
    drive = drive_of("sstl", "CP", DT, PATH, Mechanics())
    active = activate(AS_BUILT)
    x = predict_position(drive, 0.0, active, predict(drive, 0.0, active, 5.0))
    assert x == pytest.approx(PATH * (2 * 0.25 + 0.125))


def test_friction_where_the_line_is_driven_is_lost_before_the_first_stretch():
    # a straight tube without other friction has the output's tension all along
    drive = drive_of("act", "CP", DT, PATH, Mechanics())
    active = activate({**AS_BUILT, "const_friction": {"w_in_n": 0.5}})
    out = predict(drive, 0.0, active, 5.0)
    assert np.max(np.abs(out - PATH)) > 0.4
    assert predict_position(drive, 0.0, active, out) == pytest.approx(out * (0.25 + 0.125), abs=1e-6)
