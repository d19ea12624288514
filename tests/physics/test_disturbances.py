"""Disturbances from no list: any of them is finite, reaches its size, and sits where it says."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.physics import disturbances
from sstl_cli.physics.disturbances import Disturbance, Scene
from sstl_cli.physics.random_function import FORMS, RandomFunction

HZ, THETA = 50.0, 0.5
DRAWN = [disturbances.draw(np.random.default_rng(k)) for k in range(60)]


def play(command: np.ndarray, theta: np.ndarray | float) -> np.ndarray:
    """Return Eq. (3) and (5) of the paper with a theta (rad) for every sample."""
    low, high = np.exp(-np.asarray(theta)) * command, np.exp(np.asarray(theta)) * command
    out, held = np.empty(command.size), 5.0
    for k in range(command.size):
        held = out[k] = min(max(held, low[k]), high[k])
    return out


def simulate(scene: Scene, command: np.ndarray, factor: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return output and position of a play whose load and tendon have 0.25 mm/N."""
    passes = 2 if scene.system == "sstl" else 1
    out = play(command, passes * THETA * (1.0 if factor is None else factor))
    return out, 0.125 * out + 0.125 * command


def scene(system: str, order: int) -> Scene:
    time = np.arange(round(30 * HZ)) / HZ
    command = np.interp(time, [0, 4, 7, 11, 15, 17, 21, 23, 26, 30], [3.0, 22, 22, 2, 2, 18, 6, 15, 4, 20])
    bare = Scene(system, order, time, command, command, command)
    return Scene(system, order, time, command, *simulate(bare, command, None))


SCENES = [scene(s, i) for i, s in enumerate(("act", "sstl", "act", "sstl"))]


def gap(d: Disturbance, amplitude: float) -> float:
    return disturbances.rms_n(d, amplitude, SCENES, simulate)


def readings(d: Disturbance, amplitude: float, s: Scene) -> tuple[np.ndarray, np.ndarray]:
    t_in, t_out, _ = disturbances.in_line(d, amplitude, s, simulate)
    return disturbances.in_reading(d, amplitude, s, t_in, t_out)


@pytest.mark.parametrize("d", DRAWN, ids=range(len(DRAWN)))
def test_any_is_finite_and_absent_at_amplitude_zero(d: Disturbance) -> None:
    for s in SCENES:
        for amplitude in (0.0, 0.05, 1.0):
            t_in, t_out = readings(d, amplitude, s)
            assert np.all(np.isfinite(t_in)) and np.all(np.isfinite(t_out))
            assert t_in.shape == t_out.shape == s.time_s.shape
            if amplitude == 0.0:
                assert np.array_equal(t_in, s.tension_in_n) and np.array_equal(t_out, s.tension_out_n)
            elif d.in_line:
                assert np.array_equal(t_in, s.tension_in_n), "the sensor sits before the line"
            else:
                changed = t_out if d.place == "input reading" else t_in
                assert np.array_equal(changed, s.tension_out_n if d.place == "input reading" else s.tension_in_n)
    assert d.description


def test_draws_cover_every_place_action_carrier_and_form() -> None:
    many = [disturbances.draw(np.random.default_rng(k)) for k in range(400)]
    assert {d.place for d in many} == {*disturbances.READINGS, *disturbances.LINE}
    assert {d.action for d in many} == {"add", "multiply", "hold", "blank"}
    assert {c for d in many for c in d.carriers} == set(disturbances.CARRIERS)
    assert {f.form for d in many for f in d.functions} == set(FORMS)
    assert len({d.systems for d in many}) == 3
    assert len({d.description for d in many}) > 390, "hardly two alike"


@pytest.mark.parametrize("asked_n", [0.02, 0.2])
def test_drawn_one_has_the_asked_size(asked_n: float) -> None:
    for k in range(6):
        d, amplitude, reached = disturbances.draw_at(np.random.default_rng(k), asked_n, gap)
        assert reached == gap(d, amplitude)
        assert asked_n / 1.25 < reached < asked_n * 1.25


def test_size_that_nothing_reaches_is_refused() -> None:
    with pytest.raises(SstlError, match="E722|reaches"):
        disturbances.draw_at(np.random.default_rng(0), 1e4, gap)


def test_friction_that_is_multiplied_is_a_play_with_that_theta() -> None:
    waves = RandomFunction("waves", "none", (2.0,), 0.0, 1)
    d = Disturbance("friction", "multiply", ("time_s",), (waves,), ("act", "sstl"), 0)
    s = SCENES[0]
    factor = 1.0 + disturbances.FULL_SHARE * 0.1 * waves(s.time_s)
    _, out, _ = disturbances.in_line(d, 0.1, s, simulate)
    assert np.allclose(out, play(s.tension_in_n, THETA * factor))
    assert np.std(waves(np.linspace(0.0, 20.0, 4001))) == pytest.approx(1.0, rel=1e-3)


def test_load_change_is_felt_only_while_the_line_is_held() -> None:
    ramp = RandomFunction("waves", "none", (4.0,), 0.0, 2)
    d = Disturbance("after friction", "add", ("time_s",), (ramp,), ("act", "sstl"), 0)
    s = SCENES[0]
    _, out, _ = disturbances.in_line(d, 0.1, s, simulate)
    step = np.abs(np.diff(s.tension_out_n, prepend=s.tension_out_n[0]))
    # the sample in which a slide begins or ends is in between
    slides, held = step > 0.2 * np.abs(np.diff(s.tension_in_n, prepend=s.tension_in_n[0])) + 1e-9, step == 0.0
    assert np.allclose(out[slides], s.tension_out_n[slides], rtol=0.0, atol=1e-12)
    assert np.abs(out - s.tension_out_n)[held].max() > 0.1


def test_sticking_reading_repeats_its_last_value() -> None:
    d = Disturbance("output reading", "hold", (), (), ("act",), 0, event_s=0.5)
    s, noisy = SCENES[0], SCENES[0].tension_out_n + 0.01 * np.random.default_rng(0).standard_normal(SCENES[0].time_s.size)
    _, seen = disturbances.in_reading(d, 0.5, s, s.tension_in_n, noisy)
    stuck = np.flatnonzero(seen != noisy)
    assert np.array_equal(seen[stuck], seen[stuck - 1])
    assert 0.2 < stuck.size / seen.size < 0.4, "about 0.3"
    other = Scene("sstl", *[getattr(s, n) for n in ("order", "time_s", "tension_in_n", "tension_out_n", "position_in_mm")])
    assert disturbances.in_reading(d, 0.5, other, s.tension_in_n, noisy)[1] is noisy


@pytest.mark.parametrize("simulator", ["rig", pytest.param("bristle", marks=pytest.mark.slow)])
def test_factor_on_friction_reaches_the_simulators(simulator: str) -> None:
    """A factor of 1.2 on friction lowers the pulling line of a rig to exp(-1.2 theta)."""
    from sstl_cli.physics import bristle, rig

    time = np.arange(400) / 100.0
    command, factor = np.linspace(5.0, 25.0, 400), np.full(400, 1.2)
    beside = disturbances.as_neighbour(factor, simulator)
    effects = {"tendon_crosstalk": {"c_bend_per_n": disturbances.NEIGHBOUR_PER_N}}
    if simulator == "rig":
        run = rig.RigRun("act", THETA, "CP", time, "tension", command, beside)
        out = rig.simulate_rig(rig.RigSpec(), run, effects, rig.QUIET).true_tension_out_n
    else:
        given = bristle.BristleRun("act", THETA, "CP", time, "tension", command, beside)
        out = bristle.simulate_bristle(bristle.BristleSpec(), given, effects, bristle.NoiseSpec(white_n=0.0)).true_tension_out_n
    assert out[-1] / 25.0 == pytest.approx(np.exp(-1.2 * THETA), rel=0.01)


def test_equal_seeds_give_equal_functions() -> None:
    x = np.linspace(-3.0, 50.0, 500)
    for form in FORMS:
        f = RandomFunction(form, "none", (1.5,), 0.4, 9)
        assert np.array_equal(f(x), f(x))
        assert np.any(f(x) != RandomFunction(form, "none", (1.5,), 0.4, 10)(x))
        size = np.sqrt(np.mean(f(np.linspace(0.0, 300.0, 30001)) ** 2))
        assert 0.3 < size < 3.0, form


def test_what_the_catalogue_has_a_name_for_is_known_by_it() -> None:
    over_runs = Disturbance("friction", "multiply", ("run",), (), ("act", "sstl"), 1)
    assert over_runs.listed == ("friction_drift",)
    assert Disturbance("output reading", "hold", (), (), ("act",), 1).listed == ("acquisition_faults",)
    for other in (
        Disturbance("friction", "multiply", ("run", "load_n"), (), ("act",), 1),
        Disturbance("friction", "multiply", ("time_s",), (), ("act",), 1),
    ):
        assert other.listed == ()
