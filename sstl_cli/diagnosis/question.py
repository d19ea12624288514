"""What a diagnosis is asked: of which simulator, among which effects, how many of them together."""

from __future__ import annotations

from dataclasses import dataclass

from sstl_cli.diagnosis import scaling
from sstl_cli.diagnosis.constants import MOST_EFFECTS
from sstl_cli.diagnosis.weights import Weights, learned
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario


@dataclass(frozen=True)
class Question:
    """What to compare: a simulator (none: one is assumed), the candidates, how many effects may be combined, by how many threads.

    ``position`` asks for what the recorded position shows as well.
    """

    sim: Scenario | None = None
    effects: tuple[str, ...] | None = None
    exclude: tuple[str, ...] = ()
    max_effects: int = MOST_EFFECTS
    workers: int = 1
    position: bool = False

    def given(self, unit_n: float) -> Scenario:
        """Return the simulator that was given, or the base in proportion to tensions that are fitted in units of ``unit_n`` (N)."""
        return self.sim or scaling.in_proportion(unit_n)

    @property
    def weights(self) -> Weights:
        """The weights of the verdict: a model that a diagnosis accepted makes it a question of what has changed."""
        return learned(self.sim is not None and self.sim.package_version is not None)


def candidates(asked: Question) -> list[str]:
    """Return the ids of the effects to compare; those that the simulator contains are compared as changes of them.

    Raises
    ------
    SstlError
        If there is no such effect.
    """
    ids = [get(e).id for e in asked.effects] if asked.effects else list(catalogue())
    excluded = {get(e).id for e in asked.exclude}
    return [i for i in ids if i not in excluded]
