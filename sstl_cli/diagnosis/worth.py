"""What the named effect is worth to a controller: asked of the accepted simulator, with and without what was found."""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.downstream import Tracking, tracking
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.physics.scenario import Scenario


def can_be_asked(found: Evidence, accepted: Fit) -> bool:
    """Whether an effect of the output is named that a controller could know, at tensions for which its task is meant."""
    return found.problem.unit_n == 1.0 and accepted is not found.search.base and accepted.hypothesis.foretold


def of_the_middle(found: Evidence, accepted: Fit, model: Scenario, given: Scenario) -> tuple[str, list[Tracking]]:
    """Return the configuration nearest the middle, and the tracking errors of a controller there.

    Parameters
    ----------
    model, given : Scenario
        The accepted simulator, and the one that was given.

    Raises
    ------
    SstlError
        E920 if a simulator shows no propagation.
    """
    middle = int(np.argsort(accepted.theta)[len(accepted.theta) // 2])
    name = found.problem.configs[middle]
    return name, tracking(model, name, _before(found, model, given))


def _before(found: Evidence, model: Scenario, given: Scenario) -> Scenario:
    """Return an accepted simulator as it was given, theta re-tuned, without what was found."""
    theta = found.search.base.theta.tolist()
    tuned = tuple(c.model_copy(update={"theta": t}) for c, t in zip(model.configurations, theta, strict=True))
    return model.model_copy(update={"configurations": tuned, "effects": given.effects, "rig": given.rig})
