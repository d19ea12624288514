"""Sound logs drawn from the simulators that stand in for hardware: bends, movements, noise, rates and effects at random."""

from __future__ import annotations

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory, load
from sstl_cli.steps import simulate

SIMULATORS = ("rig", "bristle", "variant")
MOVEMENTS = ("trapezoid", "minor_loops", "ramp_hold", "random", "chirp", "sinusoid")
# of a parameter's way from neutral to its bound
PLAUSIBLE = (0.05, 0.5)
LEADS_MM = (10.0, 25.0, 40.0, 55.0, 70.0, 85.0, 100.0)
DURATIONS_S = {"trapezoid": 12.0, "minor_loops": 40.0, "ramp_hold": 40.0, "random": 80.0, "chirp": 40.0, "sinusoid": 100.0}


def draw(seed: int, effects: int = 1, leads: int | None = None, systems: tuple[str, ...] = ("act", "sstl")) -> list[Run]:
    """Return the runs of one sound log: ``effects`` effects of plausible size, ``leads`` bends (2 or 3 if not given)."""
    for attempt in range(20):
        rng = np.random.default_rng((seed, attempt))
        scenario, values = _scenario(rng, effects, leads, systems)
        try:
            return list(simulate.run(scenario, values, int(rng.integers(1 << 30))))
        except SstlError:
            # an effect that the simulator does not know, or that needs another tendon
            continue
    raise RuntimeError(f"no simulator takes what seed {seed} draws")


def _scenario(
    rng: np.random.Generator, effects: int, leads: int | None, systems: tuple[str, ...]
) -> tuple[Scenario, dict[str, dict[str, float]]]:
    count = leads or int(rng.integers(2, 4))
    base, slope = rng.uniform(0.35, 0.5), rng.uniform(0.0012, 0.0025)
    at = sorted(rng.choice(len(LEADS_MM), count, replace=False))
    bends = [Configuration(id=f"CP-{LEADS_MM[i]:03.0f}", location="CP", lead_mm=LEADS_MM[i], theta=base + slope * LEADS_MM[i]) for i in at]
    kinds = ["trapezoid", *rng.choice(MOVEMENTS[1:], int(rng.integers(1, 3)), replace=False)]
    moves = [Trajectory(kind=k, duration_s=DURATIONS_S[k], systems=systems, record_position=True, record_reference=True) for k in kinds]  # type: ignore[arg-type]
    found = load("sample").model_copy(
        update={
            "simulator": str(rng.choice(SIMULATORS)),
            "sampling_hz": float(rng.choice([50.0, 100.0, 250.0])),
            "noise": NoiseSection(white_n=float(rng.choice([0.01, 0.02, 0.05])), coloured_n=float(rng.choice([0.0, 0.02]))),
            "configurations": tuple(bends),
            "trajectories": tuple(moves),
        }
    )
    drawn = rng.choice(sorted(catalogue()), effects, replace=False) if effects else []
    return found, {str(name): _sizes(str(name), rng) for name in drawn}


def _sizes(name: str, rng: np.random.Generator) -> dict[str, float]:
    values = {}
    for p in catalogue()[name].parameters:
        if p.shape:
            values[p.name] = p.start if p.start is not None else p.neutral
            continue
        bound = p.low if p.low < p.neutral and (p.high <= p.neutral or rng.random() < 0.5) else p.high
        way = rng.uniform(*PLAUSIBLE)
        # full scale goes down from 1000 N: what clips lies near the tensions
        values[p.name] = rng.uniform(22.0, 60.0) if name == "saturation" else p.neutral + way * (bound - p.neutral)
    return catalogue()[name].complete(values)
