"""Limits, defaults and small parts of the simulators, worked by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from sstl_cli.physics.effect import Drive, Mechanics
from sstl_cli.physics.filters import delayed, first_order, low_pass, play, second_low_pass
from sstl_cli.physics.noise import NoiseModel, sensor_noise
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, parameters, resolve_effects
from sstl_cli.physics.rig.chain import Load, TensionLaw, friction_limit, load_tension
from sstl_cli.physics.rig.drive import Motor, loop_commit, loop_line
from sstl_cli.physics.rig.effect import Parts
from sstl_cli.physics.rig.effects.channel_lowpass import first_order as rig_first_order
from sstl_cli.physics.rig.effects.quantisation import rounded
from sstl_cli.physics.rig.effects.sensor_nonlinearity import sensor_play
from sstl_cli.physics.rig.effects.tension_loop_lag import shape_command
from sstl_cli.physics.rig.sensors import coloured
from sstl_cli.physics.rig.simulate import build
from sstl_cli.physics.rig.spec import bend_weights
from sstl_cli.physics.scenario import Lines, Trajectory
from sstl_cli.physics.trajectories import position_driven, probe, times
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of, knots
from sstl_cli.physics.transmission.play import bounded_play, play_operator

GOLDEN = Path(__file__).with_name("test_physics_values.csv")
TIME = np.linspace(0.0, 1.0, 11)


def test_the_rig_has_the_ranges_of_the_catalogue() -> None:
    golden = {
        tuple(k.split(".")): v.split(",") for k, v in (line.split(",", 1) for line in GOLDEN.read_text(encoding="utf-8").splitlines())
    }
    for (effect, name), (neutral, low, high, *_) in golden.items():
        b = parameters()[effect][name]
        assert (b.neutral, b.low, b.high) == (float(neutral), float(low), float(high)), (effect, name)
    sheath = parameters()["sheath_compliance"]["c_t_per_n"]
    assert (sheath.neutral, sheath.low, sheath.high) == (0.0, 0.0, 0.01)
    assert resolve_effects({"slack": {"gap_mm": 5.0}})["slack"]["gap_mm"] == 5.0
    assert resolve_effects({})["gain_error"] == {"g_act": 1.0, "g_sstl": 1.0}
    for wrong in (-0.01, 5.01, math.inf):
        with pytest.raises(ValueError, match="outside"):
            resolve_effects({"slack": {"gap_mm": wrong}})


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        ("length_mm", 1e-3, 0.0), ("ea_n", 1e-3, 0.0), ("load_k1_n_per_mm", 1e-3, -1.0), ("stick_breakaway_mm", 1e-9, 0.0), ("friction_memory_s", 1e-9, 0.0),
        ("weakening_mm", 1e-9, 0.0), ("healing_mm", 1e-9, 0.0), ("tolerance_n", 1e-12, 0.0), ("pretension_n", 0.0, -1e-9), ("pid_kp_mm_per_n", 0.0, -1.0),
        ("pid_ki_mm_per_n_s", 0.0, -1.0), ("pid_kd_mm_s_per_n", 0.0, -1.0), ("motor_lag_s", 0.0, math.inf), ("length_mm", 0.5, math.nan), ("nodes", 4, 3), ("nodes", 400, 401),
        ("bend_arc_fraction", 1.0, 1.01), ("bend_arc_fraction", 0.01, 0.0), ("max_substeps", 1, 0), ("max_iterations", 5, 4), ("bend_centres", {"A": 0.0, "B": 1.0}, {"A": 1.01}),
        ("bend_centres", {"A": 0.5}, {"A": -0.01}),
    ],
)  # fmt: skip
def test_what_can_be_built(kind: str, good: object, bad: object) -> None:
    assert getattr(RigSpec(**{kind: good}), kind) == good  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=kind):
        RigSpec(**{kind: bad})  # type: ignore[arg-type]


def test_defaults_of_the_rig() -> None:
    s = RigSpec()
    assert (s.length_mm, s.ea_n, s.nodes, s.bend_arc_fraction, s.load_k1_n_per_mm, s.pretension_n) == (2000.0, 8000.0, 30, 0.25, 8.0, 5.0)
    assert (s.stick_breakaway_mm, s.friction_memory_s, s.weakening_mm, s.healing_mm) == (1e-4, 0.005, 0.02, 0.5)
    assert (s.pid_kp_mm_per_n, s.pid_ki_mm_per_n_s, s.pid_kd_mm_s_per_n, s.motor_lag_s) == (0.05, 4.0, 0.0, 0.02)
    assert (s.max_substeps, s.max_iterations, s.tolerance_n, s.bend_centres) == (64, 120, 1e-8, {"NP": 0.2, "CP": 0.5, "ND": 0.8})
    n = NoiseSpec()
    assert (n.white_n, n.coloured_n, n.correlation_s, n.position_mm) == (0.02, 0.0, 0.3, 0.0)


def run(**more: object) -> RigRun:
    return RigRun(**({"system": "act", "theta": 0.5, "location": None, "time_s": TIME, "drive": "tension", "command": TIME + 5} | more))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("theta", 3.01), ("theta", -0.01), ("time_s", np.zeros(11)), ("time_s", TIME.reshape(1, 11)), ("command", TIME.reshape(11, 1)), ("neighbour_n", np.ones(10)),
        ("neighbour_n", np.full(11, np.nan)),
    ],
)  # fmt: skip
def test_what_can_be_run(field: str, bad: object) -> None:
    with pytest.raises(ValueError, match=field):
        run(**{field: bad})
    assert run(theta=3.0).theta == 3.0 and run(theta=0.0).theta == 0.0
    assert run(time_s=[0.0, 1.0], command=[1, 2], neighbour_n=[3, 4]).neighbour_n.tolist() == [3.0, 4.0]  # type: ignore[union-attr]
    with pytest.raises(ValueError, match="two samples"):
        run(time_s=[0.0], command=[1.0])
    for name in ("white_n", "coloured_n", "position_mm"):
        with pytest.raises(ValueError, match=name):
            NoiseSpec(**{name: -1e-9})
    for wrong in (0.0, math.inf):
        with pytest.raises(ValueError, match="correlation_s"):
            NoiseSpec(correlation_s=wrong)


def built(spec: RigSpec, given: RigRun, effects: dict[str, dict[str, float]]) -> Parts:
    return build(spec, given, resolve_effects(effects))


def test_bend_weights() -> None:
    spec = RigSpec(nodes=10, bend_arc_fraction=0.3, bend_centres={"NP": 0.1, "CP": 0.5, "ND": 0.8, "end": 0.95})
    # 0.65 to 0.95 of the pass: half a node, two nodes, half a node
    assert bend_weights(spec, "act", "ND") == pytest.approx([0] * 6 + [1 / 6, 1 / 3, 1 / 3, 1 / 6])
    # a bend that would hang over the end is shifted inwards
    assert bend_weights(spec, "act", "NP") == pytest.approx([1 / 3] * 3 + [0] * 7)
    assert bend_weights(spec, "act", "end") == pytest.approx([0] * 7 + [1 / 3] * 3)
    assert bend_weights(spec, "sstl", "NP") == pytest.approx([1 / 3] * 3 + [0] * 15 + [1 / 3] * 3)
    assert bend_weights(spec, "act", None) == pytest.approx(bend_weights(spec, "act", "CP"))


def test_chain_and_contacts_as_built() -> None:
    spec = RigSpec(nodes=4, length_mm=1000.0, ea_n=5000.0, pretension_n=2.0)
    effects = {"viscous": {"c_l_n_s_per_mm": 0.04}, "presliding": {"breakaway_mm": 0.2, "spread": 0.5}, "const_friction": {"w_l_n": 0.4},
               "pulley_friction": {"m_p": 0.1, "m_r": 0.2, "f0_n": 1.0}, "load_spring": {"play_mm": 1.0}}  # fmt: skip
    one = built(spec, run(), effects)
    assert (one.load.k1, one.load.y0, one.load.half_play, one.load.play_width) == (8.0, 0.25, 0.5, 2e-3)
    chain = one.chain
    assert chain.compliance == pytest.approx(np.array([125, 250, 250, 250, 125]) / 5000.0)
    assert chain.u.tolist() == [0, 0, 0, 0, 0.25] and chain.drag == pytest.approx([0.01] * 4) and chain.tension == pytest.approx([2.0] * 5)
    golden = (math.sqrt(5) - 1) / 2
    assert chain.breakaway == pytest.approx([1e-4 + 0.2 * (1 + 0.5 * (2 * ((k + 0.5) * golden % 1.0) - 1)) for k in range(4)])
    loop = built(spec, run(system="sstl"), effects)
    both, contact = loop.chain, loop.contact
    assert both.compliance == pytest.approx(np.array([125, 250, 250, 250, 125, 125, 250, 250, 250, 125]) / 5000.0)
    assert both.breakaway[4] == 1e-4 and both.drag[4] == 0.0 and both.drag[5] == pytest.approx(0.01)
    assert contact.weight_n == pytest.approx([0.1] * 4 + [0.0] + [0.1] * 4) and contact.fixed[4] == 1
    # straight nodes never change either
    assert contact.fixed.tolist() == [1, 0, 0, 1, 1, 1, 0, 0, 1]
    # across the pulley T exp(-m) - f0 comes out of T: with the limit slope * mean + bias
    for t_in, m, sign, slope, bias in (
        (10.0, 0.1, -1, both.slope_pull[4], both.bias_pull[4]),
        (10.0, 0.2, 1, both.slope_release[4], both.bias_release[4]),
    ):
        t_out = t_in * math.exp(sign * m) + sign * 1.0
        assert sign * (t_out - t_in) == pytest.approx(slope * 0.5 * (t_in + t_out) + bias)


def test_a_stiffening_load_rests_at_the_pretension() -> None:
    stiff = built(RigSpec(), run(), {"load_spring": {"k3_per_mm2": 0.1}}).load
    assert load_tension(stiff, stiff.y0)[0] == pytest.approx(5.0, abs=1e-9) and stiff.k3 == 0.1
    load_spring = Load(8.0, 0.0, k3=0.1)
    assert load_tension(load_spring, 2.0) == pytest.approx((8 * 2.8, 8 * 2.2))
    assert load_tension(load_spring, -2.0) == pytest.approx((-1.6e-5, 8e-6)) and load_tension(load_spring, 0.0) == (0.0, 8.0)


def test_friction_limits() -> None:
    assert friction_limit(TensionLaw(0.0, 0.0), 0.1, 0.3, 20.0) == pytest.approx((2.3, 0.1))
    assert friction_limit(TensionLaw(0.2, 0.0), 0.1, 0.3, -1.0) == (0.3, 0.0) == friction_limit(TensionLaw(0.0, 0.0), 0.1, 0.3, 0.0)
    for law in (TensionLaw(0.2, 0.0), TensionLaw(0.0, 0.01), TensionLaw(-0.1, 0.02)):
        for t in (0.02, 0.2, 10.0, 35.0):

            def limit(x: float, law: TensionLaw = law) -> float:
                return 0.1 * x * (max(x, 0.05) / 10.0) ** -law.alpha * (1 + law.c_t * x) + 0.3

            value, slope = friction_limit(law, 0.1, 0.3, t)
            assert value == pytest.approx(limit(t))
            assert slope == pytest.approx((limit(t * 1.0001) - limit(t * 0.9999)) / (2e-4 * t), rel=1e-5)


def test_settings_follow_the_effects() -> None:
    def flags(effects: dict[str, dict[str, float]], **more: object) -> tuple[bool, bool, bool]:
        s = built(RigSpec(), run(**more), effects).setting
        return s.varying, s.remembering, s.breakable

    assert flags({}) == (False, False, False)
    assert flags({"tendon_crosstalk": {"c_bend_per_n": 0.01}}, neighbour_n=TIME) == (True, False, False)
    assert flags({"friction_drift": {"d_mu": 0.1}}) == (True, False, False)
    assert flags({"stribeck": {"ratio": 1.1}}) == (True, True, False)
    assert flags({"stick_slip": {"ratio": 1.1}}) == flags({"dwell_aging": {"b": 0.01}}) == (True, True, True)


def test_neighbours_never_bend_a_tube_straight() -> None:
    bent = {"tendon_crosstalk": {"c_bend_per_n": -0.01}}
    beside = np.linspace(0.0, 110.0, 11)
    assert built(RigSpec(), run(neighbour_n=beside), bent).swell == pytest.approx(np.maximum(1 - 0.01 * beside, 0.05))
    assert built(RigSpec(), run(), bent).swell.size == 0 and built(RigSpec(), run(neighbour_n=beside), {}).swell.size == 0


def test_motor_and_command() -> None:
    t = np.array([0.0, 0.1, 0.3])
    step = np.array([0.0, 10.0, 10.0])
    assert shape_command(t, step, 0.0, 0.0).tolist() == step.tolist()
    assert shape_command(t, step, 0.2, 0.0) == pytest.approx([0.0, 10 * (1 - math.exp(-0.5)), 10 * (1 - math.exp(-1.5))])
    assert shape_command(t, step, 0.0, 0.05) == pytest.approx([0.0, 2.0, 6.0])
    assert shape_command(t, -step, 0.0, 0.05) == pytest.approx([0.0, -2.0, -6.0])
    # x = a - g T solves x = x_old + share (PID - x_old) for every T
    motor, state = Motor(0.05, 4.0, 2e-4, 0.02), np.array([1.0, 0.3, 0.7])
    a, g = loop_line(motor, state, 12.0, 0.01)
    for tension in (3.0, 11.0):
        error = 12.0 - tension
        pid = 0.05 * error + 0.3 + 4.0 * 0.01 * error + 2e-4 * (error - 0.7) / 0.01
        assert a - g * tension == pytest.approx(1.0 + (1 - math.exp(-0.5)) * (pid - 1.0))
    assert loop_line(Motor(0.05, 4.0, 0.0, 0.0), state, 12.0, 0.01) == pytest.approx((0.09 * 12 + 0.3, 0.09))
    loop_commit(motor, state, 12.0, 9.0, 1.4, 0.01)
    assert state.tolist() == pytest.approx([1.4, 0.3 + 4.0 * 0.01 * 3.0, 3.0])


def test_filters_of_both_simulators() -> None:
    ramp = np.arange(50) * 0.2
    for response in (low_pass(ramp, 0.1, 0.3), rig_first_order(np.arange(50) * 0.1, ramp, 0.3)):
        # the exact answer to a ramp of 2 per second: late by tau, once the start has decayed
        t = np.arange(50) * 0.1
        assert response == pytest.approx(2.0 * (t - 0.3 * (1 - np.exp(-t / 0.3))))
    step = np.array([0.0, 10.0, 10.0, 10.0])
    assert first_order(step, 0.1, 0.2) == pytest.approx(10 * (1 - np.exp(-0.5 * np.arange(4))))
    assert first_order(step, 0.1, 0.0, 0.05).tolist() == pytest.approx([0.0, 2.0, 4.0, 6.0])
    assert first_order(-step, 0.1, 0.0, 0.05).tolist() == pytest.approx([0.0, -2.0, -4.0, -6.0])
    for same in (first_order(step, 0.1, 0.0), low_pass(step, 0.1, 0.0), delayed(step, 0.0), play(step, 0.0)):
        assert same is step
    assert delayed(np.array([1.0, 2.0, 4.0, 8.0]), 1.25).tolist() == pytest.approx([1.0, 1.0, 1.75, 3.5])
    assert delayed(np.array([1.0, 2.0, 4.0]), 1.0).tolist() == [1.0, 1.0, 2.0]
    path = np.array([5.0, 6.0, 9.0, 8.0, 4.0, 5.5])
    assert play(path, 1.0).tolist() == sensor_play(path, 1.0).tolist() == [5.0, 5.0, 8.0, 8.0, 5.0, 5.0]
    assert rounded(np.array([0.6, 3.3, 7.0]), 0.5).tolist() == [0.5, 3.5, 7.0]
    assert rounded(np.array([0.6, 7.0]), 0.0).tolist() == [0.6, 7.0]


@pytest.mark.parametrize("share", [1e-4, 0.1, 0.25, 0.26, 0.5])
@pytest.mark.parametrize("dt", [0.001, 0.05, 0.4])
def test_a_low_pass_of_second_order_is_exact_for_lines_between_samples(share: float, dt: float) -> None:
    tau, time = 0.06, np.arange(60) * dt
    signal = 3.0 + np.sin(5.0 * time) + np.abs(time % 1.0 - 0.5)
    exact = lsim(([1.0], [share * tau * tau, tau, 1.0]), signal - signal[0], time)[1] + signal[0]
    assert second_low_pass(signal, dt, tau, share) == pytest.approx(exact, abs=1e-9)


def test_a_low_pass_without_second_order_is_one_of_first() -> None:
    signal = np.array([0.0, 2.0, 1.0, 4.0])
    assert second_low_pass(signal, 0.1, 0.0, 0.3) is signal
    assert second_low_pass(signal, 0.1, 0.2, 0.0).tolist() == low_pass(signal, 0.1, 0.2).tolist()
    assert second_low_pass(signal, 0.1, 0.2, 1e-7) == pytest.approx(low_pass(signal, 0.1, 0.2), abs=1e-6)


def test_coloured_noise_by_its_recursion() -> None:
    white = np.array([1.0, 2.0, -1.0])
    d1, d2 = math.exp(-0.1 / 0.3), math.exp(-0.4 / 0.3)
    second = d1 + math.sqrt(1 - d1**2) * 2.0
    assert coloured(np.array([0.0, 0.1, 0.5]), white, 0.3) == pytest.approx([1.0, second, d2 * second - math.sqrt(1 - d2**2)])
    rng = np.random.default_rng(2)
    first, drive = rng.standard_normal(4), rng.standard_normal(4)
    start, phi = rng.standard_normal(), math.exp(-0.1 / 0.2)
    slow = [start]
    for v in drive[1:]:
        slow.append(phi * slow[-1] + math.sqrt(1 - phi**2) * v)
    assert sensor_noise(NoiseModel(0.5, 0.2, 0.2), 4, 0.1, np.random.default_rng(2)) == pytest.approx(0.5 * first + 0.2 * np.array(slow))
    assert NoiseModel() == NoiseModel(0.02, 0.0, 0.3)


def test_knots_follow_the_input_its_turns_and_both_ends() -> None:
    # half a minute at 200 Hz: a rise by 100 N within a second, a rest, a turn
    x = np.interp(np.arange(6000) * 0.005, [0.0, 10.0, 11.0, 20.0, 25.0, 30.0], [0.0, 0.0, 100.0, 100.0, 40.0, 100.0])
    at = knots(x, 0.005)
    gaps = np.diff(at)
    # no step of the input is larger than two of its two hundredths, none of the time longer than 20 ms
    assert np.abs(np.diff(x[at])).max() <= 1.0 + 1e-9 and gaps.max() <= 4 and np.all(gaps > 0)
    assert set(range(4998, 5009)) <= set(at) and at[0] == 0 and at[-1] == 5999
    rest = at[(at > 2300) & (at < 3900)]
    assert len(rest) == pytest.approx(1600 / 4, abs=3)
    assert knots(x, 0.02).tolist() == list(range(6000)) and knots(x[:7], 0.005).tolist() == list(range(7))


@pytest.mark.parametrize("rate_hz", [100.0, 500.0])
def test_a_line_with_next_to_no_effect_is_the_play_between_its_knots_too(rate_hz: float) -> None:
    time = np.arange(0.0, 12.0, 1.0 / rate_hz)
    # corners and ends of holds lie between the knots, and the end is fast
    x = 12.0 + 9.0 * np.sin(1.3 * time + 0.2 * time**2)
    drive = drive_of("act", "CP", 1.0 / rate_hz, x, Mechanics())
    play_of = predict(drive, 0.6, activate({}), 6.0)
    for effect in ({"viscous": {"c_l_n_s_per_mm": 1e-9}}, {"dwell_aging": {"b": 1e-9}}):
        error = predict(drive, 0.6, activate(effect), 6.0) - play_of
        assert np.sqrt(np.mean(error**2)) < 2e-3 and np.abs(error).max() < 0.05


def test_drive_of_a_record() -> None:
    d = drive_of("sstl", "NP", 0.5, np.array([1.0, 3.0, 2.0]), Mechanics())
    assert isinstance(d, Drive) and d.passes == 2 and d.time_s.tolist() == [0.0, 0.5, 1.0]
    assert d.path_n.tolist() == [0.0, 2.0, 3.0] and d.rate_n_s.tolist() == [4.0, 1.0, -2.0]
    assert (
        drive_of("act", None, 0.5, np.array([4.0]), Mechanics()).rate_n_s.tolist() == [0.0]
        and drive_of("act", None, 0.5, np.array([4.0]), Mechanics()).passes == 1
    )


def test_mechanics() -> None:
    m = Mechanics()
    assert (m.tendon_mm_per_n, m.end_mm_per_n("act"), m.end_mm_per_n("sstl")) == (0.25, 0.125, 0.125)
    assert m.straight("NP") == pytest.approx((0.075, 0.675)) and m.straight(None) == m.straight("elsewhere") == pytest.approx(
        (0.375, 0.375)
    )
    edge = Mechanics(arc_fraction=0.5, bend_centres={"A": 0.1, "B": 0.9})
    assert edge.straight("A") == (0.0, 0.5) and edge.straight("B") == (0.5, 0.0)


def test_play_between_tables_that_move() -> None:
    # lines 0.5 T and 2 T at scale 1, 0.25 T and 4 T at scale 2; tabulated at 0, 10, 20 N
    grid = np.array([0.0, 10.0, 20.0])
    pull, release = np.array([0.5 * grid, 0.25 * grid]), np.array([2.0 * grid, 4.0 * grid])
    t = np.array([10.0, 16.0, 4.0, 2.0, 24.0])
    one = bounded_play(t, pull, release, 10.0, np.array([1.0]), 1.0, 1.0, 3.0)
    assert one.tolist() == [5.0, 8.0, 8.0, 4.0, 12.0] == play_operator(t, 0.5, 0.0, 2.0, 0.0, 3.0).tolist()
    two = bounded_play(t, pull, release, 10.0, np.array([1.0, 1.5, 2.0, 3.0, 0.5]), 1.0, 1.0, math.nan)
    # midway 12.5 at first; halfway between the rows 3 T at the most; beyond the table its last row and first row count
    assert two.tolist() == pytest.approx([12.5, 12.5, 12.5, 8.0, 12.0])
    assert play_operator(np.array([10.0, 30.0]), 0.5, -1.0, 2.0, 1.0, math.nan).tolist() == pytest.approx([12.5, 14.0])
    assert play_operator(np.empty(0), 0.5, 0.0, 2.0, 0.0, math.nan).size == 0
    low = bounded_play(np.array([1.0]), pull - 4.0, release - 4.0, 10.0, np.array([1.0]), 1.0, 1.0, -3.0)
    assert low.tolist() == [0.0]


def test_a_line_driven_by_its_position() -> None:
    # lines 0.5 T and 2 T, tendon 0.25 and load 0.125 mm/N: 0.3125 mm/N pulled, 0.5 released, 0.125 in backlash
    x = np.array([0.0, 0.625, 0.0, -0.125, -0.125 - 0.5])
    t = position_driven(x, 10.0, 0.5, 0.0, 2.0, 0.0, 0.25, 0.125)
    # 12 N pulled to 6 N; 0.625 mm back in backlash are 5 N, 0.125 mm are 1 N: 6 N; then in backlash to 2 N, on the line 4 N
    assert t.tolist() == pytest.approx([10.0, 12.0, 7.0, 6.0, 2.0])
    further = position_driven(np.array([0.0, -1.0, -1.25, -9.0, -8.0]), 10.0, 0.5, 0.0, 2.0, 0.0, 0.25, 0.125)
    # 8 N in backlash leave 2 N; released by 0.5 mm/N to 1.5 N; slack; pulled again
    assert further.tolist() == pytest.approx([10.0, 2.0, 1.5, 0.0, 3.2])
    lines = Lines(gamma_p=0.5, beta_p=0.0, gamma_r=2.0, beta_r=0.0)
    trapezoid = Trajectory(kind="trapezoid", low_n=2.0, high_n=12.0)
    seconds = times(trapezoid, 10.0)
    found = probe(trapezoid, "act", seconds, lines, 0.25, 0.125)
    assert found[0] == 2.0 and found[48] == pytest.approx(12.0) and found.min() >= 0.0 and len(found) == 120
    assert probe(Trajectory(kind="trapezoid"), "act", seconds, lines, 0.25, 0.125).max() == pytest.approx(30.0)
    twice = probe(Trajectory(kind="trapezoid", low_n=2.0, high_n=12.0, cycles=2), "act", seconds, lines, 0.25, 0.125)
    assert twice[24] == pytest.approx(12.0)
