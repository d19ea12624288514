"""What ``compensate``, ``export`` and the controller's stages say."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class ScoreRow(Part):
    """The tracking errors of one run under one method within one window."""

    run_id: str
    config_id: str | None
    location: str | None
    trajectory: str | None
    method: str
    window: str
    rmse_n: float | None
    std_n: float | None
    mape_pct: float | None
    mape_floor_n: float
    masked_pct: float
    reduction_pct: float | None


class MeanScore(Part):
    """Means over ``n`` configurations of one reference, place and method."""

    trajectory: str | None
    location: str | None
    method: str
    n: int
    rmse_n: float | None
    std_n: float | None
    mape_pct: float | None
    reduction_pct: float | None
    window: str


class CompensatedRun(Part):
    """What is told of one run beside its scores."""

    run_id: str
    config_id: str | None
    trajectory: str | None
    method: str
    theta: tuple[float, float, float, float] | None = Field(description="gamma_p, beta_p, gamma_r and beta_r of the controller")
    slopes_from: Literal["mapping", "identified"] | None
    outside_trained_range: bool
    bound_cost_n: float | None = Field(description="RMSE that the bounds on rate and jump cost")
    mape_bound_pct: dict[str, float | None] = Field(description="the least MAPE that these bounds allow, by window")


class ControllerSettings(Part):
    """How the controller acts."""

    dt_s: float = Field(description="period of the controller")
    doubled: bool = Field(description="doubled error term in backlash")
    t_max_n: float = Field(description="largest command")
    max_rate_n_s: float | None = Field(description="largest rate of the command, null where it has no bound")
    max_jump_n: float | None = Field(description="largest change of the command in one sample, null where it has no bound")
    lead_s: float = Field(description="lead for the lag of the tension loop")
    observer: float = Field(
        description="share of the difference between measured and modelled tension that corrects the state behind the lead"
    )
    reversal: Literal["paper", "play"] = Field(description="reversals by Algorithm 1, or by the exact inverse of the play")
    presliding: float = Field(description="spread of presliding that is followed, 0 to 1")
    widths: list[float] | None = Field(description="relative widths of the plays instead, where they were fitted")
    band_n: float = Field(
        description="with reversal play: how far from the modelled output the reference must be, against the way it goes, for a new command"
    )
    deadband_n: float = Field(description="change of the reference that is no reversal")
    tolerance_n: float = Field(description="by how much reference and measured tension may leave their range before they count as faulty")
    hold_s: float = Field(description="for how long the last command is held where what is read is faulty")
    ramp_n_s: float = Field(description="rate (N/s) at which the command falls to zero after that, and comes back")


class CompensateDocument(Document):
    """Command streams and their scores (``sstl compensate``)."""

    schema_id: Literal["sstl.compensate/1"] = Field(alias="schema")
    seed: int
    out: str | None
    scores_file: str | None
    options: ControllerSettings = Field(description="settings of the controller")
    methods: list[str]
    left_out_methods: dict[str, str]
    summary: list[MeanScore] = Field(description="means over configurations in the steadiest window")
    scores: list[ScoreRow]
    runs: list[CompensatedRun]
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
    options: ControllerSettings | None = None


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
