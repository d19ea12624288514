"""An actively bending distal joint behind the tube, simulated: its friction grows with the tension that bends it.

The tendon leaves the tube with T_1, runs around a joint that a spring holds straight, and ends with T_2. The joint bends
by q = kappa T_2, the tendon wraps it by that angle, and the capstan equation, Eq. (1), gives T_2 exp(+-mu q) = T_1: a play
whose lines are curved. Sensing loop and mapping end at the tube and know nothing of it. Its one constant a = mu kappa is
found from one movement recorded with the joint held straight and with it free; the reference is then taken backwards
through the joint, and the controller tracks what the tube has to give.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from sstl_cli.control import references
from sstl_cli.control.controller import IDENTITY, Controller, Options
from sstl_cli.control.plant import Plant, TensionLoop, track
from sstl_cli.control.references import Reference
from sstl_cli.control.scoring import WINDOW_STEADY, score, windows
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run
from sstl_cli.paper.bench import NOISE_N
from sstl_cli.paper.better import Calibration, Source, sources, tracked_bends
from sstl_cli.paper.rig import GAP, LAG_S, Bend, RigTendon, known, lines_of, recorded, slow_sine

Array = NDArray[np.float64]
#: 60 degrees at 30 N, friction of a steel rope on steel
KAPPA_RAD_PER_N, MU = 0.035, 0.15
JOINT_PER_N = KAPPA_RAD_PER_N * MU
TRACKING_DT_S = 0.01
MOST_PER_N = 0.02
RANDOM_S = 200.0
NEWTON_STEPS = 30


@dataclass(frozen=True)
class Bent:
    """What one way reaches with the joint: RMSE of T_2 (N) and of the joint's angle (degrees) by trajectory, mean over bends."""

    way: str
    rmse_n: Mapping[str, float]
    rmse_deg: Mapping[str, float]
    joint_per_n: float
    identified_per_n: float


NONE, UNKNOWN, MOVING, INVERTED = (
    "no compensation",
    "all means, joint not known",
    "direct identification, joint moving",
    "all means, joint inverted",
)
WAYS = (NONE, UNKNOWN, MOVING, INVERTED)


def joint(tension_1: Array, per_n: float) -> Array:
    """Return T_2 (N) behind the joint for T_1 (N, shape (n,)) before it: T_2 exp(+-a T_2) = T_1 with a = ``per_n`` (1/N)."""
    return _play(np.ascontiguousarray(tension_1, dtype=np.float64), per_n)


def before_joint(reference: Reference, per_n: float) -> Reference:
    """Return what has to enter the joint so that a reference leaves it; it jumps by the joint's backlash at reversals."""
    t = reference.tension_n
    direction = np.sign(np.diff(t, prepend=t[0]))
    # a flat keeps the direction; the first one is a pull
    moved = np.maximum.accumulate(np.where(direction != 0.0, np.arange(len(t)), 0))
    signed = np.where(direction[moved] != 0.0, direction[moved], 1.0)
    return Reference(reference.name, reference.time_s, np.asarray(t * np.exp(signed * per_n * t)), reference.cycle_s)


def identify(bend: Bend, seed: int, per_n: float = JOINT_PER_N) -> float:
    """Return a (1/N) from one movement recorded behind the joint, held straight and free."""
    straight = recorded(bend, "act", *slow_sine(), seed).tension_out_n
    free = _moving(bend, seed, per_n).tension_out_n
    # the play keeps the highest noise that it meets: means of a second have none to speak of
    held, seen = (v[: len(v) // 500 * 500].reshape(-1, 500).mean(axis=1) for v in (straight, free))
    found = minimize_scalar(
        lambda a: float(np.mean((joint(held, a) - seen) ** 2)), bounds=(0.0, MOST_PER_N), method="bounded", options={"xatol": 1e-7}
    )
    return float(found.x)


def run(seed: int, calibration: Calibration, tests: Sequence[Bend] | None = None) -> list[Bent]:
    """Return what every way reaches on both references with the joint, at one bend a location."""
    used = tracked_bends(seed) if tests is None else tests
    known = {b: sources(calibration, b, seed) for b in used}
    found = identify(used[0], seed)
    done = []
    for way in WAYS:
        rmse = {
            name: float(np.mean([_tracked(way, b, known[b], name, calibration.lag.tau_s, found, seed) for b in used]))
            for name in ("sinusoid", "random")
        }
        degrees = {name: float(np.degrees(KAPPA_RAD_PER_N * v)) for name, v in rmse.items()}
        done.append(Bent(way, rmse, degrees, JOINT_PER_N, found))
    return done


def _tracked(way: str, bend: Bend, source: Source, trajectory: str, lag_s: float, per_n: float, seed: int) -> float:
    """Return the RMSE (N) of T_2 without the first cycle."""
    if trajectory == "sinusoid":
        reference = references.sinusoid(TRACKING_DT_S, cycles=2)
    else:
        reference = references.random(stream(seed, "reference", bend.location), TRACKING_DT_S, RANDOM_S)
    lines, widths = source.lines["physics"], source.widths
    if way == MOVING:
        lines = known(lines_of(segment_run(_moving(bend, seed, JOINT_PER_N))))
    options = Options(dt_s=TRACKING_DT_S, lead_s=lag_s, reversal="play", widths=widths)
    controller = Controller(IDENTITY if way == NONE else lines, options, way != NONE)
    entering = before_joint(reference, per_n) if way == INVERTED else reference
    tube = RigTendon(bend, GAP)
    plant = Plant(lambda tension, dt: joint(tube(tension, dt), JOINT_PER_N), TensionLoop(LAG_S, noise_n=NOISE_N))
    out = track(controller, plant, entering.tension_n, stream(seed, "sensor", bend.name, reference.name)).tension_out
    part = windows(reference.time_s, reference.cycle_s)[WINDOW_STEADY]
    return score(reference.tension_n[part], out[part]).rmse_n


def _moving(bend: Bend, seed: int, per_n: float) -> Run:
    """Return the slow movement of direct identification as recorded behind the free joint."""
    time, tension = slow_sine()
    rng = stream(seed, "distal", bend.name)
    seen_in, seen_out = (
        v + NOISE_N * rng.standard_normal(len(time)) for v in (tension, joint(RigTendon(bend, GAP)(tension, float(time[1])), per_n))
    )
    return Run(f"{bend.name}-joint", "act", time, seen_in, seen_out, bend.name, bend.location)


@njit(cache=True)
def _play(tension_1: Array, a: float) -> Array:
    out = np.empty_like(tension_1)
    y = _behind(tension_1[0], a)
    for k in range(tension_1.size):
        y = max(_behind(tension_1[k], a), min(y, _behind(tension_1[k], -a)))
        out[k] = y
    return out


@njit(cache=True)
def _behind(t1: float, a: float) -> float:
    """Return T_2 of T_2 exp(a T_2) = T_1 by Newton's rule; a tension below zero bends nothing."""
    t2 = t1
    if t1 <= 0.0 or a == 0.0:
        return t2
    for _ in range(NEWTON_STEPS):
        grown = np.exp(a * t2)
        step = (t2 * grown - t1) / (grown * (1.0 + a * t2))
        t2 -= step
        if abs(step) < 1e-12:
            break
    return t2
