"""Better than the paper: the published pipeline on the rig, then one means after the other, without a distal sensor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control import references
from sstl_cli.control.controller import IDENTITY, Options, Theta
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.paper.bench import ModelBench
from sstl_cli.paper.diagnosed import completed
from sstl_cli.paper.rig import LAG_S, TABLE_II, Bend, bends, identified, lines_of, recorded, slow_sine, tracked, trapezoid
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
TARGETS_N = {"sinusoid": 0.45, "random": 0.86}
CALIBRATION_BENDS = 12
DIAGNOSED_BENDS = 2
PRESLIDING = 0.2


@dataclass(frozen=True)
class Calibration:
    """What is learned once, with a distal sensor: linear maps from the sensing loop, mean biases, a simulator.

    The simulator is that of Table II's effects with what ``sstl diagnose`` adds to it on two bends a location.
    ``slopes`` has the shape (3, 2): act slopes from (Gamma_p, Gamma_r, 1) of the sensing loop; ``all_four``
    (5, 4): slopes and biases from its four parameters and 1.
    """

    slopes: Array
    all_four: Array
    biases: tuple[float, float]
    simulator: ModelBench

    def mapped(self, sstl: Theta) -> Theta:
        """Return the paper's mapping: slopes from slopes, constant biases."""
        gp, gr = np.array([sstl.gamma_p, sstl.gamma_r, 1.0]) @ self.slopes
        return Theta(float(gp), self.biases[0], float(gr), self.biases[1])

    def with_biases(self, sstl: Theta) -> Theta:
        """Return slopes and biases mapped from slopes and biases."""
        return Theta(*(float(v) for v in np.array([sstl.gamma_p, sstl.beta_p, sstl.gamma_r, sstl.beta_r, 1.0]) @ self.all_four))


@dataclass(frozen=True)
class Rung:
    """One set of means and what it reaches: RMSE (N) of every bend by trajectory, and the bends it failed on."""

    name: str
    rmse_n: dict[str, tuple[float, ...]]
    std_n: dict[str, tuple[float, ...]]
    mape_pct: dict[str, tuple[float, ...]]

    def mean(self, trajectory: str) -> float:
        return float(np.mean(self.rmse_n[trajectory]))


PUBLISHED = Options()


@dataclass(frozen=True)
class Way:
    """Where the lines come from, and how the controller uses them."""

    name: str
    lines: str
    options: Options = PUBLISHED
    compensate: bool = True


LEAD = Options(lead_s=LAG_S)
PLAY = Options(lead_s=LAG_S, reversal="play")
EVERYTHING = Options(lead_s=LAG_S, reversal="play", presliding=PRESLIDING)
NO_LEAD = Options(reversal="play", presliding=PRESLIDING)
WAYS = (
    Way("no compensation", "mapped", compensate=False),
    Way("direct identification (distal sensor)", "direct"),
    Way("the paper's pipeline", "mapped"),
    Way("+ biases mapped", "biases"),
    Way("+ physics-informed mapping", "physics"),
    Way("+ loop-lag lead", "physics", LEAD),
    Way("+ exact inverse at reversals", "physics", PLAY),
    Way("+ presliding followed (all means)", "physics", EVERYTHING),
    Way("all means, but biases constant", "mapped", EVERYTHING),
    Way("all means, but no physics", "biases", EVERYTHING),
    Way("all means, but no lead", "physics", NO_LEAD),
    Way("all means, but Algorithm 1 at reversals", "physics", LEAD),
    Way("all means on directly identified lines", "direct", EVERYTHING),
)
ALL_MEANS = "+ presliding followed (all means)"


def calibrate(seed: int) -> Calibration:
    """Record both systems at calibration bends, identify them, and fit maps and effects.

    Raises
    ------
    SstlError
        If too few bends could be identified for a map of five coefficients.
    """
    sets = bends(CALIBRATION_BENDS, stream(seed, "better", "calibration"))
    runs = {(b.name, s): recorded(b, s, *trapezoid(s), seed) for b in sets for s in ("act", "sstl")}
    found = {key: lines_of(identified(run)) for key, run in runs.items()}
    rows = [(a, s) for b in sets if (a := found[b.name, "act"]) is not None and (s := found[b.name, "sstl"]) is not None]
    if len(rows) < 8:
        raise SstlError(f"only {len(rows)} of {len(sets)} calibration bends could be identified", code="E802")
    act, sstl = (np.array([_vector(r[i]) for r in rows]) for i in (0, 1))
    ones = np.ones((len(rows), 1))
    slopes = np.linalg.lstsq(np.hstack([sstl[:, [0, 2]], ones]), act[:, [0, 2]], rcond=None)[0]
    all_four = np.linalg.lstsq(np.hstack([sstl, ones]), act, rcond=None)[0]
    used = [b for i, b in enumerate(sets) if i % CALIBRATION_BENDS < DIAGNOSED_BENDS]
    known: list[Run] = [runs[b.name, s] for b in used for s in ("act", "sstl")]
    biases = (float(act[:, 1].mean()), float(act[:, 3].mean()))
    scenario, _ = completed(Scenario(effects=TABLE_II), known, workers=1)
    return Calibration(slopes, all_four, biases, ModelBench(scenario))


def sources(calibration: Calibration, bend: Bend, seed: int) -> dict[str, Theta]:
    """Return the actuation lines of a new bend by every means; only ``direct`` used its distal sensor."""
    probe = recorded(bend, "sstl", *trapezoid("sstl"), seed)
    sstl = lines_of(identified(probe))
    direct = lines_of(identified(recorded(bend, "act", *slow_sine(), seed)))
    physics = calibration.simulator.lines(bend, calibration.simulator.theta(probe))
    if sstl is None or direct is None or physics is None:
        raise SstlError(f"bend {bend.name} could not be identified", code="E802")
    return {"mapped": calibration.mapped(sstl), "biases": calibration.with_biases(sstl), "physics": physics, "direct": direct}


def tracked_bends(seed: int) -> list[Bend]:
    """Return the bends that are tracked, one a location, none of them a calibration bend."""
    return [replace(b, name=f"{b.location}-test") for b in bends(1, stream(seed, "better", "test"))]


def run(
    seed: int, calibration: Calibration | None = None, ways: Sequence[Way] = WAYS, advance: Callable[[float], None] | None = None
) -> list[Rung]:
    """Return what every way reaches on the rig, on both references, at one bend a location."""
    learned = calibration or calibrate(seed)
    tests = tracked_bends(seed)
    lines = {b.name: sources(learned, b, seed) for b in tests}
    done = []
    for way in ways:
        scores: dict[str, list[tuple[float, float, float]]] = {"sinusoid": [], "random": []}
        for bend in tests:
            for reference in (references.sinusoid(cycles=2), references.random(stream(seed, "reference", bend.location), duration_s=200.0)):
                own = lines[bend.name][way.lines] if way.compensate else IDENTITY
                s, _ = tracked(bend, own, reference, way.options, way.compensate, seed)
                scores[reference.name].append((s.rmse_n, s.std_n, s.mape_pct if s.mape_pct is not None else float("nan")))
        columns = [{t: tuple(v[i] for v in values) for t, values in scores.items()} for i in range(3)]
        done.append(Rung(way.name, *columns))
        if advance is not None:
            advance(1)
    return done


def _vector(t: Theta) -> tuple[float, float, float, float]:
    return t.gamma_p, t.beta_p, t.gamma_r, t.beta_r
