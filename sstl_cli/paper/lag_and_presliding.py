"""Loop lag and presliding found from recordings, where the paper's controller would have to know them.

The lag needs command and measured input tension of one movement, both proximal. Presliding needs one recording of small
loops a calibration bend: after every reversal the friction builds up over the break-away distance, and in loops smaller
than the backlash it never has. Its two parameters are fitted in a simulator, which then predicts how rounded the loop
of a new bend is, without a distal sensor there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from sstl_cli.control import loop_lag
from sstl_cli.control.controller import IDENTITY, Controller, Options
from sstl_cli.control.loop_lag import LoopLag
from sstl_cli.control.plant import Plant, TensionLoop, track
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.paper.bench import NOISE_N, THETA_BOUNDS, ModelBench, RigBench, block_means
from sstl_cli.paper.rig import DT_S, GAP, LAG_S, Bend, Effects, trapezoid
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
#: input tension at the turns of the small loops (N): ever smaller ones about the middle of the task
TURNS_N = (1.0, 30.0, 4.0, 26.0, 8.0, 22.0, 12.0, 18.0, 14.0)
SPEED_N_S = 6.0
PRESLIDING: Mapping[str, Mapping[str, float]] = {"presliding": {"breakaway_mm": 0.05, "spread": 0.3}}


@dataclass(frozen=True)
class Fitted:
    """Parameters of effects that were fitted to recordings, by (effect, parameter), and the RMS (N) that is left."""

    values: Mapping[tuple[str, str], float]
    scenario: Scenario
    rms_n: float


def small_loops(dt_s: float = DT_S) -> tuple[Array, Array]:
    """Return time (s) and input tension (N) of loops that grow smaller, at the speed of the probe."""
    turns = np.array(TURNS_N)
    at = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)) / SPEED_N_S)])
    time = np.arange(int(at[-1] / dt_s), dtype=np.float64) * dt_s
    return time, np.interp(time, at, turns)


def loop_of(bend: Bend, seed: int, lag_s: float = LAG_S, effects: Effects = GAP) -> LoopLag:
    """Return the lag of the tension loop, from what is commanded and measured while a trapezoid is driven uncompensated."""
    command = trapezoid("act")[1]
    plant = Plant(RigBench(effects).tendon(bend), TensionLoop(lag_s, noise_n=NOISE_N))
    done = track(Controller(IDENTITY, Options(dt_s=DT_S), compensate=False), plant, command)
    noise = stream(seed, "identified", "input sensor", bend.name).standard_normal(len(command))
    return loop_lag.identify(done.command, done.tension_in + NOISE_N * noise, DT_S)


def fit_effects(scenario: Scenario, runs: Sequence[Run], starts: Mapping[str, Mapping[str, float]]) -> Fitted:
    """Return the parameters of effects, and the theta of every run, that explain recordings best in a simulator.

    Parameters
    ----------
    scenario : Scenario
        The simulator; its other effects stay as they are.
    starts : mapping
        Effect to parameter to the value the fit begins at; bounds are those of the catalogue.
    """
    names = [(effect, p) for effect, values in starts.items() for p in values]
    bounds = [_bounds(*name) for name in names] + [THETA_BOUNDS] * len(runs)
    means = [block_means(run) for run in runs]

    def model(x: Array) -> Scenario:
        own = {effect: {p: float(v) for (e, p), v in zip(names, x, strict=False) if e == effect} for effect in starts}
        return scenario.model_copy(update={"effects": {**scenario.effects, **own}})

    def residual(x: Array) -> Array:
        bench = ModelBench(model(x))
        return np.concatenate([bench.residual(run, x[len(names) + i]) for i, run in enumerate(means)])

    first = ModelBench(scenario)
    start = np.array([starts[e][p] for e, p in names] + [first.theta(run) for run in runs])
    low, high = np.array(bounds).T
    fit = least_squares(residual, np.clip(start, low, high), bounds=(low, high), x_scale=0.1 * (high - low), diff_step=1e-3)
    values = {name: float(v) for name, v in zip(names, fit.x, strict=False)}
    return Fitted(values, model(fit.x), float(np.sqrt(np.mean(fit.fun**2))))


def _bounds(effect: str, parameter: str) -> tuple[float, float]:
    found = next(p for p in get(effect).parameters if p.name == parameter)
    return found.low, found.high
