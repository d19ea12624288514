"""Choose the lines that drive each configuration of a rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sstl_cli.control.controller import IDENTITY, Options, Theta
from sstl_cli.control.controllers import Controllers
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


def controllers(cases: Sequence[Case], aside: Mapping[str, str], method: str | None, options: Options) -> Controllers:
    """Return the controllers of cases, and those that were set aside before with those that the method cannot drive.

    Raises
    ------
    SstlError
        If the method is possible for no case.
    """
    lines, chosen = lines_for(cases, method)
    undriven = {c.config_id: f"method '{chosen}' is not possible" for c in cases if c.config_id not in lines}
    return Controllers(lines, chosen, options, {**aside, **undriven})
