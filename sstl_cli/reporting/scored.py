"""The score of a withheld-effect check as a page shows it: ``sstl.blind.score/1`` of this version or an older one."""

from __future__ import annotations

from typing import Annotated

from sstl_cli.reporting.documents import NAN, PART, ROWS, Matrix, Number, Rate, Share, Shown, Text, Texts


class Rates(Shown):
    """The rates that every comparison has."""

    isolation: Share = Rate()
    false_alarm: Share = Rate()
    wrong_commits: Share = Rate()
    unknown_recall: Share = Rate()

    def of(self, score: str) -> Rate:
        """Return one of them by its name."""
        found: Rate = getattr(self, score)
        return found


class Strength(Rates):
    """The rates at one strength: gap over noise RMS."""

    strength: Number = NAN


class Rule(Rates):
    """The rates of a simpler rule on the same cases."""

    name: Text = "?"


class Effect(Shown):
    """How often one effect was named at each strength, and why it was likely missed."""

    effect: Text = ""
    isolation: Annotated[dict[str, Share], PART] = {}
    reason: Text = ""


class Bin(Shown):
    """Verdicts of about one stated probability, and how many of them were right."""

    p_low: Number = NAN
    p_high: Number = NAN
    mean_p: Number = NAN
    share_right: Number = NAN
    n: Number = NAN


class Stratum(Shown):
    """Single effects whose distance to base and nearest rival is alike: how many were named, and in the set."""

    d2_median: Number = NAN
    isolation: Share = Rate()
    in_group: Share = Rate()


class Target(Shown):
    """A score beside what is asked of it; ``met`` is null where no case bears on it."""

    name: Text = ""
    value: Number = NAN
    target: Number = NAN
    met: object = None


class Shrunk(Shown):
    """How far the gap of one case was said to shrink, and how far it did."""

    predicted_pct: Number = NAN
    realised_pct: Number = NAN


class Confusion(Shown):
    """What was withheld (rows) against what was named (columns; as the rows where the document has none)."""

    labels: Texts = ()
    columns: Texts = ()
    matrix: Matrix = ()


class Scored(Shown):
    """The score of a set of cases."""

    file: Text = ""
    name: Text = ""
    cases: object = None
    seal: Text = ""
    confusion: Annotated[Confusion, PART] = Confusion()
    by_strength: Annotated[tuple[Strength, ...], ROWS] = ()
    by_effect: Annotated[tuple[Effect, ...], ROWS] = ()
    baselines: Annotated[tuple[Rule, ...], ROWS] = ()
    reliability: Annotated[tuple[Bin, ...], ROWS] = ()
    ece: Number = NAN
    shrink: Annotated[tuple[Shrunk, ...], ROWS] = ()
    targets: Annotated[tuple[Target, ...], ROWS] = ()
    by_d2: Annotated[tuple[Stratum, ...], ROWS] = ()
