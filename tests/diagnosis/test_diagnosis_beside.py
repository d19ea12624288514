"""A verdict on a channel beside the output: its numbers are all of one channel, in one unit."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.sentence import _fall
from sstl_cli.steps.diagnose_rows import gap_beside, notes_beside, with_beside

OF_OUTPUT = {
    "rmse_base_n": 0.5, "rmse_retuned_n": 0.022, "rmse_with_effect_n": 0.022, "noise_floor_n": 0.02, "shrink_pct": 0.0, "shrink_ci95_pct": None,
    "explained_of_reducible_pct": 0.0, "held_out": True, "samples": "analysed",
}  # fmt: skip


def told(channel, unit, effect):
    """Return the gap and the notes of a verdict that names what one channel alone shows."""
    only = [ChannelGap(channel, unit, effect, {}, 0.4, 0.01, 0.008, 900.0)]
    g = SimpleNamespace(verdict=SimpleNamespace(effects=(effect,)))
    return gap_beside(g, Gap.model_validate(OF_OUTPUT), only), notes_beside(g, only)


def test_a_tension_beside_has_the_gap_to_itself():
    gap, notes = told("tension_in", "N", "tension_loop_lag")
    assert (gap.rmse_retuned_n, gap.rmse_with_effect_n, gap.noise_floor_n, gap.held_out) == (0.4, 0.01, 0.008, False)
    assert gap.shrink_pct == pytest.approx(97.5) and gap.samples == "channel tension_in (N)"
    assert notes == ["the error is that of channel tension_in; where it lies is told of the output"]


def test_the_fall_of_a_position_is_said_to_be_its_own():
    """Beside "0.02 N -> 0.02 N" stood "falls by 97.5 %", of what nobody said."""
    gap, notes = told("position_in", "mm", "tendon_elasticity")
    assert gap.shrink_pct == pytest.approx(97.5) and gap.samples == "channel position_in (mm)" and gap.rmse_with_effect_n == 0.022
    assert notes == [
        "the error of channel position_in falls from 0.4 mm to 0.01 mm; errors in newtons are of the output, which the effect does not change"
    ]
    assert _fall(gap) == "  error of channel position_in (mm) falls by 97.5 %"


def test_what_a_channel_beside_shows_is_in_the_units_of_the_recording():
    """Where tensions were fitted in a unit of their own, errors and parameters of the channel beside stayed in it."""
    lag = ChannelGap("tension_in", "N", "tension_loop_lag", {"tau_s": 0.2}, 0.4, 0.01, 0.008, 900.0)
    long = ChannelGap("position_in", "mm", "tendon_elasticity", {"compliance_per_kn": 0.5}, 0.4, 0.01, 0.008, 800.0)
    sim = SimpleNamespace(fixed={"tendon_elasticity": {"compliance_per_kn": 0.2}})
    g = SimpleNamespace(
        beside=(long, lag),
        problem=SimpleNamespace(unit_n=10.0),
        search=SimpleNamespace(sim=sim),
        verdict=SimpleNamespace(effects=("tension_loop_lag",), probabilities={}),
    )
    found = with_beside(g, DiagnosisDocument.model_construct(gap=Gap.model_validate(OF_OUTPUT), candidates=[]), (long, lag))
    assert (found.gap.rmse_base_n, found.gap.rmse_with_effect_n, found.gap.noise_floor_n) == pytest.approx((4.0, 0.1, 0.08))
    assert (found.beside.channel, found.beside.rmse_base, found.beside.parameters) == ("tension_in", 4.0, {"tau_s": 0.2})
    by_id = {c.id: c for c in found.candidates}
    assert by_id["tension_loop_lag"].rmse_held_out_n == pytest.approx(0.1) and by_id["tendon_elasticity"].rmse_held_out_n is None
    assert by_id["tendon_elasticity"].parameters[0].estimate == pytest.approx(0.05)
    # of what the simulator has it is a change
    assert by_id["tendon_elasticity"].change == pytest.approx({"compliance_per_kn": 0.03}) and by_id["tension_loop_lag"].change is None
