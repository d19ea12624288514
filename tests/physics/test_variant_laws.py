"""Each law of the variant rig against its equation, solved by hand or by another method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from variant_cases import EVERY_LAW, STRENGTHS, movement, recorded

from sstl_cli.physics.variant import VariantRun, VariantSpec, VariantTruth, laws_of, march_variant, parameters, resolve_effects
from sstl_cli.physics.variant.build import build
from sstl_cli.physics.variant.contact import grip
from sstl_cli.physics.variant.effects.viscoelastic_creep import creep_spectrum

THETA = 0.6
CHANNELS = ("tension_in_n", "tension_out_n", "position_in_mm")


def pulled(
    effect: str,
    law: str,
    values: dict[str, float],
    system: str = "act",
    theta: float = THETA,
    seconds: float = 8.0,
    top: float = 26.0,
    **spec: float,
) -> VariantTruth:
    """Return a slow straight pull from 2 N to the top, then a release back (500 Hz)."""
    time = np.arange(round(2.0 * seconds * 500.0)) / 500.0
    command = np.interp(time, [0.0, seconds, 2.0 * seconds], [2.0, top, 2.0])
    built = VariantSpec(laws={effect: law}, law_seed=1, **spec)  # type: ignore[arg-type]
    return march_variant(built, VariantRun(system, theta, "CP", time, "tension", command), {effect: values})


def ends(truth: VariantTruth) -> tuple[float, float, float, float]:
    """Return input and output at the top of the pull and at the end of the release."""
    top = int(np.argmax(truth.tension_in_n))
    return truth.tension_in_n[top], truth.tension_out_n[top], truth.tension_in_n[-1], truth.tension_out_n[-1]


def along(law: Callable[[float], float], start: float, sign: float, theta: float = THETA) -> float:
    """Return the tension behind a bend: dT/dphi = -sign mu(T)/mu0 T, by an adaptive Runge-Kutta method."""
    found = solve_ivp(lambda _, t: -sign * law(t[0]) * t, (0.0, theta), [start], rtol=1e-9, atol=1e-9)
    return float(found.y[0, -1])


def shape(effect: str, law: str) -> float:
    return laws_of(VariantSpec(laws={effect: law}, law_seed=1))[effect].shape


@pytest.mark.parametrize(("effect", "law"), EVERY_LAW)
def test_every_law_shows_and_vanishes_at_neutral(effect: str, law: str) -> None:
    """It shows in some channel of some system, more at full strength than at a tenth; at a millionth hardly at all."""
    sizes = []
    for scale in (1.0, 0.1, 1e-6):
        if effect in ("saturation", "acquisition_faults") and scale < 1.0:
            continue
        worst = 0.0
        for system in ("act", "sstl"):
            bare, found = recorded(system, None), recorded(system, effect, law, scale)
            assert found.unconverged == 0
            for name in CHANNELS:
                changed = getattr(found, name) - getattr(bare, name)
                assert np.all(np.isfinite(changed))
                worst = max(worst, float(np.sqrt(np.mean((changed - (changed.mean() if name == CHANNELS[2] else 0.0)) ** 2))))
        sizes.append(worst)
    assert sizes[0] > 0.003
    if len(sizes) == 3 and effect != "tendon_elasticity":  # which takes the place of the tendon as built
        assert sizes[0] > 1.5 * sizes[1] > 0.0
        # a rounding to q and a dead band show q itself
        assert sizes[2] < 1e-3


@pytest.mark.parametrize("end", [pytest.param("low", marks=pytest.mark.slow), "high"])
@pytest.mark.parametrize(("effect", "law"), EVERY_LAW)
def test_both_ends_of_twice_the_range_are_solved(effect: str, law: str, end: str) -> None:
    values = {k: getattr(b, end) for k, b in parameters()[effect].items()}
    if effect == "saturation":
        values = dict.fromkeys(values, 5.0)
    for system in ("act", "sstl"):
        found = march_variant(VariantSpec(laws={effect: law}, law_seed=2), movement(system), {effect: values})
        assert found.unconverged == 0
        assert np.all(np.isfinite(found.tension_out_n)) and np.all(found.tension_out_n >= 0.0)


def test_lines_of_pull_and_release_are_the_capstans() -> None:
    truth = pulled("viscous", "power", {})
    top_in, top_out, low_in, low_out = ends(truth)
    assert top_out / top_in == pytest.approx(math.exp(-THETA), rel=1e-9)
    assert low_out / low_in == pytest.approx(math.exp(THETA), rel=1e-9)


@pytest.mark.parametrize(
    ("effect", "values", "laws"),
    [
        ("load_dependent_friction", {"alpha": 0.2}, {
            "hertz": lambda t: 0.4 + 0.6 * (t / 10.0) ** (-1.0 / 3.0),
            "step": lambda t: 1.0 + 0.138 * math.tanh((shape("load_dependent_friction", "step") - t) / 1.5),
        }),
        ("sheath_compliance", {"c_t_per_n": 0.01}, {
            "beam_column": lambda t: 1.0 / (1.0 - 0.01 * t),
            "stop": lambda t: 1.0 + 0.01 * (s := shape("sheath_compliance", "stop")) * (1.0 - math.exp(-t / s)),
        }),
    ],
)  # fmt: skip
def test_laws_of_the_local_tension(effect: str, values: dict[str, float], laws: dict[str, Callable[[float], float]]) -> None:
    for law, factor in laws.items():
        top_in, top_out, low_in, low_out = ends(pulled(effect, law, values, nodes=60))
        assert top_out == pytest.approx(along(factor, top_in, 1.0), rel=1e-3), law
        assert low_out == pytest.approx(along(factor, low_in, -1.0), rel=1e-3), law


def test_asymmetric_friction() -> None:
    top_in, top_out, low_in, low_out = ends(pulled("asymmetric_friction", "one_sided", {"a": 0.1}))
    assert math.log(top_in / top_out) == pytest.approx(1.2 * THETA) and math.log(low_out / low_in) == pytest.approx(THETA)
    n = shape("asymmetric_friction", "by_load")
    top_in, top_out, low_in, low_out = ends(pulled("asymmetric_friction", "by_load", {"a": 0.1}, nodes=60))
    assert top_out == pytest.approx(along(lambda t: 1 + 0.1 * min((t / 10) ** n, 2), top_in, 1.0), rel=1e-3)
    assert low_out == pytest.approx(along(lambda t: 1 - 0.1 * min((t / 10) ** n, 2), low_in, -1.0), rel=1e-3)


def test_constant_friction() -> None:
    decay, w = math.exp(-THETA), 0.4
    top_in, top_out, _, _ = ends(pulled("const_friction", "adhesive", {"w_l_n": w}))
    assert top_out == pytest.approx(top_in * decay - w * (1.0 - decay) / THETA)
    top_in, top_out, low_in, low_out = ends(pulled("const_friction", "terminal", {"w_l_n": w}))
    assert top_out == pytest.approx((top_in - 0.5 * w) * decay - 0.5 * w)
    assert low_out == pytest.approx((low_in + 0.5 * w) / decay + 0.5 * w)


@pytest.mark.parametrize("law", ["rolling", "bearing"])
def test_pulley(law: str) -> None:
    values, y = {"m_p": 0.1, "m_r": 0.05, "f0_n": 0.3}, shape("pulley_friction", law)
    top_in, top_out, low_in, low_out = ends(pulled("pulley_friction", law, values, "sstl", seconds=60.0, top=80.0, ea_n=1e7))

    def constant(t: float) -> float:
        return 0.3 * (1.0 - math.exp(-t / 2.0)) if law == "rolling" else 0.3

    t = top_in * math.exp(-THETA)
    t = t * math.exp(-0.1 * (t / 10.0) ** y) - constant(t)
    assert top_out == pytest.approx(t * math.exp(-THETA), rel=1e-6)
    t = low_in * math.exp(THETA)
    t = t * math.exp(0.05 * (t / 10.0) ** y) + constant(t)
    assert low_out == pytest.approx(t * math.exp(THETA), rel=1e-6)
    assert np.array_equal(pulled("pulley_friction", law, values).tension_out_n, pulled("pulley_friction", law, {}).tension_out_n)


def test_drift_by_time_by_heat_and_by_wear() -> None:
    values = {"d_mu": 0.2, "path_n": 100.0}
    rate = shape("friction_drift", "time")
    truth = pulled("friction_drift", "time", values)
    late = 0.2 * math.exp(-(16.0 - 1.0 / 500.0) * rate / 100.0)
    low_in, low_out = ends(truth)[2:]
    assert math.log(low_out / low_in) == pytest.approx(THETA * (1.0 + late), rel=1e-3)
    # heat goes in a pause and wear does not: a pull, half an hour of rest, a pull
    time = np.concatenate((np.arange(0.0, 9.0, 0.01), [1800.0], np.arange(1801.0, 1810.0, 0.01)))
    command = np.interp(time, [0.0, 8.0, 9.0, 1800.0, 1801.0, 1810.0], [2.0, 26.0, 25.0, 25.0, 2.0, 26.0])
    found = {}
    for law in ("heat", "wear"):
        spec = VariantSpec(laws={"friction_drift": law}, law_seed=1)
        truth = march_variant(spec, VariantRun("act", THETA, None, time, "tension", command), {"friction_drift": values})
        slope = np.log(truth.tension_in_n / truth.tension_out_n) / THETA
        found[law] = (slope[800], slope[-1])
        assert 1.0 < found[law][0] < 1.2
    assert found["heat"][1] > found["heat"][0] - 0.05
    assert found["wear"][1] < found["wear"][0]


@pytest.mark.parametrize("law", ["curvature", "power", "eyring"])
def test_drag_of_a_stiff_tendon(law: str) -> None:
    """Without Coulomb friction and stretch the whole tendon moves at rate / k: T_in - T_out is the drag at that speed."""
    c, rate = 0.04, 3.0
    truth = pulled("viscous", law, {"c_l_n_s_per_mm": c}, theta=0.0, ea_n=1e7)
    v, s = rate / 8.0, shape("viscous", law)
    expected = {"curvature": c * v, "power": c * 2.0 * (v / 2.0) ** s, "eyring": c * s * math.asinh(v / s)}[law]
    middle = truth.tension_in_n.size // 4
    assert truth.tension_in_n[middle] - truth.tension_out_n[middle] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("law", ["dahl", "bouc_wen"])
def test_presliding_force_is_that_of_the_differential_equation(law: str) -> None:
    """The closed form of a step against the law integrated in tiny steps, through reversals, limits 2 and 3 N."""
    spec = VariantSpec(laws={"presliding": law})
    rate = build(spec, movement("act"), resolve_effects({"presliding": {"breakaway_mm": 0.1}}), laws_of(spec), 0).rate
    z, pull, release, force = 0.05, 2.0, 3.0, 0.0
    for move in (0.08, -0.03, 0.02, -0.2, 0.15, 0.01):
        found, slope = grip(rate, force, pull, release, z, move)
        du, f = move / 20_000, force
        for _ in range(20_000):
            limit = pull if du > 0.0 else release
            if law == "dahl":
                f += limit / z * (1.0 - math.copysign(1.0, du) * f / limit) * du
            else:
                against = f * du < 0.0
                grown = (pull if f > 0.0 else release) / z
                f += grown * du if against else (limit / z - abs(f) / z) * du
        assert found == pytest.approx(f, abs=2e-3)
        nudged = grip(rate, force, pull, release, z, move + math.copysign(1e-7, move))[0]
        assert slope == pytest.approx((nudged - found) / math.copysign(1e-7, move), rel=1e-3)
        force = found


def test_static_friction_overshoots_after_a_rest_and_more_after_a_longer_one() -> None:
    for effect, law in (("dwell_aging", "power"), ("dwell_aging", "kato"), ("stick_slip", "kato"), ("stick_slip", "armstrong")):
        peaks = []
        for rest in (1.0, 30.0):
            time = np.concatenate((np.arange(0.0, 8.0, 0.002), np.arange(8.0 + rest, 16.0 + rest, 0.002)))
            command = np.interp(time, [0.0, 8.0, 8.0 + rest, 16.0 + rest], [2.0, 14.0, 14.0, 26.0])
            values = {"b": 0.05} if effect == "dwell_aging" else {"ratio": 1.2, "v_c_mm_s": 0.1}
            spec = VariantSpec(laws={effect: law}, law_seed=1)
            truth = march_variant(spec, VariantRun("act", THETA, None, time, "tension", command), {effect: values})
            after = (time > 8.0 + rest) & (time < 10.5 + rest)
            peaks.append(float(np.max(np.log(truth.tension_in_n / truth.tension_out_n)[after]) / THETA))
        assert 1.005 < peaks[0] < peaks[1] < 1.3, (effect, law, peaks)


def test_friction_falls_with_speed() -> None:
    for law in ("hess_soom", "exponent"):
        slopes = []
        for seconds, v_s in ((20.0, 20.0), (0.5, 0.05)):
            truth = pulled("stribeck", law, {"ratio": 1.3, "v_s_mm_s": v_s}, seconds=seconds)
            # between two jumps friction comes up to what it is at low speed
            slopes.append(float(np.log(truth.tension_in_n / truth.tension_out_n).max()) / THETA)
        assert 1.2 < slopes[0] <= 1.3, law
        assert slopes[1] < 1.05, law


@pytest.mark.parametrize("law", ["two_times", "power"])
def test_creep_of_a_free_line(law: str) -> None:
    """Without friction the tension is the same everywhere; the tendon creeps by the sum of its Kelvin elements."""
    time = np.concatenate(([0.0, 1e-6], np.geomspace(0.05, 60.0, 800)))
    command = np.where(time > 0.0, 15.0, 5.0)
    spec = VariantSpec(laws={"viscoelastic_creep": law}, law_seed=1)
    values = {"viscoelastic_creep": {"fraction": 0.3, "tau_s": 10.0}}
    truth = march_variant(spec, VariantRun("act", 0.0, None, time, "tension", command), values)
    taus, shares = creep_spectrum(10.0, laws_of(spec)["viscoelastic_creep"])
    expected = 10.0 * 0.25 * 0.3 * (shares * (1.0 - np.exp(-time[2:, None] / taus))).sum(axis=1)
    assert np.allclose(truth.position_in_mm[2:] - truth.position_in_mm[1], expected, atol=0.01 * expected[-1])
    assert (shares * (1.0 - np.exp(-10.0 / taus))).sum() == pytest.approx(1.0 - math.exp(-1.0), rel=0.1)
    if law == "power":
        growth = np.interp([3.0, 30.0], time[2:], expected)
        exponent = shape("viscoelastic_creep", "power")
        assert math.log10(growth[1] / growth[0]) == pytest.approx(exponent, abs=0.12), "a power law over a decade"


def test_springs_of_a_free_line() -> None:
    """Position without friction against the equations of load, tendon, sheath and slack."""

    def x(effect: str, law: str, values: dict[str, float]) -> np.ndarray:
        truth = pulled(effect, law, values, theta=0.0)
        bare = (truth.tension_in_n - 5.0) * (0.125 + 0.25)
        return np.asarray(truth.position_in_mm - bare)

    t = pulled("slack", "toe", {}, theta=0.0).tension_in_n
    top = int(np.argmax(t))

    def rise(law: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return np.asarray(law(t) - law(np.full(1, 5.0)))

    b = math.log(1.0 + 27.0 * 0.05) / 3.0
    found = x("load_spring", "fung", {"k3_per_mm2": 0.05})
    assert np.allclose(found, rise(lambda t: np.log1p(b * t / 8.0) / b - t / 8.0), atol=1e-6)
    found = x("load_spring", "hysteretic", {"k3_per_mm2": 0.05})
    assert found[top] == pytest.approx(-1.5 / 8.0, rel=1e-6) and found[-1] == pytest.approx(1.5 / 8.0, rel=1e-6)
    s = shape("tendon_elasticity", "stiffening")
    found = x("tendon_elasticity", "stiffening", {"compliance_per_kn": 0.2})
    assert np.allclose(found, rise(lambda t: 0.4 * (t + 4.0 * s * (1.0 - np.exp(-t / 4.0))) - 0.25 * t), atol=1e-6)
    s = shape("tendon_elasticity", "hysteretic")
    found = x("tendon_elasticity", "hysteretic", {"compliance_per_kn": 0.2}) - 0.15 * (t - 5.0)
    assert found[top] == pytest.approx(-0.4 * s * 2.0, rel=1e-6) and found[-1] == pytest.approx(0.4 * s * 2.0, rel=1e-6)
    s = shape("slack", "catenary")
    assert np.allclose(x("slack", "catenary", {"gap_mm": 3.0}), rise(lambda t: 3.0 * t**2 / (t**2 + s**2)), atol=1e-9)
    found = x("sheath_compliance", "beam_column", {"k_sh_mm_per_n": 0.1})
    assert np.allclose(found, rise(lambda t: 0.1 * t * (1.0 + t / 50.0)), atol=1e-9)


@pytest.mark.parametrize("law", ["second_order", "transport"])
def test_tension_loop_is_late_by_its_time_constant(law: str) -> None:
    truth = pulled("tension_loop_lag", law, {"tau_s": 0.2})
    assert pytest.approx((2.0 + 3.0 * 4.0) - np.interp(4.0, np.arange(8000) / 500.0, truth.tension_in_n), rel=0.01) == 3.0 * 0.2
    slow = pulled("tension_loop_lag", law, {"inverse_slew_s_per_n": 0.4}).tension_in_n
    assert np.abs(np.diff(slow)).max() * 500.0 <= 2.5 + 1e-9, "at most the slew limit"


@pytest.mark.parametrize("effect", ["load_dependent_friction", "viscous", "presliding", "viscoelastic_creep", "friction_drift"])
def test_solution_converges_in_step_and_nodes(effect: str) -> None:
    """Twice the samples or stations change the output by less than the coarser ones did, and by little at last."""
    law = next(name for e, name in EVERY_LAW if e == effect)
    time = np.arange(1601) / 80.0
    command = 12.0 - 9.0 * np.cos(2.0 * np.pi * time / 8.0)

    def out(step: int, nodes: int) -> np.ndarray:
        fine = np.arange(1600 * step + 1) / (80.0 * step)
        spec = VariantSpec(laws={effect: law}, law_seed=1, nodes=nodes)
        run = VariantRun("sstl", 0.5, "NP", fine, "tension", np.interp(fine, time, command))
        return march_variant(spec, run, {effect: STRENGTHS[effect]}).tension_out_n[::step]

    for pairs in ([(1, 30), (2, 30), (8, 30)], [(1, 15), (1, 30), (1, 120)]):
        first, second, third = (out(*p) for p in pairs)
        coarse, finer = np.std(first - third), np.std(second - third)
        assert finer <= 0.7 * coarse + 1e-6
        assert finer < 0.01
