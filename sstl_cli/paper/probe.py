"""A shorter probe: errors of Theta and of tracking as the 12 s probe gets faster or goes only part of the way.

Fast probes meet friction that follows speed. So the curve is measured on the rig as it is (its friction falls with speed)
and on one with a drag that grows with it: there with the simulator calibrated at the speed of the 12 s probe alone, and
with one whose drag was fitted to probes at two speeds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.control import references
from sstl_cli.control.controller import Options, Theta
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.paper.bench import ModelBench
from sstl_cli.paper.better import Calibration, calibrate
from sstl_cli.paper.lag_and_presliding import fit_effects
from sstl_cli.paper.rig import GAP, RANGE_N, Bend, Effects, bends, identified, lines_of, recorded, slow_sine, tracked, trapezoid

FULL, PARTIAL, SHORT = "full stroke, faster", "partial stroke, same speed", "30 % of the stroke, faster"
#: kind, time (s), share of the stroke
PLANS = (
    *((FULL, t, 1.0) for t in (12.0, 6.0, 3.0, 2.0, 1.0, 0.5, 0.25)),
    *((PARTIAL, 12.0 * s, s) for s in (0.3, 0.15)),
    *((SHORT, t, 0.3) for t in (0.9, 0.25)),
)
NEAR = 1.10
BENDS_EACH = 4
CALIBRATION_EACH = 2
#: probes that speed-dependent friction is fitted to (s)
TWO_SPEEDS_S = (12.0, 1.0)
#: 0.1 N at the speed of the 12 s probe, 1 N in 1 s
DRAG: Effects = {**GAP, "viscous": {"c_l_n_s_per_mm": 0.01}}
SPEED: Effects = {"viscous": {"c_l_n_s_per_mm": 0.002}}
ONE, TWO = "one speed", "two speeds"
#: rig, its effects, speeds of the calibration
SETTINGS: tuple[tuple[str, Effects, str], ...] = (("rig", GAP, ONE), ("with drag", DRAG, ONE), ("with drag", DRAG, TWO))
#: the plant follows 0.01 Hz, for which five times the sampling period of the paper's controller is the same to a millinewton
TRACKING_DT_S = 0.01


@dataclass(frozen=True)
class Probe:
    """One probe: rig, calibration, kind, time (s), top of the input tension (N), errors over the bends.

    ``lines_error`` is the root mean square relative error of the predicted actuation slopes by the fitted theta,
    ``segmented_error`` that by segmentation and the linear map (None where the probe shows no release line on
    some bend); ``tracking_n`` is the mean RMSE on the sinusoid with all means.
    """

    kind: str
    time_s: float
    top_n: float
    lines_error: float
    segmented_error: float | None
    tracking_n: float
    rig: str = "rig"
    calibration: str = ONE


@dataclass(frozen=True)
class _Bench:
    """A rig with its bends and the lines that direct identification finds there, and the simulator of a calibration."""

    rig: str
    effects: Effects
    calibration: str
    learned: Calibration
    simulator: ModelBench
    direct: Mapping[Bend, Theta]


def run(
    seed: int,
    calibration: Calibration | None = None,
    advance: Callable[[float], None] | None = None,
    settings: Sequence[tuple[str, Effects, str]] = SETTINGS,
    plans: Sequence[tuple[str, float, float]] = PLANS,
    each: int = BENDS_EACH,
) -> list[Probe]:
    """Return the curve of every setting for faster full strokes, partial strokes and both at once; ``advance`` gets shares."""
    learned = calibration or calibrate(seed)
    tests = bends(each, stream(seed, "probe", "test"))
    done = []
    for rig, effects, name in settings:
        direct = {b: _must(lines_of(identified(recorded(b, "act", *slow_sine(), seed, effects)))) for b in tests}
        simulator = two_speeds(learned, effects, seed) if name == TWO else learned.simulator
        bench = _Bench(rig, effects, name, learned, simulator, direct)
        for plan in plans:
            done.append(_probe(bench, *plan, seed))
            if advance is not None:
                advance(1.0 / (len(settings) * len(plans)))
    return done


def two_speeds(learned: Calibration, effects: Effects, seed: int) -> ModelBench:
    """Return the simulator with speed-dependent friction fitted to slow and fast probes of calibration bends."""
    used = bends(CALIBRATION_EACH, stream(seed, "probe", "calibration"))
    runs = [recorded(b, "sstl", *trapezoid("sstl", t), seed, effects) for b in used for t in TWO_SPEEDS_S]
    return ModelBench(fit_effects(learned.simulator.scenario, runs, SPEED).scenario)


def shortest(probes: Sequence[Probe], measure: str) -> Probe:
    """Return the shortest probe whose error is within 10 % of the 12 s full stroke's, which comes first."""
    base = getattr(probes[0], measure)
    near = [p for p in probes if (value := getattr(p, measure)) is not None and value <= NEAR * base]
    return min(near, key=lambda p: p.time_s)


def curves(probes: Sequence[Probe]) -> dict[tuple[str, str], list[Probe]]:
    """Return the probes of every rig and calibration apart."""
    found: dict[tuple[str, str], list[Probe]] = {}
    for p in probes:
        found.setdefault((p.rig, p.calibration), []).append(p)
    return found


def _probe(bench: _Bench, kind: str, time_s: float, stroke: float, seed: int) -> Probe:
    low, high = RANGE_N["sstl"]
    top = low + stroke * (high - low)
    fitted, segmented, tracking = [], [], []
    reference = references.sinusoid(TRACKING_DT_S, cycles=2)
    for bend, true in bench.direct.items():
        record = recorded(bend, "sstl", *trapezoid("sstl", time_s, high=top), seed, bench.effects)
        theta = bench.simulator.theta(record)
        lines = _must(bench.simulator.lines(bend, theta))
        fitted.append(_error(lines, true))
        seen = lines_of(identified(record))
        segmented.append(_error(bench.learned.mapped(seen), true) if seen is not None else float("nan"))
        widths = bench.simulator.widths(bend, theta, lines)
        options = Options(dt_s=TRACKING_DT_S, lead_s=bench.learned.lag.tau_s, reversal="play", widths=widths)
        tracking.append(tracked(bend, lines, reference, options, True, seed, bench.effects)[0].rmse_n)
    whole = _rms(segmented)
    found = _rms(fitted), None if np.isnan(whole) else whole, float(np.mean(tracking))
    return Probe(kind, time_s, top, *found, rig=bench.rig, calibration=bench.calibration)


def _error(lines: Theta, true: Theta) -> float:
    return _rms([lines.gamma_p / true.gamma_p - 1.0, lines.gamma_r / true.gamma_r - 1.0])


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _must(lines: Theta | None) -> Theta:
    if lines is None:
        raise SstlError("a bend could not be identified directly", code="E802")
    return lines
