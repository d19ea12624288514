"""The simulators that stand in for hardware, behind one face: march the mechanics, then let sensors and recorder read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.physics import bristle, rig, variant
from sstl_cli.physics.bristle.sensors import record as read_bristle
from sstl_cli.physics.disturbances import NEIGHBOUR_PER_N, as_neighbour
from sstl_cli.physics.given import Built
from sstl_cli.physics.rig.sensors import record as read_rig

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]
Truth = tuple[Array, Array, Array]
NAMES = ("rig", "bristle", "variant")
# steps that may miss their tolerance, in every so many
SLOPPY = 100_000


@dataclass(frozen=True)
class Hardware:
    """One simulator of a bench: ``spec`` has the fields that all share."""

    name: str
    spec: rig.RigSpec
    law_seed: int = 0

    def march(
        self,
        system: str,
        theta: float,
        location: str | None,
        time_s: Array,
        command: Array,
        effects: Effects,
        friction: Array | None = None,
    ) -> Truth:
        """Return true tensions in and out (N) and position (mm), each (n,); SstlError where the solver gives up.

        ``friction`` is a factor on the friction of the bend, shape (n,).
        """
        values = {k: dict(v) for k, v in effects.items()}
        given: tuple[Any, ...] = (system, theta, location, time_s, "tension", command)
        if friction is not None and self.name != "variant":
            values["tendon_crosstalk"] = {"c_bend_per_n": NEIGHBOUR_PER_N}
            given = (*given, as_neighbour(friction, self.name))
        result: Any
        if self.name == "rig":
            result = rig.simulate_rig(self.spec, rig.RigRun(*given), values, rig.QUIET)
        elif self.name == "bristle":
            result = bristle.simulate_bristle(bristle.BristleSpec(**self._shared()), bristle.BristleRun(*given), values, bristle.QUIET)
        else:
            run = variant.VariantRun(system, theta, location, time_s, "tension", command, friction=friction)
            truth = variant.march_variant(self._variant(), run, values)
            return _sound(truth.unconverged, (truth.tension_in_n, truth.tension_out_n, truth.position_in_mm))
        return _sound(result.unconverged, (result.true_tension_in_n, result.true_tension_out_n, result.true_position_in_mm))

    def read(
        self, system: str, theta: float, time_s: Array, truth: Truth, effects: Effects, noise: rig.NoiseSpec, seed: int
    ) -> tuple[Array, Array, Array, Array]:
        """Return time stamps (s), tensions in and out (N) and position (mm) as sensors and recorder store them."""
        values = {k: dict(v) for k, v in effects.items()}
        if self.name == "rig":
            return read_rig(time_s, truth, rig.resolve_effects(values), system, noise, seed)
        if self.name == "bristle":
            return read_bristle(time_s, truth, bristle.resolve_effects(values), system, noise, seed)
        run = variant.VariantRun(system, theta, None, time_s, "tension", truth[0])
        return variant.read_variant(self._variant(), run, truth, values, noise, seed)

    def _shared(self) -> Built:
        s = self.spec
        return Built(
            length_mm=s.length_mm,
            ea_n=s.ea_n,
            nodes=s.nodes,
            bend_arc_fraction=s.bend_arc_fraction,
            bend_centres=dict(s.bend_centres),
            load_k1_n_per_mm=s.load_k1_n_per_mm,
        )

    def _variant(self) -> variant.VariantSpec:
        return variant.VariantSpec(**self._shared(), law_seed=self.law_seed)


def _sound(unconverged: int, truth: Truth) -> Truth:
    if unconverged > max(1, truth[0].size // SLOPPY):
        raise SstlError(f"{unconverged} steps of the simulator did not converge", code="E950")
    return truth
