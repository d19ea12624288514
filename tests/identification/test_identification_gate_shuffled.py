"""Labels of bends that are shuffled in one system, which make no run one of the other system."""

from __future__ import annotations

from dataclasses import replace

import pytest
from identification_slips import BENDS, bend

from sstl_cli.identification import gate
from sstl_cli.identification.gate.causes import NO_CAUSES, Cause
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.rules import passes
from sstl_cli.identification.gate.slopes import NO_SLOPES

# more friction from bend to bend than a second pass adds
WRAPS = dict(zip(BENDS, (0.15, 0.32, 0.7), strict=True))


def evidence(movements: tuple[int, ...] = (7, 8)) -> list[Evidence]:
    return [
        gate.evidence_of(
            replace(bend(name, wrap, system, 10 * k + j + 40 * m, movement=m), run_id=f"{system}-{name}-{m}", trajectory=f"m{m}")
        )
        for k, (name, wrap) in enumerate(WRAPS.items())
        for j, system in enumerate(("act", "sstl"))
        for m in movements
    ]


LOG = evidence()


def said(log: list[Evidence]) -> dict[str, set[str]]:
    return {r.rule: set(r.run_ids) for r in gate.judge(log)}


def test_the_log_is_sound():
    assert said(LOG) == {}


@pytest.mark.parametrize("order", [("b050", "b020", "b080"), ("b050", "b080", "b020"), ("b020", "b080", "b050")])
def test_bends_shuffled_in_one_system_are_no_exchanged_systems(order):
    new = dict(zip(WRAPS, order, strict=True))
    log = [replace(e, config_id=new[str(e.config_id)]) if e.system == "sstl" else e for e in LOG]
    assert list(passes.look(log)) == []
    assert {"labels", "exchanged"} & set(said(log))


def test_systems_of_one_bend_and_of_all_are_still_told():
    other = {"act": "sstl", "sstl": "act"}
    one = {e.run_id for e in LOG if e.config_id == "b050"}
    told = said([replace(e, system=other[e.system]) if e.run_id in one else e for e in LOG])
    assert told["passes"] and told["passes"] <= one
    assert "passes" in said([replace(e, system=other[e.system]) for e in LOG])


@pytest.mark.parametrize("speed_n", [0.12, 3.0])
def test_presliding_of_one_movement_is_no_second_pass_where_a_law_lets_it_agree(speed_n):
    """A run of another movement whose lines do not show: friction alone would be that of two passes, and friction by speed, if it explains the run, that of one."""
    odd = next(e for e in LOG if e.run_id == "act-b050-8")
    alone, by_speed = Cause(2.0 * WRAPS["b050"], 0.0, 0.1), Cause(WRAPS["b050"], 0.0, speed_n)
    causes = replace(NO_CAUSES, noise_n=0.01, friction=alone, speed=by_speed)
    hidden = replace(odd, slopes=NO_SLOPES, play=None, causes=causes)
    assert hidden.wrap_about == pytest.approx(2.0 * WRAPS["b050"])
    told = said([hidden if e is odd else e for e in LOG]).get("passes", set())
    assert told == (set() if speed_n < 1.0 else {odd.run_id})
