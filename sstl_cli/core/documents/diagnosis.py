"""The diagnosis of a sim-to-real gap (``sstl diagnose``)."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part

Interval = tuple[float | None, float | None]
Status = Literal["identified", "ambiguous", "unknown", "none"]
Identifiability = Literal["identifiable", "weak", "not_identifiable"]


class OddRun(Part):
    """A run without which the verdict differs, and what it is then."""

    run_id: str
    status: Status
    effects: list[str]


class Verdict(Part):
    """What was found: the effects of the winning model, and how sure that is."""

    status: Status
    effects: list[str] = Field(description="effects of the winning model, largest first")
    confidence: float | None = Field(description="share of such verdicts that were right; null with a reason", ge=0, le=1)
    ambiguity_group: list[str] = Field(description="set that holds the truth in 90 of 100 cases")
    why: str
    members: dict[str, list[str]] | None = Field(
        default=None, description="parts of a class that this excitation cannot separate, and of combinations in the set"
    )
    would_have_shown: Any = Field(default=None, description="for none: per effect the smallest size and gap that would have been seen")
    leftover: Any = Field(default=None, description="for unknown: where, when, at which frequency, in which run")
    odd_runs: list[OddRun] | None = Field(
        default=None, description="runs without which the verdict differs, and what it would be; null where that was not tried"
    )


class Gap(Part):
    """The error of the simulator step by step, in the unit of the output (newtons where it is N)."""

    rmse_base_n: float | None = Field(description="as given")
    rmse_retuned_n: float | None = Field(description="after re-tuning what the simulator has")
    rmse_with_effect_n: float | None = Field(description="with the named effects added")
    noise_floor_n: float | None
    noise_floor_low_n: float | None = Field(default=None, description="ends of its 95 % interval; null where none is known")
    noise_floor_high_n: float | None = None
    known_misfit_n: float | None = Field(
        default=None, description="with an accepted model as simulator: what it is known to leave of such a record, null otherwise"
    )
    shrink_pct: float | None = Field(description="fall of the held-out error from re-tuned to with effect")
    shrink_ci95_pct: Interval | None = Field(description="null, with a reason in why, where it cannot be given")
    explained_of_reducible_pct: float | None
    held_out: bool


class Place(Part):
    """One place of the gap: its share of the squared error, and its RMSE."""

    system: str
    phase: str
    config_id: str | None
    share_pct: float
    rmse_n: float


class Parameter(Part):
    """An estimated parameter of a candidate with its 95 % interval."""

    name: str
    unit: str
    estimate: float | None
    ci95: Interval | None
    at_bound: bool
    why: str | None = Field(default=None, description="why the interval is null")


class Candidate(Part):
    """One candidate: an effect, a combination (``a+b``), or a class with a name."""

    id: str
    probability: float | None
    rmse_held_out_n: float | None
    shrink_pct: float | None
    parameters: list[Parameter]
    identifiability: Identifiability
    members: list[str] | None = None
    sensor: Any = Field(default=None, description="the sensor that the effect sits in, where it is one of the instrument")
    d2: float | None = Field(default=None, description="distinguishability from the winner on this data")
    change: dict[str, Any] | None = Field(
        default=None, description="where the model contains the effect: by how much its parameters differ"
    )


class NextExperiment(Part):
    """The recording that would tell the leading candidates apart."""

    separates: list[str]
    trajectory: str
    why: str
    d2: float | None = Field(default=None, description="squared distance that the movement would bring between the two")
    d2_here: float | None = Field(default=None, description="the same in the log that was diagnosed")
    settles: bool | None = Field(default=None, description="whether that is enough to tell them apart (24)")
    scenario: dict[str, Any] | None = Field(default=None, description="the movement as a scenario, within the limits of the rig")
    tension_factor: float | None = Field(default=None, description="one N of the scenario in the unit of the recording")


class DiagnosisDocument(Document):
    """Where the gap between logs and simulator lies, which effect causes it, and how far it shrinks."""

    schema_id: Literal["sstl.diagnosis/1"] = Field(alias="schema")
    package_version: str | None = Field(default=None, description="version of sstl that made it")
    verdict: Verdict
    gap: Gap
    where: list[Place] = Field(description="shares sum to 100")
    where_samples: str | None = Field(default=None, description="which samples these shares are of, as gap.samples")
    candidates: list[Candidate]
    next_experiment: NextExperiment | None
    remarks: list[Any] | None = Field(default=None, description="what the check of the physics said")
    unit: str | None = Field(default=None, description="unit of the output and of all _n fields")
    sentence: str | None = Field(default=None, description="the diagnosis in one sentence")
    inputs: dict[str, str] | None = Field(default=None, description="SHA-256 of every input file by name")


class PlanDocument(Document):
    """What a movement could tell before it is recorded (``sstl diagnose --plan``)."""

    schema_id: Literal["sstl.diagnosis.plan/1"] = Field(alias="schema")
    sentence: str
    runs: int
    samples: int
    noise: dict[str, float] = Field(description="noise of the sensors as the scenario states it")
    decidable_d2: float
    effects: list[dict[str, Any]] = Field(
        description="smallest gap first: least_size and gap_n that show; told_size from which it is told from its rival"
    )
    classes: list[list[str]] = Field(description="effects that this movement cannot tell apart at any size within their ranges")
    set_aside: dict[str, str]
    inputs: dict[str, str] | None = Field(default=None, description="SHA-256 of every input file by name")
