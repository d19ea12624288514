"""The gates of a diagnosis: bounds that a build server holds it to."""

from __future__ import annotations

from dataclasses import dataclass

from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap


@dataclass(frozen=True)
class Gates:
    """Largest re-tuned RMSE in N, largest reducible part of it in percent, and the effect to be named (or ``none``)."""

    max_rmse_n: float | None = None
    max_gap_pct: float | None = None
    expect: str | None = None

    def asked(self) -> dict[str, object]:
        """Return the gates by the name of their option; None where one was not given."""
        return {"--max-rmse": self.max_rmse_n, "--max-gap-pct": self.max_gap_pct, "--expect": self.expect}

    def missed(self, document: DiagnosisDocument) -> list[str]:
        """Return the gates that a diagnosis misses, each as a sentence that begins with the name of its option."""
        verdict, unit = document.verdict, document.unit or "N"
        found = f"verdict is {verdict.status} {' + '.join(verdict.effects)}"
        missed = []
        for whose, gap in _gaps(document):
            retuned = gap.rmse_retuned_n or 0.0
            if self.max_rmse_n is not None and retuned > self.max_rmse_n:
                missed.append(f"--max-rmse: {whose}re-tuned RMSE {retuned:.3g} {unit} > {self.max_rmse_n:g} {unit}")
            reducible = 100.0 * (1.0 - gap.unavoidable_n / retuned) if retuned > 0 else 0.0
            if self.max_gap_pct is not None and reducible > self.max_gap_pct:
                missed.append(f"--max-gap-pct: {whose}reducible part {reducible:.1f} % > {self.max_gap_pct:g} %")
        if self.expect == "none" and verdict.status != "none":
            missed.append(f"--expect: expected none, {found}")
        if self.expect not in (None, "none") and not (verdict.status == "identified" and self.expect in verdict.effects):
            missed.append(f"--expect: expected {self.expect}, {found}")
        return missed


def _gaps(document: DiagnosisDocument) -> list[tuple[str, Gap]]:
    """Return the gap of every tendon and whose it is: the tendon that speaks for a log need not be the worst by each measure."""
    if not document.tendons:
        return [("", document.gap)]
    return [(f"tendon {b.tendon or 'without a name'}: ", b.gap) for b in document.tendons if b.gap is not None]
