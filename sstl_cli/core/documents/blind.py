"""What the steps of the withheld-effect check (``sstl blind``) say."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class Share(Part):
    """A proportion k of n with its Wilson interval; null in place of one where no case bears on it."""

    k: int
    n: int
    share: float
    low: float
    high: float


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


class Scores(Part):
    """Every rate of a set of cases."""

    false_alarm: Share | None
    isolation: Share | None = Field(description="strengths above 0.6 times the noise")
    isolation_weak: Share | None = Field(description="strengths of 0.1 to 0.6 times the noise")
    wrong_commits: Share | None
    unknown_recall: Share | None
    both_of_a_pair: Share | None
    ece: float | None = Field(description="expected calibration error")
    coverage: Share | None = Field(description="ambiguity groups that hold the truth")
    ece_chance: float | None = Field(None, description="calibration error that perfect calibration exceeds in 5 of 100 such sets")
    slope: float | None = Field(None, description="calibration slope: 1 is right, more is underconfident")

    def of(self, name: str) -> tuple[float | None, Share | None]:
        """Return a rate by its name: its value, and the proportion where it is one."""
        found: Share | float | None = getattr(self, name)
        return (found.share, found) if isinstance(found, Share) else (found, None)


class Confusion(Part):
    """Counts of truth (rows) against verdict (columns)."""

    labels: list[str]
    columns: list[str]
    matrix: list[list[int]]


class StrengthRow(Part):
    """The rates at one strength: gap over noise."""

    strength: float
    isolation: Share | None
    first_named: Share | None
    in_group: Share | None
    said_none: Share | None
    wrong_commits: Share | None
    unknown_recall: Share | None
    both_of_a_pair: Share | None
    coverage: Share | None
    group_size: float | None


class NothingRow(Part):
    """The rates where nothing was withheld."""

    strength: None
    nothing_missing: bool
    false_alarm: Share | None
    named: Share | None
    said_unknown: Share | None


class CaseLine(Part):
    """One case: what was withheld and what was said."""

    case: str
    kind: str
    withheld: list[str]
    strength: float | None
    status: str
    effects: list[str]
    ambiguity_group: list[str]
    confidence: float | None
    right: bool
    wrong_commit: bool


class EffectRow(Part):
    """Isolation of one effect by strength, and its misses."""

    effect: str
    isolation: dict[str, Share | None]
    below: int = Field(alias="below_0.1", description="cases below a tenth of the noise")
    misses: list[CaseLine]
    reason: str


class RuleRow(Part):
    """What the diagnosis or a simpler rule answered at one strength."""

    name: str
    strength: float
    isolation: Share | None
    false_alarm: Share | None
    wrong_commits: Share | None
    unknown_recall: Share | None


class ReliabilityBin(Part):
    """Verdicts of about one stated confidence, and the share of them that was right."""

    p_low: float
    p_high: float
    mean_p: float
    share_right: float
    n: int


class CalibrationRow(Part):
    """Stated confidence against the share that was right, beside what chance alone would show."""

    cases: str = Field(description="all, something missing or nothing missing")
    n: int
    stated: float | None = Field(description="mean confidence")
    right: float | None = Field(description="share that was right")
    ece: float | None = Field(description="expected calibration error")
    ece_chance: float | None = Field(description="mean of what as many verdicts that are right as often as they say would show")
    ece_chance_95: float | None = Field(description="what those would exceed in 5 of 100 sets")
    slope: float | None = Field(description="logistic regression of right on the logit of the confidence; null where there is none")
    slope_low: float | None = Field(description="95 % interval of the slope, from")
    slope_high: float | None = Field(description="to")


class AgainstLimit(Part):
    """What the targets ask of cases by what their recordings could decide."""

    isolation: Share | None = Field(description="single effects at any strength, of decidable cases")
    unknown_recall: Share | None = Field(description="causes that are no candidate, of decidable cases")
    unknown_recall_joined: Share | None = Field(
        None, description="the same, of cases that are decidable against pairs and triples of candidates as well"
    )
    both_of_a_pair: Share | None = Field(description="pairs, of decidable cases")
    ideal: float | None = Field(description="what an ideal observer would isolate of the same single effects")
    undecidable_in_set: Share | None = Field(description="single effects and pairs that are not decidable: sets that hold the truth")


class GroupSize(Part):
    """Size and coverage of the ambiguity set where a verdict names something that was withheld."""

    mean_size: float | None
    largest: int | None
    coverage: Share | None


class ShrunkCase(Part):
    """How far the gap of a case was said to shrink, and how far it did on recordings nobody diagnosed."""

    case: str
    predicted_pct: float
    realised_pct: float


class PoorRates(Part):
    """The rates on movements that excite little."""

    wrong_commits: Share | None
    abstained: Share | None
    coverage: Share | None


class WrongNominal(Part):
    """The rates where the stated simulator was wrong."""

    false_alarm: Share | None
    isolation: Share | None


class Seconds(Part):
    """Time a case."""

    mean: float | None
    max: float | None
    long_mean: float | None = Field(None, description="of cases of 50 000 samples and more")
    long_cases: int = Field(0, description="how many those are")


class TargetRow(Part):
    """A rate beside its target; ``met`` is null where no case bears on it."""

    id: str
    name: str
    value: float | None
    target: float
    rule: Literal["max", "min", "within"]
    met: bool | None
    k: int | None = None
    n: int | None = None
    low: float | None = None
    high: float | None = None
    chance: float | None = Field(None, description="what chance gives: the target counts as met up to here as well")


class SimulatorRow(Part):
    """Every rate of one simulator, or of all."""

    simulator: str
    cases: int
    scores: Scores
    isolation: dict[str, Share | None] = Field(description="by strength")
    in_group: dict[str, Share | None] = Field(description="by strength")


class DistanceRow(Part):
    """Rates in one stratum of the distance, beside an ideal observer's."""

    d2_low: float
    d2_high: float | None
    cases: int
    d2_median: float | None = Field(None, description="median distance of the single effects")
    isolation: Share | None
    in_group: Share | None
    ideal: float | None
    unknown_recall: Share | None
    both_of_a_pair: Share | None


class BlindScoreDocument(Document):
    """How well the diagnosis did, by strength and effect (``sstl blind score``)."""

    schema_id: Literal["sstl.blind.score/1"] = Field(alias="schema")
    cases: int
    kinds: dict[str, int]
    confusion: Confusion
    by_strength: list[StrengthRow | NothingRow] = Field(description="the row of what had nothing missing last")
    by_effect: list[EffectRow]
    baselines: list[RuleRow] = Field(description="the diagnosis beside simpler rules")
    reliability: list[ReliabilityBin]
    ece: float | None
    group: GroupSize
    shrink: list[ShrunkCase]
    shrink_mean_difference_pct: float | None
    poor: PoorRates
    wrong_nominal: WrongNominal
    seconds: Seconds
    verdicts: list[CaseLine]
    scores: Scores
    targets: list[TargetRow]
    by_simulator: list[SimulatorRow] = Field(description="every rate by simulator, all together last")
    left_out: list[SimulatorRow] | None = Field(
        None, description="the same, each simulator judged by weights that were learned without it; null where results keep no rows"
    )
    decidable: list[SimulatorRow] | None = Field(description="the same on cases that the recordings could decide")
    by_d2: list[DistanceRow] | None = Field(description="rates in strata of the smaller distance, beside an ideal observer's")
    against_limit: AgainstLimit | None = Field(None, description="what the targets ask of decidable and of undecidable cases")
    calibration: list[CalibrationRow] | None = Field(None, description="of all cases, and of those with and without something missing")
    missing_results: int
    quick: bool
    seal: str = Field(description="SHA-256 of the sealed truth")
    learned_from: list[list[int]] = Field(description="inclusive ranges of seeds that the weights were learned from")
    gates_missed: list[str]


class CaseDistance(Part):
    """How far the truth of one case is from the base and its nearest rival; null, with a reason, where it cannot be said."""

    case: str
    effects: list[str]
    channel: str | None
    d2_base: float | None
    d2_rival: float | None
    rival: str | None
    d2_base_known: float | None
    d2_rival_known: float | None
    d2_law: float | None
    d2_own: float | None
    rivals: dict[str, float]
    decidable: bool
    decidable_known: bool
    why: str | None
    d2_joined: float | None = Field(None, description="to the nearest pair or triple of candidates, where the truth is no candidate")
    joined: str | None = Field(None, description="that pair or triple")


class BlindLimitDocument(Document):
    """How far the truth of each case is from the base and its nearest rival (``sstl blind limit``)."""

    schema_id: Literal["sstl.blind.limit/1"] = Field(alias="schema")
    cases: int
    judged: int = Field(description="cases in which something was withheld and a distance could be taken")
    decidable: int = Field(description="cases told from base and rivals at 49:1 in 95 of 100 repetitions, input noise not smoothed")
    decidable_known: int = Field(description="the same where the input is known")
    decidable_d2: float
    distances: list[CaseDistance]
    seal: str = Field(description="SHA-256 of the sealed truth")


class BlindLibraryDocument(Document):
    """A library to learn from (``sstl blind library``)."""

    schema_id: Literal["sstl.blind.library/1"] = Field(alias="schema")
    out: str
    cases: int
    failed: int
    simulators: list[str]
    seeds: list[list[int]] = Field(description="inclusive ranges of seeds")
    quick: bool
    recordings: str = Field(description="complete and at a steady rate (plain), as labs make them (lab), or both in turn (mixed)")
    strengths: list[float] = Field(description="gaps over the noise, in turn")
    accepted: bool = Field(description="whether cases are compared with a model that was accepted on a session before")
    habits: bool = Field(False, description="whether rigs do what no law describes, beside what is withheld")
    rows: int


class LearnedRow(Part):
    """How weights learned on the other simulators do on one."""

    simulator: str
    cases: int
    kinds: dict[str, int]
    exact: dict[str, Share | None] = Field(description="by strength")
    both_of_a_pair: Share | None
    covered: Share | None
    false_alarm: Share | None
    wrong_commits: Share | None
    unknown_recall: Share | None
    right: Share | None
    wrong_as_drawn: Share | None = Field(description="with causes that are no candidate as they were drawn, whether or not one could tell")


class BlindLearnDocument(Document):
    """How learned weights do on simulators that they were not learned from (``sstl blind learn``)."""

    schema_id: Literal["sstl.blind.learn/1"] = Field(alias="schema")
    commit: float
    cover: float
    left_out: list[LearnedRow] = Field(description="one entry a simulator that was left out, all together last")
    accepted: list[LearnedRow] | None = Field(None, description="the same of cases compared with an accepted model, where any were given")
    out: str
    provenance: dict[str, object]
