"""What ``sstl blind real`` says: terms taken out of the model of a real rig, and effects put into its recordings."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part
from sstl_cli.core.documents.diagnosis import Verdict


class Trial(Part):
    """One term that was taken out of a model, and what the diagnosis said then; ``taken_out`` is null where nothing was."""

    origin: str
    taken_out: str | None
    status: str
    effects: list[str]
    ambiguity_group: list[str]
    confidence: float | None
    shrink_pct: float | None
    named: bool
    in_group: bool
    wrong: bool
    values: dict[str, float] | None = None


class BlindRealDocument(Document):
    """Terms taken out of the accepted model of real recordings, and diagnosed back (``sstl blind real``)."""

    schema_id: Literal["sstl.blind.real/1"] = Field(alias="schema")
    runs: int
    samples: int
    accepted: dict[str, dict[str, float]] = Field(description="terms of the accepted model that a recording of tensions can show")
    verdict: Verdict | None = Field(description="of the recordings themselves, where they were diagnosed")
    residual_rms_n: float
    trials: list[Trial]
    named: int
    in_group: int
    wrong: int
    of: int
    false_alarm: bool
    inputs: dict[str, str] = Field(description="SHA-256 of every input file by name")


class Injected(Part):
    """An effect that was put into one log (null for the untouched half), and what was said."""

    log: str
    with_model: bool
    effect: str | None
    size: float | None
    status: str
    effects: list[str]
    ambiguity_group: list[str]
    shrink_pct: float | None
    estimate: float | None
    decidable: bool | None
    close: bool | None
    named: bool
    in_group: bool
    wrong: bool
    size_fitted: float | None = Field(default=None, description="the size in newtons, where the output has another unit")


class InjectedScore(Part):
    """Counts over what was put in."""

    of: int
    named: int
    in_group: int
    wrong: int
    decidable: int
    decidable_named: int
    close: int
    untouched: int
    untouched_none: int
    untouched_named: int


class BlindInjectDocument(Document):
    """Known effects put into recordings of a real rig (``sstl blind real --inject``)."""

    schema_id: Literal["sstl.blind.inject/1"] = Field(alias="schema")
    rows: list[Injected] = Field(description="what was put in and what was said; effect is null for an untouched half")
    with_model: InjectedScore = Field(description="counts with the model accepted on the first half as simulator")
    without_model: InjectedScore | None = Field(description="counts without it")
    inputs: dict[str, str] = Field(description="SHA-256 of every input file by name")
