"""What ``report``, ``plot``, ``batch``, ``doctor`` and ``reproduce`` did."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class ReportDocument(Document):
    """A page that was written (``sstl report``)."""

    schema_id: Literal["sstl.report/1"] = Field(alias="schema")
    out: str
    bytes: int
    sections: list[str]
    inputs: list[dict[str, str]]


class PlotDocument(Document):
    """A picture that was written (``sstl plot``)."""

    schema_id: Literal["sstl.plot/1"] = Field(alias="schema")
    out: str
    kind: str
    description: str


State = Literal["done", "skipped", "set_aside", "gate", "failed"]


class BatchResult(Part):
    """One file of a batch."""

    input: str
    output: str
    state: State
    exit_code: int
    line: str
    sha256: str | None


class BatchDocument(Document):
    """The account of a batch (``sstl batch``)."""

    schema_id: Literal["sstl.batch/1"] = Field(alias="schema")
    command: str
    options: list[str]
    out_dir: str
    files: int
    done: int
    skipped: int
    set_aside: int
    gate_missed: int
    failed: int
    results: list[BatchResult]


class ProbePart(Part):
    """One check of the installation."""

    name: str
    ok: bool
    detail: str
    fix: str


class DoctorDocument(Document):
    """What the installation is made of, and whether it works (``sstl doctor``)."""

    schema_id: Literal["sstl.doctor/1"] = Field(alias="schema")
    ok: bool
    sstl: str
    python: str
    system: str
    cores: int
    cores_usable: int
    packages: dict[str, str | None]
    extras: dict[str, bool]
    probes: list[ProbePart]


class RigPart(Part):
    """Block R: the data seeds recomputed, and what of them lies outside the committed spread."""

    seeds: list[int]
    committed_seeds: int
    outside: list[str]


class ClosedPart(Part):
    """One gap between the rig and a simulator that lacks something, before and after its diagnosis (N)."""

    missing: list[str]
    status: str
    named: list[str]
    confidence: float | None
    sentence: str
    withheld_n: list[float]
    promised_n: list[float | None]
    tracked_n: list[float | None]
    tried: list[str] = Field(default=[], description="where nothing is named: what was put in on trial for the second of each pair")
    right: bool


class EntryPart(Part):
    """One entry of a table of the paper beside ours (a row of the table ``sstl.comparison``)."""

    table: str
    block: str
    row: str
    column: str
    published: float
    published_spread: float | None
    ours: float | None
    ours_mean: float | None
    ours_sd: float | None
    difference: float | None
    verdict: str
    reason: str
    origin: str


class RungPart(Part):
    """One step beyond the paper's pipeline: measures by movement, one value a data seed; ``reversal_n`` is the RMSE where the movement turns."""

    name: str
    rmse_n: dict[str, list[float | None]]
    std_n: dict[str, list[float | None]]
    mape_pct: dict[str, list[float | None]]
    reversal_n: dict[str, list[float | None]]
    elsewhere_n: dict[str, list[float | None]]
    peak_n: dict[str, list[float | None]]


class ProbedPart(Part):
    """One probing movement: relative error of the slopes that follow from it, and the tracking RMSE with them."""

    kind: str
    time_s: float
    top_n: float
    lines_error: float | None
    segmented_error: float | None
    tracking_n: float | None
    rig: str
    calibration: str


class TendonsPart(Part):
    """Several tendons tracked in one way: RMSE by tendon."""

    way: str
    crosstalk_per_n: float
    identified_per_n: float
    rmse_n: dict[str, float | None]


class DistalPart(Part):
    """An actively bending distal joint in one way of compensation: RMSE of tension and of bending by movement."""

    way: str
    rmse_n: dict[str, float | None]
    rmse_deg: dict[str, float | None]
    joint_per_n: float
    identified_per_n: float


class ContestPart(Part):
    """Two variants of Table III compared over data sets."""

    first: str
    second: str
    difference: float = Field(description="mean of Total of the first minus the second")
    sd: float = Field(description="standard deviation of that difference")
    wins: float = Field(description="share of the data sets in which the first is better")
    p: float = Field(description="of the t test")
    p_holm: float = Field(description="the same after Holm's correction")


class MappedPart(Part):
    """Table III beside the least error that the data allow, and beside mappings trained without one location."""

    best: str
    bayes_total: float | None = Field(description="Total of the Bayes-optimal predictor on the generator")
    bayes_total_here: float | None = Field(description="the same on the rows at hand")
    tests: list[ContestPart]
    left_out: dict[str, dict[str, float | None]] = Field(description="Total by the location that was left out and by variant")


class SharePart(Part):
    """One part of the explanation of Table IV, and what it is worth."""

    part: str
    alone: float = Field(description="distance to the paper with this part alone (N)")
    without: float = Field(description="with all but this part (N)")
    share_pct: float = Field(description="Shapley share in %; those of all parts add up to 100")


class GapPart(Part):
    """Distance to the paper's Table IV, and what explains it."""

    stated: float = Field(description="with the stated settings (N)")
    fitted: float = Field(description="with the fitted settings (N)")
    shares: list[SharePart]
    shrink_pct: float = Field(description="how much less the fitted distance is, in %")


class BesidePart(Part):
    """What is told beside the entries, of what was rebuilt."""

    mapping: MappedPart | None = None
    rig: RigPart | None = None
    closed: list[ClosedPart] = []
    gap: GapPart | None = None
    better: list[RungPart] = []
    identified: dict[str, dict[str, float]] = {}
    probe: list[ProbedPart] = []
    tendons: list[TendonsPart] = []
    distal: list[DistalPart] = []


class RebuiltPart(Part):
    """The entries beside the published values, and what they say."""

    spread: str | None = None
    tables: list[str] = []
    seed: int
    seeds: int
    verdicts: dict[str, int] = {}
    facts: list[str] = []
    entries: list[EntryPart] = []
    written: list[str] = []


# fields stand in the order of the bases, the last one first
class ReproduceDocument(BesidePart, RebuiltPart, Document):
    """The paper's tables beside the published values (``sstl reproduce``)."""

    schema_id: Literal["sstl.reproduce/1"] = Field(alias="schema")
