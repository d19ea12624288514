"""What an accepted model contains may have become less, or more, since then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import THETA, noise, simulator

from sstl_cli.diagnosis.hypotheses import as_changes, full
from sstl_cli.diagnosis.search import _as_known, run
from sstl_cli.steps import diagnose
from tests.diagnosis.rig_logs import record

SIM = simulator()
OPTIONS = diagnose.DiagnoseOptions(effects=("const_friction", "zero_offset", "sensor_nonlinearity"), max_effects=1, physics=False)


def test_strengths_that_are_there_change_as_far_as_the_sum_has_a_meaning_and_shapes_stay():
    h = full("presliding", ("act",))
    length = h.strengths[0].parameter
    assert length.least == length.neutral == 0.0 and any(f.parameter.shape for f in h.free)
    changed = as_changes(h, {"presliding": {length.name: 0.2}})
    own = {f.parameter.name: f.parameter for f in changed.free}[length.name]
    assert (own.least, own.low, own.neutral, own.high, own.most) == (
        -0.2,
        pytest.approx(-0.2),
        0.0,
        length.high,
        pytest.approx(length.most - 0.2),
    )
    assert not any(f.parameter.shape and f.effect.id == "presliding" for f in changed.free)
    # of an effect that is not there all is as it was
    assert as_changes(h, {"zero_offset": {"z_out_act_n": 0.3}}) == h


def test_hypotheses_that_differ_in_shapes_alone_are_one_beside_an_effect_that_is_there():
    sim = replace(SIM, fixed={"channel_lowpass": {"tau_act_s": 0.1}})
    whole = full("channel_lowpass", ("act",))
    first = next(f for f in whole.free if not f.parameter.shape)
    found = _as_known(sim, [whole, type(whole)(whole.ids, (first,))])
    assert [[f.parameter.name for f in h.free] for h in found] == [["tau_act_s"]]


@pytest.mark.parametrize(("then_n", "now_n"), [(0.45, 0.15), (0.15, 0.45)])
def test_friction_at_the_end_that_changes_is_named_by_how_much(then_n, now_n):
    """It could only grow: a joint that was freed was a curved sensor, or a bend that was not touched."""
    model = diagnose.run(record({"const_friction": {"w_l_n": then_n}}, 1), OPTIONS).model()
    assert "const_friction" in model.effects
    body = diagnose.run(record({"const_friction": {"w_l_n": now_n}}, 2), replace(OPTIONS, sim=model)).body
    assert body.verdict.status == "identified" and body.verdict.effects == ["const_friction"]
    values = {p.name: p.estimate for c in body.candidates if c.id == "const_friction" for p in c.parameters}
    assert values["w_l_n"] == pytest.approx(now_n - then_n, rel=0.1)
    assert not body.analysis.theta_changed


@pytest.mark.parametrize("behind", [False, True])
def test_more_friction_at_the_end_acts_on_what_is_known_to_be_left_where_that_is_likelier(behind):
    """What a model left of its record may arise in the line or behind it: more friction at the end holds back the one and not the other."""
    knowing = [replace(r, known=0.15 * np.sin(0.5 * r.u)) for r in SIM.problem.records]
    sim = replace(SIM, problem=replace(SIM.problem, records=tuple(knowing)), fixed={"const_friction": {"w_end_n": 0.2}})
    read = replace(sim, behind=behind).predict(THETA, {"const_friction": {"w_end_n": 0.4}}) + noise(3)
    records = tuple(replace(r, y=read[s]) for r, s in zip(knowing, sim.slices(), strict=True))
    found = run(replace(sim, problem=replace(sim.problem, records=records)), ["const_friction"], THETA, 1)
    best = found.singles["const_friction"][0].fit
    assert found.sim.behind is behind and best.effects["const_friction"]["w_end_n"] == pytest.approx(0.4, abs=0.02)
    assert best.theta == pytest.approx(THETA, abs=0.01)


def test_where_nothing_is_known_to_be_left_there_is_but_one():
    assert not SIM.left and not replace(SIM, behind=False).left
