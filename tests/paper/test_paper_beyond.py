"""Beyond the paper: reversal regions, presliding from small loops, several tendons, a joint that bends."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.control import references
from sstl_cli.control.controller import IDENTITY, Controller, Options, Theta
from sstl_cli.control.plant import Plant, TensionLoop, track
from sstl_cli.core.errors import SstlError
from sstl_cli.paper import distal, lag_and_presliding, probe, reversal, tendons
from sstl_cli.paper.probe import FULL, ONE, SHORT, TWO, Probe
from sstl_cli.paper.rig import GAP, LAG_S, TABLE_II, Bend, recorded
from sstl_cli.physics.scenario import Scenario

LINES = Theta(0.58, -1.44, 1.69, -1.04)


def test_reversal_regions_by_hand():
    reference = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 2.5, 1.5, 0.9, 0.5, 1.0, 3.0])
    # turns after samples 4 (a flat top ends there) and 8; 2 N further on the region is over
    assert reversal.near(reference).nonzero()[0].tolist() == [4, 5, 6, 8, 9]
    output = reference + np.where(reversal.near(reference), 0.4, 0.1)
    output[6] = reference[6] - 1.0
    found = reversal.apart(reference, output)
    assert found.peak_n == pytest.approx(1.0) and found.elsewhere_n == pytest.approx(0.1)
    assert found.reversal_n == pytest.approx(math.sqrt((4 * 0.16 + 1.0) / 5))
    assert np.isnan(reversal.apart(np.arange(5.0), np.arange(5.0)).reversal_n)


def test_small_loops_turn_ever_earlier():
    time, tension = lag_and_presliding.small_loops()
    assert (tension.min(), tension.max()) == (1.0, pytest.approx(30.0, abs=0.02)) and time[-1] == pytest.approx(125 / 6, abs=1.0)
    assert np.abs(np.diff(tension)).max() == pytest.approx(6.0 * 0.002)


def test_presliding_is_found_from_small_loops_of_the_rig():
    """The rig breaks away at 0.17 mm with a spread of 0.5; its friction at low speed, which no simulator here has, adds to both."""
    runs = [recorded(Bend(place, place, 0.55), "act", *lag_and_presliding.small_loops(), 3) for place in ("NP", "CP", "ND")]
    found = lag_and_presliding.fit_effects(Scenario(effects=TABLE_II), runs, lag_and_presliding.PRESLIDING)
    assert found.values["presliding", "breakaway_mm"] == pytest.approx(GAP["presliding"]["breakaway_mm"], rel=0.15)
    assert found.values["presliding", "spread"] == pytest.approx(0.5, abs=0.15)
    assert found.rms_n < 0.1 and found.scenario.effects["zero_offset"] == TABLE_II["zero_offset"]


def test_the_lag_is_that_of_the_loop_at_hand():
    for lag_s in (0.3, 0.1):
        found = lag_and_presliding.loop_of(Bend("x", "CP", 0.55), 1, lag_s)
        assert found.tau_s == pytest.approx(lag_s, abs=5 * found.error_s)


def test_tendons_side_by_side_are_driven_as_one_alone(monkeypatch):
    """Without cross-talk and noise, each tendon does what the compiled loop of one tendon does."""
    monkeypatch.setattr(tendons, "NOISE_N", 0.0)
    reference = references.random(np.random.default_rng(0), tendons.TRACKING_DT_S, 60.0)
    options = Options(dt_s=tendons.TRACKING_DT_S, lead_s=LAG_S, reversal="play")
    pair = {t: Controller(LINES, options) for t in ("A", "B")}
    made = tendons.together(pair, dict.fromkeys(pair, reference), dict.fromkeys(pair, 0.0), 1)
    quiet = track(Controller(LINES, options), Plant(lambda t, dt: t, TensionLoop(LAG_S)), reference.tension_n).tension_in
    assert made["A"] == pytest.approx(quiet, abs=1e-9) and made["B"] == pytest.approx(quiet, abs=1e-9)


def test_slopes_follow_the_neighbours():
    reference = references.random(np.random.default_rng(0), tendons.TRACKING_DT_S, 60.0)
    pair = {
        "A": Controller(LINES, Options(dt_s=tendons.TRACKING_DT_S)),
        "B": Controller(IDENTITY, Options(dt_s=tendons.TRACKING_DT_S), False),
    }
    tendons.together(pair, dict.fromkeys(pair, reference), {"A": 0.001, "B": 0.0}, 1)
    gp, gr = pair["A"].vector[0], pair["A"].vector[2]
    wider = math.log(gr / LINES.gamma_r)
    assert wider == pytest.approx(math.log(LINES.gamma_p / gp)) and 0.004 < wider < 0.031
    assert pair["B"].vector[:4].tolist() == [1.0, 0.0, 1.0, 0.0]


def test_cross_talk_is_found_beside_a_neighbour_that_holds():
    assert tendons.opening(Theta(math.exp(-0.5), 0.0, math.exp(0.5), 0.0)) == pytest.approx(0.5)
    found = tendons.learn(1, 0.002, each=1)
    assert found.crosstalk_per_n == pytest.approx(0.002, rel=0.05) and found.lag_s == pytest.approx(LAG_S, abs=1e-3)


def test_the_joint_by_hand():
    a = 0.01
    # T_2 = 20 N: 20 exp(0.2) = 24.428 N before the joint while pulling, 16.375 N while releasing
    up, down = 20.0 * math.exp(0.2), 20.0 * math.exp(-0.2)
    assert distal.joint(np.array([1.0, up, down, down - 1.0]), a)[1:3] == pytest.approx([20.0, 20.0])
    assert distal.joint(np.array([1.0, up, down, down - 1.0]), a)[3] < 20.0
    assert distal.joint(np.array([3.0, -1.0]), 0.0).tolist() == [3.0, -1.0]


def test_a_reference_taken_backwards_through_the_joint_leaves_it_as_it_was():
    reference = references.random(np.random.default_rng(4), distal.TRACKING_DT_S, 60.0)
    falling = replace(reference, tension_n=reference.tension_n[::-1])
    for one in (reference, falling, references.trapezoid(0.01)):
        entering = distal.before_joint(one, 0.005)
        out = distal.joint(np.concatenate([[0.0], entering.tension_n]), 0.005)[1:]
        turned = one.tension_n[0] > one.tension_n[1]
        # a reference that begins by falling has to be reached from above once
        part = slice(int(turned), None)
        assert out[part] == pytest.approx(one.tension_n[part], abs=1e-9) or turned


def test_the_joint_is_found_from_one_movement_held_and_free():
    assert distal.identify(Bend("CP-x", "CP", 0.55), 2, 0.004) == pytest.approx(0.004, rel=0.02)


def test_curves_and_shortest_probes_are_told_by_rig_and_calibration():
    made = [
        Probe(FULL, 12.0, 80.0, 0.010, 0.02, 0.20),
        Probe(SHORT, 0.5, 24.0, 0.0105, None, 0.23),
        Probe(FULL, 12.0, 80.0, 0.020, 0.02, 0.20, "with drag", TWO),
        Probe(FULL, 1.0, 80.0, 0.021, 0.02, 0.21, "with drag", TWO),
    ]
    apart = probe.curves(made)
    assert list(apart) == [("rig", ONE), ("with drag", TWO)]
    assert probe.shortest(apart["rig", ONE], "lines_error").time_s == 0.5
    assert probe.shortest(apart["rig", ONE], "tracking_n").time_s == 12.0
    assert probe.shortest(apart["with drag", TWO], "tracking_n").time_s == 1.0
    with pytest.raises(SstlError, match="E802"):
        probe._must(None)
