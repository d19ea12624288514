"""Digits, rigs, labels and rows: what bookkeeping spoils is told by its own cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate, samples


def waves(seed, top, seconds=40.0, rate=100.0):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    w = sum(rng.normal() * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 6.28)) for f in rng.uniform(0.05, 0.5, 9))
    return t, top * (0.08 + 0.92 * (w - w.min()) / np.ptp(w))


def loop(name, seed, wrap, top=24.0, movement=7, noise=5e-4, **more):
    t, x = waves(movement, top)
    scatter = top * noise * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(name, more.pop("system", "act"), t, x + scatter[0], play(x, lines(wrap)) + scatter[1], trajectory=f"m{movement}", **more)


def without_comma(v, digits):
    return np.array([float(f"{value:.{digits}f}".rstrip("0").rstrip(".").replace(".", "")) for value in v])


def findings(r):
    return [
        f.what
        for f in samples.findings(
            samples.Piece("r", {"time_s": r.time_s, "tension_in_n": r.tension_in_n, "tension_out_n": r.tension_out_n})
        )
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("top", "digits"),
    [(45.0, 1), *(pytest.param(top, digits, marks=pytest.mark.slow) for top, digits in ((24.0, 2), (12.0, 3), (90.0, 2)))],
)
def test_a_lost_decimal_comma_is_told_as_such_and_not_as_counts_or_spikes(top, digits):
    runs = [loop(f"r{i}", i, 0.2 + 0.2 * i, top) for i in range(3)]
    assert gate.remarks(runs) == ()
    runs = [
        replace(r, tension_in_n=without_comma(r.tension_in_n, digits), tension_out_n=without_comma(r.tension_out_n, digits)) for r in runs
    ]
    (said,) = [r for r in gate.remarks(runs) if r.failed]
    assert said.rule == "counts" and "decimal comma" in said.sentence and len(said.run_ids) == 3
    for r in runs:
        assert "digits lost" in findings(r) and "spikes" not in findings(r)


@pytest.mark.parametrize("top", [45.0, 24.0])
def test_counts_are_counts(top):
    runs = [loop(f"r{i}", i, 0.2 + 0.2 * i, top) for i in range(3)]
    runs = [replace(r, tension_in_n=np.round(80.0 * r.tension_in_n), tension_out_n=np.round(80.0 * r.tension_out_n)) for r in runs]
    (said,) = gate.remarks(runs)
    assert "counts of the converter" in said.sentence and "digits lost" not in findings(runs[0])


BENDS = {"b020": 0.2, "b050": 0.35, "b080": 0.5}


@pytest.mark.parametrize("factor", [1.5, 2.25, 2.9])
def test_runs_of_another_rig_are_no_double_pass(factor):
    log = [loop(f"a-{c}", i, w, config_id=c) for i, (c, w) in enumerate(BENDS.items())]
    log += [loop(f"b-{c}", 9 + i, factor * w, config_id=c, noise=2e-3) for i, (c, w) in enumerate(BENDS.items())]
    said = {r.rule: r for r in gate.remarks(log)}
    assert "two_rigs" in said and "passes" not in said and set(said["two_rigs"].run_ids) == {f"b-{c}" for c in BENDS}
    assert said["two_rigs"].number == pytest.approx(factor, rel=0.05)


@pytest.mark.parametrize("pulley", [0.0, 0.08])
def test_loops_under_the_label_of_actuation_are_a_double_pass(pulley):
    log = [loop(f"a-{c}", i, w, config_id=c) for i, (c, w) in enumerate(BENDS.items())]
    log += [loop(f"b-{c}", 9 + i, 2.0 * w + pulley, config_id=c) for i, (c, w) in enumerate(BENDS.items())]
    said = gate.remarks(log)
    assert said[0].rule == "passes" and set(said[0].run_ids) == {f"b-{c}" for c in BENDS}


@pytest.mark.parametrize(("wrong", "to"), [("b080-8", "b020"), ("b020-7", "b080"), ("b050-8", "b020")])
def test_one_wrong_label_accuses_one_run_and_tells_where_it_fits(wrong, to):
    log = [loop(f"{c}-{m}", 10 * i + m, w, movement=m, config_id=c) for i, (c, w) in enumerate(BENDS.items()) for m in (7, 8, 9)]
    assert gate.remarks(log) == ()
    log = [replace(r, config_id=to) if r.run_id == wrong else r for r in log]
    (said,) = [r for r in gate.remarks(log) if r.rule == "labels"]
    assert said.run_ids == (wrong,) and f"that of {wrong[:4]} fits" in said.sentence


@pytest.mark.parametrize("seed", asked(range(3), 0, 2))
def test_rows_sorted_as_text_are_no_joined_recordings(seed):
    r = loop("r", seed, 0.4, movement=seed)
    at = np.array(sorted(range(len(r)), key=str))
    r = replace(r, tension_in_n=r.tension_in_n[at], tension_out_n=r.tension_out_n[at])
    assert "joined" not in {said.rule for said in gate.remarks([r])}


@pytest.mark.parametrize("seed", asked(range(5), 0, 3))
def test_a_movement_in_steps_is_no_joined_and_no_shuffled_recording(seed):
    rng = np.random.default_rng(seed)
    t = np.arange(4000) / 100.0
    x = (2.0 + 20.0 * rng.random(21))[(t / 2.0).astype(int)]
    y = play(x, lines(0.5))
    noise = 0.01 * rng.standard_normal((2, len(t)))
    assert not {r.rule for r in gate.remarks([Run("n", "act", t, x + noise[0], y + noise[1])])} & {"joined", "order"}
    # a command has no noise
    assert "order" not in {r.rule for r in gate.remarks([Run("c", "act", t, x, y + noise[1])])}
