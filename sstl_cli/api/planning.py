"""Before a recording and behind the controller: what a movement could tell, and where a tracking error comes from."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import pandas as pd
import pyarrow as pa

from sstl_cli.core.documents.control import StagesDocument
from sstl_cli.core.documents.diagnosis import PlanDocument
from sstl_cli.core.parquet import conform
from sstl_cli.core.provenance import inputs_of
from sstl_cli.core.tables import COMMAND
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import diagnose_control, diagnose_plan

__all__ = ["PlanDocument", "StagesDocument", "plan", "stages"]


def plan(scenario: Scenario | str | PathLike[str], effects: Iterable[str] | None = None) -> PlanDocument:
    """Return which effects a scenario's recordings could show and tell apart, as ``sstl diagnose --plan`` does.

    Parameters
    ----------
    scenario : Scenario, str or path
        Movements, configurations and noise: a scenario, a built-in name or a TOML file.
    effects : iterable of str, optional
        Candidates (default: all that act on the output).

    Raises
    ------
    SstlError
        If no run of the scenario could be diagnosed, its sensors are without noise, or an effect is unknown.

    Examples
    --------
    >>> [(e.effect, e.shows) for e in plan("sample", ["zero_offset"]).effects]
    [('zero_offset', True)]
    """
    given = scenario if isinstance(scenario, Scenario) else load(str(scenario))
    found = diagnose_plan.run(given, None if effects is None else tuple(effects))
    files = [Path(scenario)] if not isinstance(scenario, Scenario) and Path(scenario).is_file() else []
    return found.model_copy(update={"inputs": inputs_of(files)})


def stages(commands: pd.DataFrame) -> StagesDocument:
    """Return how the tracking error of command streams is shared over the controller's stages, as ``sstl diagnose`` does with them.

    Parameters
    ----------
    commands : DataFrame
        What ``sstl.compensate(..., commands=True)`` returns, or a table of ``sstl compensate --out``.

    Raises
    ------
    SstlError
        If no stream has both tensions, or none can be analysed.

    Examples
    --------
    >>> from sstl_cli.api.control import compensate
    >>> from sstl_cli.api.log import simulate
    >>> theta = simulate("sample", seed=1).segment()
    >>> driven = compensate(theta, methods=["DI"], cycles=1, config_id="CP-020", loop_tau_s=0.05, commands=True)
    >>> [(s.run_id, round(s.loop_tau_s, 2)) for s in stages(driven).streams]
    [('CP-020-sinusoid-DI', 0.05)]
    """
    return diagnose_control.run(conform(pa.Table.from_pandas(commands, preserve_index=False), COMMAND, "DataFrame"))
