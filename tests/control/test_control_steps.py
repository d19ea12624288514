"""The compensation step on tables in memory: configurations, mapping, methods, plants."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest
from helpers_control import TABLE_II, play, theta_row, write_theta

import sstl_cli.mapping
from sstl_cli.cli.app import main
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, track
from sstl_cli.control.references import sinusoid
from sstl_cli.control.sim_plant import plant_of
from sstl_cli.core.errors import SstlError
from sstl_cli.core.tables import THETA
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import compensate as step
from sstl_cli.steps.export_controller import lines_for

SSTL_LINES = (0.271, 0.033, 3.314, 4.366)


def table(rows, **extra):
    made = pa.Table.from_pylist(rows, schema=THETA.arrow())
    for name, values in extra.items():
        made = made.append_column(name, pa.array(values))
    return made


def test_runs_of_a_configuration_are_averaged():
    rows = [theta_row("a", "C", "act", (0.5, -1.0, 1.6, -1.2)), theta_row("b", "C", "act", (0.6, -2.0, 1.8, -1.0))]
    cases, aside = step.cases_of(table(rows))
    assert not aside and len(cases) == 1
    t = cases[0].act
    assert (t.gamma_p, t.beta_p, t.gamma_r, t.beta_r) == pytest.approx((0.55, -1.5, 1.7, -1.1))
    assert step.mean_biases(cases) == pytest.approx((-1.5, -1.1))


def test_tendons_share_the_sensing_loop():
    rows = [theta_row("a", "C", "act", TABLE_II), theta_row("b", "C", "act", (0.5, 0, 1.9, 0)), theta_row("c", "C", "sstl", SSTL_LINES)]
    cases, _ = step.cases_of(table(rows, tendon=["left", "right", None]))
    assert [c.config_id for c in cases] == ["C/left", "C/right"]
    assert all(c.sstl == (0.271, 3.314) for c in cases)
    assert cases[1].act.gamma_p == 0.5


def square_root(slopes):
    return np.sqrt(slopes)


def test_mapping_gives_slopes_and_keeps_constant_biases():
    cases = [step.Case("A", sstl=(0.25, 4.0)), step.Case("B", sstl=(9.0, 4.0)), step.Case("C")]
    done, aside = step.with_mapping(cases, square_root, (-1.4, -1.0), lambda x: x[:, 0] < 0.3)
    assert done[0].mapped == Theta(0.5, -1.4, 2.0, -1.0) and done[0].outside
    assert done[1].mapped is None and "above the release slope" in aside["B"]
    assert done[2].mapped is None


def test_proposed_and_di_differ_only_in_their_lines():
    lines = Theta(*TABLE_II)
    case = step.Case("A", act=lines, mapped=lines)
    reference = sinusoid(dt_s=0.02)
    results = {r.method: r for r in step.run([case], lambda c: [reference], lambda c: Plant(PlayTendon(lines)), options=Options(dt_s=0.02))}
    assert list(results) == ["none", "no-bias", "proposed", "DI"]
    assert np.array_equal(results["proposed"].track.command, results["DI"].track.command)
    assert results["none"].reduction_pct["all"] is None
    assert results["no-bias"].reduction_pct["all"] == pytest.approx(72.7, abs=0.3)


def test_no_bias_takes_the_mapped_slopes():
    case = step.Case("A", act=Theta(*TABLE_II), mapped=Theta(0.6, -1.0, 1.7, -1.0))
    assert case.lines("no-bias") == Theta(0.6, 0.0, 1.7, 0.0)
    assert case.usual_method() == "proposed"


def test_method_that_drives_nothing_cannot_be_exported():
    with pytest.raises(SstlError, match="E405"):
        lines_for([step.Case("A", act=Theta(*TABLE_II))], "proposed")


def test_locations_get_distinct_random_references_and_the_model_is_used(tmp_path, monkeypatch, capsys):
    rows = []
    for place in ("NP", "CP"):
        rows += [theta_row(f"{place}a", place, "act", TABLE_II, location=place)]
        rows += [theta_row(f"{place}s", place, "sstl", SSTL_LINES, location=place)]
    theta = write_theta(tmp_path / "t.parquet", rows)
    model = SimpleNamespace(
        predict=lambda x: x * 0 + [0.59, 1.70],
        outside=lambda x: np.ones(len(x), bool),
        header=SimpleNamespace(tendons=()),
        beta_act_of=lambda tendon: (-1.444, -1.043),
    )
    monkeypatch.setattr(sstl_cli.mapping, "load_model", lambda path: model, raising=False)
    args = ["--theta", theta, "--model", tmp_path / "m.safetensors", "--reference", "random", "--dt", "0.02", "--json"]
    monkeypatch.setattr(sys, "argv", ["sstl", "compensate", *map(str, args)])
    with pytest.raises(SystemExit) as ended:
        main()
    document = json.loads(capsys.readouterr().out)
    assert not ended.value.code
    assert document["methods"] == ["none", "no-bias", "proposed", "DI"]
    assert document["outside_trained_range"] == ["CP", "NP"]
    none = {r["location"]: r["rmse_n"] for r in document["scores"] if r["method"] == "none" and r["window"] == "all"}
    assert none["NP"] != none["CP"]
    proposed = next(r for r in document["runs"] if r["method"] == "proposed")
    assert proposed["theta"] == pytest.approx([0.59, -1.444, 1.70, -1.043]) and proposed["slopes_from"] == "mapping"


def scenario_with(effects):
    return Scenario.model_validate(
        {
            "schema": "sstl.scenario/1",
            "configurations": [{"id": "C", "location": "CP", "theta": 0.53}],
            "effects": effects,
            "noise": {"white_n": 0.0},
        }
    )


def test_scenario_is_a_plant_with_its_loop_and_its_effects():
    plant = plant_of(scenario_with({"tension_loop_lag": {"tau_s": 0.1}}), "C")
    assert plant.loop.tau_s == 0.1
    reference = sinusoid(frequency_hz=0.05)
    done = track(Controller(Theta(*TABLE_II), compensate=False), plant, reference.tension_n)
    g = float(np.exp(-0.53))
    np.testing.assert_allclose(done.tension_out, play(done.tension_in, (g, 0, 1 / g, 0), g * 10.0), atol=1e-9)
    rounded = plant_of(scenario_with({"presliding": {"breakaway_mm": 0.3}}), "C")
    held = (done.phase == 0) | (done.phase == 2)
    other = rounded.tendon(done.tension_in, 0.002)
    # presliding lets the output creep where the play holds it
    assert np.ptp(done.tension_out[held]) > 0 and np.abs(other - done.tension_out)[held].max() > 0.1
    with pytest.raises(SstlError, match="E406"):
        plant_of(scenario_with({}), "D")
