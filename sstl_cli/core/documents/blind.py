"""What the steps of the withheld-effect check (``sstl blind``) say."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document


class BlindMakeDocument(Document):
    """A set that was drawn and sealed (``sstl blind make``)."""

    schema_id: Literal["sstl.blind.make/1"] = Field(alias="schema")
    out: str
    purpose: str
    quick: bool
    cases: int
    samples: int
    seal: str = Field(description="SHA-256 of the sealed truth")


class BlindRunDocument(Document):
    """How many cases were diagnosed (``sstl blind run``)."""

    schema_id: Literal["sstl.blind.run/1"] = Field(alias="schema")
    out: str
    diagnosed: int
    kept: int


class BlindScoreDocument(Document):
    """How well the diagnosis did, by strength and effect (``sstl blind score``)."""

    schema_id: Literal["sstl.blind.score/1"] = Field(alias="schema")
    cases: int
    scores: dict[str, Any]
    verdicts: list[dict[str, Any]]
    gates_missed: list[str]
    missing_results: int


class BlindCalibrationDocument(Document):
    """The calibration of a diagnosis on a library kept apart (``sstl blind calibrate``)."""

    schema_id: Literal["sstl.blind.calibration/1"] = Field(alias="schema")
    cases: int
    seeds: list[int]


class BlindRealDocument(Document):
    """Terms taken out of the accepted model of real recordings, and diagnosed back (``sstl blind real``)."""

    schema_id: Literal["sstl.blind.real/1"] = Field(alias="schema")
    runs: int
    samples: int
    trials: list[dict[str, Any]]
    named: int
    wrong: int
    of: int
    false_alarm: bool
