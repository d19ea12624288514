"""Controllers for a rig, from Python: the lines that drive each configuration, as C99 source or as parameters (JSON)."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Literal

import pandas as pd

from sstl_cli.api.control import biases_of, source_of
from sstl_cli.api.mapping import Mapping
from sstl_cli.control import parameters
from sstl_cli.control.controller import METHODS, Theta
from sstl_cli.control.controller import Options as ControllerOptions
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.files import require_outputs, write_json, write_text
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import compensate_setup as setup
from sstl_cli.steps import export_controller as exporting
from sstl_cli.steps.compensate_setup import Biases


@dataclass(frozen=True)
class Controllers:
    """The controllers of configurations.

    Attributes
    ----------
    lines : dict of str to Theta
        Slopes and biases (N) that drive each configuration.
    method : str
        Whose lines they are: none, no-bias, proposed or DI.
    options : ControllerOptions
        How they act.
    set_aside : dict of str to str
        Configurations that cannot be driven so, and why.
    """

    lines: dict[str, Theta]
    method: str
    options: ControllerOptions
    set_aside: dict[str, str] = field(default_factory=dict)

    def write(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write them as parameters (JSON), whole or not at all; ``compensate`` takes the file.

        Raises
        ------
        SstlError
            If the file exists and ``force`` is not given, or cannot be written.
        """
        write_json(Path(path), parameters.document(self.lines, self.options, self.method).plain(), force)

    def write_c(
        self, path: str | PathLike[str], config_id: str | None = None, real: Literal["double", "float"] = "double", force: bool = False
    ) -> tuple[Path, Path]:
        """Write one of them as C99 source, and return its header and its source.

        Parameters
        ----------
        path : path
            Name of both files, ending in ``.c`` or without an ending.
        config_id : str, optional
            Which one; needed where there are several.
        real : str
            Number type of the code.

        Raises
        ------
        SstlError
            For an unknown configuration, several where none is given, or a file that is there without ``force``.
        """
        name = list(self.lines)[parameters.index_of(list(self.lines), config_id)]
        header, source = Path(path).with_suffix(".h"), Path(path).with_suffix(".c")
        code = exporting.to_c(name, self.lines[name], self.method, self.options, real, header.name)
        require_outputs(force, header, source)
        write_text(header, code.header, force)
        write_text(source, code.source, force)
        return header, source


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
        Theta table, as ``log.segment()`` returns it; a simulator, such as the model of a diagnosis, or its TOML file; or a
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
    if method is not None and method not in METHODS:
        raise SstlError(f"no method '{method}' ({nearest(method, METHODS)})", code="E404")
    source = source_of(theta)
    where = str(theta) if isinstance(theta, str | PathLike) else type(theta).__name__
    model = None if mapping is None else mapping.model
    cases, aside = setup.chosen(source.cases, source.aside, model, biases_of(biases), config_id, where)
    lines, used = exporting.lines_for(cases, method)
    aside = {**aside, **{c.config_id: f"method '{used}' is not possible" for c in cases if c.config_id not in lines}}
    return Controllers(lines, used, source.options if options is None else options, aside)
