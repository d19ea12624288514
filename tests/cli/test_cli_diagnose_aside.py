"""What a diagnosis sets aside, which ends with 3 (CONTRACT)."""

from __future__ import annotations

import pytest

from sstl_cli.cli._diagnose_show import aside
from sstl_cli.core.documents.diagnosis import DiagnosisDocument

HOLD = "the output never leaves its hold"


def verdict(status="unknown", confidence=None, why=HOLD):
    return {"status": status, "effects": [], "confidence": confidence, "ambiguity_group": [], "why": why}


def made(said, lost=None, **more):
    """Return a document with this verdict and these runs set aside."""
    gap = dict.fromkeys(
        (
            "rmse_base_n",
            "rmse_retuned_n",
            "rmse_with_effect_n",
            "noise_floor_n",
            "shrink_pct",
            "shrink_ci95_pct",
            "explained_of_reducible_pct",
        )
    )
    analysis = {"rate_hz": 50.0, "samples": 1, "runs": 1, "set_aside": lost or {}, "theta": {}, "noise": {}}
    rest = {"schema": "sstl.diagnosis/1", "where": [], "candidates": [], "next_experiment": None}
    return DiagnosisDocument.model_validate({**rest, "verdict": said, "gap": {**gap, "held_out": False}, "analysis": analysis, **more})


def test_a_log_that_could_not_be_judged_is_set_aside():
    """A log in which nothing propagates ended with 0."""
    assert aside(made(verdict())) == [f"all runs: {HOLD}"]


@pytest.mark.parametrize(("said", "own_odds"), [(verdict(confidence=0.6), False), (verdict("none", 0.9), False), (verdict(), True)])
def test_what_was_judged_is_not(said, own_odds):
    assert aside(made(said), own_odds) == []


def test_a_tendon_is_set_aside_once():
    blocks = [
        {"tendon": name, "sentence": "", "verdict": said}
        for name, said in (("a", verdict(why="no loop")), ("b", verdict()), ("c", verdict("none", 0.9)))
    ]
    document = made(verdict("none", 0.9), {"r1": "no loop"}, tendons=blocks)
    assert aside(document) == ["run r1: no loop", f"tendon b: {HOLD}"]
