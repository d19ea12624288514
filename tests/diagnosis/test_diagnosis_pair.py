"""A pair that pulls both ways, diagnosed: its model comes back, knows its record and says what has changed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import made_pairs
import pytest

from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.physics.scenario_file import dump
from sstl_cli.steps import diagnose, simulate

# half the readings of what is asked of one pair alone
pair = partial(made_pairs.pair, step_s=0.04)


def options(**more):
    return diagnose.DiagnoseOptions(effects=("zero_offset", "gain_error", "const_friction"), max_effects=1, physics=False, **more)


def test_a_model_of_a_pair_comes_back_knows_its_record_and_says_what_has_changed(tmp_path):
    found = diagnose.run([pair(), pair("b", 4.3)], options())
    body = found.body
    assert body.verdict.status == "none" and body.gap.rmse_retuned_n < 0.3
    assert body.analysis.preload_n.keys() == {"act"} and any("goes below zero" in note for note in body.notes)
    (tmp_path / "pair.toml").write_text(dump(found.model()), "utf-8")
    model = load(str(tmp_path / "pair.toml"))
    assert model.rig.preload_n == pytest.approx(body.analysis.preload_n)
    lows = [float(r.tension_in_n.min()) for r in simulate.run(model, {}, 0)]
    assert min(lows) == pytest.approx(-10.0, abs=0.7)
    assert diagnose.run([pair(period=5.1)], options(sim=model)).body.verdict.status == "none"
    later = diagnose.run([pair(period=5.1, zero_n=1.5), pair("b", 6.1, zero_n=1.5)], options(sim=model)).body
    assert later.verdict.status == "identified" and list(later.verdict.effects) == ["zero_offset"]


def test_the_next_experiment_of_a_pair_pulls_both_ways_within_its_preload():
    log = [pair(), replace(pair("b", 4.3), tension_out_n=1.4 * pair("b", 4.3).tension_out_n)]
    proposed = diagnose.run(
        log, diagnose.DiagnoseOptions(effects=("viscous", "dwell_aging"), max_effects=1, physics=False)
    ).body.next_experiment
    assert proposed is not None
    scenario = Scenario.model_validate(proposed.scenario)
    assert scenario.rig.preload_n is not None and -scenario.rig.preload_n["act"] < min(t.low_n for t in scenario.trajectories) < 0.0
