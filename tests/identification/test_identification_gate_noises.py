"""What noises of a log may say: shared by both channels, from a supply or from one another, and hidden behind a converter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_slips import BENDS, bend, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate

STEP_N = 0.0125


def said(log: list[Run], rule: str) -> list[tuple[str, ...]]:
    return [r.run_ids for r in gate.remarks(log) if r.rule == rule]


def supplied(r: Run, seed: int) -> Run:
    """Return a run both of whose amplifiers pick up the noise of one supply."""
    shared = 0.03 * np.random.default_rng(900 + seed).standard_normal(len(r))
    return replace(r, tension_in_n=r.tension_in_n + shared, tension_out_n=r.tension_out_n + shared)


@pytest.mark.parametrize("which", [{"act-b020", "act-b050", "act-b080"}, {"act-b050", "sstl-b080"}])
def test_a_supply_that_adds_its_noise_to_both_channels_is_no_part_of_one_in_the_other(which):
    log = [supplied(r, k) if r.run_id in which else r for k, r in enumerate(rig())]
    assert all(gate.evidence_of(r).noise_correlation > 0.5 for r in log if r.run_id in which)
    assert said(log, "crosstalk") == []


def test_a_part_of_the_output_in_the_input_adds_to_the_noise_of_one_channel():
    log = [replace(r, tension_in_n=r.tension_in_n + 0.4 * r.tension_out_n) if r.run_id == "act-b050" else r for r in rig()]
    assert said(log, "crosstalk") == [("act-b050",)]


def test_what_few_samples_share_by_chance_is_no_crosstalk():
    by_chance = 4.0 * 1.39 / np.sqrt(300.0)
    log = [replace(gate.evidence_of(r), noise_correlation=0.02, samples=300) for r in rig()]
    odd = [replace(e, noise_correlation=by_chance) if k == 2 else e for k, e in enumerate(log)]
    assert by_chance > 0.3 and "crosstalk" not in {r.rule for r in gate.judge(odd)}
    # with as many as show shared noise at all it is
    assert "crosstalk" in {r.rule for r in gate.judge([replace(e, samples=3000) for e in odd])}


def converted(louder: float) -> list[Run]:
    """Return act runs of three bends in two movements behind a converter, with noise of 1.4 of its steps, in one run of ``louder`` times as much."""
    log = []
    for k, (name, wrap) in enumerate(BENDS.items()):
        for movement in (7, 8):
            here = louder if (name, movement) == ("b050", 8) else 1.0
            r = bend(name, wrap, "act", 40 + 2 * k + movement, 1.4 * STEP_N * here, movement)
            read = {c: np.round(getattr(r, c) / STEP_N) * STEP_N for c in ("tension_in_n", "tension_out_n")}
            log.append(replace(r, run_id=f"{name}-{movement}", trajectory=f"m{movement}", **read))
    return log


def test_a_noise_of_few_steps_of_the_converter_is_not_compared_from_run_to_run():
    log = converted(1.5)
    # their second differences are whole steps: half as much again reads as twice as much
    noises = [gate.evidence_of(r).sensors[1].noise_n for r in log]
    assert max(noises) > 1.7 * sorted(noises)[-2]
    assert said(log, "odd_run") == []


def test_a_noise_of_many_steps_is_compared():
    step = 0.004
    log = [
        replace(r, **{c: np.round(getattr(r, c) / step) * step for c in ("tension_in_n", "tension_out_n")})
        for r in [*rig(), *rig(seed=100)]
    ]
    log = [replace(r, run_id=f"{r.run_id}-{k}") for k, r in enumerate(log)]
    louder = log[0].tension_in_n + np.round(0.1 * np.random.default_rng(1).standard_normal(len(log[0])) / step) * step
    assert said([replace(log[0], tension_in_n=louder), *log[1:]], "odd_run") == [(log[0].run_id,)]
