"""Say what a movement could tell before it is recorded: how small a gap of each effect would show, and what passes for what."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict

from sstl_cli.core.documents.diagnosis import PlanDocument, PlannedEffect
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.planning import Planned, plan
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import simulate


def run(scenario: Scenario, effects: Sequence[str] | None = None, advance: Callable[[float], None] = lambda _: None) -> PlanDocument:
    """Return what a scenario's recordings would tell, ``sstl.diagnosis.plan/1``.

    Parameters
    ----------
    scenario : Scenario
        Movements, configurations with theta, noise of the sensors, and the effects that the simulator contains already.
    effects : sequence of str, optional
        Candidates (default: all that act on the output).

    Raises
    ------
    SstlError
        If no run of the scenario could be diagnosed, or its sensors are without noise.
    """
    if max(scenario.noise.white_n, scenario.noise.coloured_n) <= 0.0:
        raise SstlError("sensors without noise show everything", where="noise", fix="state white_n of the sensors", code="E905")
    # a plan is in newtons, whatever unit an accepted model has
    in_newtons = scenario.model_copy(update={"simulator": "transmission", "output": None})
    runs = list(simulate.run(in_newtons, {}, 0))
    found = plan(runs, scenario, list(effects or catalogue()), advance)
    return PlanDocument(
        schema="sstl.diagnosis.plan/1",
        runs=len(found.problem.records),
        samples=sum(len(r.raw) for r in found.problem.records),
        noise=scenario.noise.model_dump(),
        decidable_d2=DECIDABLE,
        effects=[PlannedEffect(title=get(r.effect).title, **asdict(r)) for r in found.rows],
        classes=found.alike,
        set_aside=found.problem.set_aside,
        sentence=sentence(found.rows, found.alike),
    )


def sentence(rows: Sequence[Planned], alike: Sequence[Sequence[str]]) -> str:
    """Return the plan in one sentence."""
    seen, told = sum(r.shows for r in rows), sum(r.told_size is not None for r in rows)
    apart = "; ".join(" or ".join(c) for c in alike)
    text = f"With this movement {seen} of {len(rows)} effects would show within their ranges, and {told} of them be told from every other"
    return f"{text}; not apart: {apart}." if apart else f"{text}."
