"""What ``compensate``, ``export`` and the controller's stages say."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class CompensateDocument(Document):
    """Command streams and their scores (``sstl compensate``)."""

    schema_id: Literal["sstl.compensate/1"] = Field(alias="schema")
    seed: int
    out: str | None
    scores_file: str | None
    options: dict[str, Any] = Field(description="settings of the controller")
    methods: list[str]
    left_out_methods: dict[str, str]
    summary: list[dict[str, Any]] = Field(description="means over configurations in the steadiest window")
    scores: list[dict[str, Any]]
    runs: list[dict[str, Any]]
    set_aside: dict[str, str]
    outside_trained_range: list[str]
    worst_rmse_n: float | None
    max_rmse_n: float | None


class ExportDocument(Document):
    """Files that were written for other programs (``sstl export``)."""

    schema_id: Literal["sstl.export/1"] = Field(alias="schema")
    format: str
    input: str
    out: list[str]
    method: str | None = None
    configurations: list[str] = []
    set_aside: dict[str, str] = {}
    options: dict[str, Any] | None = None


class StageShares(Part):
    """The tracking error of one command stream, shared out over the stages of the controller."""

    run_id: str
    rmse_n: float
    simulated_rmse_n: float | None
    share_pct: dict[str, float]
    believed: dict[str, float] = Field(description="what the controller takes the line for")
    true: dict[str, float] = Field(description="what the recorded tensions show")
    loop_tau_s: float | None


class StagesDocument(Document):
    """Where the tracking error of command streams comes from (``sstl diagnose`` on commands)."""

    schema_id: Literal["sstl.stages/1"] = Field(alias="schema")
    streams: list[StageShares]
    set_aside: dict[str, str]
