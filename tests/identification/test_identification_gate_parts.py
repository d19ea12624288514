"""Runs that are a part of a movement: pulled alone, released alone, cut at a pause, or without the sign of their input."""

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


def pair(name: str, seed: int, slack: bool = False) -> Run:
    """Return the net drive of two tendons and the angle that it moves, with backlash; where ``slack`` the drive of the one tendon alone."""
    t = np.arange(0.0, 30.0, 0.02)
    x = 8.0 * np.sin(2.0 * np.pi * t / 9.0) + 2.0 * np.sin(2.0 * np.pi * t / 23.0)
    y = play(x, (5.0, -6.0, 5.0, 6.0), start=0.0)
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(name, "act", t, (np.maximum(x, 0.0) if slack else x) + noise[0], y + noise[1], config_id=name, unit_out="deg")


def test_an_input_without_its_sign_is_told() -> None:
    log = [pair("a", 1), pair("b", 2)]
    assert "folded" not in [r.rule for r in remarks(log)]
    (said,) = [r for r in remarks([replace(r, tension_in_n=np.abs(r.tension_in_n)) for r in log]) if r.rule == "folded"]
    assert (set(said.run_ids), said.severity) == ({"a", "b"}, "remark") and "absolute value of the input" in said.sentence
    # a tendon that is slack while the other one pulls has lost nothing
    assert "folded" not in [r.rule for r in remarks([pair("a", 1, slack=True)])]


def test_a_tension_without_its_sign_is_told_of_the_input() -> None:
    t, x = trapezoid(4.0, 25.0, rate=100.0, cycles=2)
    noise = 0.02 * np.random.default_rng(3).standard_normal((2, len(t)))
    y = play(x, lines(0.3))
    # its zero was taken under load, and its size alone was written down
    (said,) = [r for r in remarks([Run("r", "act", t, np.abs(x - 12.0 + noise[0]), y + noise[1])]) if r.rule == "folded"]
    assert said.severity == "failure" and "the input turns back at zero" in said.sentence
