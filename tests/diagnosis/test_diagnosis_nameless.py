"""Friction of the sensing loop that is not the actuation tendon's: no effect of the catalogue, and none of them is named for it."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from rig_logs import SHORT, scenario

from sstl_cli.diagnosis.free import LOOP
from sstl_cli.physics.scenario import RigSection, Scenario
from sstl_cli.steps import simulate
from sstl_cli.steps.diagnose import DiagnoseOptions, run

OPTIONS = DiagnoseOptions(effects=("pulley_friction", "gain_error", "zero_offset"))


def recorded(factor: float, effects: dict[str, dict[str, float]] | None = None, seed: int = 7):
    """Both tendons of a rig whose loop has so many times the friction."""
    plan = scenario(moves=SHORT[:2])
    whole = simulate.run(plan, effects or {}, seed)
    loops = simulate.run(with_theta(plan, factor), effects or {}, seed)
    return [r for r in whole if r.system == "act"] + [r for r in loops if r.system == "sstl"]


def with_theta(plan, factor):
    return plan.model_copy(update={"configurations": tuple(c.model_copy(update={"theta": factor * c.theta}) for c in plan.configurations)})


@pytest.mark.parametrize("factor", [1.06, pytest.param(0.95, marks=pytest.mark.slow)])
def test_friction_of_the_loop_alone_has_no_name_and_is_told_in_words(factor):
    said = run(recorded(factor), OPTIONS).verdict
    assert said.status == "unknown" and said.effects == ()
    side = "above" if factor > 1.0 else "below"
    percent = float(said.why.split("that is ")[1].split(" %")[0])
    assert percent == pytest.approx(100.0 * abs(factor - 1.0), abs=0.3)
    assert f"{side} the actuation tendon's" in said.why and said.why.endswith("and is no candidate")
    assert not any(LOOP.id in ids for ids in said.probabilities)


@pytest.mark.slow
@pytest.mark.slow
def test_a_pulley_keeps_its_name():
    runs = recorded(1.0, {"pulley_friction": {"m_p": 0.05, "m_r": 0.05}})
    said, alone = (run(x, OPTIONS).document() for x in (runs, [r for r in runs if r.config_id == "a"]))
    assert all((d["verdict"]["status"], d["verdict"]["effects"]) == ("identified", ["pulley_friction"]) for d in (said, alone))
    # in one bend nobody can tell
    alike = "above the actuation tendon's would explain this data as well"
    assert not any(alike in n for n in said["notes"]) and any(n.endswith(alike) for n in alone["notes"])


@pytest.mark.slow
def test_the_loop_has_its_own_friction_and_the_tendon_has_not():
    result = run(recorded(1.0), OPTIONS)
    sim, theta = result.evidence.search.sim, np.array([0.5, 0.6])
    base, more = sim.predict(theta, {}), sim.predict(theta, {LOOP.id: {"d": 0.1}})
    loop = np.array([r.system == "sstl" for r in sim.problem.records])[sim.run]
    assert np.array_equal(more[~loop], base[~loop]) and not np.allclose(more[loop], base[loop])
    assert more[loop] == pytest.approx(sim.predict(1.1 * theta, {})[loop])
    assert result.verdict.status == "none"


@pytest.mark.slow
def test_a_model_keeps_it_and_then_other_effects_are_asked_for():
    runs = recorded(1.06)
    result = run(runs, OPTIONS)
    note = next(n for n in result.document()["notes"] if "loop_friction" in n)
    assert float(note.split("loop_friction = ")[1].split(" ")[0]) == pytest.approx(1.06, abs=0.003)
    model = result.model()
    assert model.rig.loop_friction == pytest.approx(1.06, abs=0.003) and not model.effects
    assert run(runs, replace(OPTIONS, sim=model)).verdict.status == "none"
    assert run(changed(), replace(OPTIONS, sim=model)).verdict.effects == ("zero_offset",)


def changed():
    """The same rig with a zero that is off."""
    return recorded(1.06, {"zero_offset": {"z_out_act_n": 0.2}}, seed=8)


@pytest.mark.slow
def test_beside_another_effect_nothing_is_kept_and_what_the_rig_is_can_be_said_by_hand():
    both = run(changed(), OPTIONS)
    assert both.verdict.status == "unknown" and "+ zero_offset" in both.verdict.why and both.model().rig.loop_friction == 1.0
    stated = Scenario(rig=RigSection(loop_friction=1.06))
    assert run(changed(), replace(OPTIONS, sim=stated)).verdict.effects == ("zero_offset",)


@pytest.mark.parametrize("simulator", get_args(Scenario.model_fields["simulator"].annotation))
def test_every_simulator_takes_it_from_the_scenario(simulator):
    plan = scenario(configs=1, moves=SHORT[:1]).model_copy(update={"simulator": simulator})
    rig = plan.rig.model_copy(update={"loop_friction": 1.1})
    one, more, loops = (simulate.run(p, {}, 5) for p in (plan, with_theta(plan, 1.1), plan.model_copy(update={"rig": rig})))
    for a, b, c in zip(one, more, loops, strict=True):
        assert np.allclose(c.tension_out_n, (b if c.system == "sstl" else a).tension_out_n)
