"""The mapping a lab keeps: which channel is which column, in which unit, and how faults are handled."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from sstl_cli.core.config import Model, parse, read_toml
from sstl_cli.core.errors import SstlError, UsageError, nearest
from sstl_cli.core.units import unit_of

SIGNAL_DIMENSION = {
    "time_s": "time",
    "tension_in_n": "force",
    "tension_out_n": "force",
    "position_in_mm": "length",
    "tension_ref_n": "force",
}
REQUIRED = ("time_s", "tension_in_n", "tension_out_n")
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "trajectory", "tendon")
TARGETS = (*SIGNAL_DIMENSION, *LABELS)
Reference = int | str


class Source(Model):
    """Where one column comes from: channel by name, 1-based number or pattern, or the difference of two."""

    column: Reference | None = None
    pattern: str | None = None
    minus: tuple[Reference, Reference] | None = None
    unit: str = ""
    as_: str | None = Field(default=None, alias="as")
    sign: Literal[1, -1] = 1
    gain: float | None = None
    offset: float = 0.0
    radius_mm: float | None = Field(default=None, gt=0)
    area_mm2: float | None = Field(default=None, gt=0)
    bore_mm: float | None = Field(default=None, gt=0)
    time: Reference | None = None
    time_unit: str = "s"
    rate_hz: float | None = Field(default=None, gt=0)
    file: str | None = None

    @field_validator("pattern", "file")
    @classmethod
    def _compiles(cls, value: str | None) -> str | None:
        return compiled(value)

    @field_validator("unit", "time_unit")
    @classmethod
    def _known(cls, value: str) -> str:
        if value:
            unit_of(value)
        return value

    @model_validator(mode="after")
    def _one_source(self) -> Source:
        given = [n for n in ("column", "pattern", "minus", "rate_hz") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError("give exactly one of column, pattern, minus (and rate_hz for time_s)")
        return self

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


class Time(Model):
    """How the time of a recording is made strictly increasing."""

    repeated: Literal["last", "first", "fail"] = "last"
    backward: Literal["split", "drop", "fail"] = "split"
    gap_s: float | None = Field(default=None, gt=0)
    on_gap: Literal["split", "fill", "fail"] = "split"
    start: Literal["keep", "zero"] = "keep"


class Repair(Model):
    """How lost and wild values are handled."""

    dropouts: Literal["drop", "interpolate", "fail"] = "drop"
    spikes: Literal["keep", "interpolate", "drop"] = "keep"
    spike_factor: float = Field(default=12.0, gt=3)
    min_samples: int = Field(default=2, ge=2)


class Files(Model):
    """How several files form runs: each its own, appended in time, or side by side with own clocks."""

    merge: Literal["no", "append", "channels"] = "no"
    key: str | None = None
    shift: bool = False


class Clocks(Model):
    """How clocks of channels with their own time are compared and set."""

    align: Literal["report", "apply", "none"] = "report"
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
    columns: dict[str, Source] = {}
    constants: dict[str, str | float] = {}
    file_name: str | None = None
    manifest: str | None = None
    runs: str | None = None
    skip_samples: int = Field(default=0, ge=0)
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
            return {
                k: str(v) if isinstance(v, int) and not isinstance(v, bool) and k != "lead_mm" else v
                for k, v in value.items()
            }
        return value


def source_of(value: Any) -> Any:
    """Return the long form of a column given as a bare name or number."""
    return {"column": value} if isinstance(value, (int, str)) and not isinstance(value, bool) else value


def compiled(pattern: str | None) -> str | None:
    """Return a pattern that compiles; ValueError says where it does not."""
    if pattern is not None:
        try:
            re.compile(pattern)
        except re.error as error:
            raise ValueError(f"pattern does not compile: {error}") from None
    return pattern


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
    mapping = parse(Mapping, document, where)
    for name, source in mapping.columns.items():
        if source.rate_hz is not None and name != "time_s":
            raise SstlError(f"'{name}' cannot be a rate", where=where, fix="rate_hz belongs to time_s", code="E331")
        if source.minus is not None and name in LABELS:
            raise SstlError(f"'{name}' is a label, not a difference", where=where, code="E331")
        if source.as_ is not None and (name != "tension_out_n" or source.as_ != "N"):
            raise SstlError(
                f"'as = {source.as_!r}' on {name}",
                where=where,
                fix='only tension_out_n may hold another output, with as = "N"',
                code="E331",
            )
    return mapping


def read_mapping(path: Path) -> Mapping:
    """Return the mapping in a TOML file."""
    return mapping_of(read_toml(path), str(path))


def inline_mapping(text: str, base: Mapping | None = None) -> Mapping:
    """Return the mapping of a ``--map`` text, laid over ``base``.

    Parameters
    ----------
    text : str
        Comma-separated ``target=source[:unit]``. A source is ``colN``, ``-colN`` (sign), ``colA-colB``
        (difference), ``/pattern/`` or a channel name; a label takes a plain text as a constant.

    Raises
    ------
    UsageError
        If a part is not understood, a target unknown, or a unit unknown.
    """
    document: dict[str, Any] = base.model_dump(by_alias=True, exclude_unset=True) if base else {}
    columns, constants = dict(document.get("columns", {})), dict(document.get("constants", {}))
    for part in filter(None, (p.strip() for p in text.split(","))):
        target, equals, value = (x.strip() for x in part.partition("="))
        if not equals or not value:
            raise UsageError(f"'{part}' is not target=source[:unit]", where="--map", code="E332")
        if target not in TARGETS:
            raise UsageError(f"unknown column '{target}'", where="--map", fix=nearest(target, TARGETS), code="E330")
        source = _inline_source(value, target)
        constants.pop(target, None)
        columns.pop(target, None)
        if isinstance(source, str):
            constants[target] = source
        else:
            columns[target] = source
    document["columns"], document["constants"] = columns, constants
    try:
        return mapping_of(document, "--map")
    except UsageError:
        raise
    except SstlError as error:
        raise UsageError(error.what, where="--map", fix=error.fix, code=error.code) from None


def _inline_source(value: str, target: str) -> dict[str, Any] | str:
    body, unit = value, ""
    if target in SIGNAL_DIMENSION and ":" in value:
        body, _, unit = value.rpartition(":")
    sign = 1
    if body.startswith("-") and len(body) > 1:
        sign, body = -1, body[1:]
    source: dict[str, Any] = {"unit": unit, "sign": sign}
    difference = re.fullmatch(r"col(\d+)-col(\d+)", body)
    if difference:
        return {**source, "minus": [int(difference[1]), int(difference[2])]}
    number = re.fullmatch(r"col(\d+)", body)
    if number:
        return {**source, "column": int(number[1])}
    if len(body) > 2 and body[0] == body[-1] == "/":
        return {**source, "pattern": body[1:-1]}
    if target in LABELS:
        return {"column": body[1:]} if body.startswith("@") else value
    return {**source, "column": body}


def with_policy(mapping: Mapping, on_gap: str | None, merge: str | None) -> Mapping:
    """Return the mapping with policies from the command line laid over it."""
    document = mapping.model_dump(by_alias=True, exclude_unset=True)
    if on_gap is not None:
        if on_gap not in ("split", "fill", "fail"):
            raise UsageError(f"--on-gap is '{on_gap}'", fix="use split, fill or fail", code="E332")
        document["time"] = {**document.get("time", {}), "on_gap": on_gap}
    if merge is not None:
        if merge not in ("no", "append", "channels"):
            raise UsageError(f"--merge is '{merge}'", fix="use append or channels", code="E332")
        document["files"] = {**document.get("files", {}), "merge": merge}
    return mapping_of(document, "mapping")
