"""What ``simulate``, ``import``, ``check`` and ``info`` say of logs and other tables."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part
from sstl_cli.core.documents.gate import Remark, Sensor


class SimulateDocument(Document):
    """A log that was simulated (``sstl simulate``)."""

    schema_id: Literal["sstl.simulate/1"] = Field(alias="schema")
    out: str
    runs: int
    samples: int
    simulator: str
    effects: dict[str, dict[str, float]] = Field(description="parameters of the added effects by id")
    seed: int


class Recording(Part):
    """One recording or group of files of an import."""

    file: str
    format: str
    runs: int
    samples: int


class ClockPart(Part):
    """Offset and drift of one clock against the reference clock; null where the data were not enough."""

    reference: str
    clock: str
    offset_s: float | None
    offset_se_s: float | None
    drift_ppm: float | None
    drift_se_ppm: float | None
    correlation: float | None
    origin_s: float
    shared_content: bool
    used: bool
    why_not: str


class ImportDocument(Document):
    """Recordings taken into a log table, and what was set aside (``sstl import``)."""

    schema_id: Literal["sstl.import/1"] = Field(alias="schema")
    out: str
    recordings: list[Recording]
    runs: int
    samples_in: int
    samples_out: int
    set_aside: int
    set_aside_pct: float
    set_aside_by: dict[str, int] = Field(description="samples set aside, by reason")
    values_set_aside: dict[str, int] = Field(default={}, description="values of columns that may be empty, taken as not measured")
    found: dict[str, int] = Field(description="repeated and backward times, gaps, dropouts, spikes, filled samples")
    step_s: float | None
    gap_s: float | None
    clocks: list[ClockPart]
    files_set_aside: list[dict[str, str]] = Field(default=[], description="files of a batch with the error of each")
    remarks: list[str]
    not_a_tension: dict[str, str] | None = Field(default=None, description="unit of a column that holds no tension")


class QuestionPart(Part):
    """A line of a proposed mapping that its author still has to answer."""

    line: int
    target: str
    text: str


class GuessDocument(Document):
    """A proposed mapping of a foreign recording (``sstl import --guess``)."""

    schema_id: Literal["sstl.import-guess/1"] = Field(alias="schema")
    file: str
    files: list[str] = Field(default=[], description="all files that were looked at")
    format: str
    mapping: str = Field(description="the mapping as TOML")
    reasons: list[str]
    questions: list[QuestionPart] = Field(default=[], description="lines marked (?)")
    preview: list[str]


class Finding(Part):
    """One thing that is wrong with a table, or worth a remark."""

    file: str
    run_id: str | None
    level: Literal["failure", "remark"]
    what: str
    column: str
    count: int
    detail: str
    fix: str


class CheckDocument(Document):
    """Everything that is wrong with tables (``sstl check``); exit code 1 where ``ok`` is false."""

    schema_id: Literal["sstl.check/1"] = Field(alias="schema")
    ok: bool
    failures: int
    remarks: int
    findings: list[Finding]
    physics: list[Remark] = Field(default=[], description="what the physics gate said (docs/gate.md); in findings too")
    sensors: list[Sensor] = Field(default=[], description="how every channel of every run was sampled")
    short_left_out: int | None = Field(
        default=None, description="runs too short to be measured that physics and sensors leave out, where there are more than 1000"
    )
    files: list[str]


class LogRun(Part):
    """What one run of a log holds; times in s, tensions in their unit."""

    run_id: str
    system: str | None
    config_id: str | None
    location: str | None
    samples: int
    start_s: float | None
    end_s: float | None
    in_min_n: float | None
    in_max_n: float | None
    out_min_n: float | None
    out_max_n: float | None
    duration_s: float | None
    rate_hz: float | None


class ColumnRange(Part):
    """What one column of a table holds: its range where it holds numbers, else how many values there are."""

    nulls: int
    min: int | float | None = None
    mean: float | None = None
    max: int | float | None = None
    distinct: int | None = None
    counts: dict[str, int] | None = Field(default=None, description="rows by label, of columns that hold few")


class FileInfo(Part):
    """One table: ``runs`` for a log, ``ranges`` of the columns for others."""

    file: str
    schema_id: str = Field(alias="schema")
    version: int
    rows: int
    provenance: dict[str, Any] | None
    columns: list[str]
    runs: list[LogRun] | None = None
    runs_left_out: int | None = Field(
        default=None, description="runs of fewer than 16 samples that ``runs`` leaves out, where there are more than 1000"
    )
    ranges: dict[str, ColumnRange] | None = None


class InfoDocument(Document):
    """What tables hold and where they came from (``sstl info``)."""

    schema_id: Literal["sstl.info/1"] = Field(alias="schema")
    files: list[FileInfo]
