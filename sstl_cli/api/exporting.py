"""Controllers for a rig, from Python: the lines that drive each configuration, as C99 source or as parameters (JSON)."""

from __future__ import annotations

from os import PathLike

import pandas as pd

from sstl_cli.api.control import driven
from sstl_cli.api.mapping import Mapping
from sstl_cli.control.controller import Options as ControllerOptions
from sstl_cli.control.controllers import Controllers
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import export_controller as exporting
from sstl_cli.steps.compensate_setup import Biases

__all__ = ["Controllers", "controllers"]


def controllers(
    theta: pd.DataFrame | Scenario | str | PathLike[str],
    mapping: Mapping | None = None,
    *,
    method: str | None = None,
    options: ControllerOptions | None = None,
    biases: Biases | pd.DataFrame | None = None,
    config_id: str | None = None,
) -> Controllers:
    """Return the controllers that ``sstl export`` writes.

    Parameters
    ----------
    theta : DataFrame, Scenario or path
        Theta table, as ``log.segment()`` returns it; a simulator, such as the model of a diagnosis; a file of either; or a
        parameter file (JSON).
    mapping : Mapping, optional
        Predicts the actuation slopes from the sensing loop.
    method : str, optional
        Whose lines (none, no-bias, proposed or DI); by default proposed where a mapping is given, else DI.
    options : ControllerOptions, optional
        How they act; by default as a parameter file says, else Algorithm 1.
    biases : Biases or DataFrame, optional
        Biases that go with the slopes of a mapping, or a Theta table with them; by default those it was trained on.
    config_id : str, optional
        The only configuration.

    Raises
    ------
    SstlError
        For an unknown method or configuration, or a method that is possible for none.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> found = controllers(simulate("sample", seed=1).segment())
    >>> found.method, sorted(found.lines)
    ('DI', ['CP-020', 'CP-080'])
    """
    asked, _ = driven(theta, mapping, biases, config_id, options, () if method is None else (method,))
    return exporting.controllers(asked.cases, asked.aside, method, asked.options)
