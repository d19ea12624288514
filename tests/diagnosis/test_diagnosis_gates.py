"""The gates of a build server: every tendon is held to them, and to what can be explained alone."""

from __future__ import annotations

from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.steps.diagnose_gates import Gates

VERDICT = {"status": "none", "effects": [], "confidence": 0.9, "ambiguity_group": [], "why": "noise"}
GAP = {
    "rmse_base_n": 1.0, "rmse_retuned_n": 0.5, "rmse_with_effect_n": 0.5, "noise_floor_n": 0.3, "shrink_pct": 0.0, "shrink_ci95_pct": None,
    "explained_of_reducible_pct": None, "held_out": True,
}  # fmt: skip


def made(gap, **more):
    """Return a document with this gap."""
    rest = {"schema": "sstl.diagnosis/1", "verdict": VERDICT, "where": [], "candidates": [], "next_experiment": None}
    return DiagnosisDocument.model_validate({**rest, "gap": {**GAP, **gap}, **more})


def test_what_an_accepted_simulator_is_known_to_leave_is_not_reducible():
    assert Gates(max_gap_pct=5.0).missed(made({"known_misfit_n": 0.4})) == []
    assert Gates(max_gap_pct=5.0).missed(made({})) == ["--max-gap-pct: reducible part 40.0 % > 5 %"]


def test_every_tendon_is_held_to_the_gates():
    blocks = [
        {"tendon": name, "sentence": "", "verdict": VERDICT, "gap": None if retuned is None else {**GAP, "rmse_retuned_n": retuned}}
        for name, retuned in (("a", 0.3), ("", 0.9), ("c", None))
    ]
    document = made({"rmse_retuned_n": 0.3}, tendon="a", tendons=blocks, unit="V")
    assert Gates(max_rmse_n=0.4, max_gap_pct=50.0).missed(document) == [
        "--max-rmse: tendon without a name: re-tuned RMSE 0.9 V > 0.4 V",
        "--max-gap-pct: tendon without a name: reducible part 66.7 % > 50 %",
    ]
