"""The rig of law variants without effects: capstan lines, play, energy, convergence, and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.variant import (
    QUIET,
    NoiseSpec,
    VariantRun,
    VariantSpec,
    known_laws,
    march_variant,
    parameters,
    resolve_effects,
    simulate_variant,
)

HZ = 100.0


def movement(seconds: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    """Return instants (s) and a command (N) with loops, minor loops and holds."""
    time = np.arange(round(seconds * HZ)) / HZ
    places = np.array([0.0, 4, 7, 11, 15, 17, 21, 23, 26, 30]) * seconds / 30.0
    return time, np.interp(time, places, [3.0, 22, 22, 2, 2, 18, 6, 15, 4, 20])


def run(system: str = "act", theta: float = 0.5, location: str | None = "CP", seconds: float = 30.0) -> VariantRun:
    time, command = movement(seconds)
    return VariantRun(system, theta, location, time, "tension", command)


def played(command: np.ndarray, theta: float, start: float) -> np.ndarray:
    """Return Eq. (3) and (5) of the paper: the output is held between exp(-theta) and exp(theta) times the input."""
    out, held = [], start
    for tension in command:
        held = min(max(held, tension * math.exp(-theta)), tension * math.exp(theta))
        out.append(held)
    return np.array(out)


@pytest.mark.parametrize("location", ["NP", "CP", "ND", None])
@pytest.mark.parametrize(("system", "passes"), [("act", 1), ("sstl", 2)])
@pytest.mark.parametrize("theta", [0.0, 0.3, 0.7])
def test_base_is_the_capstan_play(system: str, passes: int, theta: float, location: str | None) -> None:
    given = run(system, theta, location)
    found = march_variant(VariantSpec(pretension_n=5.0), given)
    assert np.allclose(found.tension_out_n, played(given.command, passes * theta, 5.0), atol=1e-9)
    assert found.unconverged == 0
    assert found.min_step_dissipation_j >= 0.0


def test_position_is_stretch_of_load_and_tendon() -> None:
    """Without friction the tension is the same everywhere: x = (T - T0) (1 / k + L / EA)."""
    given = run("sstl", 0.0)
    found = march_variant(VariantSpec(), given)
    expected = (given.command - 5.0) * (1.0 / 8.0 + 2 * 2000.0 / 8000.0)
    assert np.allclose(found.position_in_mm, expected, atol=1e-9)


def test_energy_of_closed_loops_goes_into_friction() -> None:
    """Over closed loops nothing stays in tendon and load: the work of the drive is what friction has dissipated."""
    time = np.arange(4001) / HZ
    command = 12.0 - 8.0 * np.cos(2.0 * np.pi * time / 10.0)
    found = march_variant(VariantSpec(), VariantRun("act", 0.5, "ND", time, "tension", command))
    last = slice(3000, 4001)
    x, tension = found.position_in_mm[last], found.tension_in_n[last]
    work = float(np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(x))) * 1e-3
    first = march_variant(VariantSpec(), VariantRun("act", 0.5, "ND", time[:3001], "tension", command[:3001]))
    assert work == pytest.approx(found.dissipated_j - first.dissipated_j, rel=2e-3)
    assert work > 0.0


def test_every_effect_of_the_catalogue_has_another_law() -> None:
    known = {e: {p.name for p in effect.parameters} for e, effect in catalogue().items()}
    assert set(known_laws()) == set(parameters()) == set(known)
    # the fast model may have further laws of its own
    assert all(set(table) <= known[e] for e, table in parameters().items())
    assert all(len({law.id for law in laws}) == len(laws) >= 1 for laws in known_laws().values())


def test_neutral_values_change_nothing() -> None:
    given = run("sstl")
    plain = simulate_variant(VariantSpec(law_seed=1), given, {}, NoiseSpec(), 3)
    neutral = {e: {k: b.neutral for k, b in table.items()} for e, table in parameters().items()}
    same = simulate_variant(VariantSpec(law_seed=1), given, neutral, NoiseSpec(), 3)
    for name in ("time_s", "tension_in_n", "tension_out_n", "position_in_mm"):
        assert np.array_equal(getattr(plain, name), getattr(same, name)), name


@pytest.mark.parametrize(
    ("build", "part"),
    [
        (lambda: VariantSpec(nodes=2), "nodes = 2"),
        (lambda: VariantSpec(load_k1_n_per_mm=0.0), "load_k1_n_per_mm = 0.0"),
        (lambda: VariantRun("act", 4.0, None, *_short()), "theta = 4.0"),
        (lambda: VariantRun("both", 0.4, None, *_short()), "system = 'both'"),
        (lambda: NoiseSpec(white_n=-1.0), "white_n = -1.0"),
        (lambda: resolve_effects({"viscos": {}}), "did you mean 'viscous'"),
        (lambda: resolve_effects({"viscous": {"c": 1.0}}), "parameter of viscous 'c'"),
        (lambda: resolve_effects({"viscous": {"c_l_n_s_per_mm": 0.11}}), "outside 0..0.1"),
        (lambda: march_variant(VariantSpec(laws={"viscous": "eyrin"}), run()), "did you mean 'eyring'"),
        (lambda: march_variant(VariantSpec(laws={"drag": "eyring"}), run()), "unknown effect 'drag'"),
        (lambda: march_variant(VariantSpec(), run(location="XX")), "location = 'XX'"),
    ],
)
def test_refuses(build: object, part: str) -> None:
    with pytest.raises(ValueError, match="(variant|noise): ") as caught:
        build()  # type: ignore[operator]
    assert part in str(caught.value)


def _short() -> tuple[np.ndarray, str, np.ndarray]:
    return np.array([0.0, 0.1]), "tension", np.array([1.0, 2.0])


def test_seed_decides_everything() -> None:
    given, effects = run(), {"zero_drift": {"r_out_act_n": 0.5}, "viscous": {"c_l_n_s_per_mm": 0.05}}
    one, same, other = (simulate_variant(VariantSpec(), given, effects, QUIET, s) for s in (4, 4, 5))
    assert np.array_equal(one.tension_out_n, same.tension_out_n)
    assert not np.array_equal(one.tension_out_n, other.tension_out_n)
    drawn = {simulate_variant(VariantSpec(law_seed=s), given, effects, QUIET, 4).laws["viscous"] for s in range(12)}
    assert drawn == {"curvature", "power", "eyring"}
