"""What another simulator misses, put on the built-in base."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.physics.rebased import rebase
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory, load
from sstl_cli.steps import diagnose
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


def test_as_given_is_what_the_two_outputs_differ_by():
    """The base that stands for the other simulator was given theta 0.53, which neither has: 1.7 N as given where they differed by 0.033 N."""
    move = Trajectory(kind="trapezoid", duration_s=12.0, cycles=2, drive="tension", systems=("act",))
    bends = (Configuration(id="a", theta=0.15), Configuration(id="b", theta=0.25))
    plan = Scenario(sampling_hz=50.0, noise=NoiseSection(white_n=0.02), configurations=bends, trajectories=(move,))
    log = list(step.run(plan, {}, 1))
    other = [replace(r, tension_out_n=r.tension_out_n + 0.3) for r in step.run(plan, {}, 2)]
    missed = np.concatenate([a.tension_out_n - b.tension_out_n for a, b in zip(log, other, strict=True)])
    options = diagnose.DiagnoseOptions(effects=("zero_offset", "const_friction"), max_effects=1, physics=False)

    def said(log):
        return diagnose.run(rebase(log, other), options).body

    found = said(log)
    assert found.verdict.effects == ["zero_offset"]
    assert found.gap.rmse_base_n == pytest.approx(np.sqrt(np.mean(missed**2)), rel=0.01)
    assert found.gap.rmse_base_n == pytest.approx(0.3, abs=0.01)
    # a reading that the recorder has spoilt is in none of the errors
    spoilt = log[0].tension_out_n.copy()
    spoilt[200] += 50.0
    spikes = said([replace(log[0], tension_out_n=spoilt), *log[1:]])
    assert spikes.gap.rmse_base_n == pytest.approx(found.gap.rmse_base_n, rel=0.01)
    # a simulator of this program is as it was
    plain = diagnose.run(log, options).body
    assert plain.gap.rmse_base_n > 1.0
