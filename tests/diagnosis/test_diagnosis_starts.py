"""Where fits begin, against dense linear algebra on the small made records."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, gained, made, named, noise, simulator, thetas

from sstl_cli.diagnosis import starts as of
from sstl_cli.diagnosis.constants import SHAPE_GRID, STRENGTHS, WIDTHS
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.starts import by_gain, grid, screen, speeds, widths
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.effect import TRANSITION

SIM = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
ZERO = full("zero_offset", ("act",))
FRICTION, GAIN = (variants(e, ("act",))[0] for e in ("const_friction", "gain_error"))


OUT = named("zero_offset", "z_out_act_n")


def test_starts_of_strengths_and_shapes():
    assert [v.tolist() for v in grid(FRICTION.free)] == [[pytest.approx(0.5 * STRENGTHS[-1])]]
    # an offset is linear: from nothing; a factor from three places
    assert [v.tolist() for v in grid(ZERO.free)] == [[0.0, 0.0]]
    assert [float(v[0]) for v in grid(GAIN.free)] == pytest.approx([1.0, 0.3, 3.0])
    assert [float(v[0]) for v in grid(named("saturation", "t_max_out_n").free)] == pytest.approx([1000.0, 300.0, 3000.0])
    free = named("viscoelastic_creep", "fraction", "tau_s", "load_mm_per_n").free
    starts = grid(free)
    assert free[0].effect.stage == TRANSITION and len(starts) == 2 * 3
    assert [v.tolist() for v in starts] == [pytest.approx([0.3 * s, 100.0**g, 0.125]) for s, g in itertools.product(STRENGTHS, SHAPE_GRID)]
    # over less than twenty times the shape's grid is linear; a strength that may be of either sign begins a little off nothing beside it
    (spread,) = {tuple(v[1] for v in grid(variants("presliding", ("act",))[0].free))[:3]}
    assert spread == pytest.approx((0.15, 0.5, 0.85))
    # a shape that says where to begin begins there
    assert {float(v[1]) for v in grid(variants("presliding", ("act",))[2].free)} == {0.5}
    drift = named("friction_drift", "d_mu", "path_n", "load_mm_per_n")
    assert [float(v[0]) for v in grid(drift.free)] == pytest.approx([STRENGTHS[0] * 0.6] * 3)


def test_screening_gains_what_the_linear_model_gains():
    z = made(noise(1) + 0.03)
    sim = replace(SIM)
    sim.y = z.prediction + z.residual
    gain, start = screen(sim, z, OUT)
    column = z.whiten(sim.predict(THETA, {"zero_offset": {"z_in_act_n": 0.0, "z_out_act_n": 0.01}}) - z.prediction)
    nothing = np.zeros((len(SIM.y), 0))
    assert gain == pytest.approx(gained(np.column_stack((thetas(z), column)), nothing, z.whiten(z.residual)), rel=1e-3)
    # what a sensor adds begins where the step leads, and what lies in the line beside nothing
    assert start == pytest.approx([0.03], abs=0.005) and screen(sim, z, FRICTION)[1] == pytest.approx(grid(FRICTION.free)[0])
    # of several parameters at once
    drift = full("zero_drift", ("act",))
    both = screen(sim, z, drift)[0]
    columns = [
        sim.predict(THETA, {"zero_drift": {"r_in_act_n": 0.0, "r_out_act_n": 0.0, k: 0.004}}) - z.prediction
        for k in ("r_in_act_n", "r_out_act_n")
    ]
    assert both == pytest.approx(
        gained(np.column_stack((thetas(z), z.whiten(np.stack(columns, axis=1)))), nothing, z.whiten(z.residual)), rel=0.01
    )


def test_screening_stays_inside_what_an_effect_can_be():
    # friction that gives something back is none: nothing can be gained by it, beside what theta gains
    z = made()
    response = SIM.predict(THETA, {"const_friction": {"w_l_n": 0.05}}) - z.prediction
    sim = replace(SIM)
    gains = []
    for sign in (1.0, -1.0):
        sim.y = z.prediction + sign * response
        left = replace(z, residual=sign * response, cost=0.5 * float(np.sum(z.whiten(response) ** 2)) + 0.5 * z.whiten.log_det)
        gains.append(screen(sim, left, FRICTION)[0])
    assert gains[0] > 1.5 * gains[1]
    step = of._inside(np.array([5.0, -1.0]), np.array([0.2]), FRICTION.free, 1)
    assert step.tolist() == [5.0, -0.2] and of._inside(np.array([0.0, 9.0]), np.array([0.2]), FRICTION.free, 1)[1] == pytest.approx(4.8)


def test_every_hypothesis_with_a_strength_is_started_and_variants_each():
    # all sensors at once, from which single ones follow, and every other law
    started = of.starting("zero_offset", ("act",))
    assert [[f.parameter.name for f in h.free] for h in started] == [
        ["z_in_act_n", "z_out_act_n"],
        ["preload_in_act_n"],
        ["preload_out_act_n"],
        ["preload_in_act_n", "straight_in_act_n"],
        ["preload_out_act_n", "straight_out_act_n"],
    ]
    assert [[f.parameter.name for f in h.free] for h in of.starting("friction_drift", ("act",))] == [
        ["d_mu", "path_n", "load_mm_per_n"],
        ["d_mu_time", "time_s", "load_mm_per_n"],
        ["d_mu_heat_s_per_n2", "cooling_s", "load_mm_per_n"],
    ]


def test_plays_are_tried_from_the_noise_to_half_of_what_the_output_spans():
    ends = made(0.0, named("const_friction", "w_in_n", "w_end_n"), (0.01, 0.02))
    tried = np.array(widths(SIM, NOISE, ends))
    half = 0.5 * np.ptp(SIM.y)
    # one at a time, the other as it was
    assert tried[:WIDTHS, 1].tolist() == [0.02] * WIDTHS and tried[WIDTHS:, 0].tolist() == [0.01] * WIDTHS
    most = [x.parameter.most for x in ends.free]
    assert tried[:WIDTHS, 0] == pytest.approx(np.minimum(np.geomspace(NOISE_N, half, WIDTHS), most[0]))
    assert tried[WIDTHS:, 1] == pytest.approx(np.minimum(np.geomspace(NOISE_N, half, WIDTHS), most[1]))
    assert widths(SIM, NOISE, made(0.0, OUT, (0.1,))) == []


def test_a_mean_over_jumps_begins_a_little_off_nothing_at_each_speed():
    mean = made(0.0, named("stick_slip", "mean_ratio", "mean_mm_s"), (1.0, 1.0))
    spans = [0.1 * 100.0**g for g in SHAPE_GRID]
    assert [v.tolist() for v in speeds(mean)] == [pytest.approx([1.0 + 0.5 * s, v]) for v, s in itertools.product(spans, STRENGTHS)]
    assert speeds(made(0.0, FRICTION, (0.1,))) == []


def test_a_gain_is_read_off_at_each_theta_and_theta_goes_with_it():
    """A sensor of an eighth of its gain on bends that hardly rub: a base puts that down to friction."""
    truth = np.array([0.6, 0.03]) * 0.53
    sim = replace(SIM)
    sim.y = 0.12 * SIM.predict(truth, {})
    theta, gains = by_gain(sim, GAIN)
    assert gains == pytest.approx([0.12], rel=0.2) and theta == pytest.approx(truth)
    # nor is it taken for more than a gain can be
    sim.y = 1e3 * SIM.predict(truth, {})
    assert by_gain(sim, GAIN)[1].tolist() == [GAIN.free[0].parameter.most]
    assert by_gain(sim, ZERO) is None
