"""Controllers of configurations, written for a rig: as parameters (JSON) or as C99 source."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from sstl_cli.control import parameters
from sstl_cli.control.c_source import Real, c_source
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.core.errors import UsageError
from sstl_cli.core.files import require_outputs, write_json, write_text


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
    options: Options
    set_aside: dict[str, str] = field(default_factory=dict)

    def write(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write them as parameters (JSON), whole or not at all; ``compensate`` takes the file.

        Raises
        ------
        SstlError
            If the file exists and ``force`` is not given, or cannot be written.
        """
        write_json(Path(path), parameters.document(self.lines, self.options, self.method).plain(), force)

    def chosen(self, config_id: str | None) -> str:
        """Return the configuration of this name, or the only one; SstlError (E406) for an unknown one or several."""
        return list(self.lines)[parameters.index_of(list(self.lines), config_id)]

    def write_c(
        self, path: str | PathLike[str], config_id: str | None = None, real: Real = "double", force: bool = False
    ) -> tuple[Path, Path]:
        """Write one of them as C99 source, and return its header and its source.

        Parameters
        ----------
        path : path
            Name of both files, ending in ``.c`` or ``.h``, or without an ending.
        config_id : str, optional
            Which one; needed where there are several.
        real : str
            Number type of the code, double or float.

        Raises
        ------
        SstlError
            For an unknown configuration, several where none is given, a name that is none for C source, or a file that is there
            without ``force``.
        """
        name, base = self.chosen(config_id), c_name(Path(path), str(path))
        header, source = base.with_name(base.name + ".h"), base.with_name(base.name + ".c")
        controller = Controller(self.lines[name], self.options, self.method != "none")
        code = c_source(controller, name, self.method, real, header.name)
        require_outputs(force, header, source)
        write_text(header, code.header, force)
        write_text(source, code.source, force)
        return header, source


def c_name(path: Path, where: str) -> Path:
    """Return the name of C source without its ending; UsageError (E412) for one that has another, or that compilers may not take."""
    if path.suffix not in ("", ".c", ".h"):
        raise UsageError("is not a name for C source", where=str(path), fix="give a folder or a .c file", code="E412")
    base = path.with_suffix("")
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", base.name):
        raise UsageError(f"'{base.name}' is not a portable file name", where=where, fix="use letters, digits, _ . -", code="E412")
    return base
