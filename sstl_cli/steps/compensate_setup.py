"""What is needed before compensating: mapped configurations, plants, and which methods are possible."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from sstl_cli.control import references
from sstl_cli.control.parameters import Entry, index_of
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop
from sstl_cli.control.references import Reference
from sstl_cli.control.sim_plant import plant_of
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.rng import stream
from sstl_cli.mapping import MappingModel
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.compensate import Case, possible_methods, with_mapping

PlantOf = Callable[[Case], Plant | None]


@dataclass(frozen=True)
class Biases:
    """Constant biases of the actuation tendon in N: as given, else ``known``, else those of the mapping's training."""

    beta_p: float | None = None
    beta_r: float | None = None
    known: tuple[float, float] | None = None

    def of(self, mapping: MappingModel, tendon: str | None) -> tuple[float, float]:
        """Return both biases for a tendon; SstlError E507 where one is not known."""
        if self.beta_p is not None and self.beta_r is not None:
            return self.beta_p, self.beta_r
        own = self.known or mapping.beta_act_of(tendon)
        return (own[0] if self.beta_p is None else self.beta_p, own[1] if self.beta_r is None else self.beta_r)


@dataclass(frozen=True)
class Plan:
    """What is compensated: configurations, the methods that are possible, and what was left out and why."""

    cases: list[Case]
    methods: list[str]
    impossible: dict[str, str]
    aside: dict[str, str]
    plant_of: PlantOf


def mapped_cases(cases: Sequence[Case], mapping: MappingModel, biases: Biases) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations with the lines a mapping predicts, tendon by tendon, and why others have none."""
    done, aside = list(cases), {}
    names: list[str | None] = [*mapping.header.tendons] or [None]
    for tendon in names:
        chosen = [i for i, c in enumerate(cases) if tendon is None or c.config_id.endswith(f"/{tendon}")]
        predict = partial(mapping.predict, tendon=tendon) if tendon is not None else mapping.predict
        pair = biases.of(mapping, tendon)
        mapped, missing = with_mapping([cases[i] for i in chosen], predict, pair, mapping.outside)
        for i, case in zip(chosen, mapped, strict=True):
            done[i] = case
        aside.update(missing)
    return done, aside


def stored_cases(entries: Sequence[Entry]) -> list[Case]:
    """Return the configurations of a parameter file; lines that came from a mapping are still driven as such, not as identified ones."""
    return [
        Case(e.config_id, mapped=e.lines(), made_for=e.method)
        if e.method == "proposed"
        else Case(e.config_id, act=e.lines(), made_for=e.method)
        for e in entries
    ]


def chosen(
    cases: list[Case], aside: dict[str, str], mapping: MappingModel | None, biases: Biases, config_id: str | None = None, where: str = ""
) -> tuple[list[Case], dict[str, str]]:
    """Return the configurations that are driven, mapped where a mapping is given, and why others are set aside.

    Parameters
    ----------
    cases, aside
        As they were read.
    config_id : str, optional
        The only one that is asked for.

    Raises
    ------
    SstlError
        If none is usable, or the one that is asked for is unknown or set aside.
    """
    if not cases:
        reasons = _reasons(aside)
        raise SstlError("no usable configuration" + (f" ({reasons})" if reasons else ""), where=where, fix="see sstl check", code="E405")
    if mapping is not None:
        cases, unmapped = mapped_cases(cases, mapping, biases)
        aside = {**aside, **unmapped}
    if config_id is not None:
        # a run that was set aside stands behind its configuration in brackets
        aside = {name: why for name, why in aside.items() if name == config_id or name.startswith(f"{config_id} (")}
        names = [c.config_id for c in cases]
        if aside and config_id not in names:
            what = f"configuration '{config_id}' was set aside ({_reasons(aside)})"
            raise SstlError(what, where=where, fix="see sstl check", code="E405")
        cases = [cases[index_of(names, config_id)]]
    return cases, aside


def _reasons(aside: Mapping[str, str]) -> str:
    return "; ".join(sorted(set(aside.values()))[:3])


def plants(truth: Sequence[Case], scenario: Scenario | None = None, loop: TensionLoop | None = None) -> PlantOf:
    """Return a function that gives the plant of a configuration, None where it has none.

    Parameters
    ----------
    truth : sequence of Case
        Configurations whose identified lines (act) are the plants.
    scenario : Scenario, optional
        Simulated as the plants instead.
    loop : TensionLoop, optional
        Tension loop of the plants; ideal by default.
    """
    if scenario is not None:
        known = {c.id for c in scenario.configurations}
        return lambda case: plant_of(scenario, case.config_id, loop) if case.config_id in known else None
    lines_of = {c.config_id: c.act for c in truth}

    def found(case: Case) -> Plant | None:
        lines = lines_of.get(case.config_id)
        return Plant(PlayTendon(lines), loop or TensionLoop()) if lines is not None else None

    return found


def references_of(
    names: Sequence[str], loaded: Mapping[str, Reference], dt_s: float, cycles: int, seed: int
) -> Callable[[Case], list[Reference]]:
    """Return a function that gives the references of a configuration: those ``loaded``, else made by their names.

    There are distinct random references, one a location, as in Section V.
    """

    def found(case: Case) -> list[Reference]:
        return [loaded.get(n) or references.make(n, stream(seed, "reference", n, case.location or ""), dt_s, cycles) for n in names]

    return found


def plan(cases: list[Case], aside: dict[str, str], methods: Sequence[str], insist: bool, plant_of: PlantOf, where: str = "") -> Plan:
    """Return what can be compensated of what was asked for.

    Parameters
    ----------
    insist : bool
        A method that is not possible is an error, not left out.

    Raises
    ------
    UsageError
        E405 for a method that is insisted on and not possible.
    SstlError
        E405 if no configuration has a plant.
    """
    why = possible_methods(cases)
    impossible = {m: why[m] for m in methods if why[m]}
    if impossible and insist:
        name, reason = next(iter(impossible.items()))
        raise UsageError(f"method '{name}' is not possible: {reason}", where=where, code="E405")
    left = [m for m in methods if m not in impossible]
    plantless = [c.config_id for c in cases if plant_of(c) is None]
    aside = {**aside, **dict.fromkeys(plantless, "no plant: no usable act row for this configuration")}
    for case in cases:
        for name in left:
            if name != "none" and case.lines(name) is None:
                aside[f"{case.config_id} ({name})"] = "no usable row to drive this method"
    if len(plantless) == len(cases):
        raise SstlError(
            "no configuration has a plant to be scored on",
            where=where,
            fix="give --plant or --plant-sim, or a Theta table with act rows",
            code="E405",
        )
    return Plan(cases, left, impossible, aside, plant_of)
