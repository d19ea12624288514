"""Compensation from Python: controllers along references, scored on their plants, and one on a running rig."""

from __future__ import annotations

from collections.abc import Mapping as Named
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

import pandas as pd
import pyarrow as pa

from sstl_cli.api.log import Log
from sstl_cli.api.mapping import Mapping, table_of
from sstl_cli.control import reference_file
from sstl_cli.control.controller import METHODS, Controller
from sstl_cli.control.controller import Options as ControllerOptions
from sstl_cli.control.plant import TensionLoop
from sstl_cli.control.references import NAMES, Reference
from sstl_cli.control.scoring import MAPE_FLOOR_N
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import compensate as compensating
from sstl_cli.steps import compensate_live as living
from sstl_cli.steps import compensate_setup as setup
from sstl_cli.steps import compensate_source as sourcing
from sstl_cli.steps.compensate_setup import Biases
from sstl_cli.steps.compensate_source import Source

__all__ = ["Biases", "Controller", "ControllerOptions", "compensate", "controller"]

References = Sequence[str | PathLike[str]] | Named[str, pd.DataFrame]


# long: one parameter for each option of the command, each told; the body fits a screen
def compensate(
    theta: pd.DataFrame | Scenario | str | PathLike[str],
    mapping: Mapping | None = None,
    *,
    references: References = ("sinusoid",),
    methods: Sequence[str] | None = None,
    plant: pd.DataFrame | Scenario | None = None,
    cycles: int = 2,
    mape_floor_n: float = MAPE_FLOOR_N,
    seed: int = 0,
    options: ControllerOptions | None = None,
    biases: Biases | pd.DataFrame | None = None,
    loop_tau_s: float | None = None,
    recorded: Log | None = None,
    config_id: str | None = None,
    commands: bool = False,
) -> pd.DataFrame:
    """Return how well each configuration tracks references, as ``sstl compensate --scores`` writes it.

    Parameters
    ----------
    theta : DataFrame, Scenario or path
        Theta table, as ``log.segment()`` returns it; its ``act`` rows are the plants unless another is given. Or a simulator, such
        as the model of a diagnosis, for lines and plant; or a file of either; or the parameter file (JSON) of ``sstl export``.
    mapping : Mapping, optional
        Predicts the actuation slopes from the sensing loop, for the methods ``proposed`` and ``no-bias``.
    references : sequence of str or path, or mapping of name to DataFrame
        Some of sinusoid, random and trapezoid, files, or tables; files and tables have the columns ``time_s`` and ``tension_ref_n``.
    methods : sequence of str, optional
        Some of none, no-bias, proposed and DI; by default those that are possible.
    plant : DataFrame or Scenario, optional
        The Theta table of the plants, or a simulator as the plant, such as the model of a diagnosis.
    cycles : int
        Cycles of the sinusoid and the trapezoid.
    mape_floor_n : float
        References below this (N) are left out of MAPE.
    seed : int
        Seed of the random reference.
    options : ControllerOptions, optional
        How the controller acts: period, bounds, lead, reversals; by default as a parameter file says, else Algorithm 1.
    biases : Biases or DataFrame, optional
        Biases that go with the slopes of a mapping, or a Theta table with them; by default those it was trained on.
    loop_tau_s : float, optional
        Lag of the plant's tension loop in s.
    recorded : Log, optional
        Its measured input drives the controller, along the references that it holds.
    config_id : str, optional
        The only configuration.
    commands : bool
        Return the command streams instead, one row a period, as ``sstl compensate --out`` writes them.

    Raises
    ------
    SstlError
        For an unknown reference or method, one that is not possible, or without a configuration that has a plant.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> scores = compensate(simulate("sample", seed=1).segment(), methods=["none", "DI"], cycles=1)
    >>> sorted(scores["method"].unique())
    ['DI', 'none']
    """
    asked, where = driven(theta, mapping, biases, config_id, options, methods or ())
    used = asked.options
    truth = compensating.cases_of(table_of(plant))[0] if isinstance(plant, pd.DataFrame) else asked.cases
    simulated = plant if isinstance(plant, Scenario) else asked.model if plant is None else None
    loop = TensionLoop(loop_tau_s) if loop_tau_s is not None else None
    plan = setup.plan(asked.cases, asked.aside, methods or METHODS, methods is not None, setup.plants(truth, simulated, loop), where)
    if recorded is not None:
        done = compensating.run_recorded(plan.cases, recorded.runs, plan.methods, used, mape_floor_n, plan.plant_of)
    else:
        names, loaded = _references(references, used.dt_s)
        wanted = setup.references_of(names, loaded, used.dt_s, cycles, seed)
        done = compensating.run(plan.cases, wanted, plan.plant_of, plan.methods, used, seed, mape_floor_n)
    if commands:
        table = pa.concat_tables([compensating.command_table(result) for result in done])
    else:
        table = compensating.score_table([row for result in done for row in compensating.score_rows(result)])
    frame: pd.DataFrame = table.to_pandas()
    return frame


def controller(
    theta: pd.DataFrame | Scenario | str | PathLike[str],
    mapping: Mapping | None = None,
    *,
    method: str | None = None,
    options: ControllerOptions | None = None,
    biases: Biases | pd.DataFrame | None = None,
    config_id: str | None = None,
) -> Controller:
    """Return the controller that ``sstl compensate --stream`` answers a running rig with, at rest; call ``.step`` once a period.

    A sample that is lost is NaN: the command is held, then ramped down, and ``.fault`` says why.

    Parameters
    ----------
    theta, mapping, biases
        As of ``compensate``.
    method : str, optional
        Whose lines (none, no-bias, proposed or DI); by default as a parameter file says, else proposed with a mapping and DI without.
    options : ControllerOptions, optional
        How it acts, its period ``dt_s`` first; by default as a parameter file says, else Algorithm 1.
    config_id : str, optional
        Which configuration; may be left out where there is only one.

    Raises
    ------
    SstlError
        For an unknown method or configuration, a method that is not possible, or no configuration named among several.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> rig = controller(simulate("sample", seed=1).segment(), config_id="CP-020")
    >>> command_n, phase = rig.step(9.0, 8.5)
    >>> round(command_n, 1), phase, rig.fault
    (14.7, 'PP', '')
    >>> rig.step(9.0, float("nan")) == (command_n, "SAFE"), rig.fault
    (True, 'measured tension lost (not a number)')
    """
    asked, where = driven(theta, mapping, biases, config_id, options, () if method is None else (method,))
    return living.run(asked.cases, config_id, method, asked.options, where).controller


def driven(
    theta: pd.DataFrame | Scenario | str | PathLike[str],
    mapping: Mapping | None,
    biases: Biases | pd.DataFrame | None,
    config_id: str | None,
    options: ControllerOptions | None,
    methods: Sequence[str],
) -> tuple[Source, str]:
    """Return what is driven, as it is asked for, and how errors name it; raise SstlError (E404) for a method that there is not."""
    for name in methods:
        if name not in METHODS:
            raise SstlError(f"no method '{name}' ({nearest(name, METHODS)})", code="E404")
    source = source_of(theta)
    where = str(theta) if isinstance(theta, str | PathLike) else type(theta).__name__
    model = None if mapping is None else mapping.model
    cases, aside = setup.chosen(source.cases, source.aside, model, biases_of(biases), config_id, where)
    return replace(source, cases=cases, aside=aside, options=source.options if options is None else options), where


def source_of(theta: pd.DataFrame | Scenario | str | PathLike[str]) -> Source:
    """Return the lines of a Theta table, of a simulator or its name, or of a file with any of them."""
    if isinstance(theta, pd.DataFrame):
        return Source(*compensating.cases_of(table_of(theta)), ControllerOptions())
    if isinstance(theta, Scenario):
        return sourcing.simulated(theta)
    # a built-in simulator has a name without ending
    return sourcing.source_of(Path(theta)) if Path(theta).suffix else sourcing.simulated(load(str(theta)))


def biases_of(given: Biases | pd.DataFrame | None) -> Biases:
    """Return the biases that go with the slopes of a mapping, means of a Theta table where one is given."""
    if isinstance(given, pd.DataFrame):
        return Biases(known=compensating.mean_biases(compensating.cases_of(table_of(given))[0]))
    return given or Biases()


def _references(given: References, dt_s: float) -> tuple[list[str], dict[str, Reference]]:
    """Return the references by name, and those of them that are files or tables."""
    if isinstance(given, Named):
        tables = {name: reference_file.of_frame(name, frame, dt_s) for name, frame in given.items()}
        return list(tables), tables
    names = [str(name) for name in given]
    for name in names:
        if name not in NAMES and not Path(name).exists():
            raise SstlError(f"'{name}' is neither a reference ({nearest(name, NAMES)}) nor a file", code="E407")
    return names, {n: reference_file.read(Path(n), dt_s) for n in names if n not in NAMES}
