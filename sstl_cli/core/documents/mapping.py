"""What ``segment``, ``train`` and ``evaluate`` found."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part
from sstl_cli.core.documents.gate import Remark


class ThetaRow(Part):
    """Theta of one run: slopes, biases in N and their standard errors; null where ``status`` says why."""

    run_id: str
    config_id: str | None
    system: str
    location: str | None
    lead_mm: float | None
    gamma_p: float | None
    beta_p: float | None
    gamma_r: float | None
    beta_r: float | None
    gamma_p_se: float | None
    beta_p_se: float | None
    gamma_r_se: float | None
    beta_r_se: float | None
    inlier_p: float | None
    inlier_r: float | None
    rmse_p_n: float | None
    rmse_r_n: float | None
    loops: int
    status: str
    tendon: str | None = None


class Aside(Part):
    """A run that was set aside in part or whole."""

    run_id: str
    status: str


class SegmentDocument(Document):
    """Theta of every run (``sstl segment``)."""

    schema_id: Literal["sstl.segment/1"] = Field(alias="schema")
    out: str
    phases: str | None
    runs: int
    samples: int
    set_aside: int
    set_aside_runs: list[Aside]
    remarks: list[Remark] = Field(default=[], description="what the physics gate said (docs/gate.md)")
    theta: list[ThetaRow]
    unit: str = Field(default="N", description="unit of the output, biases and residuals")
    unit_in: str = Field(default="N", description="unit of the input; slopes are in unit / unit_in")
    seed: int


class AsideRow(Part):
    """A row of a Theta table that could not be paired, and why."""

    run_id: str
    why: str


class TrainDocument(Document):
    """A trained mapping (``sstl train``)."""

    schema_id: Literal["sstl.train/1"] = Field(alias="schema")
    out: str
    history: str | None
    pairs: int
    configurations: dict[str, int] = Field(description="configurations fitted, for validation, held out")
    seed: int
    seeds: list[int]
    default: str = Field(description="variant that predicts by default")
    variants: list[dict[str, Any]]
    tendons: list[str]
    strategy: str
    strategy_rmse: dict[str, float]
    left_out: str | None
    per_seed_split: bool
    beta_act_n: tuple[float, float] | None
    input_low: list[float]
    input_high: list[float]
    data_sha256: str
    rows: int
    set_aside: int
    set_aside_runs: list[AsideRow]


class EvaluateDocument(Document):
    """A mapping judged on held-out configurations, or Tables I and II (``sstl evaluate``)."""

    schema_id: Literal["sstl.evaluate/1"] = Field(alias="schema")
    rows: int
    set_aside: int
    set_aside_runs: list[AsideRow]
    rmse_gamma_p: float | None = None
    rmse_gamma_r: float | None = None
    rmse_total: float | None = None
    outside_range_pct: float | None = None
    variants: list[dict[str, Any]] = []
    comparisons: list[dict[str, Any]] = []
    table_i: dict[str, Any] | None = None
    table_ii: dict[str, Any] | None = None
    gate: str | None = Field(default=None, description="the gate that was missed")
