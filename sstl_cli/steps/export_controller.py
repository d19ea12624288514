"""Turn a configuration's lines into something a rig can run: C99 source or a JSON document."""

from __future__ import annotations

from collections.abc import Sequence

from sstl_cli.control.c_source import CSource, Real, c_source
from sstl_cli.control.controller import IDENTITY, Controller, Options, Theta
from sstl_cli.core.errors import SstlError
from sstl_cli.steps.compensate import Case


def lines_for(cases: Sequence[Case], method: str | None) -> tuple[dict[str, Theta], str]:
    """Return the lines of every case that a method can drive, and the method.

    Parameters
    ----------
    method : str, optional
        By default ``proposed`` where a mapping was given, else ``DI``.

    Raises
    ------
    SstlError
        If the method is possible for no case.
    """
    usual = [c.usual_method() for c in cases]
    chosen = method or ("proposed" if "proposed" in usual else usual[0])
    found = {}
    for case in cases:
        lines = case.lines(chosen) or (IDENTITY if chosen == "none" else None)
        if lines is not None:
            found[case.config_id] = lines
    if not found:
        raise SstlError(
            f"method '{chosen}' is possible for no configuration",
            fix="segment runs of both systems, or choose another --method",
            code="E405",
        )
    return found, chosen


def to_c(config_id: str, lines: Theta, method: str, options: Options, real: Real, header_name: str) -> CSource:
    """Return header and source of one configuration."""
    return c_source(Controller(lines, options, method != "none"), config_id, method, real, header_name)
