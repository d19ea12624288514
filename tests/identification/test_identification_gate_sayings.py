"""What is said names what it is: noise is no straight line, a command is no clock, less is not more, a gain of ten fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine
from identification_slips import rig

from sstl_cli.identification import gate

BENT = "act-b050"


def noise(n, k, sd=1.0):
    return sd * np.random.default_rng(k).standard_normal(n)


def said(runs, rule):
    return [r for r in gate.remarks(runs) if r.rule == rule]


def test_an_output_lies_along_no_line_of_an_input_that_is_noise():
    runs = [replace(r, tension_in_n=10.0 + noise(len(r), k, 2.0)) for k, r in enumerate(rig())]
    assert said(runs, "same_channel") == [] and said(runs, "unrelated")


def test_two_sensors_at_one_end_are_still_told():
    runs = [replace(r, tension_out_n=r.tension_in_n + noise(len(r), k, 0.02)) for k, r in enumerate(rig())]
    assert said(runs, "same_channel")


def test_an_output_without_noise_that_comes_first_is_the_command():
    runs = [replace(r, tension_out_n=np.interp(r.time_s + 0.06, *multisine(7, 3.0, 26.0, seconds=90.0)[:2])) for r in rig()]
    ahead = [
        replace(r, tension_in_n=np.interp(r.time_s, *multisine(7, 3.0, 26.0, seconds=90.0)[:2]) + noise(len(r), k, 0.02))
        for k, r in enumerate(runs)
    ]
    (first, *rest) = said(ahead, "lead")
    assert first.severity == "failure" and "probably the command" in first.sentence and "column" in first.mend and not rest


@pytest.mark.parametrize(("factor", "words"), [(1.0 / 40.0, "is 1/4"), (40.0, "is 4")])
def test_a_noise_that_is_less_is_a_part_of_the_others(factor, words):
    evidence = [gate.evidence_of(replace(r, run_id=f"{r.run_id}-{k}")) for k in (0, 1) for r in rig(seed=100 * k) if r.system == "act"]
    odd = [
        replace(e, sensors=(e.sensors[0], replace(e.sensors[1], noise_n=factor * e.sensors[1].noise_n))) if e is evidence[1] else e
        for e in evidence
    ]
    (told,) = [r for r in gate.judge(odd) if r.rule == "odd_run" and "noise of the output" in r.sentence]
    assert f"noise of the output {words}" in told.sentence or f"noise of the output {words.replace('4', '3')}" in told.sentence


@pytest.mark.parametrize(("factor", "severity"), [(10.0, "failure"), (1.0 / 4.448, "failure"), (2.0, "remark")])
def test_a_gain_of_one_run_fails_from_three_on(factor, severity):
    runs = [replace(r, tension_out_n=factor * r.tension_out_n) if r.run_id == BENT else r for r in rig(1.2)]
    (told,) = said(runs, "gain")
    assert told.severity == severity and told.run_ids == (BENT,)


def test_one_run_that_rubs_as_another_bend_may_have_the_wrong_configuration():
    runs = [*rig(), *(replace(r, run_id=f"{r.run_id}-again", trajectory="other") for r in rig(seed=50))]
    runs = [replace(r, config_id="b020") if r.run_id == "act-b080-again" else r for r in runs]
    (told,) = said(runs, "passes")
    assert told.run_ids == ("act-b080-again",) and "label of its configuration" in told.sentence and "config_id" in told.mend


def test_two_channels_of_noise_are_told():
    runs = [replace(r, tension_in_n=noise(len(r), 2 * k), tension_out_n=noise(len(r), 2 * k + 1)) for k, r in enumerate(rig())]
    (told,) = said(runs, "dead")
    assert len(told.run_ids) == len(runs) and "nothing was moved" in told.sentence
    assert not said(rig(), "dead")
