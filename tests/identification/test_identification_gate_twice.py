"""A recording that a run holds twice, a reference of another run, labels of all files shuffled, and a gain of one system alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate


def moving(k, movement=3, wrap=0.4, noise=0.02, seconds=40.0, rate=100.0, **labels):
    t, x = multisine(movement, 3.0, 26.0, seconds=seconds, rate=rate)
    scatter = noise * np.random.default_rng(k).standard_normal((2, len(t)))
    return Run(f"r{k}", "act", t, x + scatter[0], play(x, lines(wrap)) + scatter[1], **labels)


def twice(r, gap_s=0.5):
    columns = {n: np.tile(getattr(r, n), 2) for n in ("tension_in_n", "tension_out_n")}
    return replace(r, time_s=np.concatenate((r.time_s, r.time_s + r.time_s[-1] - r.time_s[0] + gap_s)), **columns)


def rules(runs):
    return [r.rule for r in gate.remarks(runs)]


@pytest.mark.parametrize(("seconds", "rate"), [(40.0, 100.0), (100.0, 400.0)])
def test_a_recording_that_stands_in_its_own_run_twice_is_told(seconds, rate):
    r = moving(1, seconds=seconds, rate=rate)
    said = gate.remarks([twice(r), moving(2, movement=4)])[0]
    assert said.rule == "duplicate" and said.run_ids == ("r1",) and said.number > 95.0
    assert f"{seconds:.4g} s apart" in said.sentence or f"{seconds + 0.5:.4g} s apart" in said.sentence


@pytest.mark.parametrize(("noise", "step"), [(0.02, 0.0), (0.0, 0.0), (0.02, 0.1), (0.003, 0.1)])
def test_a_movement_that_repeats_is_no_copy(noise, step):
    t = np.arange(6000) / 100.0
    x = 4.0 + 20.0 * np.abs((t / 3.0) % 1.0 - 0.5)
    scatter = noise * np.random.default_rng(5).standard_normal((2, len(t)))
    a, b = x + scatter[0], play(x, lines(0.4)) + scatter[1]
    r = Run("a", "act", t, *(np.round(v / step) * step if step else v for v in (a, b)))
    assert "duplicate" not in rules([r])


def test_a_reference_that_one_run_alone_does_not_follow_is_told():
    runs = [moving(k, movement=k) for k in range(5)]
    runs = [replace(r, tension_ref_n=np.roll(r.tension_in_n, -4)) for r in runs]
    assert "reference" not in rules(runs)
    runs[2] = replace(runs[2], tension_ref_n=runs[4].tension_ref_n)
    (said,) = [r for r in gate.remarks(runs) if r.rule == "reference"]
    assert said.run_ids == ("r2",) and "another run" in said.sentence
    # where most are followed badly, or few runs tell, nothing is said
    assert "reference" not in rules(runs[2:])
    runs[1] = replace(runs[1], tension_ref_n=runs[4].tension_ref_n)
    assert "reference" not in rules(runs)


def test_labels_of_all_files_that_were_shuffled_are_told_as_such():
    log = [replace(r, run_id=f"{r.run_id}-{k}") for k in range(3) for r in rig(1.0, 100 * k)]
    order = np.random.default_rng(3).permutation(len(log))
    mixed = [replace(r, system=log[k].system, config_id=log[k].config_id) for r, k in zip(log, order, strict=True)]
    said = [r for r in gate.remarks(mixed) if r.rule == "passes"]
    assert said and all("shuffled" in r.sentence for r in said)
    # both labels of one bend exchanged are that and no more
    other = {"act": "sstl", "sstl": "act"}
    swapped = [replace(r, system=other[r.system]) if r.config_id == "b050" else r for r in log]
    said = [r for r in gate.remarks(swapped) if r.rule == "passes"]
    assert said and not any("shuffled" in r.sentence for r in said)


def test_a_gain_of_all_runs_of_one_system_is_not_measured_by_the_other():
    log = [replace(r, run_id=f"{r.run_id}-{k}") for k in range(2) for r in rig(1.0, 100 * k)]
    half = [replace(r, tension_out_n=2.1 * r.tension_out_n) if r.system == "act" else r for r in log]
    said = [r for r in gate.remarks(half) if r.rule == "gain"]
    assert said and not any("other runs" in r.sentence for r in said)


def tracking(k, name):
    """Return a run of a sine or a triangle of one period, and its reference."""
    t = np.arange(3000) / 100.0
    s = 0.5 - 0.5 * np.cos(2.0 * np.pi * t / 6.0) if name == "sine" else 1.0 - np.abs(2.0 * (t / 6.0 % 1.0) - 1.0)
    x, scatter = 2.0 + 22.0 * s, 0.02 * np.random.default_rng(k).standard_normal((2, len(t)))
    run = Run(
        f"r{k}",
        "act",
        t,
        np.roll(x, 2) + scatter[0],
        play(x, lines(0.2 + 0.1 * (k // 2))) + scatter[1],
        config_id=f"b{k // 2}",
        trajectory=name,
    )
    return replace(run, tension_ref_n=x)


def test_the_reference_of_another_movement_of_the_same_period_is_told():
    runs = [tracking(k, ("sine", "triangle")[k % 2]) for k in range(6)]
    assert "reference" not in rules(runs)
    other = [replace(runs[0], tension_ref_n=runs[3].tension_ref_n), *runs[1:]]
    (said,) = [r for r in gate.remarks(other) if r.rule == "reference"]
    assert said.run_ids == ("r0",) and "it is probably the reference of another run" in said.sentence
    # an input that is off under the right reference is no slip of that
    off = [replace(runs[0], tension_in_n=np.minimum(runs[0].tension_in_n, 17.0)), *runs[1:]]
    assert "reference" not in rules(off)
