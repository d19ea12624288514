"""The diagnosis of a sim-to-real gap (``sstl diagnose``)."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from sstl_cli.core.documents.base import Document, Part
from sstl_cli.core.documents.gate import Remark
from sstl_cli.core.documents.quantity import Quantity

Interval = tuple[float | None, float | None]
Status = Literal["identified", "ambiguous", "unknown", "none"]
Identifiability = Literal["identifiable", "weak", "not_identifiable"]


class OddRun(Part):
    """A run without which the verdict differs, and what it is then."""

    run_id: str
    status: Status
    effects: list[str]


class LeastShown(Part):
    """The smallest size of an effect that this data would have shown, and the gap (N, RMS) that it leaves."""

    effect: str
    parameter: str
    unit: str
    size: Annotated[float, Quantity.OWN]
    gap_n: Annotated[float, Quantity.OUTPUT]
    rival: str | None = Field(default=None, description="the effect that it is hardest to tell from on this data")
    told_size: Annotated[float | None, Quantity.OWN] = Field(
        default=None,
        description="size from which it would have been told from that one (D^2 of 24, refitted); null: at no size within its range",
    )


class LeftOver(Part):
    """A test of what is left that noise alone does not pass, by how many sigma, and where it peaks."""

    test: str
    sigma: float
    where: str | None


class Verdict(Part):
    """What was found: the effects of the winning model, and how sure that is."""

    status: Status
    effects: list[str] = Field(description="effects of the winning model, largest first")
    confidence: float | None = Field(description="share of such verdicts that were right; null with a reason", ge=0, le=1)
    ambiguity_group: list[str] = Field(
        description="effects that are not told apart; where the cause is a candidate and something is named, the truth is among them in 90 of 100 "
        "cases (`confidence` counts the other cases, too)"
    )
    why: str
    probability_none: float | None = Field(default=None, description="part of the calibrated distribution on: nothing is missing")
    probability_unknown: float | None = Field(default=None, description="part of the calibrated distribution on: none of the candidates")
    members: dict[str, list[str]] | None = Field(
        default=None, description="parts of a class that this excitation cannot separate, and of combinations in the set"
    )
    causes: list[list[str]] | None = Field(default=None, description="the same set, one entry a candidate: effects that stand together")
    would_have_shown: list[LeastShown] | None = Field(
        default=None, description="for none: per effect the smallest size and gap that would have been seen"
    )
    leftover: list[LeftOver] | None = Field(default=None, description="for unknown: where, when, at which frequency, in which run")
    odd_runs: list[OddRun] | None = Field(
        default=None, description="runs without which the verdict differs, and what it would be; null where that was not tried"
    )
    confidence_why: str | None = Field(default=None, description="why the confidence is null")


class Gap(Part):
    """The error of the simulator step by step, in the unit of the output (newtons where it is N)."""

    rmse_base_n: Annotated[float | None, Quantity.OUTPUT] = Field(description="as given")
    rmse_retuned_n: Annotated[float | None, Quantity.OUTPUT] = Field(description="after re-tuning what the simulator has")
    rmse_with_effect_n: Annotated[float | None, Quantity.OUTPUT] = Field(description="with the named effects added")
    noise_floor_n: Annotated[float | None, Quantity.OUTPUT]
    noise_floor_low_n: Annotated[float | None, Quantity.OUTPUT] = Field(
        default=None, description="ends of its 95 % interval; null where none is known"
    )
    noise_floor_high_n: Annotated[float | None, Quantity.OUTPUT] = None
    known_misfit_n: Annotated[float | None, Quantity.OUTPUT] = Field(
        default=None, description="with an accepted model as simulator: what it is known to leave of such a record, null otherwise"
    )
    shrink_pct: float | None = Field(description="fall of the held-out error from re-tuned to with effect")
    shrink_ci95_pct: Interval | None = Field(description="null, with a reason in shrink_why, where it cannot be given")
    shrink_why: str | None = Field(default=None, description="why the interval is null")
    explained_of_reducible_pct: float | None
    explained_scale: str | None = Field(
        default=None,
        description="what explained_of_reducible_pct is of: the error above the noise floor, and above the known misfit where there is one",
    )
    accounted_pct: float | None = Field(
        default=None,
        description="share of the squared error beyond the noise that the named effects account for, where they are jumps of which only the mean "
        "can be foretold; null of other effects",
    )
    samples: str | None = Field(default=None, description="what the errors are of: analysed samples, all, or a channel beside")
    held_out: bool
    held_out_kind: str | None = Field(
        default=None, description="what was held out in turn: trajectory, configuration, run, part of the only run, or nothing"
    )
    worse_regions: list[str] | None = Field(default=None, description="systems and phases whose held-out error grew")

    @property
    def unavoidable_n(self) -> float:
        """What a perfect model would leave: the noise, and what an accepted simulator is known to leave of such a record."""
        return math.hypot(self.noise_floor_n or 0.0, self.known_misfit_n or 0.0)


class Place(Part):
    """One place of the gap: its share of the squared error, and its RMSE."""

    system: str
    phase: str
    config_id: str | None
    share_pct: float
    rmse_n: Annotated[float, Quantity.OUTPUT]


class Band(Part):
    """A range of a quantity (``from``, ``to``), or a ``name``, and its share of the squared error."""

    # "from" is no name that Python lets an argument have
    model_config = ConfigDict(frozen=True, extra="allow", populate_by_name=True)

    low: float | None = Field(default=None, alias="from")
    high: float | None = Field(default=None, alias="to")
    name: str | None = None
    share_pct: float


class TensionBand(Band):
    """A range of the input tension, or of its rate."""

    low: Annotated[float | None, Quantity.INPUT] = Field(default=None, alias="from")
    high: Annotated[float | None, Quantity.INPUT] = Field(default=None, alias="to")


class Parameter(Part):
    """An estimated parameter of a candidate with its 95 % interval."""

    name: str
    effect: str | None = Field(default=None, description="effect of the candidate that the parameter is of")
    unit: str
    estimate: Annotated[float | None, Quantity.OWN]
    ci95: Annotated[Interval | None, Quantity.OWN]
    why: str | None = Field(default=None, description="why the interval is null")
    at_bound: bool
    identifiability: Identifiability | None = None


class Candidate(Part):
    """One candidate: an effect, a combination (``a+b``), or a class with a name."""

    id: str
    probability: float | None
    rmse_held_out_n: Annotated[float | None, Quantity.OUTPUT]
    shrink_pct: float | None
    samples: str | None = Field(default=None, description="what these two are of, as gap.samples")
    evidence_nats: float | None = Field(default=None, description="its gain less what its parameters are charged")
    gain_nats: float | None = Field(
        default=None, description="log-likelihood beyond that of the re-tuned base, before parameters are charged"
    )
    discrepancy: float | None = Field(default=None, description="share of its own response by which the law of the effect may be off")
    d2: float | None = Field(default=None, description="distinguishability from the winner on this data")
    change: dict[str, float] | None = Field(
        default=None, description="where the model contains the effect: by how much its parameters differ"
    )
    sensor: list[str] | str | None = Field(
        default=None, description="the sensor that the effect sits in, where it is one of the instrument; or the channel beside"
    )
    parameters: list[Parameter]
    alternatives: list[dict[str, float]] | None = Field(
        default=None,
        description="strengths of the same effect by other hypotheses (another sensor, another law) that explain the data as well",
    )
    identifiability: Identifiability
    members: list[str] | None = None


class NextExperiment(Part):
    """The recording that would tell the leading candidates apart."""

    separates: list[str]
    trajectory: str
    why: str
    d2: float | None = Field(default=None, description="squared distance that the movement would bring between the two")
    d2_here: float | None = Field(default=None, description="the same in the log that was diagnosed")
    settles: bool | None = Field(default=None, description="whether that is enough to tell them apart (24)")
    chance: float | None = Field(
        default=None, description="share of recordings of the movement that would give 49 to 1 for the true one of the two, were laws exact"
    )
    scenario: dict[str, object] | None = Field(default=None, description="the movement as a scenario, within the limits of the rig")
    tension_factor: float | None = Field(default=None, description="one N of the scenario in the unit of the recording")


class Estimated(Part):
    """A number with its 95 % interval, or why it has none."""

    estimate: float
    ci95: Interval | None
    why: str | None = None


class EstimatedInput(Estimated):
    """The same of noise of an input's sensor, in N."""

    estimate: Annotated[float, Quantity.INPUT]
    ci95: Annotated[Interval | None, Quantity.INPUT]


class EstimatedOutput(Estimated):
    """The same of noise of an output's sensor, in the unit of the output."""

    estimate: Annotated[float, Quantity.OUTPUT]
    ci95: Annotated[Interval | None, Quantity.OUTPUT]


class OutputScale(Part):
    """The scale of an output that is not in newtons, which is nobody's fault."""

    unit: str
    per_n: dict[str, float]
    origin: dict[str, float]


class Analysis(Part):
    """What was analysed: rate, samples, runs and what was set aside, the re-tuned base by bend, and the noise by sensor.

    ``theta_before`` is that of a model that was accepted before, ``theta_with_effect`` that beside the effects that are named, and
    ``theta_changed`` whether it is another one now.
    """

    rate_hz: float
    samples: int
    runs: int
    set_aside: dict[str, str]
    theta: dict[str, float]
    noise: dict[str, dict[str, dict[str, Estimated]]]
    output_scale: OutputScale | None = None
    preload_n: dict[str, float] | None = Field(
        None,
        description="by system, by how much (N) a pair that pulls both ways is stretched where it reads nothing; unset where an input only pulls",
    )
    theta_before: dict[str, float] | None = None
    theta_with_effect: dict[str, float] | None = None
    theta_changed: bool | None = None


class Simple(Part):
    """What simpler rules would have answered; null for nothing."""

    smallest_rmse: str | None
    iid_bic: str | None


class Cosines(Part):
    """Cosines between the responses of the candidates."""

    ids: list[str]
    cosine: list[list[float]]


class LoopCurves(Part):
    """A measured loop with the simulated ones before and after, thinned for drawing."""

    run_id: str
    system: str
    tension_in_n: Annotated[list[float], Quantity.INPUT]
    measured_n: Annotated[list[float], Quantity.READING]
    base_n: Annotated[list[float], Quantity.READING]
    with_effect_n: Annotated[list[float], Quantity.READING]


class ResidualCurves(Part):
    """Measured minus simulated of one run, before and after, thinned for drawing."""

    run_id: str
    system: str
    time_s: list[float]
    tension_in_n: Annotated[list[float], Quantity.INPUT]
    base_n: Annotated[list[float], Quantity.DIFFERENCE]
    effect_n: Annotated[list[float], Quantity.DIFFERENCE]


class Beside(Part):
    """What the likeliest effect beside the output does to its channel."""

    channel: str
    unit: str
    effects: list[str]
    rmse_base: float
    rmse_with_effect: float
    shrink_pct: float
    parameters: dict[str, float]


class Tracked(Part):
    """The tracking error of a reference with a controller designed without and with the named effect."""

    reference: str
    rmse_without_n: Annotated[float, Quantity.OUTPUT]
    rmse_with_n: Annotated[float, Quantity.OUTPUT]


class Downstream(Part):
    """What the named effect is worth to a controller, on the configuration nearest the middle."""

    config_id: str
    tracking: list[Tracked]


class TendonBlock(Part):
    """One tendon of several: a block of its own, or why it could not be diagnosed."""

    tendon: str
    sentence: str
    verdict: Verdict
    gap: Gap | None = None
    where: list[Place] | None = None
    candidates: list[Candidate] | None = None
    next_experiment: NextExperiment | None = None
    beside: Beside | None = None
    downstream: Downstream | None = None
    notes: list[str] | None = None


class DiagnosisDocument(Document):
    """Where the gap between logs and simulator lies, which effect causes it, and how far it shrinks."""

    schema_id: Literal["sstl.diagnosis/1"] = Field(alias="schema")
    package_version: str | None = Field(default=None, description="version of sstl that made it")
    verdict: Verdict
    gap: Gap
    where: list[Place] = Field(description="shares sum to 100")
    where_samples: str | None = Field(default=None, description="which samples these shares are of, as gap.samples")
    where_bands: dict[str, list[Band]] | None = Field(
        default=None, description="shares by tension, rate, direction, time since a reversal, time and frequency"
    )
    candidates: list[Candidate]
    next_experiment: NextExperiment | None
    unit: str | None = Field(default=None, description="unit of the output and of all _n fields")
    remarks: list[Remark] | None = Field(default=None, description="what the check of the physics said")
    analysis: Analysis | None = None
    baselines: Simple | None = Field(default=None, description="what simpler rules would have answered")
    notes: list[str] | None = None
    isolability: Cosines | None = None
    loops: list[LoopCurves] | None = Field(default=None, description="for drawing")
    residuals: list[ResidualCurves] | None = Field(default=None, description="for drawing")
    beside: Beside | None = Field(default=None, description="what the channels beside the output show, where any does")
    sentence: str | None = Field(default=None, description="the diagnosis in one sentence")
    downstream: Downstream | None = Field(default=None, description="what the named effect is worth to a controller")
    tendon: str | None = Field(default=None, description="the leading tendon, where there are several")
    tendons: list[TendonBlock] | None = Field(default=None, description="one block a tendon, where there are several")
    inputs: dict[str, str] | None = Field(default=None, description="SHA-256 of every input file by name")
    environment: dict[str, str] | None = Field(default=None, description="SSTL_* values that were used")


class PlannedEffect(Part):
    """What a movement could tell of one effect: the size that shows, and the one from which it is told from its rival."""

    effect: str
    title: str
    parameter: str
    unit: str
    least_size: float
    gap_n: float
    shows: bool = Field(description="whether that size lies within the effect's range")
    rival: str | None
    told_size: float | None
    d2: float | None


class PlanDocument(Document):
    """What a movement could tell before it is recorded (``sstl diagnose --plan``)."""

    schema_id: Literal["sstl.diagnosis.plan/1"] = Field(alias="schema")
    runs: int
    samples: int
    noise: dict[str, float] = Field(description="noise of the sensors as the scenario states it")
    decidable_d2: float
    effects: list[PlannedEffect] = Field(
        description="smallest gap first: least_size and gap_n that show; told_size from which it is told from its rival"
    )
    classes: list[list[str]] = Field(description="effects that this movement cannot tell apart at any size within their ranges")
    set_aside: dict[str, str]
    sentence: str
    inputs: dict[str, str] | None = Field(default=None, description="SHA-256 of every input file by name")
