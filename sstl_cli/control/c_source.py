"""The controller of one configuration as self-contained C99, the mirror of :mod:`sstl_cli.control.law`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from importlib import resources
from typing import Literal

from sstl_cli.control import law
from sstl_cli.control.controller import Controller

Real = Literal["double", "float"]
_CONSTANTS = {
    "GAMMA_P": law.P_GP,
    "BETA_P": law.P_BP,
    "GAMMA_R": law.P_GR,
    "BETA_R": law.P_BR,
    "T_MAX": law.P_T_MAX,
    "STEP_MAX": law.P_STEP_MAX,
    "LOOP_GAIN": law.P_LOOP_GAIN,
    "DEADBAND": law.P_DEADBAND,
    "BAND": law.P_BAND,
    "REF_LOW": law.P_REF_LOW,
    "REF_HIGH": law.P_REF_HIGH,
    "IN_LOW": law.P_IN_LOW,
    "IN_HIGH": law.P_IN_HIGH,
    "RAMP": law.P_RAMP,
    "OBSERVER": law.P_OBSERVER,
}


@dataclass(frozen=True)
class CSource:
    """A header and a source file, as text."""

    header: str
    source: str


SINGLE = """ *
 * Single precision: commands are within 5 mN of those in double. A decision that hangs on less (a turn of the
 * reference by under one part in ten million, the end of backlash or of a return after a loss) may fall some
 * samples apart, and with it the command, never outside its range and its bounds.
"""


def c_source(
    controller: Controller, config_id: str, method: str = "DI", real: Real = "double", header_name: str = "sstl_controller.h"
) -> CSource:
    """Return the C99 text of a controller.

    Parameters
    ----------
    real : {"double", "float"}
        Type of every tension; ``double`` gives the commands of the Python controller.
    header_name : str
        File name under which the source includes the header.
    """
    p = controller.vector
    bounded = math.isfinite(p[law.P_STEP_MAX])
    plays = int(p[law.P_PLAYS])
    lines = []
    for name, index in _CONSTANTS.items():
        # the bound is not used where there is none, and infinity has no literal
        value = float(p[index]) if math.isfinite(p[index]) else 0.0
        lines.append(f"static const sstl_real {name} = {_literal(value)}; /* {value:.6g} */")
    tolerance = law.SOLVE_TOLERANCE_N if real == "double" else 1e-5
    lines.append(f"static const sstl_real TOLERANCE = {_literal(tolerance)}; /* {tolerance:g} N */")
    slack = law.SLACK_N
    lines.append(f"static const sstl_real SLACK = {_literal(slack)}; /* {slack:g} N */")
    lines.append(f"static const long HOLD = {int(p[law.P_HOLD])}L; /* samples */")
    suffix = "" if real == "double" else "f"
    values = {
        "CONFIG": _comment(config_id),
        "METHOD": _comment(method),
        "PERIOD": f"{controller.options.dt_s:g}",
        "PRECISION": SINGLE if real == "float" else "",
        "REAL": real,
        "PLAYS": str(plays),
        "HEADER": header_name,
        "CONSTANTS": "\n".join(lines),
        "SHARES": ", ".join(_literal(float(v)) for v in p[law.P_SHARES :]),
        "BOUNDED": str(int(bounded)),
        "COMPENSATE": str(int(p[law.P_COMPENSATE])),
        "DOUBLED": str(int(p[law.P_DOUBLED])),
        "FOLLOW": str(int(p[law.P_FOLLOW])),
        "FABS": f"fabs{suffix}",
        "SQRT": f"sqrt{suffix}",
    }
    return CSource(_fill("controller.h", values), _fill("controller.c", values))


def _fill(name: str, values: dict[str, str]) -> str:
    text = (resources.files("sstl_cli.control") / "templates" / name).read_text(encoding="utf-8")
    return re.sub(r"@([A-Z]+)@", lambda match: values[match.group(1)], text)


def _literal(value: float) -> str:
    """Return a hexadecimal constant, which C99 reads without rounding."""
    return f"(sstl_real){value.hex()}"


def _comment(text: str) -> str:
    """Return text that cannot end a C comment or leave its line."""
    return re.sub(r"[^A-Za-z0-9 ._-]", "_", text)
