"""A log far from a tendon's forces is fitted in units of its own; the document is in those of the recording."""

from __future__ import annotations

import pytest

from sstl_cli.diagnosis.scaling import restore

DOCUMENT = {
    "unit": "N",
    "gap": {"rmse_base_n": 2.0, "shrink_pct": 40.0, "held_out": True},
    "candidates": [
        {"parameters": [
            {"name": "w_l_n", "unit": "N", "estimate": 3.0, "ci95": [2.0, 4.0]},
            {"name": "alpha", "unit": "1", "estimate": 0.1, "ci95": None},
            {"name": "c_t_per_n", "unit": "1/N", "estimate": 0.5, "ci95": None},
        ]},
    ],
    "analysis": {"noise": {"act": {"output": {
        "white_n": {"estimate": 0.2, "ci95": [0.1, 0.3]}, "correlation_s": {"estimate": 0.4, "ci95": None},
    }}}},
    "verdict": {"would_have_shown": [
        {"effect": "const_friction", "parameter": "w_l_n", "unit": "N", "size": 0.2, "gap_n": 0.1},
        {"effect": "gain_error", "parameter": "g_act", "unit": "1", "size": 0.01, "gap_n": 0.1},
    ]},
}  # fmt: skip


def test_every_tension_and_every_interval_is_in_the_recordings_units_again():
    found = restore(DOCUMENT, 100.0)
    assert found["gap"] == {"rmse_base_n": 200.0, "shrink_pct": 40.0, "held_out": True}
    width, alpha, compliance = found["candidates"][0]["parameters"]
    assert (width["estimate"], width["ci95"]) == (300.0, [200.0, 400.0])
    assert (alpha["estimate"], alpha["ci95"]) == (0.1, None)
    assert compliance["estimate"] == pytest.approx(0.005) and compliance["ci95"] is None
    output = found["analysis"]["noise"]["act"]["output"]
    assert output["white_n"] == {"estimate": 20.0, "ci95": [10.0, 30.0]}
    assert output["correlation_s"] == {"estimate": 0.4, "ci95": None}
    friction, gain = found["verdict"]["would_have_shown"]
    assert (friction["size"], friction["gap_n"]) == (20.0, 10.0) and (gain["size"], gain["gap_n"]) == (0.01, 10.0)


def test_a_log_of_usual_forces_stays_as_it_is():
    assert restore(DOCUMENT, 1.0) is DOCUMENT
