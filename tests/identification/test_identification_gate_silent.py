"""An input that shows none of its noise while the output moves: told by how long a live sensor would repeat a reading, behind coarse levels as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play, trapezoid
from identification_slips import BENDS, bend, lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate

NOISE_N = 0.05


def read(v, seed, step):
    v = v + NOISE_N * np.random.default_rng(seed).standard_normal(len(v))
    return np.round(v / step) * step


def log(seed, noises, movement):
    """Return two runs of two bends behind a converter of so many noises a step."""
    t, x = movement(seed)
    return [
        Run(
            f"act-b{k}",
            "act",
            t,
            read(x, 7 * seed + k, noises * NOISE_N),
            read(play(x, lines(w)), 7 * seed + k + 3, noises * NOISE_N),
            config_id=f"b{k}",
        )
        for k, w in enumerate((0.3, 0.6))
    ]


def swings(seed):
    t, x = multisine(seed, 3.0, 26.0, seconds=60.0)
    return t[: len(t) // 3], x[::3]


def stairs(_):
    return trapezoid(low=3.0, high=26.0, rate=100.0, cycles=2)


def stopped(run, first, last):
    """Return a run whose input repeats one reading between two parts of it."""
    x, a, b = run.tension_in_n.copy(), round(first * len(run)), round(last * len(run))
    x[a:b] = x[a]
    return replace(run, tension_in_n=x)


@pytest.mark.each_once
@pytest.mark.parametrize("noises", asked((0.5, 1.0, 2.0), 1.0))
@pytest.mark.parametrize(("first", "last"), [(0.4, 0.8), (0.3, 1.0), (0.0, 1.0)])
@pytest.mark.parametrize("movement", [swings, stairs])
def test_an_input_without_its_noise_while_the_output_moves_is_stuck(noises, first, last, movement):
    told = log(5, noises, movement)
    said = gate.remarks([stopped(told[0], first, last), told[1]])
    assert {(r.rule, r.run_ids) for r in said} == {("stuck", ("act-b0",))}


@pytest.mark.each_once
@pytest.mark.parametrize("noises", [1.0, 2.0, 3.0, 8.0])
@pytest.mark.parametrize("movement", [swings, stairs])
def test_an_input_that_is_held_behind_coarse_levels_is_live(noises, movement):
    """The tops of the stairs last 60 samples, those of a slow swing as long between two levels."""
    for seed in range(4):
        assert gate.remarks(log(seed, noises, movement)) == ()


def test_an_input_that_never_changes_may_hide_a_movement_within_a_level():
    """An output that moves by less than friction makes of one step of the input tells nothing of a flat one."""
    flat, other = log(1, 8.0, swings)
    t = flat.time_s
    within = 10.0 + 0.15 * np.sin(t)
    output = np.round(play(within, lines(0.3)) / 0.1) * 0.1
    flat = replace(flat, tension_in_n=np.full(len(t), 10.0), tension_out_n=output)
    assert not [r for r in gate.remarks([flat, other]) if r.rule == "stuck"]


@pytest.mark.slow
def test_an_input_that_is_cut_off_in_all_runs_of_both_systems_is_told_of_all():
    """Noise hides in the loops of one system that the output goes on."""
    level, step = 20.6, 0.05
    runs = []
    for i, (name, theta) in enumerate(BENDS.items()):
        for system in ("act", "sstl"):
            r = bend(name, 1.0 * theta, system, 200 + 10 * i + len(system), sd=0.07, movement=9)
            runs.append(replace(r, tension_in_n=np.round(np.minimum(r.tension_in_n, level) / step) * step))
    (said,) = [r for r in gate.remarks(runs) if r.rule == "limit"]
    assert set(said.run_ids) == {r.run_id for r in runs}
    # of an input that goes further in one run nothing is said there
    runs[0] = bend("b020", BENDS["b020"], "act", 203, sd=0.07, movement=9)
    (said,) = [r for r in gate.remarks(runs) if r.rule == "limit"]
    assert runs[0].run_id not in said.run_ids and len(said.run_ids) == 5
