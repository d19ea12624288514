"""A pulley in the loop: it adds to the friction of the second pass, alike in all bends."""

from __future__ import annotations

from dataclasses import replace

import pytest
from identification_slips import bend

from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import remarks

BENDS = {"b20": 0.29, "b40": 0.34, "b60": 0.39, "b80": 0.44}


def pulled(added: dict[str, float]) -> list[Run]:
    """Return both systems of all bends, with the friction that a pulley adds to the loop of each."""
    one = [bend(name, theta, "act", i, movement=i) for i, (name, theta) in enumerate(BENDS.items())]
    # the loop of a bend has twice its friction, and the pulley's
    two = [bend(name, theta + 0.5 * added[name], "sstl", 20 + i, movement=i) for i, (name, theta) in enumerate(BENDS.items())]
    return [*one, *two]


def exchanged(log: list[Run], first: str, second: str) -> list[Run]:
    to = {first: second, second: first}
    return [replace(r, config_id=to.get(r.config_id or "", r.config_id)) if r.system == "sstl" else r for r in log]


def test_exchanged_labels_are_told_beside_a_pulley() -> None:
    log = pulled(dict.fromkeys(BENDS, 0.1))
    assert not remarks(log)
    said = remarks(exchanged(log, "b20", "b60"))
    assert said[0].rule == "exchanged" and {"sstl-b20", "sstl-b60"} <= set(said[0].run_ids)
    assert "b20, b60" in said[0].sentence and not {"act-b40", "sstl-b40", "act-b80", "sstl-b80"} & set(said[0].run_ids)
    # in a place of their own as well: the pulley is that of the rig
    apart = [replace(r, location="left" if r.config_id in ("b20", "b60") else "right") for r in exchanged(log, "b20", "b60")]
    assert [r.rule for r in remarks(apart)] == ["exchanged"]


def test_loops_of_another_recorder_may_be_of_another_rig() -> None:
    log = exchanged(pulled(dict.fromkeys(BENDS, 0.1)), "b20", "b60")
    one = next(r for r in remarks(log) if r.rule == "exchanged")
    assert "two rigs" not in one.sentence and "each rig" not in one.mend

    def slower(r: Run) -> Run:
        return replace(r, time_s=r.time_s[::2], tension_in_n=r.tension_in_n[::2], tension_out_n=r.tension_out_n[::2])

    two = next(r for r in remarks([slower(r) if r.system == "sstl" else r for r in log]) if r.rule == "exchanged")
    assert "act and loop come from two rigs: they differ in rate" in two.sentence and "a log for each rig" in two.mend


@pytest.mark.parametrize("added", [(0.2, 0.1, 0.0, 0.1), (0.0, 0.3, 0.0, 0.3), (0.15, 0.0, 0.05, 0.0)])
def test_a_return_path_of_other_bends_is_no_exchange(added: tuple[float, ...]) -> None:
    assert "exchanged" not in [r.rule for r in remarks(pulled(dict(zip(BENDS, added, strict=True))))]


def test_bends_that_hardly_differ_are_not_called_exchanged() -> None:
    log = [
        bend(n, theta, s, 10 * i + len(s), movement=i)
        for i, (n, theta) in enumerate(zip(BENDS, (0.4, 0.42, 0.5, 0.6), strict=True))
        for s in ("act", "sstl")
    ]
    assert "exchanged" not in [r.rule for r in remarks(exchanged(log, "b20", "b40"))]
