"""One position in two runs: what the readings of an encoder cannot be, and what a commanded position may."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_slips import BENDS, bend

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def log(jitter_mm: float = 0.002) -> list[Run]:
    """Return act runs of three bends in two movements, the position of each behind an encoder of its own noise."""
    runs = []
    for k, (name, wrap) in enumerate(BENDS.items()):
        for movement in (7, 8):
            r = bend(name, wrap, "act", 40 + 2 * k + movement, movement=movement)
            noise = jitter_mm * np.random.default_rng(70 + 2 * k + movement).standard_normal(len(r))
            # the line grows longer by what its tension is on the way
            grown = 0.1 * (r.tension_in_n + r.tension_out_n) + noise
            runs.append(replace(r, run_id=f"{name}-{movement}", trajectory=f"m{movement}", position_in_mm=grown))
    return runs


def given(runs: list[Run], to: str, of: str) -> list[Run]:
    position = next(r.position_in_mm for r in runs if r.run_id == of)
    return [replace(r, position_in_mm=position) if r.run_id == to else r for r in runs]


def said(runs: list[Run]) -> list[tuple[str, tuple[str, ...]]]:
    return [(r.rule, r.run_ids) for r in gate.remarks(runs)]


def test_positions_of_their_own_are_passed_over():
    assert said(log()) == []


def test_the_position_of_another_movement_is_told_of_the_run_that_has_it():
    assert said(given(log(), "b050-7", "b020-8")) == [("position", ("b050-7",))]


def stretched(r: Run, position: np.ndarray) -> Run:
    """Return a run beside which a position of other length was put, row by row of its own clock."""
    part = position[: len(position) * 7 // 10]
    return replace(r, position_in_mm=np.interp(np.linspace(0.0, 1.0, len(r)), np.linspace(0.0, 1.0, len(part)), part))


def test_a_position_that_has_nothing_of_its_input_is_told_where_that_of_every_other_run_has():
    runs = log()
    other = next(r.position_in_mm for r in runs if r.run_id == "b020-8")
    assert other is not None
    assert said([stretched(r, other) if r.run_id == "b050-7" else r for r in runs]) == [("position", ("b050-7",))]
    # beside an input of another recording it is that which is told
    foreign = [replace(r, tension_in_n=r.tension_in_n[::-1].copy()) if r.run_id == "b050-7" else r for r in runs]
    assert "position" not in {rule for rule, _ in said(foreign)}


@pytest.mark.parametrize(("to", "of"), [("b020-7", "b050-7"), ("b080-8", "b020-8")])
def test_the_position_of_another_bend_is_told_of_the_two_runs(to, of):
    ((rule, ids),) = said(given(log(), to, of))
    assert rule == "position" and to in ids and set(ids) <= {to, of}


def test_a_shorter_run_with_the_beginning_of_another_position_is_told():
    runs = log()
    short = [
        replace(
            r,
            time_s=r.time_s[:-40],
            tension_in_n=r.tension_in_n[:-40],
            tension_out_n=r.tension_out_n[:-40],
            position_in_mm=r.position_in_mm[:-40],
        )
        if r.run_id == "b050-7"
        else r
        for r in runs
    ]
    other = next(r.position_in_mm for r in runs if r.run_id == "b080-8")[:-40]
    wrong = [replace(r, position_in_mm=other) if r.run_id == "b050-7" else r for r in short]
    assert said(wrong) == [("position", ("b050-7",))]


def test_a_commanded_position_is_the_same_in_every_run_of_its_movement():
    runs = log()
    commands = {r.trajectory: 0.2 * r.tension_in_n for r in runs if r.run_id.startswith("b020")}
    assert said([replace(r, position_in_mm=commands[r.trajectory]) for r in runs]) == []
    # of two runs nothing tells it from a slip
    few = [r for r in runs if r.trajectory == "m7"][:2] + [r for r in runs if r.trajectory == "m8"][:1]
    assert said([replace(r, position_in_mm=commands[r.trajectory]) for r in few]) == []
