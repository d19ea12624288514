"""What an accepted simulator drives where it is simulated: the program's own movements, within the tensions of its record.

The input of a record is a measured curve, for which a scenario has no form; movements are of no account where a diagnosis takes
the model again.
"""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.constants import FASTEST_HZ
from sstl_cli.diagnosis.following import recorded_n
from sstl_cli.diagnosis.records import Problem
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import HIGHEST_N, Scenario, Trajectory, load


def with_movements(scenario: Scenario, problem: Problem) -> Scenario:
    """Return an accepted simulator with movements to simulate, as many channels as its record and its effects have, and its rate.

    One that was given with movements of its own keeps them.
    """
    if scenario.trajectories or scenario.generator:
        return scenario
    runs = [r.raw for r in problem.records]
    needed = {name for effect_id in scenario.effects for name in get(effect_id).needs}
    channels = {
        "record_position": "position_in_mm" in needed or any(r.position_in_mm is not None for r in runs),
        "record_reference": "tension_ref_n" in needed or any(r.tension_ref_n is not None for r in runs),
    }
    found: list[Trajectory] = []
    for usual in load("default").trajectories:
        for system in problem.systems:
            low, high = _range_n(problem, system, scenario.rig.mechanics().preload(system) / problem.unit_n)
            # driven by position it would leave this range
            how = {"systems": (system,), "low_n": low, "high_n": high, "drive": "tension", **channels}
            found.append(usual.model_copy(update=how))
    step = float(np.median([r.dt_s for r in runs]))
    return scenario.model_copy(update={"trajectories": tuple(found), "sampling_hz": float(f"{min(1.0 / step, FASTEST_HZ):.4g}")})


def _range_n(problem: Problem, system: str, preload_n: float = 0.0) -> tuple[float, float]:
    """Return lowest and highest input tension of a system in the recording's unit, as far as a scenario takes them."""
    low, most = (problem.unit_n * end for end in recorded_n(problem, system, preload_n))
    high = float(f"{min(most, HIGHEST_N):.3g}")
    # rounded it may be one at which the tendon is slack
    return max(float(f"{min(low, 0.5 * high):.3g}"), 0.0 - problem.unit_n * preload_n, -HIGHEST_N), high
