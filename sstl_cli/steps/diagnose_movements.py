"""The recording that a diagnosis proposes as a file holds it, and what is said of the movements of a saved simulator."""

from __future__ import annotations

from sstl_cli.core.documents.diagnosis import NextExperiment
from sstl_cli.diagnosis.following import table
from sstl_cli.physics.scenario import Scenario

SAID = "movements of sstl within the tensions that were recorded: for the recorded ones there is no form here"


def proposed(experiment: NextExperiment | None) -> Scenario | None:
    """Return a proposed recording as a scenario, None where none is proposed."""
    return None if experiment is None or experiment.scenario is None else Scenario.model_validate(experiment.scenario)


def tensions(movement: Scenario, experiment: NextExperiment) -> str:
    """Return the tensions to drive in the movement that an experiment proposes as CSV, in its unit: ``system,time_s,tension_in_n``."""
    return table(movement, experiment.tension_factor or 1.0)
