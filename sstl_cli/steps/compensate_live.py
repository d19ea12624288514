"""The controller of one configuration, ready for a running rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sstl_cli.control.controller import IDENTITY, Controller, Options
from sstl_cli.control.parameters import index_of
from sstl_cli.core.errors import UsageError
from sstl_cli.steps.compensate import Case


@dataclass(frozen=True)
class Live:
    """What drives a rig: its configuration, the method, and the controller at rest."""

    config_id: str
    method: str
    controller: Controller


def run(cases: Sequence[Case], config_id: str | None, method: str | None, options: Options, where: str = "") -> Live:
    """Return the controller of one configuration, at rest.

    Parameters
    ----------
    config_id : str, optional
        Which; may be left out where there is only one.
    method : str, optional
        Whose lines; by default what the configuration is usually driven with.

    Raises
    ------
    UsageError
        E405 if the method is not possible.
    SstlError
        E406 if the configuration is unknown, or there are several and none is named.
    """
    case = cases[index_of([c.config_id for c in cases], config_id)]
    chosen = method or case.usual_method()
    lines = case.lines(chosen)
    if lines is None and chosen != "none":
        raise UsageError(f"method '{chosen}' is not possible for {case.config_id}", where=where, code="E405")
    controller = Controller(lines or IDENTITY, options, chosen != "none")
    # the first call loads compiled code: not while the rig waits for its answer
    controller.step(0.0, 0.0)
    controller.reset()
    return Live(case.config_id, chosen, controller)
