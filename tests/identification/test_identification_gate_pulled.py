"""Runs that are only pulled: one slope, of friction and gain together, and what it says of a label."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import BENDS, lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.bounds import bounds


def pulled(name: str, wrap: float, system: str, seed: int, gain: float) -> Run:
    """Return a pull, by another way in every repetition, behind sensors of one gain."""
    t = np.arange(900) / 100.0
    at = [0.0, 0.6, 2.0 + 0.5 * (seed % 3), 5.0, 8.0, 9.0]
    x = np.interp(t, at, [2.5, 2.5, 8.0, 8.0 + 4.0 * (seed % 3), 27.0 + 0.3 * (seed % 4), 27.0 + 0.3 * (seed % 4)])
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    y = gain * play(x, lines(wrap))
    return Run(f"{system}-{name}-{seed % 3}", system, t, x + noise[0], y + noise[1], config_id=name, trajectory=f"pull {seed % 3}")


def log(gain: float = 1.0, wears: float = 0.0) -> list[Run]:
    """Return a sound log of three bends pulled three times in both systems; friction ``wears`` from one time to the next."""
    return [
        pulled(name, (2.0 if system == "sstl" else 1.0) * wrap * (1.0 + wears * k), system, 300 + 30 * i + 6 * j + k, gain)
        for i, (name, wrap) in enumerate(BENDS.items())
        for j, system in enumerate(("act", "sstl"))
        for k in range(3)
    ]


def said(runs: list[Run]) -> list[tuple[str, tuple[str, ...]]]:
    return [(r.rule, r.run_ids) for r in gate.remarks(runs)]


@pytest.mark.each_once
@pytest.mark.parametrize("gain", [1.0, 0.9, 1.12])
@pytest.mark.parametrize(("which", "label"), [("act-b050-0", "b020"), ("sstl-b020-1", "b050")])
def test_one_label_among_runs_that_are_only_pulled_is_told(which, label, gain):
    runs = log(gain)
    assert not [r for r in runs if gate.evidence_of(r).slopes.known]
    assert said(runs) == []
    assert said([replace(r, config_id=label) if r.run_id == which else r for r in runs]) == [("relabelled", (which,))]


def test_pulls_that_wear_as_much_as_bends_differ_by_tell_no_label():
    assert said(log(wears=0.25)) == []


def test_a_run_that_passes_on_as_no_other_bend_does_has_no_label_of_one():
    runs = [replace(r, tension_out_n=0.9 * r.tension_out_n) if r.run_id == "act-b020-1" else r for r in log()]
    assert "relabelled" not in {rule for rule, _ in said(runs)}


@pytest.mark.slow
def test_a_position_beside_runs_that_are_only_pulled_is_not_taken_for_their_output():
    """The output creeps as it is pulled, so that friction does not explain it; along one line friction explains whatever rises with its input."""
    runs = []
    for k, r in enumerate(log()):
        x = r.tension_in_n
        slid = 0.12 * np.sin(0.9 * r.time_s + k) * (x - x.min()) / np.ptp(x)
        position = 0.7 * x + 0.01 * np.random.default_rng(500 + k).standard_normal(len(x))
        runs.append(replace(r, tension_out_n=r.tension_out_n * (1.0 + slid), position_in_mm=position))
    evidence = [gate.evidence_of(r) for r in runs]
    # with the position as the output friction leaves next to nothing of most of them
    tempting = [e for e in evidence if e.instead[1].rms_n < 0.3 * e.causes.friction.rms_n / e.ranges[1].span]
    assert 2 * len(tempting) > len(runs)
    assert "columns" not in {r.rule for r in gate.judge(evidence)}


@pytest.mark.each_once
@pytest.mark.parametrize("gain", [1.0, 0.95, 1.05])
@pytest.mark.parametrize(("which", "label"), [("act-b050-0", "b020"), ("sstl-b020-0", "b080")])
def test_one_label_is_told_where_every_bend_is_pulled_once_in_both_systems(which, label, gain):
    once = [r for r in log(gain) if r.run_id.endswith("-0")]
    assert said(once) == []
    assert said([replace(r, config_id=label) if r.run_id == which else r for r in once]) == [("relabelled", (which,))]
    # in one system alone it is as likely the other run of that label
    alone = [r for r in once if r.system == which.split("-")[0]]
    assert "relabelled" not in {rule for rule, _ in said([replace(r, config_id=label) if r.run_id == which else r for r in alone])}


def test_one_pass_that_passes_on_what_two_of_another_bend_do_may_have_the_label_of_its_system_wrong():
    runs = [replace(r, system="sstl") if r.run_id == "act-b050-1" else r for r in log()]
    (told,) = gate.remarks(runs)
    assert told.run_ids == ("act-b050-1",) and "of its configuration or of its system" in told.sentence


def creeping(runs: list[Run]) -> list[Run]:
    """Return runs whose friction gives way as they go on, by parts of their own."""
    return [replace(r, tension_out_n=r.tension_out_n * (1.0 + 0.04 * (k % 3) * r.time_s / r.time_s[-1])) for k, r in enumerate(runs)]


def test_what_a_pull_passes_on_is_its_friction_however_laws_explain_it():
    for r in creeping(log()):
        e = gate.evidence_of(r)
        low, high = bounds(e)
        assert e.one_way and low <= -e.passed <= high
