"""A sensor whose gain is far off, on a line that hardly rubs: no friction of a base is the measure of it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from made_pairs import pair

from sstl_cli.steps import diagnose


def test_a_pair_without_friction_read_at_an_eighth_is_a_gain_and_no_hold(monkeypatch):
    """What the base can do about it is to hold: found at friction that a hold has, the gain would stay where it began."""
    monkeypatch.setattr("made_pairs.THETA", 0.002)
    runs = [replace(r, tension_out_n=0.12 * r.tension_out_n) for r in (pair(step_s=0.04), pair("b", 4.3, step_s=0.04))]
    names = ("gain_error", "zero_offset", "crosstalk", "const_friction")
    body = diagnose.run(runs, diagnose.DiagnoseOptions(effects=names, max_effects=1, physics=False)).body
    assert body.verdict.status == "identified" and list(body.verdict.effects) == ["gain_error"]
    (found,) = (p.estimate for c in body.candidates if c.id == "gain_error" for p in c.parameters if p.name == "g_act")
    assert found == pytest.approx(0.12, rel=0.02)
