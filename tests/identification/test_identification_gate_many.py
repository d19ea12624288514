"""Logs of many runs: what is kept of each to recognise copies is bounded, and copies are told all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate import fingerprints
from sstl_cli.identification.gate.rules import duplicate, labels


def recorded(k, seconds=30.0, noise=0.02):
    t, x = multisine(3, 3.0, 26.0, seconds=seconds, rate=100.0)
    scatter = noise * np.random.default_rng(k).standard_normal((2, len(t)))
    return Run(f"r{k}", "act", t, x + scatter[0], play(x, lines(0.4)) + scatter[1])


def with_copies():
    """Twelve runs; of the last three one is a copy, one a copy from a third on, and one holds the output of another run."""
    runs = [recorded(k) for k in range(12)]
    late = slice(len(runs[0]) // 3, None)
    other = recorded(99)
    return [
        *runs,
        replace(runs[2], run_id="same"),
        replace(runs[5].cut(late), run_id="late"),
        replace(runs[7], run_id="attached", tension_in_n=other.tension_in_n),
    ]


def judged(runs):
    found = gate.Witnesses()
    for run in runs:
        found.add(run)
    return found.log, [r for r in gate.judge(found.log) if r.rule == "duplicate"]


@pytest.mark.parametrize("most", [40_000, 10_000])
def test_a_part_of_the_fingerprints_tells_the_same_copies(monkeypatch, most):
    whole, expected = judged(with_copies())
    assert {name for r in expected for name in r.run_ids} == {"same", "late", "r7", "attached"}
    monkeypatch.setattr(gate, "MOST_PRINTS", most)
    monkeypatch.setattr(gate, "PRINTS_EACH", 0)
    part, said = judged(with_copies())
    held = sum(len(e.prints) + len(e.output_prints) for e in part)
    assert held <= most < sum(len(e.prints) + len(e.output_prints) for e in whole)
    assert [r.run_ids for r in said] == [r.run_ids for r in expected]
    # of n random ones a share is known to a few times 1 / (2 sqrt(n)); each keeps LEFT at the least
    assert [r.number for r in said] == pytest.approx([r.number for r in expected], abs=400.0 / 2.0 / fingerprints.LEFT**0.5)


def test_a_short_run_keeps_its_fingerprints_beside_long_ones(monkeypatch):
    short = recorded(50, seconds=2.0)
    monkeypatch.setattr(gate, "MOST_PRINTS", 8_000)
    log, said = judged([*(recorded(k, seconds=60.0) for k in range(4)), short, replace(short, run_id="same")])
    by_name = {e.run_id: e for e in log}
    assert len(by_name["same"].prints) > 128 and by_name["same"].prints.below == fingerprints.ALL
    assert by_name["r0"].prints.below < fingerprints.ALL
    assert [r.run_ids for r in said] == [("same",)] and said[0].number == 100.0


def test_each_run_costs_no_more_than_a_few_fingerprints(monkeypatch):
    monkeypatch.setattr(gate, "MOST_PRINTS", 1)
    log, _ = judged([recorded(k) for k in range(8)])
    assert sum(len(e.prints) + len(e.output_prints) for e in log) <= gate.PRINTS_EACH * len(log)
    assert all(len(e.prints) >= fingerprints.LEFT for e in log)


@pytest.mark.parametrize("at_once", [1, 50, 10**6])
def test_keys_sorted_part_by_part_are_shared_by_the_same_pairs(monkeypatch, at_once):
    rng = np.random.default_rng(4)
    keys = [np.unique(rng.integers(0, 400, 150)).astype(np.uint64) << np.uint64(54) for _ in range(6)] + [fingerprints.NO_KEYS]
    monkeypatch.setattr(duplicate, "AT_ONCE", at_once)
    found = duplicate._shared(keys, (1,))
    owners = {}
    for i, of in enumerate(keys):
        for key in of.tolist():
            owners.setdefault(key, []).append(i)
    expected = {}
    for of in owners.values():
        for pair in zip(of[:-1], of[1:], strict=True):
            expected[pair] = expected.get(pair, 0) + 1
    assert dict(found) == expected
    assert not duplicate._shared([fingerprints.NO_KEYS] * 3, (1,))


def test_pairs_of_bends_are_taken_a_row_at_once_and_none_is_missed():
    """The rule of labels looks closer at the pairs that a look at all of them names: those are all whose order turns."""
    rng = np.random.default_rng(8)
    bends, columns = [f"c{k}" for k in range(9)], [("act", None, None), ("sstl", None, None), ("sstl", "b", None)]
    cells = [(k, c) for k in bends for c in columns if rng.random() < 0.8]
    level = {at: float(rng.normal(bends.index(at[0]) * 0.1, 0.15)) for at in cells}
    error = {at: float(rng.choice([0.001, 0.02, np.nan])) for at in cells}

    def turns(first, second):
        steps = [
            (level[second, c] - level[first, c], 4.0 * max(error[first, c], error[second, c]))
            for c in columns
            if {(first, c), (second, c)} <= set(cells)
        ]
        return any(d > max(0.04, e) for d, e in steps) and any(d < -max(0.04, e) for d, e in steps)

    found = list(labels._turned(bends, columns, level, error, 0.04))
    assert found == sorted(found)
    expected = {(a, b) for i, a in enumerate(bends) for b in bends[i + 1 :] if turns(a, b)}
    assert expected <= set(found) and len(expected) > 3
    sure = {at: np.nan_to_num(e) for at, e in error.items()}
    error = sure
    assert (
        set(found) == {(a, b) for i, a in enumerate(bends) for b in bends[i + 1 :] if turns(a, b)} < {(a, b) for a in bends for b in bends}
    )
