"""Noise beside the models that were found: what two effects explain together is none of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import record

from sstl_cli.diagnosis.again import beside_the_best
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.noise import strain
from sstl_cli.diagnosis.question import Question
from sstl_cli.physics.scenario import Trajectory

MOVES = (Trajectory(kind="random", duration_s=16.0, low_n=2.0), Trajectory(kind="ramp_hold", duration_s=12.0))
PAIR = {"crosstalk": {"c_in_to_out": 0.01}, "pulley_friction": {"m_p": 0.06, "m_r": 0.06}}
OPTIONS = Question(effects=(*PAIR, "zero_offset"), max_effects=2)


@pytest.mark.slow
def test_what_two_effects_explain_is_no_noise():
    found = gather(record(PAIR, moves=MOVES), OPTIONS).search
    assert set(found.ranked()[0].ids) == set(PAIR) and strain(found.noise, found.measured) < 1.0


@pytest.mark.slow
def test_noise_that_was_strained_is_believed_again_and_every_model_judged_by_it():
    found = gather(record(PAIR, moves=MOVES), OPTIONS).search
    loud = {s: replace(x, coloured_n=6.0 * x.coloured_n) for s, x in found.noise.output.items()}
    strained = replace(found, noise=replace(found.noise, output=loud))
    again = beside_the_best(strained, 2, 1)
    assert strain(again.noise, again.measured) < 1.0 < strain(strained.noise, strained.measured)
    best, was = again.ranked()[0], found.ranked()[0]
    # gains go with the noise of the input, which 28 s of movement show to a part only
    assert best.ids == was.ids and np.isclose(best.gain, was.gain, rtol=0.15)
    assert np.allclose(best.fit.values, was.fit.values, rtol=0.02)
    assert set(again.singles) == set(found.singles) and set(again.combined) == set(found.combined)
    # noise that nothing pulls at stays as it is
    assert beside_the_best(again, 2, 1) is again
