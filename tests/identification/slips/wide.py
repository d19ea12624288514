"""Sound logs of rigs that differ in size, speed, sensors and what they record, drawn at random."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slips.sound import LEADS_MM, MOVEMENTS, SIMULATORS, _sizes
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory, load
from sstl_cli.steps import simulate

Array = NDArray[np.float64]
SHORT_S = {"trapezoid": 12.0, "minor_loops": 30.0, "ramp_hold": 30.0, "random": 40.0, "chirp": 30.0, "sinusoid": 40.0}
# what the sensors do to the signal is drawn here, after the motion
SENSORS = ("acquisition_faults", "saturation", "quantisation")
# the simulators' rate; what the log's becomes follows from how fast the rig moves and how its recorder thins
RATES_HZ = (50.0, 100.0, 200.0)
# largest tension of a rig, log-uniform: a microcatheter to a heavy cable
SMALLEST_N, LARGEST_N = 0.3, 500.0


@dataclass(frozen=True)
class Sensing:
    """How a recorder sees one tension channel: white noise over span, bits, samples a value is held, lag (samples), zero over span."""

    noise: float
    bits: int | None
    hold: int
    lag: float
    zero: float


def wide(
    seed: int, effects: int | None = None, leads: int | None = None, systems: tuple[str, ...] | None = None, moves: tuple[str, ...] = ()
) -> list[Run]:
    """Return one sound log of a rig drawn at random; ``moves`` are movements that it has in any case."""
    for attempt in range(30):
        rng = np.random.default_rng((seed, attempt, 77))
        scenario, values = _scenario(rng, effects, leads, systems, moves)
        try:
            log = list(simulate.run(scenario, values, int(rng.integers(1 << 30))))
        except SstlError:
            continue
        return _recorded(log, rng)
    raise RuntimeError(f"no simulator takes what seed {seed} draws")


def _scenario(
    rng: np.random.Generator, effects: int | None, leads: int | None, systems: tuple[str, ...] | None, moves: tuple[str, ...]
) -> tuple[Scenario, dict[str, dict[str, float]]]:
    count = leads or int(rng.choice([1, 2, 3]))
    base, slope = rng.uniform(0.15, 0.6), rng.uniform(0.0012, 0.004)
    at = sorted(rng.choice(len(LEADS_MM), count, replace=False))
    bends = [Configuration(id=f"CP-{LEADS_MM[i]:03.0f}", location="CP", lead_mm=LEADS_MM[i], theta=base + slope * LEADS_MM[i]) for i in at]
    recorded = systems or (("act",), ("sstl",), ("act", "sstl"))[int(rng.choice(3, p=[0.35, 0.15, 0.5]))]
    others = [m for m in MOVEMENTS if m not in moves]
    kinds = [*moves, *rng.choice(others, int(rng.integers(0 if moves else 1, 3)), replace=False)]
    trajectories = [
        Trajectory(kind=k, duration_s=SHORT_S[k], systems=recorded, record_position=True, record_reference=bool(rng.random() < 0.5))
        for k in kinds
    ]  # type: ignore[arg-type]
    found = load("sample").model_copy(
        update={
            "simulator": str(rng.choice(SIMULATORS)),
            "sampling_hz": float(rng.choice(RATES_HZ)),
            # noise is the recorder's
            "noise": NoiseSection(white_n=0.0, coloured_n=0.0),
            "configurations": tuple(bends),
            "trajectories": tuple(trajectories),
        }
    )
    many = int(rng.integers(0, 3)) if effects is None else effects
    drawn = rng.choice([c for c in sorted(catalogue()) if c not in SENSORS], many, replace=False) if many else []
    return found, {str(name): _sizes(str(name), rng) for name in drawn}


def _sensing(rng: np.random.Generator) -> Sensing:
    return Sensing(
        noise=float(np.exp(rng.uniform(np.log(1e-4), np.log(6e-3)))),
        bits=None if rng.random() < 0.5 else int(rng.integers(9, 17)),
        hold=1 if rng.random() < 0.75 else int(rng.integers(2, 9)),
        lag=0.0 if rng.random() < 0.6 else float(rng.uniform(0.0, 3.0)),
        zero=float(rng.uniform(-0.02, 0.02)),
    )


def _recorded(log: list[Run], rng: np.random.Generator) -> list[Run]:
    """Give all runs of a log one size of forces, one speed, and sensors of their own for both channels."""
    largest = max(float(r.tension_in_n.max()) for r in log)
    force = float(np.exp(rng.uniform(np.log(SMALLEST_N), np.log(LARGEST_N)))) / largest
    speed = float(np.exp(rng.uniform(np.log(0.25), np.log(8.0))))
    sensing = {s: (_sensing(rng), _sensing(rng)) for s in ("act", "sstl")}
    span = {s: max((float(np.ptp(r.tension_in_n)) for r in log if r.system == s), default=0.0) * force for s in ("act", "sstl")}
    # a soft or stiff tendon goes with the size of the rig
    travel = force ** float(rng.uniform(0.5, 1.0))
    out = []
    for r in log:
        a, b = sensing[r.system]
        full = span[r.system]
        out.append(
            replace(
                r,
                time_s=r.time_s / speed,
                tension_in_n=_seen(force * r.tension_in_n, replace(a, lag=0.0), full, rng),
                tension_out_n=_seen(force * r.tension_out_n, b, full, rng),
                tension_ref_n=None if r.tension_ref_n is None else force * r.tension_ref_n,
                position_in_mm=None if r.position_in_mm is None else travel * r.position_in_mm,
            )
        )
    return out


def _seen(v: Array, s: Sensing, full: float, rng: np.random.Generator) -> Array:
    if s.lag > 0.0:
        keep = np.exp(-1.0 / s.lag)
        out, state = np.empty_like(v), v[0]
        for k, value in enumerate(v):
            state = keep * state + (1.0 - keep) * value
            out[k] = state
        v = out
    v = v + s.zero * full + s.noise * full * rng.standard_normal(len(v))
    if s.hold > 1:
        v = v[np.arange(len(v)) // s.hold * s.hold]
    if s.bits is not None:
        step = 2.0 * full / 2**s.bits
        v = np.round(v / step) * step
    return v
