"""The gates of a diagnosis: bounds that a build server holds it to."""

from __future__ import annotations

from dataclasses import dataclass

from sstl_cli.core.documents.diagnosis import DiagnosisDocument


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
        verdict, retuned, floor = document.verdict, document.gap.rmse_retuned_n or 0.0, document.gap.noise_floor_n or 0.0
        found = f"verdict is {verdict.status} {' + '.join(verdict.effects)}"
        missed = []
        if self.max_rmse_n is not None and retuned > self.max_rmse_n:
            missed.append(f"--max-rmse: re-tuned RMSE {retuned:.3g} N > {self.max_rmse_n:g} N")
        reducible = 100.0 * (1.0 - floor / retuned) if retuned > 0 else 0.0
        if self.max_gap_pct is not None and reducible > self.max_gap_pct:
            missed.append(f"--max-gap-pct: reducible part {reducible:.1f} % > {self.max_gap_pct:g} %")
        if self.expect == "none" and verdict.status != "none":
            missed.append(f"--expect: expected none, {found}")
        if self.expect not in (None, "none") and not (verdict.status == "identified" and self.expect in verdict.effects):
            missed.append(f"--expect: expected {self.expect}, {found}")
        return missed
