"""What another simulator misses, put on the built-in base."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.physics.rebased import rebase
from sstl_cli.physics.scenario import load
from sstl_cli.steps import simulate as step

MORE_N = 0.08


def test_what_both_logs_hold_is_not_missing():
    """A pulley makes the loop rub more than twice; the base that its difference is put on has one theta for both systems."""
    plan = load("default")
    quiet = plan.noise.model_copy(update={"white_n": 0.0})
    plan = plan.model_copy(update={"noise": quiet, "configurations": plan.configurations[:1], "trajectories": plan.trajectories[:1]})
    other = list(step.run(plan, {"pulley_friction": {"m_p": 0.08, "m_r": 0.06}}, 1))
    log = [replace(r, tension_out_n=r.tension_out_n + MORE_N) for r in other]
    moved = rebase(log, other)
    assert {r.system for r in moved} == {"act", "sstl"}
    # on a pull the output of the base is exp(-n theta) of its input
    at = [int(np.argmax(r.tension_in_n)) for r in moved]
    thetas = [-np.log((r.tension_out_n[i] - MORE_N) / r.tension_in_n[i]) / r.passes for r, i in zip(moved, at, strict=True)]
    assert thetas == pytest.approx([thetas[0]] * len(thetas), rel=1e-9)
