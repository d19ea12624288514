"""The lines of a controller from a simulator: what was diagnosed mends the controller."""

from __future__ import annotations

from sstl_cli.control.sim_plant import plant_of
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.constants import STROKE_N
from sstl_cli.diagnosis.downstream import lines_of
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.compensate import Case


def cases_of(scenario: Scenario) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations of a simulator with the lines that it shows with every effect in it, and why others have none."""
    found, aside = [], {}
    stroke = stroke_of(scenario)
    for c in scenario.configurations:
        try:
            found.append(Case(c.id, c.location, lines_of(plant_of(scenario, c.id), stroke)))
        except SstlError as error:
            aside[c.id] = error.what
    return found, aside


def stroke_of(scenario: Scenario) -> tuple[float, float]:
    """Return the tensions (N) that an accepted model was seen at; those of a usual tendon where it does not say."""
    seen = [x for m in scenario.misfits if m.system == "act" for x in m.input_n]
    return (min(seen), max(seen)) if seen and min(seen) < max(seen) else STROKE_N
