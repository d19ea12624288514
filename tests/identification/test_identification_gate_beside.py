"""What the other runs of a log betray of one of them: a lead, a loss, a rate, a sensor."""

from __future__ import annotations

from dataclasses import replace

import pytest
from test_identification_gate import leads

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def at(mm: list[float], thetas: list[float]) -> list[Run]:
    return [replace(r, lead_mm=lead) for r, lead in zip(leads(thetas), mm, strict=True)]


@pytest.mark.parametrize("zero", [0.0, 30.0])
def test_a_screw_that_bends_to_both_sides_goes_through_the_straight_sheath(zero):
    both = at([lead + zero for lead in (-24.0, -12.0, 0.0, 12.0, 24.0)], [0.31, 0.2, 0.1, 0.2, 0.3])
    assert gate.remarks(both) == ()
    # to the other side alone
    assert gate.remarks(at([-40.0, -30.0, -20.0, -10.0, 0.0], [0.5, 0.4, 0.3, 0.2, 0.1])) == ()
    assert [r.rule for r in gate.remarks(at([10.0, 20.0, 30.0, 40.0, 50.0], [0.5, 0.4, 0.3, 0.2, 0.1]))] == ["lead_order"]


@pytest.mark.parametrize(("wrong", "named"), [(2.4, {"r1", "r2"}), (120.0, {"r2", "r3"})])
def test_one_wrong_lead_of_four_stands_off_by_more_than_the_errors_of_friction(wrong, named):
    thetas = [0.12, 0.22, 0.34, 0.46]
    assert gate.remarks(at([0.0, 12.0, 24.0, 36.0], thetas)) == ()
    (said,) = gate.remarks(at([0.0, 12.0, wrong, 36.0], thetas))
    assert said.rule == "lead_order" and set(said.run_ids) == named


def test_bends_of_nearly_one_lead_may_rub_in_any_order():
    assert gate.remarks(at([10.0, 12.0, 14.0, 40.0], [0.32, 0.3, 0.31, 0.45])) == ()
