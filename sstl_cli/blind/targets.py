"""Each rate of a score beside what is asked of it."""

from __future__ import annotations

from sstl_cli.core.documents.blind import AgainstLimit, CalibrationRow, Scores, Share, TargetRow

# name, value at most or at least or within, what is asked
TARGETS = (
    ("false_alarm", "max", 0.02),
    ("isolation", "min", 0.95),
    ("isolation_weak", "min", 0.95),
    ("wrong_commits", "max", 0.02),
    ("unknown_recall", "min", 0.90),
    ("both_of_a_pair", "min", 0.80),
    ("ece", "max", 0.03),
    ("slope", "within", 1.0),
    ("coverage", "within", 0.90),
)
# the same of cases by what their recordings could decide
OF_LIMIT = (
    ("isolation", "min", 0.95),
    ("unknown_recall", "min", 0.90),
    ("unknown_recall_joined", "min", 0.90),
    ("both_of_a_pair", "min", 0.80),
    ("undecidable_in_set", "min", 0.90),
)
WITHIN = {"coverage": 0.05, "slope": 0.1}
SAID = {
    "false_alarm": "false alarm",
    "isolation": "isolation above 0.6 x noise",
    "isolation_weak": "isolation at 0.1-0.6 x noise",
    "wrong_commits": "wrong commits",
    "unknown_recall": "unknown recall",
    "both_of_a_pair": "both of a pair",
    "ece": "expected calibration error",
    "ece_chance": "what perfect calibration exceeds in 5 of 100 sets",
    "slope": "calibration slope",
    "coverage": "coverage of the ambiguity set",
}
SAID_OF_LIMIT = {
    "isolation": "isolation, decidable cases",
    "unknown_recall": "unknown recall, decidable cases",
    "unknown_recall_joined": "unknown recall, decidable against pairs and triples too",
    "both_of_a_pair": "both of a pair, decidable cases",
    "undecidable_in_set": "undecidable cases in the set",
}


def targets(measured: Scores, calibration: CalibrationRow | None = None, limit: AgainstLimit | None = None) -> list[TargetRow]:
    """Return each target with what was measured; ``met`` is None where no case of the set bears on it.

    Parameters
    ----------
    calibration : CalibrationRow, optional
        Of all cases: the interval of the slope.
    limit : AgainstLimit, optional
        Rates of decidable and undecidable cases, where distances are known.
    """
    rows = [_row(name, SAID[name], *measured.of(name), rule, wanted, measured.ece_chance) for name, rule, wanted in TARGETS]
    if calibration is not None:
        spread = {"low": calibration.slope_low, "high": calibration.slope_high}
        rows = [r.model_copy(update=spread) if r.id == "slope" else r for r in rows]
    if limit is not None:
        for name, rule, wanted in OF_LIMIT:
            found: Share | None = getattr(limit, name)
            rows.append(_row(f"limit_{name}", SAID_OF_LIMIT[name], None if found is None else found.share, found, rule, wanted))
    return rows


def _row(
    name: str, said: str, value: float | None, found: Share | None, rule: str, wanted: float, by_chance: float | None = None
) -> TargetRow:
    # a set of a few hundred verdicts shows an error above 0.03 however well it is calibrated
    chance = by_chance if name == "ece" else None
    met = None
    if value is not None:
        most = max(wanted, chance or wanted) + 1e-12
        off = WITHIN.get(name, 0.0) + 1e-12
        met = {"max": value <= most, "min": value >= wanted - 1e-12, "within": abs(value - wanted) <= off}[rule]
    row = TargetRow.model_validate({"id": name, "name": said, "value": value, "target": wanted, "rule": rule, "met": met, "chance": chance})
    return row if found is None else row.model_copy(update={"k": found.k, "n": found.n, "low": found.low, "high": found.high})
