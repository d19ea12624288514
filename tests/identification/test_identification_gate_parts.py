"""Runs that are a part of a movement: pulled alone, released alone, or cut at a pause."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from identification_loops import play, trapezoid
from identification_slips import lines

from sstl_cli.core.runs import Run, read_runs
from sstl_cli.identification.gate import evidence_of, judge, remarks

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"


def cut(r: Run, first: int, last: int | None, name: str) -> Run:
    columns = ("time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n")
    found = {k: v[first:last] for k in columns if (v := getattr(r, k)) is not None}
    return replace(r, run_id=name, **found)


@pytest.mark.parametrize("at", [600, 720])
def test_a_run_cut_at_a_pause_is_sound(at: int) -> None:
    # the second part is a release and a rest at no tension, whose noise alone made a line of a pull
    runs = list(read_runs(SAMPLE))
    whole = next(r for r in runs if r.system == "act")
    parts = [cut(whole, 0, at, whole.run_id), cut(whole, at, None, f"{whole.run_id}~2")]
    assert judge([evidence_of(r) for r in [*parts, *(r for r in runs if r is not whole)]]) == ()


def test_bends_that_are_only_released_are_no_copies() -> None:
    def released(name: str, theta: float) -> Run:
        t, x = trapezoid(2.0, 25.0, rate=100.0)
        y = play(x, lines(theta))
        kept = t > 9.0
        noise = 0.02 * np.random.default_rng(len(name)).standard_normal((2, len(t)))
        return cut(Run(name, "act", t, x + noise[0], y + noise[1], config_id=name), int(np.argmax(kept)), None, name)

    assert "same_channel" not in [r.rule for r in remarks([released("b20", 0.2), released("bend40", 0.4)])]
