"""The tables that subcommands pass to one another: columns, types and units in one place."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pyarrow as pa


@dataclass(frozen=True)
class Column:
    """One column of a table: its Arrow type, unit and whether nulls are allowed."""

    name: str
    type: pa.DataType
    unit: str = ""
    nullable: bool = False
    meaning: str = ""


@dataclass(frozen=True)
class Schema:
    """A named, versioned table; columns beyond these are carried along untouched."""

    id: str
    version: int
    columns: tuple[Column, ...]

    @property
    def names(self) -> list[str]:
        return [c.name for c in self.columns]

    @property
    def required(self) -> list[str]:
        return [c.name for c in self.columns if not c.nullable]

    def column(self, name: str) -> Column:
        return next(c for c in self.columns if c.name == name)

    def in_units(self, units: dict[str, str]) -> Schema:
        """Return the schema with the given columns in other units (a log whose output is no tension)."""
        return replace(self, columns=tuple(replace(c, unit=units[c.name]) if c.name in units else c for c in self.columns))

    def arrow(self) -> pa.Schema:
        """Return the Arrow schema with the unit of each column in its field metadata."""
        return pa.schema([pa.field(c.name, c.type, c.nullable, {"unit": c.unit, "meaning": c.meaning}) for c in self.columns])


_S, _F, _I = pa.string(), pa.float64(), pa.int64()

LOG = Schema(
    "sstl.log",
    1,
    (
        Column("run_id", _S, meaning="one uninterrupted recording"),
        Column("config_id", _S, nullable=True, meaning="bending configuration"),
        Column("system", _S, meaning="act (single pass) or sstl (double pass)"),
        Column("location", _S, nullable=True, meaning="NP, CP, ND or the user's own"),
        Column("lead_mm", _F, "mm", True, "lead-screw displacement"),
        Column("trajectory", _S, nullable=True, meaning="the user's label"),
        Column("time_s", _F, "s", meaning="strictly increasing within a run"),
        Column("tension_in_n", _F, "N", meaning="proximal input tension"),
        Column("tension_out_n", _F, "N", meaning="output tension: distal (act), proximal return end (sstl)"),
        Column("position_in_mm", _F, "mm", True, "proximal displacement"),
        Column("tension_ref_n", _F, "N", True, "reference being tracked"),
    ),
)
TENDON = Column("tendon", _S, nullable=True, meaning="actuation tendon, where several share one SSTL")

PARAMETERS = ("gamma_p", "beta_p", "gamma_r", "beta_r")
_UNIT = {"gamma_p": "1", "gamma_r": "1", "beta_p": "N", "beta_r": "N"}

THETA = Schema(
    "sstl.theta",
    1,
    (
        Column("run_id", _S),
        Column("config_id", _S, nullable=True),
        Column("system", _S),
        Column("location", _S, nullable=True),
        Column("lead_mm", _F, "mm", True),
        *(Column(p, _F, _UNIT[p], True) for p in PARAMETERS),
        *(Column(p + "_se", _F, _UNIT[p], True, "standard error") for p in PARAMETERS),
        Column("inlier_p", _F, "1", True, "share of RANSAC inliers, pull"),
        Column("inlier_r", _F, "1", True, "share of RANSAC inliers, release"),
        Column("rmse_p_n", _F, "N", True),
        Column("rmse_r_n", _F, "N", True),
        Column("loops", _I, "1"),
        Column("status", _S, meaning="ok, or why a value is null"),
    ),
)

PHASES = Schema("sstl.phases", 1, (Column("run_id", _S), Column("time_s", _F, "s"), Column("phase", _S, meaning="PB, PP, RB or RP")))

COMMAND = Schema(
    "sstl.command",
    1,
    (
        Column("run_id", _S),
        Column("config_id", _S, nullable=True),
        Column("location", _S, nullable=True),
        Column("trajectory", _S, nullable=True),
        Column("method", _S, meaning="none, no-bias, proposed or DI"),
        Column("time_s", _F, "s"),
        Column("tension_ref_n", _F, "N"),
        Column("tension_cmd_n", _F, "N"),
        Column("tension_in_n", _F, "N", True, "input tension reached by the tension loop"),
        Column("tension_out_n", _F, "N", True, "output tension of the plant"),
        Column("phase", _S, meaning="PB, PP, RB or RP"),
    ),
)

SCORE = Schema(
    "sstl.score",
    1,
    (
        Column("run_id", _S),
        Column("config_id", _S, nullable=True),
        Column("location", _S, nullable=True),
        Column("trajectory", _S, nullable=True),
        Column("method", _S),
        Column("window", _S, meaning="all, or without the first cycle"),
        Column("rmse_n", _F, "N"),
        Column("std_n", _F, "N", meaning="standard deviation of the signed error"),
        Column("mape_pct", _F, "%", True),
        Column("mape_floor_n", _F, "N"),
        Column("masked_pct", _F, "%", meaning="share of samples below the MAPE floor"),
        Column("reduction_pct", _F, "%", True, "RMSE reduction against no compensation"),
    ),
)

EVALUATION = Schema(
    "sstl.evaluation",
    1,
    (
        Column("variant", _S),
        Column("seed", _I, nullable=True),
        Column("rmse_gamma_p", _F, "1"),
        Column("rmse_gamma_r", _F, "1"),
        Column("rmse_total", _F, "1"),
        Column("outside_range_pct", _F, "%", meaning="test inputs outside the trained range"),
    ),
)


def theta_units(unit_in: str, unit_out: str) -> dict[str, str]:
    """Return the units of Theta's columns where input and output are not both in newtons."""
    if unit_in == unit_out == "N":
        return {}
    slope = "1" if unit_in == unit_out else f"{unit_out}/{unit_in}"
    names = [n for p in PARAMETERS for n in (p, p + "_se")]
    units = {n: slope if n.startswith("gamma") else unit_out for n in names}
    return {**units, "rmse_p_n": unit_out, "rmse_r_n": unit_out}


SCHEMAS = {s.id: s for s in (LOG, THETA, PHASES, COMMAND, SCORE, EVALUATION)}
