"""Contract of every effect in the catalogue; a new file beside the others is covered by itself."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from program import inside

from sstl_cli.blind.strength import direction
from sstl_cli.core.errors import SstlError
from sstl_cli.physics import effects as package
from sstl_cli.physics.effect import STAGES, Law, Mechanics, Sampling
from sstl_cli.physics.effects import catalogue, get, parse
from sstl_cli.physics.rig import QUIET, RigRun, RigSpec, simulate_rig
from sstl_cli.physics.rig import effects as hardware
from sstl_cli.physics.transmission import activate, measure, predict, predict_position
from sstl_cli.physics.transmission.model import drive_of, observed_output, true_input

DT = 0.01
T = np.arange(6000) * DT
PATH = 17.0 + 14.0 * np.interp(T % 20, [0, 4, 5, 9, 12, 13, 18, 19, 20], [-1, 1, 1, -0.3, 0.5, 0.5, -1, -1, -1])
BESIDE = 12.0 + 10.0 * np.sin(0.7 * T)
THETA = 0.53
ALL = sorted(catalogue())


def response(effect_id, values, system="act", path=PATH):
    """Everything that an effect may change: output, measured input, position, loop."""
    active = activate({effect_id: values})
    # another tendon is pulled beside, which only an effect between tendons may notice
    drive = replace(drive_of(system, "CP", DT, path, Mechanics()), neighbour_n=BESIDE)
    out = predict(drive, THETA, active, float(path[0]))
    seen_in, seen_out = measure(system, DT, path, out, active, np.random.default_rng(1))
    effect = get(effect_id)
    loop = effect.loop(path, DT, effect.complete(values)) if effect.loop else path
    return np.concatenate([seen_in, seen_out, predict_position(drive, THETA, active, out), loop])


@pytest.mark.parametrize("effect_id", ALL)
def test_declaration_is_complete(effect_id):
    e = get(effect_id)
    assert e.id == effect_id and e.stage in STAGES
    assert e.title and e.equation and e.source and e.excitation and e.parameters
    assert any((e.law, e.transition, e.output, e.input, e.position, e.loop))
    for p in e.parameters:
        assert p.unit and p.meaning and p.low <= p.neutral <= p.high and p.low < p.high
        # a strength may be there or not, and nothing in between
        assert (p.least <= p.low or p.least > p.neutral) and p.high <= p.most
    assert not e.active(e.neutral())


@pytest.mark.parametrize("effect_id", ALL)
@pytest.mark.parametrize("system", ["act", "sstl"])
def test_neutral_is_exactly_the_identity(effect_id, system):
    base = response("gain_error", {}, system)
    assert np.array_equal(response(effect_id, get(effect_id).neutral(), system), base)


@pytest.mark.parametrize("effect_id", ALL)
def test_finite_at_all_bounds(effect_id):
    e = get(effect_id)
    for side in ("low", "high", "least", "most"):
        values = {p.name: getattr(p, side) for p in e.parameters}
        for system in e.systems:
            assert np.isfinite(response(effect_id, values, system)).all()


@pytest.mark.parametrize("effect_id", ALL)
def test_every_parameter_changes_something(effect_id):
    e = get(effect_id)
    path = np.maximum(PATH - 5.0, 0.0)
    strong = {p.name: p.neutral + 0.95 * ((p.high if p.high > p.neutral else p.low) - p.neutral) for p in e.parameters}
    if effect_id == "saturation":
        strong = {"t_max_in_n": 20.0, "t_max_out_n": 6.3, "soft_out": 0.9, "knee_n": 6.0, "width_n": 0.3, "knee_sstl_n": 7.0}
    for p in e.parameters:
        other = dict(strong)
        other[p.name] = p.neutral if not p.shape else (p.low if strong[p.name] != p.low else p.high)
        systems = [p.system] if p.system else list(e.systems)
        changed = [not np.array_equal(response(effect_id, strong, s, path), response(effect_id, other, s, path)) for s in systems]
        assert any(changed), p.name


@pytest.mark.parametrize(
    "effect_id", [e.id for e in catalogue().values() if e.fitted and e.channel == "out" and e.id not in ("stribeck", "stick_slip")]
)
def test_step_refinement_converges(effect_id):
    e = get(effect_id)
    name = e.parameters[0].name
    values = {name: e.parameters[0].neutral + 0.2 * (e.parameters[0].high - e.parameters[0].neutral)}

    def output(factor):
        time = np.arange(6000 * factor) * DT / factor
        path = np.interp(time, T, PATH)
        drive = drive_of("act", "CP", DT / factor, path, Mechanics())
        active = activate({effect_id: values})
        out = observed_output("act", DT / factor, path, predict(drive, THETA, active, 3.0), active)
        return out[::factor]

    coarse, fine, finest = output(1), output(2), output(4)
    first, second = np.sqrt(np.mean((coarse - finest) ** 2)), np.sqrt(np.mean((fine - finest) ** 2))
    assert second <= max(first, 0.02)
    assert second < 0.05


LINES = {
    # EFFECTS.md at theta = 0.53: change of ln Gp, ln Gr, beta_p, beta_r (N), by system
    "pulley_friction": ({"m_p": 0.1, "m_r": 0.1}, "sstl", (-0.1, 0.1, 0.0, 0.0)),
    "gain_error": ({"g_act": 0.95}, "act", (np.log(0.95), np.log(0.95), 0.0, 0.0)),
    "asymmetric_friction": ({"a": 0.1}, "act", (-0.053, -0.053, 0.0, 0.0)),
    "zero_offset": ({"z_out_act_n": 0.3}, "act", (0.0, 0.0, 0.3, 0.3)),
}


@pytest.mark.parametrize("effect_id", sorted(LINES))
def test_fingerprint(effect_id):
    values, system, expected = LINES[effect_id]
    n = 2 if system == "sstl" else 1
    path = np.interp(np.arange(8000) * DT, [0, 20, 40, 60, 80], [0.2, 40, 0.2, 40, 0.2])
    active = activate({effect_id: values})
    drive = drive_of(system, "CP", DT, path, Mechanics())
    true = predict(drive, THETA, active, 0.2)
    out = observed_output(system, DT, path, true, active)
    moving = np.abs(np.gradient(true)) > 1e-6
    rising = np.gradient(path) > 0
    late = np.arange(len(path)) > 2200
    gp, bp = np.polyfit(path[late & moving & rising], out[late & moving & rising], 1)
    gr, br = np.polyfit(path[late & moving & ~rising], out[late & moving & ~rising], 1)
    found = (np.log(gp) + n * THETA, np.log(gr) - n * THETA, bp, br)
    assert found == pytest.approx(expected, abs=0.01)


def test_unknown_names_answer_with_the_nearest():
    with pytest.raises(SstlError, match="pulley_friction"):
        get("puley_friction")
    with pytest.raises(SstlError, match="m_p"):
        parse("pulley_friction:mp=0.1")
    with pytest.raises(SstlError, match=r"outside 0\.\.0\.25 1"):
        parse("pulley_friction:m_p=3")
    # further than usual, but it has a meaning: a scenario may say so
    assert get("pulley_friction").complete({"m_p": 0.5})["m_p"] == 0.5
    with pytest.raises(SstlError, match=r"outside 0\.\.2\.5 1"):
        get("pulley_friction").complete({"m_p": 3.0})
    with pytest.raises(SstlError, match="param=value"):
        parse("pulley_friction:m_p")


def test_a_dropped_in_effect_is_found(tmp_path, monkeypatch):
    (tmp_path / "magic_scale.py").write_text(
        "from sstl_cli.physics.effect import INSTRUMENT, Effect, Parameter\n"
        "EFFECT = Effect(id='magic_scale', title='Scale', stage=INSTRUMENT, equation='T g', source='test',\n"
        "    parameters=(Parameter('g', '1', 1.0, 0.5, 2.0, 'gain'),), excitation='any',\n"
        "    output=lambda t, other, run, v: t * v['g'])\n"
    )
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    catalogue.cache_clear()
    try:
        assert "magic_scale" in catalogue()
        scaled = response("magic_scale", {"g": 2.0})
        n = len(PATH)
        assert scaled[n : 2 * n] == pytest.approx(2.0 * response("gain_error", {})[n : 2 * n])
    finally:
        monkeypatch.undo()
        catalogue.cache_clear()


def test_an_effect_of_another_simulator_is_refused():
    from sstl_cli.physics.bristle import effects as bristle
    from sstl_cli.physics.bristle.effect import Effect as OfBristle
    from sstl_cli.physics.given import discovered
    from sstl_cli.physics.rig.effect import Effect as OfRig

    assert discovered(OfBristle, bristle.__name__, bristle.__path__) == bristle.catalogue()
    with pytest.raises(TypeError, match=r"bristle.effects.\w+.EFFECT is no sstl_cli.physics.rig.effect.Effect"):
        discovered(OfRig, bristle.__name__, bristle.__path__)


def files_of_contributing(folder: Path) -> dict[str, str]:
    """Write the files that CONTRIBUTING shows for an effect as far as their packages, and return the folder of each package."""
    text = Path(__file__).parents[2].joinpath("CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.split("## Add an effect")[1].split("\n## ")[0]
    found = {}
    for block in re.findall(r"```python\n(.*?)```", section, re.DOTALL):
        body = textwrap.dedent(block)
        name, place = body.splitlines()[0].removeprefix("# ").split(" in ")
        folder.joinpath(place).mkdir(parents=True)
        folder.joinpath(place, name).write_text(body, encoding="utf-8")
        found[".".join(Path(place).parts)] = str(folder / place)
    return found


@pytest.mark.slow
def test_an_effect_added_as_contributing_says_is_simulated_recorded_and_named(tmp_path, monkeypatch):
    """These two files and nothing else: one for the catalogue, along the line, and one for the rig."""
    added = {"sstl_cli.physics.effects": package, "sstl_cli.physics.rig.effects": hardware}
    folders = files_of_contributing(tmp_path)
    assert set(folders) == set(added)
    for name, where in added.items():
        monkeypatch.setattr(where, "__path__", [*where.__path__, folders[name]])
        where.catalogue.cache_clear()
    try:
        base = response("presliding", {})
        assert np.array_equal(response("sticky_line", {}), base)
        half = response("presliding", {"breakaway_mm": 0.5, "spread": 0.0})
        assert np.array_equal(response("sticky_line", {"distance_mm": 1.0}), half) and not np.array_equal(half, base)
        assert rig_response("sticky_line", {}) == rig_response("presliding", {})
        assert rig_response("sticky_line", {"distance_mm": 1.0}) == rig_response("presliding", {"breakaway_mm": 0.5, "spread": 0.0})
        assert direction("sticky_line", np.random.default_rng(1), 30.0, 20.0).at(0.5) == {"distance_mm": 1.5}
        done = inside("effects", "list", "--json")
        assert "sticky_line" in done.stdout
        log = tmp_path / "log.parquet"
        for simulator in ("rig", "transmission"):
            made = ("--scenario", "sample", "--simulator", simulator, "--effect", "sticky_line:distance_mm=1.5")
            done = inside("simulate", *made, "--seed", 1, "--out", log, "--force")
            assert done.returncode == 0, done.stderr
        few = ("--effects", "sticky_line,viscous", "--max-effects", 1)
        done = inside("diagnose", log, *few, "--out", tmp_path / "d.json")
        found = json.loads((tmp_path / "d.json").read_text())["candidates"][0]
        assert found["id"] == "sticky_line" and found["parameters"][0]["estimate"] == pytest.approx(1.5, rel=0.1)
        done = inside("report", log, tmp_path / "d.json", "--out", tmp_path / "page.html")
        assert "sticky line" in (tmp_path / "page.html").read_text()
    finally:
        monkeypatch.undo()
        for where in added.values():
            where.catalogue.cache_clear()


def rig_response(effect_id, values):
    """What the elastic rig records with one effect."""
    run = RigRun("act", THETA, "CP", T[:1200], "tension", PATH[:1200])
    return simulate_rig(RigSpec(nodes=10), run, {effect_id: values}, QUIET).tension_out_n.tolist()


def test_a_common_mount_shows_the_sum_of_both_tensions() -> None:
    pull, beside = np.array([10.0, 20.0]), np.array([6.0, 1.0])
    effect, run = get("crosstalk"), Sampling("act", 0.01, 2)
    values = effect.complete({"m_out": 0.02, "m_in": 0.01, "c_out_to_in": 0.03})
    assert np.allclose(effect.output(beside, pull, run, values), [6.32, 1.42])
    seen = effect.input(pull, beside, run, values)
    assert np.allclose(seen, [10.34, 20.24])
    assert np.allclose(effect.input_inverse(seen, beside, run, values), pull, rtol=1e-14)


def test_a_curved_sensor_is_undone_exactly_however_curved() -> None:
    tension = np.array([0.5, 10.0, 25.0, 49.0])
    effect, run = get("sensor_nonlinearity"), Sampling("act", 0.01, 4)
    for a in (-0.5, 0.02, 0.6):
        values = effect.complete({"a_in": a})
        assert np.allclose(effect.input_inverse(effect.input(tension, tension, run, values), tension, run, values), tension, rtol=1e-12)


@pytest.mark.parametrize(
    ("closing", "grown"),
    [
        (0.0, lambda t: t),
        (0.1, lambda t: 10.0 * (1.0 - np.exp(-t / 10.0))),  # coils that close
        (-0.01, lambda t: 100.0 * (np.exp(t / 100.0) - 1.0)),  # a tube that buckles
    ],
)
def test_a_sheath_yields_by_its_law(closing: float, grown: Callable[[np.ndarray], np.ndarray]) -> None:
    law, t = Law(), np.array([1.0, 8.0, 30.0])
    effect = get("sheath_compliance")
    effect.law(law, effect.complete({"c_t_per_n": 0.006, "closing_per_n": closing}))
    assert np.allclose(law.factors[0](t), 1.0 + 0.006 * grown(t), rtol=1e-12)


@pytest.mark.filterwarnings("error")
def test_friction_without_end_holds_the_line_and_stays_a_number():
    for theta in (1e3, -1e3):
        out = predict(drive_of("sstl", "CP", DT, np.maximum(PATH - PATH.min(), 0.0), Mechanics()), theta, activate({}), 5.0)
        assert np.isfinite(out).all()
    assert predict(drive_of("act", "CP", DT, PATH, Mechanics()), 1e3, activate({}), 5.0) == pytest.approx(np.full(len(PATH), 5.0))


def test_hysteresis_of_a_sensor_is_a_part_of_its_reading_behind_plays():
    sensor = get("sensor_nonlinearity")

    def read(system, **values):
        return sensor.output(PATH, PATH, Sampling(system, DT, len(PATH), begin_n=float(PATH[0])), sensor.complete(values))

    assert np.array_equal(read("act", h_act_n=0.2), read("act", h_n=0.2)) and np.array_equal(read("sstl", h_act_n=0.2), PATH)
    assert np.array_equal(read("sstl", k_act=0.1, width_n=1.0), PATH)
    # past every play a pull reads k times their mean half-width low, a release as much high
    off = read("act", k_act=0.1, width_n=1.0) - PATH
    mean = 0.1 * (0.3 + 1.0 + 3.0) / 3.0
    assert (off.min(), off.max()) == pytest.approx((-mean, mean))
    # and comes round gradually: between them there are more than two levels
    assert len(np.unique(off.round(3))) > 50


def test_a_sensor_may_be_soft_beyond_a_knee():
    sensor, run = get("sensor_nonlinearity"), Sampling("act", DT, len(PATH))
    seen = sensor.output(PATH, PATH, run, sensor.complete({"b_out": -0.05, "knee_n": 8.0}))
    below = PATH <= 8.0
    assert np.array_equal(seen[below], PATH[below])
    assert seen[~below] == pytest.approx(PATH[~below] - 0.05 * (PATH[~below] - 8.0))
    values = sensor.complete({"b_in": 0.05, "knee_n": 8.0})
    assert sensor.input_inverse(sensor.input(PATH, PATH, run, values), PATH, run, values) == pytest.approx(PATH)


def test_a_reading_may_come_to_its_limit_softly():
    sensor, run = get("saturation"), Sampling("act", DT, len(PATH))
    soft = {"soft_out": 1.0, "knee_n": 8.0, "width_n": 0.2}
    seen = sensor.output(PATH, PATH, run, sensor.complete(soft))
    assert seen == pytest.approx(PATH - 0.2 * np.log1p(np.exp((PATH - 8.0) / 0.2)), abs=1e-9)
    assert seen.max() == pytest.approx(8.0, abs=1e-6) and seen[np.isclose(PATH, 8.0, atol=0.02)] == pytest.approx(
        8.0 - 0.2 * np.log(2.0), abs=0.02
    )
    # a tension far beyond its knee is only a number
    assert np.isfinite(sensor.output(np.array([1e9]), PATH, run, sensor.complete({**soft, "width_n": 0.05}))).all()


def test_a_preload_grows_with_the_bend_and_a_curve_may_be_of_one_sensor_alone():
    tension = np.linspace(0.0, 30.0, 61)
    still = activate({"zero_offset": {"preload_out_act_n": 0.4}})
    for theta in (0.0, THETA, 1.5 * THETA):
        assert observed_output("act", DT, tension, tension, still, theta) == pytest.approx(tension + 0.4 * theta / THETA)
        assert observed_output("sstl", DT, tension, tension, still, theta) == pytest.approx(tension)
        from_some = activate({"zero_offset": {"preload_out_act_n": 0.4, "straight_out_act_n": -0.3}})
        assert observed_output("act", DT, tension, tension, from_some, theta) == pytest.approx(tension + 0.4 * theta / THETA - 0.3)
    curved = activate({"sensor_nonlinearity": {"a_out_act": 0.02, "chord": 0.6}})
    # back on the line at 0.6 of 50 N
    seen = observed_output("act", DT, tension, tension, curved)
    assert seen == pytest.approx(tension + 0.02 * tension * (0.6 - tension / 50.0)) and seen[-1] == pytest.approx(30.0)
    assert observed_output("sstl", DT, tension, tension, curved) == pytest.approx(tension)
    # what the input's sensor does is undone
    both = activate({"sensor_nonlinearity": {"a_in_act": -0.03, "chord": 0.2, "a_in": 0.01}, "zero_offset": {"preload_in_act_n": 0.3}})
    read = measure("act", DT, tension, tension, both, theta=0.7)[0]
    assert true_input("act", DT, read, tension, both, 0.7) == pytest.approx(tension, abs=1e-9) and np.ptp(read - tension) > 0.1


def test_friction_that_warms_and_cools():
    # pulled at 2 N/s from 10 N for 5 s, then held: power is T times 2 N/s, then nothing
    time = np.arange(0.0, 20.0, 0.01)
    tension = 10.0 + 2.0 * np.minimum(time, 5.0)
    drive = drive_of("act", None, 0.01, tension, Mechanics(), np.where(time < 5.0, 2.0, 0.0))
    law = Law()
    effect = get("friction_drift")
    effect.law(law, effect.complete({"d_mu_heat_s_per_n2": 0.01, "cooling_s": 4.0}))
    factor = law.friction_scale[0](drive)
    # h' = (20 + 4 t - h) / 4 from 0: h = 4 + 4 t - 4 exp(-t / 4)
    warm = 4.0 + 4.0 * 5.0 - 4.0 * np.exp(-1.25)
    assert factor[0] == 1.0 and factor[499] == pytest.approx(1.0 + 0.01 * warm, abs=2e-3)
    assert factor[-1] == pytest.approx(1.0 + 0.01 * warm * np.exp(-15.0 / 4.0), abs=2e-3)
