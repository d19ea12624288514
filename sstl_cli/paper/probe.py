"""A shorter probe: errors of Theta and of tracking as the 12 s probe gets faster or goes only part of the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.control import references
from sstl_cli.control.controller import Theta
from sstl_cli.core.rng import stream
from sstl_cli.paper.better import ALL_MEANS, WAYS, Calibration, calibrate
from sstl_cli.paper.rig import RANGE_N, Bend, bends, identified, lines_of, recorded, slow_sine, tracked, trapezoid

DURATIONS_S = (12.0, 10.0, 8.0, 6.0, 5.0, 4.0, 3.0, 2.5, 2.0)
STROKES = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)
FULL, PARTIAL = "full stroke, faster", "partial stroke, same speed"
NEAR = 1.10


@dataclass(frozen=True)
class Probe:
    """One probe: kind, time (s), top of the input tension (N), errors over the bends.

    ``lines_error`` is the root mean square relative error of the predicted actuation slopes by the fitted theta,
    ``segmented_error`` that by segmentation and the linear map (None where the probe shows no release line on
    some bend); ``tracking_n`` is the RMSE on the sinusoid with all means.
    """

    kind: str
    time_s: float
    top_n: float
    lines_error: float
    segmented_error: float | None
    tracking_n: float


def run(seed: int, calibration: Calibration | None = None, advance: Callable[[float], None] | None = None) -> list[Probe]:
    """Return the curve for faster full strokes and for partial strokes at the speed of the 12 s probe."""
    learned = calibration or calibrate(seed)
    tests = bends(1, stream(seed, "probe", "test"))
    direct = {b.name: _must(lines_of(identified(recorded(b, "act", *slow_sine(), seed)))) for b in tests}
    low, high = RANGE_N["sstl"]
    plans = [(FULL, t, high) for t in DURATIONS_S]
    plans += [(PARTIAL, DURATIONS_S[0] * s, low + s * (high - low)) for s in STROKES[1:]]
    done = []
    for kind, time, top in plans:
        done.append(_probe(kind, time, top, tests, direct, learned, seed))
        if advance is not None:
            advance(1)
    return done


def shortest(probes: Sequence[Probe], measure: str) -> Probe:
    """Return the shortest probe whose error is within 10 % of the 12 s full stroke's."""
    base = getattr(probes[0], measure)
    near = [p for p in probes if (value := getattr(p, measure)) is not None and value <= NEAR * base]
    return min(near, key=lambda p: p.time_s)


def _probe(
    kind: str, time_s: float, top_n: float, tests: Sequence[Bend], direct: dict[str, Theta], learned: Calibration, seed: int
) -> Probe:
    way = next(w for w in WAYS if w.name == ALL_MEANS)
    fitted, segmented, tracking = [], [], []
    for bend in tests:
        record = recorded(bend, "sstl", *trapezoid("sstl", time_s, high=top_n), seed)
        lines = _must(learned.simulator.lines(bend, learned.simulator.theta(record)))
        fitted.append(_error(lines, direct[bend.name]))
        seen = lines_of(identified(record))
        segmented.append(_error(learned.mapped(seen), direct[bend.name]) if seen is not None else float("nan"))
        score, _ = tracked(bend, lines, references.sinusoid(cycles=2), way.options, True, seed)
        tracking.append(score.rmse_n)
    whole = _rms(segmented)
    return Probe(kind, time_s, top_n, _rms(fitted), None if whole != whole else whole, float(np.mean(tracking)))


def _error(lines: Theta, true: Theta) -> float:
    return _rms([lines.gamma_p / true.gamma_p - 1.0, lines.gamma_r / true.gamma_r - 1.0])


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _must(lines: Theta | None) -> Theta:
    from sstl_cli.core.errors import SstlError

    if lines is None:
        raise SstlError("a bend could not be identified directly", code="E802")
    return lines
