"""The mapping a lab keeps: which channel is which column, in which unit, and how faults are handled."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from sstl_cli.core.config import MAX_TOML_BYTES, Model, parse, read_toml
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.pattern import compiled

SIGNAL_DIMENSION = {
    "time_s": "time",
    "tension_in_n": "force",
    "tension_out_n": "force",
    "position_in_mm": "length",
    "tension_ref_n": "force",
}
TENSIONS = ("tension_in_n", "tension_out_n")
REQUIRED = ("time_s", "tension_in_n", "tension_out_n")
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "trajectory", "tendon")
TARGETS = (*SIGNAL_DIMENSION, *LABELS)
Reference = int | str


class Source(Model):
    """Where one column comes from: channel by name, 1-based number or pattern, the difference or norm of several."""

    column: Reference | None = None
    pattern: str | None = None
    minus: tuple[Reference, Reference] | None = None
    norm: tuple[Reference, ...] | None = Field(default=None, min_length=2, max_length=8)
    zeros: tuple[float, ...] | None = None
    unit: str = ""
    as_: str | None = Field(default=None, alias="as")
    sign: Literal[1, -1] = 1
    gain: float | None = None
    offset: float = 0.0
    scale: float = 1.0
    radius_mm: float | None = Field(default=None, gt=0)
    area_mm2: float | None = Field(default=None, gt=0)
    bore_mm: float | None = Field(default=None, gt=0)
    time: Reference | None = None
    time_unit: str = "s"
    time_scale: float = Field(default=1.0, gt=0)
    time_offset: float = 0.0
    fraction: Reference | None = None
    fraction_unit: str = "ns"
    rate_hz: float | None = Field(default=None, gt=0)
    file: str | None = None

    @field_validator("pattern", "file")
    @classmethod
    def _compiles(cls, value: str | None) -> str | None:
        return compiled(value)

    @model_validator(mode="after")
    def _consistent(self) -> Source:
        given = [n for n in ("column", "pattern", "minus", "norm", "rate_hz") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError("give exactly one of column, pattern, minus, norm (and rate_hz for time_s)")
        if self.scale == 0:
            raise ValueError("scale is 0: give the factor on the recorded number")
        several = self.minus or self.norm
        if self.zeros is not None and (several is None or len(self.zeros) != len(several)):
            raise ValueError("zeros are the readings at no load of the channels of minus or norm, one each")
        # an output that is no tension may be in any unit: its numbers are kept
        for unit in filter(None, (self.time_unit, self.fraction_unit, "" if self.as_ is not None else self.unit)):
            unit_of(unit)
        if self.as_ is not None and not (0 < len(self.unit) <= 24 and self.unit.isprintable()):
            raise ValueError('as = "N" needs the unit of what the channel is, such as unit = "deg"')
        return self

    @property
    def several(self) -> tuple[Reference, ...]:
        """The channels of a difference or norm (empty for a single channel)."""
        return self.minus or self.norm or ()

    @property
    def area(self) -> float | None:
        """Piston area in mm2, from ``area_mm2`` or ``bore_mm``."""
        return math.pi * self.bore_mm**2 / 4 if self.bore_mm is not None else self.area_mm2


class Text(Model):
    """How text files are cut: see docs/import.md."""

    skip_rows: int = Field(default=0, ge=0, le=1_000_000)
    delimiter: str | None = None
    header: bool | None = None
    decimal: Literal[".", ","] | None = None
    comment: str | None = Field(default=None, min_length=1, max_length=4)
    blocks: Literal["runs", "append"] | None = None
    block_lines: tuple[str, ...] = Field(default=(), max_length=len(LABELS))

    @field_validator("block_lines")
    @classmethod
    def _compile(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for pattern in value:
            compiled(pattern)
        return value

    @model_validator(mode="after")
    def _in_blocks(self) -> Text:
        if self.block_lines and self.blocks is None:
            raise ValueError('block_lines are those of blocks: write blocks = "runs", or "append" where they are one recording')
        return self


class Time(Model):
    """How the time of a recording is made strictly increasing."""

    repeated: Literal["last", "first", "fail"] = "last"
    backward: Literal["split", "drop", "fail"] = "split"
    gap_s: float | None = Field(default=None, gt=0)
    on_gap: Literal["split", "fill", "fail"] = "split"
    start: Literal["keep", "zero"] = "keep"
    from_s: float | None = Field(default=None, ge=0)
    to_s: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _window(self) -> Time:
        if self.from_s is not None and self.to_s is not None and self.to_s <= self.from_s:
            raise ValueError(f"to_s = {self.to_s:g} is not after from_s = {self.from_s:g}")
        return self


class Repair(Model):
    """How lost and wild values are handled."""

    dropouts: Literal["drop", "interpolate", "fail"] = "drop"
    spikes: Literal["keep", "interpolate", "drop"] = "keep"
    spike_factor: float = Field(default=12.0, gt=3)
    refreshed: Literal["tension_in_n", "tension_out_n", "any", "both"] | None = None
    min_samples: int = Field(default=2, ge=2)


class Files(Model):
    """How several files form runs: each its own, appended in time, side by side with own clocks or row by row."""

    merge: Literal["no", "append", "channels", "rows"] = "no"
    key: str | None = None
    shift: bool = False


class Clocks(Model):
    """How clocks of channels with their own time are compared and set."""

    align: Literal["report", "apply", "start", "none"] = "report"
    content: tuple[Source, Source] | None = None
    max_offset_s: float | None = Field(default=None, gt=0)

    @field_validator("content", mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        return [source_of(v) for v in value] if isinstance(value, (list, tuple)) else value


class Mapping(Model):
    """A whole mapping file."""

    format: str | None = None
    text: Text = Text()
    units: dict[str, str] = {}
    columns: dict[str, Source] = {}
    constants: dict[str, str | float] = {}
    file_name: str | None = None
    manifest: str | None = None
    runs: str | None = None
    skip_samples: int = Field(default=0, ge=0)
    skip_end_samples: int = Field(default=0, ge=0, le=10_000_000)
    time: Time = Time()
    repair: Repair = Repair()
    files: Files = Files()
    clocks: Clocks = Clocks()

    @field_validator("columns", mode="before")
    @classmethod
    def _shorthand(cls, value: Any) -> Any:
        return {k: source_of(v) for k, v in value.items()} if isinstance(value, dict) else value

    @field_validator("file_name", "runs")
    @classmethod
    def _compiles(cls, value: str | None) -> str | None:
        return compiled(value)

    @field_validator("constants", mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return {k: str(v) if isinstance(v, int) and not isinstance(v, bool) and k != "lead_mm" else v for k, v in value.items()}
        return value


def source_of(value: Any) -> Any:
    """Return the long form of a column given as a bare name or number."""
    return {"column": value} if isinstance(value, (int, str)) and not isinstance(value, bool) else value


def mapping_of(document: dict[str, Any], where: str) -> Mapping:
    """Return a checked mapping; an unknown column name or unit answers with the nearest."""
    for table in ("columns", "constants"):
        for name in document.get(table, {}) if isinstance(document.get(table, {}), dict) else ():
            allowed = TARGETS if table == "columns" else LABELS
            if name not in allowed:
                raise SstlError(
                    f"'{name}' is not a column of the log table that [{table}] can give",
                    where=where,
                    fix=nearest(name, allowed),
                    code="E330",
                )
    mapping = parse(Mapping, _with_own_units(document, where), where)
    for name, source in mapping.columns.items():
        if source.rate_hz is not None and name != "time_s":
            raise SstlError(f"'{name}' cannot be a rate", where=where, fix="rate_hz belongs to time_s", code="E331")
        if source.several and (name in LABELS or name == "time_s"):
            raise SstlError(f"'{name}' cannot be made of several channels", where=where, fix="name one column", code="E331")
        if source.fraction is not None and (source.column is None if name == "time_s" else source.time is None):
            fix = "fraction belongs to the column of time_s, or to the time of a channel with a clock of its own"
            raise SstlError(f"'fraction' on {name}", where=where, fix=fix, code="E331")
        if source.as_ is not None and (name not in TENSIONS or source.as_ != "N"):
            raise SstlError(
                f"'as = {source.as_!r}' on {name}",
                where=where,
                fix='only tension_in_n and tension_out_n may hold another quantity, with as = "N"',
                code="E331",
            )
    return mapping


_OWN_UNIT = re.compile(r"\s*([+]?\d*\.?\d+(?:[eE][+-]?\d+)?)\s*(\S+)\s*")


def _with_own_units(document: dict[str, Any], where: str) -> dict[str, Any]:
    """Return the document with units that the user defined in [units] put as a known unit and a scale."""
    own, columns = document.get("units"), document.get("columns")
    if not isinstance(own, dict) or not own or not isinstance(columns, dict):
        return document
    known: dict[str, tuple[float, str]] = {}
    for name, text in own.items():
        found = _OWN_UNIT.fullmatch(text) if isinstance(text, str) else None
        if is_unit(name) or found is None or not is_unit(found[2]) or float(found[1]) == 0:
            what = f"'{name}' is a known unit" if is_unit(name) else f"unit '{name}' is {text!r}"
            fix = "choose another name" if is_unit(name) else 'give a number and a known unit, such as "0.0125 N"'
            raise SstlError(what, where=f"{where}, [units]", fix=fix, code="E331")
        known[name] = (float(found[1]), found[2])
    out = {}
    for target, source in columns.items():
        if isinstance(source, dict) and source.get("as") is None and source.get("unit") in known:
            factor, unit = known[source["unit"]]
            scale = source.get("scale", 1.0)
            source = {**source, "unit": unit, "scale": factor * scale if isinstance(scale, (int, float)) else scale}
        out[target] = source
    return {**document, "columns": out}


@dataclass(frozen=True)
class Question:
    """A line of a proposed mapping that its author still has to answer."""

    line: int
    target: str
    text: str


def open_questions(text: str) -> list[Question]:
    """Return the lines that ``sstl import --guess`` marked ``(?)`` and nobody has completed."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        body, mark, _ = line.partition("(?)")
        if mark and "=" in body:
            found.append(Question(number, body.split("=")[0].strip(" #\t"), line.strip()))
    return found


def still_open(path: Path, answered: Collection[str] = ()) -> list[Question]:
    """Return the open questions of a mapping file without those answered elsewhere."""
    try:
        asked = open_questions(path.read_text(encoding="utf-8")) if path.is_file() and path.stat().st_size <= MAX_TOML_BYTES else []
    except (OSError, ValueError):
        # what is wrong with the file is said when it is read as TOML
        return []
    return [q for q in asked if q.target not in answered]


def read_mapping(path: Path, answered: Collection[str] = ()) -> Mapping:
    """Return the mapping in a TOML file.

    Parameters
    ----------
    answered : collection of str
        Columns and labels that the command line gives: their lines in the file do not count.

    Raises
    ------
    SstlError
        If a line is still marked ``(?)``: a proposal is not taken for an answer.
    """
    asked = still_open(path, answered)
    if asked:
        more = f" (and {len(asked) - 1} more, lines {', '.join(str(q.line) for q in asked[1:9])})" if asked[1:] else ""
        raise SstlError(
            f"line {asked[0].line} still asks: {asked[0].text}{more}",
            where=str(path),
            fix="complete each such line and delete its (?), or answer with --map target=...",
            code="E348",
        )
    document = read_toml(path)
    for table in ("columns", "constants"):
        if isinstance(document.get(table), dict):
            document[table] = {k: v for k, v in document[table].items() if k not in answered}
    return mapping_of(document, str(path))
