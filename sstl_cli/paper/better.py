"""Better than the paper: the published pipeline on the rig, then one means after the other, without a distal sensor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control import references
from sstl_cli.control.controller import IDENTITY, Options, Theta
from sstl_cli.control.loop_lag import LoopLag
from sstl_cli.control.scoring import WINDOW_STEADY, windows
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.paper.bench import ModelBench
from sstl_cli.paper.diagnosed import completed
from sstl_cli.paper.lag_and_presliding import PRESLIDING, Fitted, fit_effects, loop_of, small_loops
from sstl_cli.paper.published import value
from sstl_cli.paper.reversal import apart
from sstl_cli.paper.rig import GAP, LAG_S, TABLE_II, Bend, bends, identified, lines_of, recorded, slow_sine, tracked, trapezoid
from sstl_cli.paper.settings import TRAJECTORIES
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
#: the paper's direct identification
TARGETS_N = {t: value("summary", f"{t} DI", "rmse") for t in TRAJECTORIES}
CALIBRATION_BENDS = 12
DIAGNOSED_BENDS = 2


@dataclass(frozen=True)
class Calibration:
    """What is learned once, with a distal sensor: linear maps from the sensing loop, mean biases, a simulator, the loop's lag.

    The simulator is that of Table II's effects with what ``sstl diagnose`` adds to it on two bends a location, and with
    ``presliding`` as fitted to small loops of the same bends. ``slopes`` has the shape (3, 2): act slopes from (Gamma_p, Gamma_r, 1) of the sensing loop; ``all_four``
    (5, 4): slopes and biases from its four parameters and 1.
    """

    slopes: Array
    all_four: Array
    biases: tuple[float, float]
    simulator: ModelBench
    lag: LoopLag
    presliding: Fitted

    def mapped(self, sstl: Theta) -> Theta:
        """Return the paper's mapping: slopes from slopes, constant biases."""
        gp, gr = np.array([sstl.gamma_p, sstl.gamma_r, 1.0]) @ self.slopes
        return Theta(float(gp), self.biases[0], float(gr), self.biases[1])

    def with_biases(self, sstl: Theta) -> Theta:
        """Return slopes and biases mapped from slopes and biases."""
        return Theta(*(float(v) for v in np.array([sstl.gamma_p, sstl.beta_p, sstl.gamma_r, sstl.beta_r, 1.0]) @ self.all_four))


@dataclass(frozen=True)
class Rung:
    """One set of means and what it reaches at every bend, by trajectory (N): RMSE, STD, MAPE (%), and the error apart.

    ``reversal_n`` is the RMSE in reversal regions, ``elsewhere_n`` that outside them, ``peak_n`` the largest error there.
    """

    name: str
    rmse_n: dict[str, tuple[float, ...]]
    std_n: dict[str, tuple[float, ...]]
    mape_pct: dict[str, tuple[float, ...]]
    reversal_n: dict[str, tuple[float, ...]]
    elsewhere_n: dict[str, tuple[float, ...]]
    peak_n: dict[str, tuple[float, ...]]

    def mean(self, trajectory: str, measure: str = "rmse_n") -> float:
        """Return the mean of a measure over the bends."""
        return float(np.mean(getattr(self, measure)[trajectory]))


@dataclass(frozen=True)
class Way:
    """Where the lines come from, and what the controller uses: lead, exact inverse, plays of presliding.

    Lag and presliding are those that were identified, or with ``known`` those of the rig, for comparison.
    """

    name: str
    lines: str
    lead: bool = False
    play: bool = False
    presliding: bool = False
    known: bool = False
    compensate: bool = True

    def options(self, calibration: Calibration, source: Source) -> Options:
        """Return how the controller acts at a bend."""
        lag_s = LAG_S if self.known else calibration.lag.tau_s
        widths = source.known_widths if self.known else source.widths
        return Options(
            lead_s=lag_s if self.lead else 0.0, reversal="play" if self.play else "paper", widths=widths if self.presliding else None
        )


@dataclass(frozen=True)
class Source:
    """What is known of a new bend: actuation lines by every means, widths of the plays as identified and with the rig's presliding."""

    lines: dict[str, Theta]
    widths: tuple[float, ...]
    known_widths: tuple[float, ...]


WAYS = (
    Way("no compensation", "mapped", compensate=False),
    Way("direct identification (distal sensor)", "direct"),
    Way("the paper's pipeline", "mapped"),
    Way("+ biases mapped", "biases"),
    Way("+ physics-informed mapping", "physics"),
    Way("+ loop-lag lead", "physics", lead=True),
    Way("+ exact inverse at reversals", "physics", lead=True, play=True),
    Way("+ presliding followed (all means)", "physics", lead=True, play=True, presliding=True),
    Way("all means, lag and presliding known", "physics", lead=True, play=True, presliding=True, known=True),
    Way("all means, but biases constant", "mapped", lead=True, play=True, presliding=True),
    Way("all means, but no physics", "biases", lead=True, play=True, presliding=True),
    Way("all means, but no lead", "physics", play=True, presliding=True),
    Way("all means on directly identified lines", "direct", lead=True, play=True, presliding=True),
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
    act, sstl = (np.array([astuple(r[i]) for r in rows]) for i in (0, 1))
    ones = np.ones((len(rows), 1))
    slopes = np.linalg.lstsq(np.hstack([sstl[:, [0, 2]], ones]), act[:, [0, 2]], rcond=None)[0]
    all_four = np.linalg.lstsq(np.hstack([sstl, ones]), act, rcond=None)[0]
    used = [b for i, b in enumerate(sets) if i % CALIBRATION_BENDS < DIAGNOSED_BENDS]
    known: list[Run] = [runs[b.name, s] for b in used for s in ("act", "sstl")]
    biases = (float(act[:, 1].mean()), float(act[:, 3].mean()))
    scenario, _ = completed(Scenario(effects=TABLE_II), known, workers=1)
    rounded = fit_effects(scenario, [recorded(b, "act", *small_loops(), seed) for b in used], PRESLIDING)
    return Calibration(slopes, all_four, biases, ModelBench(rounded.scenario), loop_of(used[0], seed), rounded)


def sources(calibration: Calibration, bend: Bend, seed: int) -> Source:
    """Return what is known of a new bend by every means; only the lines ``direct`` used its distal sensor."""
    probe = recorded(bend, "sstl", *trapezoid("sstl"), seed)
    sstl = lines_of(identified(probe))
    direct = lines_of(identified(recorded(bend, "act", *slow_sine(), seed)))
    simulator = calibration.simulator
    theta = simulator.theta(probe)
    physics = simulator.lines(bend, theta)
    if sstl is None or direct is None or physics is None:
        raise SstlError(f"bend {bend.name} could not be identified", code="E802")
    lines = {"mapped": calibration.mapped(sstl), "biases": calibration.with_biases(sstl), "physics": physics, "direct": direct}
    known = simulator.with_effect("presliding", GAP["presliding"])
    return Source(lines, simulator.widths(bend, theta, physics), known.widths(bend, theta, known.lines(bend, theta) or physics))


def tracked_bends(seed: int) -> list[Bend]:
    """Return the bends that are tracked, one a location, none of them a calibration bend."""
    return [replace(b, name=f"{b.location}-test") for b in bends(1, stream(seed, "better", "test"))]


def run(
    seed: int, calibration: Calibration | None = None, ways: Sequence[Way] = WAYS, advance: Callable[[float], None] | None = None
) -> list[Rung]:
    """Return what every way reaches on the rig, on both references, at one bend a location."""
    learned = calibration or calibrate(seed)
    tests = tracked_bends(seed)
    known = {b.name: sources(learned, b, seed) for b in tests}
    done = []
    for way in ways:
        found: dict[str, list[tuple[float, ...]]] = {"sinusoid": [], "random": []}
        for bend in tests:
            for reference in (references.sinusoid(cycles=2), references.random(stream(seed, "reference", bend.location), duration_s=200.0)):
                own = known[bend.name].lines[way.lines] if way.compensate else IDENTITY
                s, out = tracked(bend, own, reference, way.options(learned, known[bend.name]), way.compensate, seed)
                part = windows(reference.time_s, reference.cycle_s)[WINDOW_STEADY]
                region = apart(reference.tension_n[part], out[part])
                mape = s.mape_pct if s.mape_pct is not None else float("nan")
                found[reference.name].append((s.rmse_n, s.std_n, mape, region.reversal_n, region.elsewhere_n, region.peak_n))
        columns = [{t: tuple(v[i] for v in values) for t, values in found.items()} for i in range(6)]
        done.append(Rung(way.name, *columns))
        if advance is not None:
            advance(1)
    return done
