"""The numbers that a verdict is made from, where they are known by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import made, simulator

from sstl_cli.diagnosis.constants import EXAMINED
from sstl_cli.diagnosis.features import _examined, _independent, _means, _share, instability
from sstl_cli.diagnosis.hypotheses import Hypothesis, full
from sstl_cli.diagnosis.residuals import Leftover, Misfit

OUT = Hypothesis(("zero_offset",), tuple(f for f in full("zero_offset", ("act",)).free if f.parameter.name == "z_out_act_n"))


@pytest.mark.parametrize(
    "removed, reducible, share", [(1.0, 2.0, 0.5), (2.0, 2.0, 1.0), (3.0, 2.0, 1.0), (-1.0, 2.0, 0.0), (0.0, -1.0, 0.0), (0.1, -1.0, 1.0)]
)
def test_the_share_of_what_is_reducible(removed, reducible, share):
    assert _share(removed, reducible) == share


def test_a_model_without_strengths_or_of_one_run_is_not_unstable():
    assert instability(simulator(), made(1.0)) == 1.0


@pytest.mark.parametrize("by_run, stable", [([1.0, 1.0, 1.0, 1.0], True), ([1.0, 1.0, -1.0, -1.0], False)])
def test_strengths_on_which_two_halves_of_the_runs_disagree_are_unstable(by_run, stable):
    # of four runs the first two are one half, the last two the other
    left = 0.05 * np.array(by_run)[simulator().run]
    found = instability(simulator(), made(left, OUT, (0.1,)))
    assert found < 1e-6 if stable else found > 100.0


def record(samples=100, **known):
    made_up = {"weight": np.ones(samples), "misfit_n": None, "misfit_s": 1.0, "system": "act", "factor": 1, "dt_s": 0.1}
    return SimpleNamespace(**{**made_up, **known})


def search(*records):
    noise = SimpleNamespace(output={"act": SimpleNamespace(white_n=1.0)})
    return SimpleNamespace(noise=noise, sim=SimpleNamespace(problem=SimpleNamespace(records=records)))


@pytest.mark.parametrize(
    "known, alone",
    [
        ({}, 100.0),
        # half of the scatter stays for 2 x 1 s: 20 samples say what one does
        ({"misfit_n": np.ones(100)}, 100.0 / (1.0 + 0.5 * 19.0)),
        ({"misfit_n": np.zeros(100)}, 100.0),
        # shorter than a sample
        ({"misfit_n": np.ones(100), "misfit_s": 0.01}, 100.0),
    ],
)
def test_a_slow_known_scatter_says_the_same_for_as_long_as_it_lasts(known, alone):
    assert _independent(search(record(**known)), 100) == round(alone)
    both = _independent(search(record(**known), record()), 200)
    assert both == round(200 * (alone + 100.0) / 200.0)


def test_samples_without_weight_are_none():
    weight = np.repeat([1.0, 0.0], 50)
    assert _independent(search(record(weight=weight, misfit_n=np.ones(100))), 50) == round(50 / 10.5)
    assert _independent(search(record(weight=np.zeros(100))), 0) == 1


def test_the_best_and_the_best_without_a_leading_effect_are_examined():
    leaders = [SimpleNamespace(ids=("a", f"{i}")) for i in range(EXAMINED)]
    other, last = SimpleNamespace(ids=("b",)), SimpleNamespace(ids=("c",))
    found = _examined([*leaders, other, last])
    assert found[:EXAMINED] == leaders and other in found and last not in found and len(found) == EXAMINED + 1


def test_the_tests_of_means_are_picked_by_their_name():
    tests = (Misfit("mean by run", 2.0, 1.0, ""), Misfit("mean by speed", 5.0, 1.0, ""), Misfit("spread by run", 9.0, 1.0, ""))
    assert _means(replace(Leftover(10, 1.0, 0.0, 0.0, 0.0, tests))) == 5.0
