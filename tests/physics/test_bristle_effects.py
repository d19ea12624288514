"""Every effect of the bristle simulator: identity when neutral, sound at its bounds, seen when active, its own law."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.physics.bristle import QUIET, BristleRun, BristleSpec, parameters, resolve_effects, simulate_bristle

THETA = 0.53
PASSES = {"act": 1, "sstl": 2}
SPEC = BristleSpec()
# parameters that only shape an effect: without its strength they must not matter
SHAPES = ("path_n", "v_s_mm_s", "v_c_mm_s", "spread", "t0_s", "spike_n")
FIELDS = ("time_s", "tension_in_n", "tension_out_n", "position_in_mm")


def mixed(size=1000, dt=0.04):
    """Ramps, a hold, slack, fast and noisy content."""
    time = np.arange(size) * dt
    command = np.interp(time, [0, 6, 12, 15, 18, 22, 30, 40], [5, 30, 0, 0, 20, 20, 8, 30])
    command = command + np.where(time > 30, 4 * np.sin(2 * np.pi * 0.9 * time), 0.0)
    return time, command + 0.05 * np.random.default_rng(0).standard_normal(size)


def record(system, effects, time, command, drive="tension", noise=QUIET, spec=SPEC, seed=0):
    # another tendon is pulled beside, which only an effect between tendons may notice
    run = BristleRun(system, THETA, "CP", time, drive, command, 12.0 + 10.0 * np.sin(0.7 * time))
    return simulate_bristle(spec, run, effects, noise, seed)


def lines(system, effects):
    """Slopes and offsets of the two propagation lines: Gp, Gr, bp, br."""
    time = np.linspace(0.0, 120.0, 1501)
    command = np.interp(time, [0, 60, 120], [1.5, 45, 1.5])
    done = record(system, effects, time, command)
    pull, release = (time < 60) & (command > 25), (time > 60) & (command < 4)
    gp, bp = np.polyfit(done.tension_in_n[pull], done.tension_out_n[pull], 1)
    gr, br = np.polyfit(done.tension_in_n[release], done.tension_out_n[release], 1)
    return np.array([gp, gr, bp, br])


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.parametrize("name", sorted(parameters()))
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_neutral_is_exactly_the_identity(name, system):
    time, command = mixed(400)
    base = record(system, {}, time, command, drive="loop", noise=None)
    shapes = (*SHAPES, "tau_s") if name == "viscoelastic_creep" else SHAPES
    for side in ("neutral", "high"):
        values = {key: getattr(b, side) if key in shapes else b.neutral for key, b in parameters()[name].items()}
        same = record(system, {name: values}, time, command, drive="loop", noise=None)
        for field in FIELDS:
            assert np.array_equal(getattr(base, field), getattr(same, field)), field


@pytest.mark.each_once
@pytest.mark.parametrize("name", sorted(parameters()))
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_sound_at_both_bounds_and_seen(name, system):
    time, command = mixed()
    base = record(system, {}, time, command, drive="loop")
    seen = 0.0
    for side in ("low", "high"):
        values = {key: getattr(bounds, side) for key, bounds in parameters()[name].items()}
        for drive in ("tension", "position", "loop"):
            driven = 0.25 * (command - 5.0) if drive == "position" else command
            done = record(system, {name: values}, time, driven, drive=drive)
            assert done.unconverged == 0
            assert done.min_step_dissipation_j > -1e-12
            assert done.true_tension_in_n.min() >= 0.0
            for field in (*FIELDS, "true_tension_out_n"):
                assert np.all(np.isfinite(getattr(done, field)))
            assert np.all(np.diff(done.time_s) > 0.0)
        for field in FIELDS[1:]:
            seen = max(seen, rms(getattr(base, field) - getattr(done, field)))
    if (name, system) == ("pulley_friction", "act"):
        assert seen == 0.0
    else:
        assert seen > 0.01


def test_random_rigs_with_random_effects_converge():
    rng = np.random.default_rng(5)
    names = sorted(parameters())
    for _ in range(30):
        time = np.arange(400) / rng.choice([50.0, 200.0, 1000.0])
        knots = np.sort(rng.uniform(0.0, time[-1], 8))
        command = np.interp(time, knots, rng.uniform(0.0, 50.0, 8))
        spec = BristleSpec(
            ea_n=rng.uniform(2e3, 2e4), load_k1_n_per_mm=np.exp(rng.uniform(np.log(0.9), np.log(50.0))),
            nodes=int(rng.integers(10, 61)), length_mm=rng.uniform(300.0, 3000.0),
            bend_arc_fraction=rng.uniform(0.05, 1.0),
        )  # fmt: skip
        effects = {
            str(name): {key: rng.uniform(b.low, b.high) for key, b in parameters()[name].items()}
            for name in rng.choice(names, int(rng.integers(0, 4)), replace=False)
        }
        drive = str(rng.choice(["tension", "position", "loop"]))
        driven = 0.2 * command if drive == "position" else command
        place = str(rng.choice(["NP", "CP", "ND"]))
        run = BristleRun(str(rng.choice(["act", "sstl"])), rng.uniform(0.0, 1.5), place, time, drive, driven)
        done = simulate_bristle(spec, run, effects)
        assert done.unconverged == 0, (spec, run, effects)
        assert done.min_step_dissipation_j > -1e-9
        assert np.all(np.isfinite(done.tension_out_n)) and np.all(np.isfinite(done.position_in_mm))


def shift(system, effects):
    return lines(system, effects) - lines(system, {})


def test_fingerprint_of_the_pulley():
    base = lines("sstl", {})[:2]
    m = np.log(lines("sstl", {"pulley_friction": {"m_p": 0.1, "m_r": 0.1}})[:2] / base)
    assert m == pytest.approx([-0.1, 0.1], abs=1e-3)
    one_way = np.log(lines("sstl", {"pulley_friction": {"m_p": 0.1}})[:2] / base)
    assert one_way == pytest.approx([-0.1, 0.0], abs=1e-3)
    constant = shift("sstl", {"pulley_friction": {"f0_n": 0.5}})
    assert constant == pytest.approx([0, 0, -0.5 * np.exp(-THETA), 0.5 * np.exp(THETA)], abs=0.01)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_fingerprints_of_const_friction_gain_zero_and_asymmetry(system):
    n, w, a, base = PASSES[system], 0.4, 0.1, lines(system, {})
    gp, gr = base[:2]
    constant = shift(system, {"const_friction": {"w_l_n": w}})
    assert constant[:2] == pytest.approx([0, 0], abs=0.003 * gr)
    assert constant[2:] == pytest.approx([-w / THETA * (1 - gp), w / THETA * (gr - 1)], rel=0.12)
    gain = lines(system, {"gain_error": {f"g_{system}": 1.06}})
    assert np.log(gain[:2] / base[:2]) == pytest.approx([np.log(1.06)] * 2, abs=1e-4)
    assert shift(system, {"zero_offset": {f"z_out_{system}_n": 0.7}}) == pytest.approx([0, 0, 0.7, 0.7], abs=1e-6)
    inward = shift(system, {"zero_offset": {f"z_in_{system}_n": 0.7}})
    assert inward == pytest.approx([0, 0, -gp * 0.7, -gr * 0.7], abs=1e-6)
    skewed = lines(system, {"asymmetric_friction": {"a": a}})
    assert np.log(skewed[:2]) == pytest.approx([-n * THETA * (1 + a), n * THETA * (1 - a)], abs=1e-3)


def exponent(effects, tension, seconds=60.0, system="act"):
    """Wrap exponent -ln(out / in) per pass at the end of a pull to this tension (N)."""
    time = np.linspace(0.0, seconds, 1501)
    command = np.interp(time, [0.0, seconds], [0.5 * tension, tension])
    done = record(system, effects, time, command, spec=BristleSpec(pretension_n=0.4 * tension * np.exp(-THETA)))
    return -np.log(done.true_tension_out_n[-1] / tension) / PASSES[system]


def capstan(tension, factor, steps=2000):
    """Wrap exponent of d ln T = -theta factor(T) along the bend, from this tension on."""
    log = np.log(tension)
    for _ in range(steps):
        middle = log - 0.5 * THETA / steps * factor(np.exp(log))
        log -= THETA / steps * factor(np.exp(middle))
    return np.log(tension) - log


@pytest.mark.parametrize("tension", [4.0, 40.0])
def test_load_sheath_and_neighbours_change_the_angle_by_their_own_laws(tension):
    hertz = capstan(tension, lambda t: ((t + 1.0) / 11.0) ** -0.2)
    assert exponent({"load_dependent_friction": {"alpha": 0.2}}, tension) == pytest.approx(hertz, rel=0.004)
    bent = capstan(tension, lambda t: 1.0 + 0.008 * t / (1.0 + 0.004 * t))
    assert exponent({"sheath_compliance": {"c_t_per_n": 0.008}}, tension) == pytest.approx(bent, rel=0.004)
    swell = np.exp(2.0 * np.tanh(0.5 * 0.01 * (12.0 + 10.0 * np.sin(0.7 * 60.0))))
    assert exponent({"tendon_crosstalk": {"c_bend_per_n": 0.01}}, tension) == pytest.approx(THETA * swell, rel=0.004)


def test_friction_drifts_by_time_also_in_a_pause():
    time = np.arange(0.0, 100.0, 0.02)
    # two equal pulls; the path is walked at 50 N in 100 s, so that 50 N stand for 100 s
    command = np.interp(time, [0, 10, 20, 80, 90, 100], [5, 17.5, 5, 5, 17.5, 17.5])
    done = record("act", {"friction_drift": {"d_mu": 0.3, "path_n": 25.0}}, time, command)
    rate = np.abs(np.diff(command)).sum() / time[-1]
    for instant in (10.0, 90.0):
        k = int(instant / 0.02)
        expected = THETA * (1.0 + 0.3 * np.exp(-instant * rate / 25.0))
        assert -np.log(done.true_tension_out_n[k] / command[k]) == pytest.approx(expected, rel=0.005)


def test_stribeck_follows_tustin_where_sliding_is_steady():
    # so stiff, and with so long a memory, that sliding is stable at every speed
    stiff = BristleSpec(ea_n=2e4, load_k1_n_per_mm=40.0, film_mm=0.2)
    for seconds in (0.5, 2.0, 16.0):
        time = np.linspace(0.0, seconds, 2001)
        command = np.interp(time, [0.0, seconds], [5.0, 40.0])
        run = BristleRun("act", THETA, "ND", time, "tension", command)
        out = simulate_bristle(stiff, run, {"stribeck": {"ratio": 1.1, "v_s_mm_s": 1.0}}, QUIET).true_tension_out_n
        # speed of the bend: that of the load end and of what stretches behind the bend, 0.2 of the length
        rate = (out[-1] - out[-201]) / (time[-1] - time[-201])
        speed = rate * (1.0 / 40.0 + 0.2 * 2000.0 / 2e4)
        expected = THETA * (1.0 + 0.1 * np.exp(-speed / 1.0))
        assert -np.log(out[-1] / command[-1]) == pytest.approx(expected, rel=0.005)


def test_viscous_drag_grows_with_speed():
    drag = {"viscous": {"c_l_n_s_per_mm": 0.05}}
    assert exponent(drag, 30.0, 2.0) - THETA > 5 * (exponent(drag, 30.0, 20.0) - THETA) > 0.0


def roughness(effects, seconds):
    """Deviation of the second half of a rise from a straight line, N RMS."""
    time = np.arange(0.0, seconds, 0.005)
    out = record("act", effects, time, np.linspace(5.0, 30.0, time.size)).true_tension_out_n[time.size // 2 :]
    grid = np.arange(out.size)
    return np.std(out - np.polyval(np.polyfit(grid, out, 1), grid))


def test_stick_slip_is_a_sawtooth_at_low_speed_only():
    effects = {"stick_slip": {"ratio": 1.4, "v_c_mm_s": 0.5}}
    assert roughness(effects, 60.0) > 0.3
    assert roughness(effects, 0.8) < 0.1
    assert roughness({}, 60.0) < 1e-3


def test_dwell_aging_grows_with_the_pause_by_a_power():
    def lag(pause):
        """How far the input has to rise after a pause until the output moves, over the tension of the pause."""
        time = np.arange(0.0, 20.0 + pause, 0.01)
        command = np.interp(time, [0, 10, 10 + pause, 20 + pause], [5, 20, 20, 28])
        out = record("act", {"dwell_aging": {"b": 0.05, "t0_s": 1.0}}, time, command).true_tension_out_n
        at_rest = int((10 + pause) / 0.01)
        moved = at_rest + int(np.argmax(out[at_rest:] > out[at_rest] + 0.05))
        return np.log(command[moved] / out[at_rest])

    for pause in (5.0, 50.0):
        assert lag(pause) == pytest.approx(THETA * (1.0 + pause) ** 0.05, rel=0.02)


def test_presliding_rounds_the_corners_and_creep_relaxes_holds():
    time = np.linspace(0.0, 60.0, 3001)
    command = np.interp(time, [0, 20, 40, 60], [5, 30, 18, 18])
    held = (time > 24) & (time < 34)
    base = record("act", {}, time, command)
    soft = record("act", {"presliding": {"breakaway_mm": 0.2}}, time, command)
    assert np.ptp(base.true_tension_out_n[held]) < 1e-3 < 0.05 < np.ptp(soft.true_tension_out_n[held])
    creep = record("act", {"viscoelastic_creep": {"fraction": 0.3, "tau_s": 10.0}}, time, command)
    moved = creep.position_in_mm - base.position_in_mm
    assert 0.05 < moved[1001] < moved[1050]
    assert np.ptp(creep.true_tension_out_n[held]) > 0.02


def test_creep_ends_at_its_share_of_the_stretch_and_has_two_times():
    time = np.arange(0.0, 400.0, 0.1)
    command = np.where(time < 0.05, 5.0, 25.0)
    effects = {"viscoelastic_creep": {"fraction": 0.2, "tau_s": 10.0}}
    free = BristleSpec()
    run = BristleRun("act", 0.0, "CP", time, "tension", command)
    moved = simulate_bristle(free, run, effects, QUIET).position_in_mm - simulate_bristle(free, run, {}, QUIET).position_in_mm
    stretch = 20.0 * free.length_mm / free.ea_n
    t = time - time[1]
    expected = 0.1 * stretch * (2.0 - np.exp(-3.0 * t / 10.0) - np.exp(-t / 30.0))
    assert moved[-1] == pytest.approx(0.2 * stretch, rel=0.01)
    assert np.max(np.abs(moved - expected)[10:]) < 0.03 * stretch * 0.2


@pytest.mark.parametrize(
    "effects",
    [
        {"tendon_elasticity": {"compliance_per_kn": 0.3}},
        {"load_spring": {"k3_per_mm2": 0.1}},
        {"load_spring": {"play_mm": 1.0}},
        {"sheath_compliance": {"k_sh_mm_per_n": 0.1}},
        {"slack": {"gap_mm": 3.0}},
    ],
)
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_position_effects_leave_the_tensions_alone(effects, system):
    time, command = mixed()
    base, other = record(system, {}, time, command), record(system, effects, time, command)
    assert rms(base.tension_out_n - other.tension_out_n) < 0.01
    assert np.max(np.abs(base.position_in_mm - other.position_in_mm)) > 0.1


def test_load_hardens_as_sinh_and_has_its_play():
    time = np.linspace(0.0, 40.0, 2001)
    command = np.interp(time, [0, 20, 40], [5.0, 30.0, 5.0])
    run = BristleRun("act", 0.0, "CP", time, "tension", command)
    x = simulate_bristle(SPEC, run, {"load_spring": {"k3_per_mm2": 0.1}}, QUIET).position_in_mm
    q = np.sqrt(0.6)

    def load_end(tension):
        return np.arcsinh(tension * q / 8.0) / q

    assert x[1000] == pytest.approx(load_end(30.0) - load_end(5.0) + 25.0 * 0.25, abs=1e-3)
    loose = simulate_bristle(SPEC, run, {"load_spring": {"play_mm": 1.0}}, QUIET).position_in_mm
    assert loose[500] - loose[1500] == pytest.approx(1.0, abs=0.02)


def test_slack_and_loop_lag():
    time, command = mixed()
    base = record("act", {}, time, command)
    gap = record("act", {"slack": {"gap_mm": 3.0}}, time, command).position_in_mm - base.position_in_mm
    assert gap[base.true_tension_in_n > 0.01] == pytest.approx(3.0)
    assert gap[base.true_tension_in_n == 0.0] == pytest.approx(0.0)
    pulled = record("act", {"slack": {"gap_mm": 3.0}}, time, np.linspace(0.0, 6.0, time.size), drive="position")
    assert np.mean(pulled.true_tension_in_n == 0.0) > 0.15
    rise = np.linspace(5.0, 30.0, time.size)
    lagged = record("act", {"tension_loop_lag": {"tau_s": 0.5}}, time, rise)
    assert rise[-1] - lagged.true_tension_in_n[-1] == pytest.approx(0.5 * 25.0 / time[-1], rel=0.05)
    steep = np.where(time < 1.0, 5.0, 25.0)
    slewed = record("act", {"tension_loop_lag": {"inverse_slew_s_per_n": 0.2}}, time, steep).true_tension_in_n
    assert np.max(np.diff(slewed)) == pytest.approx(5.0 * 0.04) and slewed[-1] == pytest.approx(25.0)


def test_unknown_names_and_bad_values_are_refused():
    with pytest.raises(ValueError, match="did you mean 'stribeck'"):
        resolve_effects({"stribek": {}})
    with pytest.raises(ValueError, match="parameter of stribeck 'v_s'"):
        resolve_effects({"stribeck": {"v_s": 1.0}})
    with pytest.raises(ValueError, match=r"pulley_friction.f0_n = 3.0 is outside 0..2$"):
        resolve_effects({"pulley_friction": {"f0_n": 3.0}})
    with pytest.raises(ValueError, match="outside"):
        resolve_effects({"viscous": {"c_l_n_s_per_mm": float("nan")}})
