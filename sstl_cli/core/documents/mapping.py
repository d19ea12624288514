"""What ``segment``, ``train`` and ``evaluate`` found."""

from __future__ import annotations

from typing import Literal

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
    set_aside_runs: list[Aside] = Field(description="the first 1000 of them")
    remarks: list[Remark] = Field(default=[], description="what the physics gate said (docs/gate.md)")
    theta: list[ThetaRow]
    theta_left_out: int | None = Field(
        default=None, description="rows without a line that ``theta`` leaves out, where there are more than 1000; the table has all"
    )
    unit: str = Field(default="N", description="unit of the output, biases and residuals")
    unit_in: str = Field(default="N", description="unit of the input; slopes are in unit / unit_in")
    seed: int


class AsideRow(Part):
    """A row of a Theta table that could not be paired, and why."""

    run_id: str
    why: str


class TrainedVariant(Part):
    """One trained variant: shortcut weight (null for linear regression), lambda, validation RMSE, and the mean of its best epochs."""

    name: str
    alpha: float | None
    weight_inv: float
    rmse_validation: float | None
    best_epoch: float | None


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
    variants: list[TrainedVariant]
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


class VariantScore(Part):
    """How a variant does on held-out pairs, by slope (``gamma_p``, ``gamma_r``) and in ``total``; null where nothing could be judged."""

    variant: str
    title: str
    rmse_mean: dict[str, float | None]
    rmse_sd_over_seeds: dict[str, float | None]
    abs_error_sd_over_samples: dict[str, float | None]
    rmse_of_mean_over_seeds: dict[str, float | None]


class ComparisonPart(Part):
    """Two variants paired over seeds: total of ``a`` minus ``b``, and p values (null where undefined)."""

    a: str
    b: str
    difference: float | None
    p_t: float | None
    p_wilcoxon: float | None
    p_holm: float | None


class CorrelationPart(Part):
    """One direction of Table I: slope of the loop against that of the tendon squared."""

    n: int
    pearson_r: float | None
    identity_rmse: float | None
    slope: float | None
    bias: float | None
    fit_rmse: float | None


class SummaryPart(Part):
    """One entry of Table II."""

    n: int
    mean: float | None
    std: float | None
    min: float | None
    max: float | None


class TablesPart(Part):
    """Tables I and II of a Theta table."""

    table_i: dict[str, CorrelationPart] | None = Field(default=None, description="by direction (pull, release)")
    table_ii: dict[str, dict[str, SummaryPart]] | None = Field(default=None, description="by system, then by quantity")


class JudgedPart(Part):
    """How the variants of a mapping do."""

    default: str | None = Field(default=None, description="the variant that is used where none is asked for; the errors here are its own")
    pairs: int | None = Field(default=None, description="configurations that were judged, one a tendon")
    seeds: list[int] | None = None
    per_seed_split: bool | None = Field(default=None, description="whether every seed held out configurations of its own")
    left_out: str | None = Field(default=None, description="the location that was held out instead of a share")
    rmse_gamma_p: float | None = None
    rmse_gamma_r: float | None = None
    rmse_total: float | None = None
    outside_range_pct: float | None = None
    outside_range: list[str] | None = Field(default=None, description="configurations outside the trained range")
    variants: list[VariantScore] = []
    comparisons: list[ComparisonPart] = []


class WrittenPart(Part):
    """The tables that were written of a mapping's errors."""

    out: str | None = Field(default=None, description="table of the errors of every variant and seed, if one was written")
    predictions: str | None = Field(default=None, description="table of true and predicted slopes, if one was written")


# fields stand in the order of the bases, the last one first
class EvaluateDocument(JudgedPart, WrittenPart, TablesPart, Document):
    """A mapping judged on held-out configurations, or Tables I and II (``sstl evaluate``)."""

    schema_id: Literal["sstl.evaluate/1"] = Field(alias="schema")
    rows: int
    set_aside: int
    set_aside_runs: list[AsideRow]
    gate: str | None = Field(default=None, description="the gate that was missed")
