"""Propagation lines of the fast model against closed forms: composition, the fingerprint table, curved laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.transmission import activate, play_operator, predict
from sstl_cli.physics.transmission.model import drive_of, observed_output, true_input

DT, THETA = 0.01, 0.53
TIME = np.arange(9000) * DT
# the first ramp leaves the start behind; in both systems the last two reach pulling and releasing
PATH = np.interp(TIME, [0, 10, 50, 90], [40, 0.2, 40, 0.2])
W, TAU, C, RATE = 0.4, 0.1, 0.05, 39.8 / 40
GP, GR = {n: np.exp(-n * THETA) for n in (1, 2)}, {n: np.exp(n * THETA) for n in (1, 2)}
# whole sheath bent, so that friction per length is friction per angle, as the closed forms have it
BENT = Mechanics(arc_fraction=1.0, bend_centres={"CP": 0.5})


def lines(effects, system, seen_input=False):
    """Least-squares propagation lines: slope and bias of pulling, then of releasing."""
    n = 2 if system == "sstl" else 1
    active = activate(effects)
    path = true_input(system, DT, PATH, PATH, active) if seen_input else PATH
    true = predict(drive_of(system, "CP", DT, path, BENT), THETA, active, 0.5)
    out = observed_output(system, DT, PATH, true, active)
    # well inside both phases, where no law of the table has a kink
    pull = (TIME > 25) & (TIME < 49)
    release = (TIME > 51) & (0.8 * 40 * GP[n] / GR[n] > PATH) & (TIME < 89) & (PATH > 1.0)
    gp, bp = np.polyfit(PATH[pull], out[pull], 1)
    gr, br = np.polyfit(PATH[release], out[release], 1)
    return np.log(gp), np.log(gr), bp, br


def shift(effects, system, seen_input=False):
    return np.subtract(lines(effects, system, seen_input), lines({}, system))


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_slopes_without_effects(system, n):
    assert lines({}, system) == pytest.approx((-n * THETA, n * THETA, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_fingerprint_table(system, n):
    gp, gr = GP[n], GR[n]
    h = W / THETA
    z, g = 0.3, 1.06
    table = {
        "const_friction": ({"w_l_n": W}, (0, 0, -h * (1 - gp), h * (gr - 1))),
        "const_friction, bend": ({"w_bend_n": W}, (0, 0, -W * (1 - gp), W * (gr - 1))),
        "const_friction, begin": ({"w_in_n": W}, (0, 0, -W * gp, W * gr)),
        "const_friction, end": ({"w_end_n": W}, (0, 0, -W, W)),
        "gain_error": ({f"g_{system}": g}, (np.log(g), np.log(g), 0, 0)),
        "asymmetric_friction": ({"a": 0.1}, (-n * THETA * 0.1, -n * THETA * 0.1, 0, 0)),
    }
    for effect_id, (values, expected) in table.items():
        assert shift({effect_id.partition(",")[0]: values}, system) == pytest.approx(expected, abs=2e-3), effect_id
    out = shift({"zero_offset": {f"z_out_{system}_n": z}}, system)
    assert out == pytest.approx((0, 0, z, z), abs=2e-3)
    seen = shift({"zero_offset": {f"z_in_{system}_n": z}}, system, seen_input=True)
    assert seen == pytest.approx((0, 0, -gp * z, -gr * z), abs=2e-3)
    # the output moves at Gamma times the rate of the input, up while pulling and down while releasing
    late = shift({"channel_delay": {f"tau_{system}_s": TAU}}, system)
    assert late == pytest.approx((0, 0, -gp * RATE * TAU, gr * RATE * TAU), abs=2e-3)
    slow = shift({"channel_lowpass": {f"tau_{system}_s": TAU}}, system)
    assert slow == pytest.approx(late, abs=2e-3)


def test_fingerprint_of_the_pulley():
    m, f0 = 0.1, 0.5
    both = shift({"pulley_friction": {"m_p": m, "m_r": m}}, "sstl")
    assert both == pytest.approx((-m, m, 0, 0), abs=2e-3)
    constant = shift({"pulley_friction": {"f0_n": f0}}, "sstl")
    assert constant == pytest.approx((0, 0, -np.exp(-THETA) * f0, np.exp(THETA) * f0), abs=2e-3)
    assert shift({"pulley_friction": {"m_p": m, "m_r": m, "f0_n": f0}}, "act") == pytest.approx((0, 0, 0, 0), abs=1e-12)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_drag_opens_both_lines_and_grows_with_the_rate(system):
    mild, strong = (shift({"viscous": {"c_l_n_s_per_mm": c}}, system) for c in (0.5 * C, C))
    for d in (mild, strong):
        assert d[2] < 0.0 < d[3]
        assert abs(d[0]) < 0.01 and abs(d[1]) < 0.02
    assert strong[2:] == pytest.approx(2.0 * mild[2:], rel=0.15)


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_drag_at_the_end_takes_the_speed_of_the_load(system, n):
    # the end moves with the load spring: du/dt = (dT/dt) / k
    c, k = 0.5, BENT.load_n_per_mm
    drag = n * c * RATE / k
    assert shift({"viscous": {"c_end_n_s_per_mm": c}}, system) == pytest.approx((0, 0, -drag * GP[n], drag * GR[n]), abs=3e-3)
    # a seal there is met once, whatever the passes
    assert shift({"viscous": {"c_seal_n_s_per_mm": n * c}}, system) == pytest.approx((0, 0, -drag * GP[n], drag * GR[n]), abs=3e-3)


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_curved_laws_follow_their_differential_equation(system, n):
    rise = np.linspace(5, 40, 4000)
    drive = drive_of(system, "CP", DT, rise, Mechanics())
    alpha, c = 0.2, 0.01
    load = predict(drive, THETA, activate({"load_dependent_friction": {"alpha": alpha}}), 5.0)
    assert load[-1] == pytest.approx(10.0 * (4.0**alpha - alpha * n * THETA) ** (1 / alpha), rel=1e-4)
    sheath = predict(drive, THETA, activate({"sheath_compliance": {"c_t_per_n": c}}), 5.0)
    assert sheath[-1] == pytest.approx(1.0 / ((1.0 / 40.0 + c) * np.exp(n * THETA) - c), rel=1e-4)


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_friction_that_steps_has_its_own_angle_on_either_side(system, n):
    law, rise = {"load_dependent_friction": {"step": 0.2, "step_n": 8.0}}, np.linspace(0.5, 60, 4000)
    drive = drive_of(system, "CP", DT, rise, Mechanics())
    out = predict(drive, 0.3, activate(law), 0.2)
    # far below the step and far above it, where both ends of the line are on the same side
    low, high = (rise > 2.0) & (rise < 4.0), out > 20.0
    for part, angle in ((low, 1.2), (high, 0.8)):
        assert np.polyfit(rise[part], np.log(out[part] / rise[part]), 1) == pytest.approx((0.0, -0.3 * n * angle), abs=2e-3)


@pytest.mark.parametrize(("system", "n"), [("act", 1), ("sstl", 2)])
def test_friction_that_falls_with_load_is_that_of_a_tube_that_straightens(system, n):
    """Both are a factor of the local tension: 1 + c (1 - exp(-q T)) / q is 1 + c / q times 1 + f exp(-q T), f = -c / (q + c)."""
    c, q, path = -0.03, 0.15, 14.0 + 12.0 * np.sin(np.linspace(0, 12, 900))
    drive = drive_of(system, "CP", DT, path, Mechanics())
    tube = predict(drive, THETA, activate({"sheath_compliance": {"c_t_per_n": c, "closing_per_n": q}}), 6.0)
    load = {"load_dependent_friction": {"fall": -c / (q + c), "fall_n": 1.0 / q}}
    assert predict(drive, THETA * (1.0 + c / q), activate(load), 6.0) == pytest.approx(tube, abs=1e-6)


def test_what_presses_without_tension_is_as_four_equal_zeros():
    theta, path = 0.5, 12.0 + 10.0 * np.sin(np.linspace(0, 12, 900))
    pressed = predict(drive_of("sstl", "CP", DT, path, Mechanics()), theta, activate({"const_friction": {"w_bend_n": W}}), 6.0)
    offset = predict(drive_of("sstl", "CP", DT, path + W, Mechanics()), theta, activate({}), 6.0 + W) - W
    assert pressed == pytest.approx(offset, abs=1e-9)


def test_bristles_of_one_stiffness_break_away_later_at_higher_tension():
    """What friction builds up over the first way back is the same at all tensions, in proportion to the tension otherwise."""
    held = {}
    for law in ("breakaway_mm", "bristle_mm"):
        for tension in (5.0, 20.0):
            path = np.concatenate((np.linspace(1.0, tension, 400), np.linspace(tension, tension - 0.02, 20)))
            effects = activate({"presliding": {law: 1.0, "spread": 0.0}})
            out = predict(drive_of("act", "CP", DT, path, Mechanics()), 0.5, effects, 1.0)
            held[law, tension] = (out[399] - out[-1]) / 0.02
    # stiffer contacts hold back more of a small step: by their tension, or alike
    assert held["breakaway_mm", 20.0] < 0.8 * held["breakaway_mm", 5.0]
    assert held["bristle_mm", 20.0] == pytest.approx(held["bristle_mm", 5.0], rel=0.05)


def test_drag_that_thins_grows_with_its_power_of_the_speed():
    def opened(rate):
        path = np.concatenate((np.linspace(2, 30, round(28 / rate / DT)), np.linspace(30, 2, round(28 / rate / DT))))
        drive = drive_of("act", "CP", DT, path, Mechanics())
        drag, free = (predict(drive, 0.3, activate({"viscous": v}), 1.0) for v in ({"c_l_n_s_per_mm": 0.05, "power": 0.5}, {}))
        return float(np.mean((free - drag)[len(path) // 4 : len(path) // 3]))

    assert opened(40.0) / opened(10.0) == pytest.approx(2.0, rel=0.1)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 50.0), min_size=2, max_size=60), st.floats(0.05, 1.0), st.floats(0.05, 1.0))
def test_two_passes_are_one_play_with_both_angles(path, a, b):
    path = np.array(path)
    first = play_operator(path, np.exp(-a), 0.0, np.exp(a), 0.0, path[0])
    second = play_operator(first, np.exp(-b), 0.0, np.exp(b), 0.0, first[0])
    start = play_operator(first[:1], np.exp(-b), 0.0, np.exp(b), 0.0, first[0])[0]
    whole = play_operator(path, np.exp(-a - b), 0.0, np.exp(a + b), 0.0, start)
    assert np.allclose(second, whole, rtol=1e-9, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 50.0), min_size=2, max_size=60), st.lists(st.floats(0.0, 5.0), min_size=60, max_size=60))
def test_more_input_never_gives_less_output(path, more):
    low = np.array(path)
    high = low + np.array(more[: len(low)])
    args = (0.6, -0.2, 1.7, 0.3, 4.0)
    assert np.all(play_operator(high, *args) >= play_operator(low, *args))
