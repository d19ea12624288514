"""Table IV: identify three configurations, map, and track both references under given settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control import references
from sstl_cli.control.controller import Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop
from sstl_cli.control.scoring import WINDOW_STEADY
from sstl_cli.core.rng import stream
from sstl_cli.mapping.pairs import pairs_of
from sstl_cli.paper import table_iii
from sstl_cli.paper.scores import tracking_entries
from sstl_cli.paper.settings import FITTED, METHODS, STATED, Settings
from sstl_cli.paper.table_i_ii import Slopes, identify
from sstl_cli.paper.table_i_ii import run as run_slopes
from sstl_cli.physics.generator import generate
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory, load
from sstl_cli.steps import compensate
from sstl_cli.steps.compensate import Case, Result

Array = NDArray[np.float64]
Key = tuple[str, str, str]
Predict = Callable[[Array], Array]
LEAD_MM = 50.0
CYCLES = 3


@dataclass(frozen=True)
class Prepared:
    """The tracked configurations (truth) and what was identified and mapped for them, by location."""

    truth: dict[str, Configuration]
    cases: dict[str, Case]


@dataclass(frozen=True)
class Block:
    """One block of Table IV: settings, entries, and every result with its tracks."""

    settings: Settings
    entries: dict[Key, float]
    results: tuple[Result, ...]


def tracked(seed: int) -> dict[str, Configuration]:
    """Return the configuration at 50 mm of lead at each location; training must leave these out."""
    drawn = generate("paper-150", stream(seed, "configurations"))
    return {str(c.location): c for c in drawn if c.lead_mm == LEAD_MM}


def prepare(seed: int, predict: Predict, biases: tuple[float, float]) -> Prepared:
    """Probe the sensing loop (12 s trapezoid) and the actuation tendon (sinusoid, for DI), identify and map.

    Parameters
    ----------
    predict : callable
        Maps sensing-loop slopes, shape (n, 2), to actuation slopes.
    biases : tuple of float
        Pre-calibrated beta_p and beta_r of the actuation tendon (N).
    """
    truth = tracked(seed)
    probes = (
        Trajectory(kind="trapezoid", systems=("sstl",), duration_s=12.0),
        Trajectory(kind="sinusoid", systems=("act",), duration_s=100.0, low_n=1.0, high_n=30.0),
    )
    scenario = Scenario(schema="sstl.scenario/1", configurations=tuple(truth.values()), trajectories=probes, noise=NoiseSection())
    theta, _ = identify(scenario, seed)
    found, _ = compensate.cases_of(theta)
    mapped, _ = compensate.with_mapping(found, predict, biases)
    return Prepared(truth, {str(c.location): c for c in mapped})


def biases(slopes: Slopes) -> tuple[float, float]:
    """Return the pre-calibrated biases of the actuation tendon (N): means over Table I's configurations."""
    return slopes.entries["bias", "act_beta_p", "mean"], slopes.entries["bias", "act_beta_r", "mean"]


def draw(seed: int) -> dict[str, dict[Key, float]]:
    """Return Tables I, II and IV of one data set by block: its own configurations, noise, mapping and references."""
    slopes = run_slopes(seed)
    pairs = pairs_of(identify(load("paper-150"), seed)[0])
    predict = table_iii.handed_on(pairs, tuple(c.id for c in tracked(seed).values()), seed)
    prepared = prepare(seed, predict, biases(slopes))
    stated, fitted = (block(s, prepared, seed).entries for s in (STATED, FITTED))
    return {STATED.name: {**slopes.entries, **stated}, FITTED.name: fitted}


def block(settings: Settings, prepared: Prepared, seed: int, methods: Sequence[str] = METHODS) -> Block:
    """Return Table IV under the given settings."""
    cases = {place: _case(settings, prepared, place) for place in prepared.cases}
    plants = {c.config_id: Plant(PlayTendon(plant_lines(settings, prepared, p)), _loop(settings)) for p, c in cases.items()}

    def wanted(case: Case) -> list[references.Reference]:
        low, high = settings.random_n[str(case.location)]
        return [
            references.sinusoid(cycles=CYCLES, amplitude_n=settings.amplitude_n, offset_n=settings.offset_n),
            references.random(stream(seed, "reference", str(case.location)), low_n=low, high_n=high),
        ]

    done = tuple(compensate.run(cases.values(), wanted, lambda c: plants[c.config_id], methods, Options(), seed))
    return Block(settings, entries(done), done)


def entries(results: Sequence[Result], window: str = WINDOW_STEADY) -> dict[Key, float]:
    """Return the entries of Table IV, of Section V-C's summary and of the abstract."""
    return tracking_entries({(r.trajectory, r.method, str(r.case.location)): r.scores[window] for r in results})


def _loop(settings: Settings) -> TensionLoop:
    return TensionLoop(tau_s=settings.lag_s, noise_n=0.02)


def plant_lines(settings: Settings, prepared: Prepared, place: str) -> Theta:
    """Return the lines of the plant at a location under the given settings."""
    act = prepared.truth[place].act
    assert act is not None
    own = Theta(act.gamma_p, act.beta_p, act.gamma_r, act.beta_r)
    return settings.lines or (_opened(own, settings.mismatch) if settings.mismatch else own)


def _opened(lines: Theta, friction: float) -> Theta:
    return replace(lines, gamma_p=lines.gamma_p * math.exp(-friction), gamma_r=lines.gamma_r * math.exp(friction))


def _case(settings: Settings, prepared: Prepared, place: str) -> Case:
    """Return what the controller believes; with other lines of the plant, its errors stay as identified and mapped."""
    case, act = prepared.cases[place], prepared.truth[place].act
    if settings.lines is None or act is None:
        return case
    true = (act.gamma_p, act.beta_p, act.gamma_r, act.beta_r)
    before = _opened(settings.lines, -settings.mismatch)

    def moved(lines: Theta | None) -> Theta | None:
        if lines is None:
            return None
        return Theta(
            before.gamma_p * lines.gamma_p / true[0],
            before.beta_p + lines.beta_p - true[1],
            before.gamma_r * lines.gamma_r / true[2],
            before.beta_r + lines.beta_r - true[3],
        )

    return replace(case, act=moved(case.act), mapped=moved(case.mapped))
