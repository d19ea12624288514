"""Every effect of the rig: identity when neutral, finite at its bounds, and the fingerprint the catalogue promises."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.physics.rig import QUIET, RigRun, RigSpec, parameters, resolve_effects, simulate_rig

THETA = 0.53
PASSES = {"act": 1, "sstl": 2}
SPEC = RigSpec()
# Parameters that only shape an effect: without its strength they must not matter.
SHAPES = ("path_n", "v_s_mm_s", "v_c_mm_s", "spread", "t0_s", "tau_s", "spike_n")


def mixed(size=4000, dt=0.01):
    """Ramps, a hold, slack, fast and noisy content."""
    time = np.arange(size) * dt
    command = np.interp(time, [0, 6, 12, 15, 18, 22, 30, 40], [5, 30, 0, 0, 20, 20, 8, 30])
    command = command + np.where(time > 30, 4 * np.sin(2 * np.pi * 0.9 * time), 0.0)
    return time, command + 0.05 * np.random.default_rng(0).standard_normal(size)


def record(system, effects, time, command, drive="tension", noise=QUIET, spec=SPEC, **options):
    # another tendon is pulled beside, which only an effect between tendons may notice
    run = RigRun(system, THETA, "CP", time, drive, command, 12.0 + 10.0 * np.sin(0.7 * time))
    return simulate_rig(spec, run, effects, noise, **options)


def lines(system, effects, **options):
    """Slopes and offsets of the two propagation lines: Gp, Gr, bp, br."""
    time = np.linspace(0.0, 120.0, 6001)
    command = np.interp(time, [0, 60, 120], [1.5, 45, 1.5])
    result = record(system, effects, time, command, **options)
    pull = (time < 60) & (command > 25)
    release = (time > 60) & (command < 4)
    gp, bp = np.polyfit(result.tension_in_n[pull], result.tension_out_n[pull], 1)
    gr, br = np.polyfit(result.tension_in_n[release], result.tension_out_n[release], 1)
    return np.array([gp, gr, bp, br])


def neutral(name):
    return {key: bounds.neutral for key, bounds in parameters()[name].items()}


@pytest.mark.parametrize("name", sorted(parameters()))
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_neutral_is_exactly_the_identity(name, system):
    time, command = mixed(1500)
    shaped = {key: bounds.high if key in SHAPES else bounds.neutral for key, bounds in parameters()[name].items()}
    if name == "tension_loop_lag":
        shaped = neutral(name)
    base = record(system, {}, time, command, drive="loop", noise=None)
    for values in (neutral(name), shaped):
        same = record(system, {name: values}, time, command, drive="loop", noise=None)
        for field in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm"):
            assert np.array_equal(getattr(base, field), getattr(same, field)), field


@pytest.mark.each_once
@pytest.mark.parametrize("name", sorted(parameters()))
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_finite_and_converged_at_both_bounds(name, system):
    time, command = mixed()
    base = record(system, {}, time, command, drive="loop")
    differs = False
    for side in ("low", "high"):
        values = {key: getattr(bounds, side) for key, bounds in parameters()[name].items()}
        for drive in ("tension", "position", "loop"):
            driven = 0.25 * (command - 5.0) if drive == "position" else command
            result = record(system, {name: values}, time, driven, drive=drive)
            assert result.unconverged == 0
            assert result.min_step_dissipation_j > -1e-12
            assert result.true_tension_in_n.min() >= 0.0
            for field in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "true_tension_out_n"):
                assert np.all(np.isfinite(getattr(result, field)))
        for field in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm"):
            differs = differs or not np.array_equal(getattr(base, field), getattr(result, field))
    assert differs or (name, system) == ("pulley_friction", "act")


def test_unconverged_steps_are_rarer_than_one_in_100_000():
    time = np.arange(100_000) * 0.01
    command = np.abs(16 + 9 * np.sin(time) + 6 * np.sin(0.313 * time) + 0.02 * np.sin(40 * time))
    effects = {
        "presliding": {"breakaway_mm": 0.1},
        "stick_slip": {"ratio": 1.3},
        "stribeck": {"ratio": 1.3, "v_s_mm_s": 2.0},
        "load_dependent_friction": {"alpha": 0.2},
        "load_spring": {"k3_per_mm2": 0.1, "play_mm": 1.0},
    }
    assert record("act", {}, time, command).unconverged <= 1
    assert record("act", effects, time[:30_000], command[:30_000]).unconverged == 0


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
    assert np.array_equal(lines("act", {"pulley_friction": {"f0_n": 2.0, "m_p": 0.2}}), lines("act", {}))


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_fingerprint_of_constant_friction(system):
    w = 0.4
    d = shift(system, {"const_friction": {"w_l_n": w}})
    gp, gr = lines(system, {})[:2]
    assert d[:2] == pytest.approx([0, 0], abs=0.003 * gr)
    # The table spreads the friction as the bend angle; here it is uniform along the sheath, 2-10 % apart.
    assert d[2] == pytest.approx(-w / THETA * (1 - gp), rel=0.1)
    assert d[3] == pytest.approx(w / THETA * (gr - 1), rel=0.1)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_fingerprint_of_gain_zero_and_asymmetry(system):
    base = lines(system, {})
    gain = lines(system, {"gain_error": {f"g_{system}": 1.06}})
    assert np.log(gain[:2] / base[:2]) == pytest.approx([np.log(1.06)] * 2, abs=1e-4)
    out = shift(system, {"zero_offset": {f"z_out_{system}_n": 0.7}})
    assert out == pytest.approx([0, 0, 0.7, 0.7], abs=1e-6)
    inward = shift(system, {"zero_offset": {f"z_in_{system}_n": 0.7}})
    assert inward == pytest.approx([0, 0, -base[0] * 0.7, -base[1] * 0.7], abs=1e-6)
    n, a = PASSES[system], 0.1
    asymmetric = lines(system, {"asymmetric_friction": {"a": a}})
    assert np.log(asymmetric[:2]) == pytest.approx([-n * THETA * (1 + a), n * THETA * (1 - a)], abs=1e-3)


@pytest.mark.parametrize("system", ["act", "sstl"])
def test_load_dependent_friction_follows_its_differential_equation(system):
    alpha, n = 0.2, PASSES[system]
    result = record(system, {"load_dependent_friction": {"alpha": alpha}}, *slow_rise())
    # dT/dphi = -mu0 T (T / 10 N)^-alpha, integrated in closed form over n passes.
    top = result.true_tension_in_n[-1] / 10.0
    expected = 10.0 * (top**alpha - alpha * n * THETA) ** (1 / alpha)
    assert result.true_tension_out_n[-1] == pytest.approx(expected, rel=3e-3)
    c = 0.01
    stiff = record(system, {"sheath_compliance": {"c_t_per_n": c}}, *slow_rise())
    top = stiff.true_tension_in_n[-1]
    expected = 1.0 / ((1.0 / top + c) * np.exp(n * THETA) - c)
    assert stiff.true_tension_out_n[-1] == pytest.approx(expected, rel=3e-3)


def slow_rise(high=30.0, seconds=40.0):
    time = np.linspace(0.0, seconds, 4001)
    return time, np.linspace(5.0, high, 4001)


def opening(effects, seconds):
    """How far the output lags behind the capstan line at the end of a rise, N."""
    time, command = slow_rise(seconds=seconds)
    result = record("sstl", effects, time, command)
    return np.exp(-2 * THETA) * command[-1] - result.true_tension_out_n[-1]


def test_rate_dependent_friction():
    drag = {"viscous": {"c_l_n_s_per_mm": 0.05}}
    assert opening(drag, 2.0) > 5 * opening(drag, 20.0) > 0.0
    weakening = {"stribeck": {"ratio": 1.4, "v_s_mm_s": 0.3}}
    assert opening(weakening, 400.0) > opening(weakening, 2.0) + 0.5


def roughness(effects, seconds):
    """Deviation of the second half of a rise from a straight line, N RMS."""
    time = np.arange(0.0, seconds, 0.002)
    out = record("act", effects, time, np.linspace(5.0, 30.0, time.size)).true_tension_out_n[time.size // 2 :]
    grid = np.arange(out.size)
    return np.std(out - np.polyval(np.polyfit(grid, out, 1), grid))


def test_stick_slip_is_a_sawtooth_at_low_speed_only():
    effects = {"stick_slip": {"ratio": 1.4, "v_c_mm_s": 0.5}}
    assert roughness(effects, 60.0) > 0.3
    assert roughness(effects, 0.8) < 0.1
    assert roughness({}, 60.0) < 1e-3


def overshoot(pause):
    time = np.arange(int((30 + pause) / 0.01)) * 0.01
    command = np.interp(time, [0, 15, 15 + pause, 30 + pause], [5, 20, 20, 35])
    aged = record("act", {"dwell_aging": {"b": 0.05, "t0_s": 1.0}}, time, command).true_tension_out_n
    plain = record("act", {}, time, command).true_tension_out_n
    return np.max((plain - aged)[time > 15 + pause])


def test_dwell_aging_grows_with_the_pause():
    assert overshoot(100.0) > overshoot(5.0) + 0.1 > 0.1


def test_presliding_rounds_the_corners_and_creep_relaxes_holds():
    time = np.linspace(0.0, 60.0, 6001)
    command = np.interp(time, [0, 20, 40, 60], [5, 30, 18, 18])
    held = (time > 24) & (time < 34)
    base = np.ptp(record("act", {}, time, command).true_tension_out_n[held])
    soft = record("act", {"presliding": {"breakaway_mm": 0.2}}, time, command)
    assert base < 1e-3 < 0.05 < np.ptp(soft.true_tension_out_n[held])
    creep = record("act", {"viscoelastic_creep": {"fraction": 0.3, "tau_s": 10.0}}, time, command)
    moved = creep.position_in_mm - record("act", {}, time, command).position_in_mm
    assert 0.05 < moved[2001] < moved[2100]
    relaxed = creep.true_tension_out_n[held]
    assert np.ptp(relaxed) > 0.02


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
    assert np.sqrt(np.mean((base.tension_out_n - other.tension_out_n) ** 2)) < 0.003
    assert np.max(np.abs(base.position_in_mm - other.position_in_mm)) > 0.1


def test_slack_lets_the_position_move_by_the_gap():
    time, command = mixed()
    moved = record("act", {"slack": {"gap_mm": 3.0}}, time, command).position_in_mm
    base = record("act", {}, time, command)
    gap = moved - base.position_in_mm
    assert gap[base.true_tension_in_n > 0.01] == pytest.approx(3.0)
    assert gap[base.true_tension_in_n == 0.0] == pytest.approx(0.0)
    pulled = record("act", {"slack": {"gap_mm": 3.0}}, time, np.linspace(0.0, 6.0, time.size), drive="position")
    assert np.mean(pulled.true_tension_in_n == 0.0) > 0.15


def test_friction_drift_and_loop_lag():
    time = np.linspace(0.0, 200.0, 20_001)
    command = 16 + 14 * np.sin(2 * np.pi * time / 20.0 - np.pi / 2)
    result = record("act", {"friction_drift": {"d_mu": 0.3, "path_n": 100.0}}, time, command)
    peaks = result.true_tension_out_n[1000::2000] / 30.0
    assert -np.log(peaks[-1]) == pytest.approx(THETA, rel=0.01)
    assert -np.log(peaks[0]) == pytest.approx(THETA * (1 + 0.3 * np.exp(-28 / 100)), rel=0.02)
    lagged = record("act", {"tension_loop_lag": {"tau_s": 0.5}}, *slow_rise())
    rate = 25.0 / 40.0
    assert slow_rise()[1][-1] - lagged.true_tension_in_n[-1] == pytest.approx(0.5 * rate, rel=0.02)


def test_unknown_names_and_bad_values_are_refused():
    with pytest.raises(ValueError, match="did you mean 'stribeck'"):
        resolve_effects({"stribek": {}})
    with pytest.raises(ValueError, match="parameter of stribeck 'v_s'"):
        resolve_effects({"stribeck": {"v_s": 1.0}})
    with pytest.raises(ValueError, match=r"pulley_friction.f0_n = 3.0 is outside 0..2$"):
        resolve_effects({"pulley_friction": {"f0_n": 3.0}})
    with pytest.raises(ValueError, match="outside"):
        resolve_effects({"viscous": {"c_l_n_s_per_mm": float("nan")}})
