"""What drives a controller, from a file: a Theta table, a simulator, or parameters that were exported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sstl_cli.control import parameters
from sstl_cli.control.controller import Options
from sstl_cli.core.files import read_json
from sstl_cli.core.parquet import open_table
from sstl_cli.core.tables import THETA
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import compensate
from sstl_cli.steps.compensate import Case
from sstl_cli.steps.compensate_setup import stored_cases


@dataclass(frozen=True)
class Source:
    """What drives the controller: configurations, why others are set aside, options that are stored, a simulator."""

    cases: list[Case]
    aside: dict[str, str]
    options: Options
    model: Scenario | None = None


def source_of(path: Path) -> Source:
    """Return the lines of a Theta table, of a simulator (``.toml``) or of a parameter file (``.json``).

    Raises
    ------
    SstlError
        If the file is missing, damaged, or something else.
    """
    if path.suffix == ".json":
        stored = parameters.read(read_json(path, parameters.SCHEMA), str(path))
        return Source(stored_cases(stored.configurations), {}, stored.options)
    if path.suffix == ".toml":
        return simulated(load(str(path)))
    return Source(*compensate.cases_of(open_table(path, THETA).table()), Options())


def simulated(model: Scenario) -> Source:
    """Return the lines that a simulator shows with every effect in it."""
    # loads the models that a diagnosis fits, which a controller on a running rig need not wait for
    from sstl_cli.steps.compensate_model import cases_of

    return Source(*cases_of(model), Options(), model)
