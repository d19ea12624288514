"""A controller made from a simulator: what was diagnosed mends it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sstl_cli.diagnosis.constants import STROKE_N
from sstl_cli.physics.scenario import Configuration, MisfitSection, Scenario
from sstl_cli.physics.scenario_file import dump
from sstl_cli.steps.compensate_model import cases_of, stroke_of

BENDS = (Configuration(id="CP-1", location="CP", theta=0.53), Configuration(id="ND-1", theta=0.7))


def model(effects=None, **more):
    return Scenario(configurations=BENDS, effects=effects or {}, **more)


@pytest.fixture
def saved(tmp_path):
    def save(scenario):
        (tmp_path / "rig.toml").write_text(dump(scenario), encoding="utf-8")
        return tmp_path / "rig.toml"

    return save


def test_the_lines_are_those_of_the_simulator():
    cases, aside = cases_of(model())
    assert [c.config_id for c in cases] == ["CP-1", "ND-1"] and aside == {}
    assert cases[0].location == "CP" and cases[0].act.gamma_p == pytest.approx(np.exp(-0.53), rel=1e-3)
    assert cases[1].act.gamma_r == pytest.approx(np.exp(0.7), rel=1e-3)


def test_friction_is_in_the_lines_and_the_zero_of_a_sensor_is_not():
    (dry, _), _ = cases_of(model({"const_friction": {"w_l_n": 0.4}}))
    assert dry.act.beta_p < -0.1 and dry.act.beta_r > 0.1
    # the line carries no more for it that a sensor reads more
    (read, _), _ = cases_of(model({"zero_offset": {"z_out_act_n": 0.4}}))
    assert read.act.beta_p == pytest.approx(0.0, abs=1e-3)


def test_a_bend_without_propagation_is_set_aside():
    stuck = model().model_copy(update={"configurations": (BENDS[0], Configuration(id="stuck", theta=4.9))})
    cases, aside = cases_of(stuck)
    assert [c.config_id for c in cases] == ["CP-1"] and "no propagation" in aside["stuck"]


def test_the_stroke_is_where_the_model_was_seen():
    assert stroke_of(model()) == STROKE_N
    seen = MisfitSection(
        system="act", config_id="CP-1", along="turning", correlation_s=0.1, input_n=(40.0, 600.0), other=(1.0,),
        mean_n=(0.0,) * 4, sd_n=(0.1,) * 4,
    )  # fmt: skip
    assert stroke_of(model(misfits=(seen,))) == (40.0, 600.0)
    assert cases_of(model(misfits=(seen,)))[0][0].act.gamma_p == pytest.approx(np.exp(-0.53), rel=1e-3)


def test_compensate_takes_it_for_lines_and_plant(sstl, saved):
    path = saved(model({"const_friction": {"w_l_n": 0.4}}))
    code, text, err = sstl("compensate", "--sim", path, "--methods", "none,DI", "--dt", "0.02", "--json")
    assert code == 0, err
    rmse = {(r["config_id"], r["method"]): r["rmse_n"] for r in json.loads(text)["scores"] if r["window"] == "all"}
    assert rmse["CP-1", "DI"] < 0.05 < rmse["CP-1", "none"]


def test_export_writes_its_controller(sstl, saved, tmp_path):
    code, _, err = sstl("export", saved(model()), "--out", tmp_path / "c.json")
    assert code == 0, err
    made = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert [c["config_id"] for c in made["configurations"]] == ["CP-1", "ND-1"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "give --theta, or --sim"),
        (["--theta", "a.parquet", "--sim", "b.toml"], "exclude one another"),
        (["--sim", "b.parquet"], "is not a simulator"),
    ],
)
def test_lines_come_from_one_place(sstl, words, says):
    code, _, err = sstl("compensate", *words)
    assert code == 2 and says in err
