"""The physical model of a scenario as the plant: its tension loop, and its tendon with every effect in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.controller import Theta
from sstl_cli.control.plant import Plant, PlayTendon, Tendon, TensionLoop
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import Active, drive_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulatedTendon:
    """The actuation tendon of the fast model: theta of the bend and the active effects."""

    theta: float
    location: str | None
    mechanics: Mechanics
    active: Active

    def __call__(self, tension_in: Array, dt_s: float) -> Array:
        return predict(drive_of("act", self.location, dt_s, tension_in, self.mechanics), self.theta, self.active)


def plant_of(scenario: Scenario, config_id: str | None, loop: TensionLoop | None = None) -> Plant:
    """Return a configuration of a scenario as a plant.

    Parameters
    ----------
    loop : TensionLoop, optional
        Tension loop; by default the scenario's effect ``tension_loop_lag`` (ideal if it has none).

    Raises
    ------
    SstlError
        If the scenario has no such configuration.
    """
    found = next((c for c in scenario.configurations if c.id == config_id), None)
    if found is None:
        hint = nearest(str(config_id), [c.id for c in scenario.configurations])
        raise SstlError(f"scenario has no configuration '{config_id}' ({hint})", code="E406")
    effects = dict(scenario.effects)
    values = effects.pop("tension_loop_lag", {})
    if loop is None:
        inverse = values.get("inverse_slew_s_per_n", 0.0)
        loop = TensionLoop(values.get("tau_s", 0.0), 1.0 / inverse if inverse > 0.0 else float("inf"), noise_n=scenario.noise.white_n)
    tendon: Tendon
    if found.theta is None and found.act is not None:
        a = found.act
        tendon = PlayTendon(Theta(a.gamma_p, a.beta_p, a.gamma_r, a.beta_r))
    elif found.theta is not None:
        tendon = SimulatedTendon(found.theta, found.location, scenario.rig.mechanics(), activate(effects))
    else:
        raise SstlError(
            f"configuration '{config_id}' does not describe the actuation tendon", fix="give it theta or lines of act", code="E406"
        )
    return Plant(tendon, loop)
