"""Explanations that compete: the remark that names no cause is silent where another rule explains the run, and a common slip is told as one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import remarks


def steps(name: str, theta: float, seed: int) -> Run:
    """Return a bend that is driven from level to level by ramps of 0.3 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 36.0, 0.01)
    levels = rng.uniform(3.0, 24.0, 13)
    x = np.interp(t % 3.0, [0.0, 0.3], [0.0, 1.0]) * (levels[1:][(t // 3.0).astype(int)] - levels[:-1][(t // 3.0).astype(int)])
    x = x + levels[:-1][(t // 3.0).astype(int)]
    noise = 0.02 * rng.standard_normal((2, len(t)))
    return Run(name, "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory="stair")


def swapped(r: Run) -> Run:
    return replace(r, tension_in_n=r.tension_out_n, tension_out_n=r.tension_in_n)


def test_swapped_channels_are_told_of_all_runs_and_nothing_else_of_the_rest() -> None:
    log = [swapped(r) for r in (*rig()[:2], steps("steps", 0.6, 4))]
    said = remarks(log)
    assert {r.rule for r in said} == {"swapped"}
    assert set(said[0].run_ids) == {r.run_id for r in log}


def test_a_clock_that_drifts_is_no_other_recording() -> None:
    def drifting(r: Run) -> Run:
        late = np.interp(r.time_s / 1.012, r.time_s, r.tension_out_n)
        return replace(r, time_s=r.time_s, tension_out_n=late)

    def repeated(seed: int, theta: float) -> Run:
        t = np.arange(0.0, 110.0, 0.02)
        x = 12.0 + 7.5 * np.sin(2.0 * np.pi * t / 5.5)
        noise = 0.012 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(f"r{seed}", "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory="sine")

    said = remarks([drifting(repeated(1, 0.4)), drifting(repeated(2, 0.4)), repeated(3, 0.4), repeated(4, 0.4)])
    assert "unrelated" not in {r.rule for r in said}


def test_a_gap_that_was_filled_is_no_reference_of_another_run() -> None:
    def filled(r: Run) -> Run:
        keep = (r.time_s < 9.0) | (r.time_s > 16.0)
        x, y = (np.interp(r.time_s, r.time_s[keep], v[keep]) for v in (r.tension_in_n, r.tension_out_n))
        return replace(r, tension_in_n=x, tension_out_n=y)

    log = [replace(r, tension_ref_n=np.convolve(np.pad(r.tension_in_n, 10, mode="edge"), np.ones(21) / 21, "valid")) for r in rig()]
    said = remarks([filled(log[0]), *log[1:]])
    assert {r.rule for r in said} == {"filled"}


@pytest.mark.parametrize("stiffness", [2.0, 6.0])
def test_position_and_reference_exchanged_are_told_as_such_and_not_as_a_unit(stiffness: float) -> None:
    def beside(r: Run) -> Run:
        reference = np.convolve(np.pad(r.tension_in_n, 25, mode="edge"), np.ones(51) / 51, "valid")
        return replace(r, position_in_mm=reference, tension_ref_n=r.tension_in_n / stiffness + 0.2)

    (said,) = remarks([beside(r) for r in rig()])
    assert (said.rule, len(said.run_ids)) == ("reference", 6)
    assert "exchanged" in said.sentence
    assert "ozf" not in said.mend
    right = [replace(r, position_in_mm=r.tension_ref_n, tension_ref_n=r.position_in_mm) for r in map(beside, rig())]
    assert not remarks(right)


def test_a_single_pass_over_a_large_bend_is_no_double_one() -> None:
    def pass_of(theta: float, seed: int) -> Run:
        t, x = multisine(seed, 0.5, 40.0, seconds=90.0)
        t, x = t[: len(t) // 3], x[::3]
        noise = 0.01 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(f"r{seed}", "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory=f"m{seed}")

    assert not remarks([pass_of(0.93, s) for s in (1, 2, 3)])
