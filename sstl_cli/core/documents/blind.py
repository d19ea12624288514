"""What the steps of the withheld-effect check (``sstl blind``) say."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document


class BlindMakeDocument(Document):
    """A set that was drawn and sealed (``sstl blind make``)."""

    schema_id: Literal["sstl.blind.make/1"] = Field(alias="schema")
    out: str
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
    by_simulator: list[dict[str, Any]] = Field(description="every rate by simulator, all together last")
    decidable: list[dict[str, Any]] | None = Field(description="the same on cases that the recordings could decide")
    by_d2: list[dict[str, Any]] | None = Field(description="rates in strata of the smaller distance, beside an ideal observer's")
    verdicts: list[dict[str, Any]]
    gates_missed: list[str]
    missing_results: int


class BlindLimitDocument(Document):
    """How far the truth of each case is from the base and its nearest rival (``sstl blind limit``)."""

    schema_id: Literal["sstl.blind.limit/1"] = Field(alias="schema")
    cases: int
    judged: int = Field(description="cases whose withheld effects the fast model can hold")
    decidable: int = Field(description="cases told from base and rivals at 49:1 in 95 of 100 repetitions, input noise not smoothed")
    decidable_known: int = Field(description="the same where the input is known")
    decidable_d2: float
    distances: list[dict[str, Any]]
    seal: str = Field(description="SHA-256 of the sealed truth")


class BlindLibraryDocument(Document):
    """A library to learn from (``sstl blind library``)."""

    schema_id: Literal["sstl.blind.library/1"] = Field(alias="schema")
    out: str
    cases: int
    failed: int
    rows: int
    simulators: list[str]
    seeds: list[list[int]] = Field(description="inclusive ranges of seeds")
    quick: bool
    accepted: bool = Field(description="whether cases are compared with a model that was accepted on a session before")


class BlindLearnDocument(Document):
    """How learned weights do on simulators that they were not learned from (``sstl blind learn``)."""

    schema_id: Literal["sstl.blind.learn/1"] = Field(alias="schema")
    out: str
    commit: float
    cover: float
    left_out: list[dict[str, Any]] = Field(description="one entry a simulator that was left out, all together last")
    accepted: list[dict[str, Any]] | None = Field(
        None, description="the same of cases compared with an accepted model, where any were given"
    )
    provenance: dict[str, Any]


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


class BlindInjectDocument(Document):
    """Known effects put into recordings of a real rig (``sstl blind real --inject``)."""

    schema_id: Literal["sstl.blind.inject/1"] = Field(alias="schema")
    rows: list[dict[str, Any]] = Field(description="what was put in and what was said; effect is null for an untouched half")
    with_model: dict[str, Any] = Field(description="counts with the model accepted on the first half as simulator")
    without_model: dict[str, Any] | None = Field(description="counts without it")
