"""Tension in a neighbouring tendon: simulated twice, named where it is there, and no candidate elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from tendon_logs import SPEC, command, log, without_tendons
from typer.testing import CliRunner

from sstl_cli.cli.app import _register, app
from sstl_cli.core.runs import read_runs
from sstl_cli.physics.rig import QUIET, RigRun, simulate_rig
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Tendon, Trajectory
from sstl_cli.steps import diagnose_tendons, simulate
from sstl_cli.steps.diagnose import DiagnoseOptions

C = 0.004
COUPLED = {"tendon_crosstalk": {"c_bend_per_n": C}}
# its look-alikes and what is usual; docs/tendons.md has the whole catalogue
RIVALS = ("tendon_crosstalk", "sheath_compliance", "gain_error", "load_dependent_friction")
OPTIONS = DiagnoseOptions(max_effects=1, workers=2, effects=RIVALS)


def coefficient(block):
    row = next(c for c in block["candidates"] if c["id"] == "tendon_crosstalk")
    return row["parameters"][0]


@pytest.mark.slow
def test_cross_talk_is_named_for_every_tendon():
    found = diagnose_tendons.run(log(COUPLED, COUPLED), OPTIONS).document()
    for block in found["tendons"]:
        assert block["verdict"]["status"] == "identified", block["verdict"]
        assert block["verdict"]["effects"] == ["tendon_crosstalk"]
        assert coefficient(block)["estimate"] == pytest.approx(C, rel=0.1)
        assert block["gap"]["shrink_pct"] > 50
        # a movement of one tendon cannot tell it from anything
        assert block["next_experiment"] is None


@pytest.mark.slow
def test_without_cross_talk_nothing_is_named():
    only = DiagnoseOptions(max_effects=1, workers=2, effects=("tendon_crosstalk",))
    found = diagnose_tendons.run(log({}, {}), only).document()
    for block in found["tendons"]:
        assert block["verdict"]["effects"] == [], block["verdict"]
        # it was asked about, and nothing of it is there
        assert abs(coefficient(block)["estimate"]) < 0.1 * C


@pytest.mark.slow
def test_one_tendon_alone_does_not_know_it():
    alone = without_tendons(log(COUPLED, COUPLED))
    document = diagnose_tendons.run(alone, OPTIONS).document()
    assert "tendon_crosstalk" not in [c["id"] for c in document["candidates"]]
    assert document["verdict"]["status"] != "none"


@pytest.mark.slow
def test_another_effect_is_not_taken_for_it():
    found = diagnose_tendons.run(log({}, {"gain_error": {"g_act": 1.05}}), OPTIONS).document()
    assert found["tendon"] == "B"
    assert "tendon_crosstalk" not in found["verdict"]["ambiguity_group"]


def test_slopes_of_the_rig_follow_the_neighbour():
    """With a steady neighbour the lines are those of the capstan at theta (1 + c T_n)."""
    time = np.linspace(0.0, 120.0, 6001)
    path = np.interp(time, [0, 60, 120], [1.5, 45, 1.5])
    for tension in (0.0, 20.0):
        run = RigRun("act", 0.5, "CP", time, "tension", path, np.full(time.size, tension))
        found = simulate_rig(SPEC, run, {"tendon_crosstalk": {"c_bend_per_n": 0.01}}, QUIET)
        pull = (time < 60) & (path > 25)
        slope = np.polyfit(found.tension_in_n[pull], found.tension_out_n[pull], 1)[0]
        assert np.log(slope) == pytest.approx(-0.5 * (1.0 + 0.01 * tension), abs=1e-3)


def scenario(simulator, tendons=2):
    names = (Tendon(id="A"), Tendon(id="B", theta_factor=1.1, level=0.8, delay_s=9.0))
    return Scenario(
        simulator=simulator,
        sampling_hz=50.0,
        noise=NoiseSection(white_n=0.0),
        tendons=names[:tendons],
        configurations=(Configuration(id="c1", location="CP", theta=0.5),),
        trajectories=(Trajectory(kind="ramp_hold", duration_s=40.0),),
    )


def test_fast_model_and_rig_agree():
    for effects in ({}, {"tendon_crosstalk": {"c_bend_per_n": 0.01}}):
        fast, rig = (list(simulate.run(scenario(s), effects, 1)) for s in ("transmission", "rig"))
        assert [(r.run_id, r.tendon) for r in fast] == [(r.run_id, r.tendon) for r in rig]
        assert [r.tendon for r in fast] == ["A", "B", None]
        for a, b in zip(fast[:2], rig[:2], strict=True):
            late = a.time_s > 12.0
            assert np.sqrt(np.mean((a.tension_out_n - b.tension_out_n)[late] ** 2)) < 0.02


def test_tendons_of_a_scenario_move_and_bend_as_stated():
    a, b, _ = simulate.run(scenario("transmission"), {}, 1)
    k = int(9.0 * 50.0)
    np.testing.assert_allclose(b.tension_in_n[k:], 0.8 * a.tension_in_n[: len(a) - k], atol=1e-9)
    # the first ramp is a pull: out / in is exp(-theta) of the tendon's own angle
    assert np.log(np.min(a.tension_out_n[1:] / a.tension_in_n[1:])) == pytest.approx(-0.5, abs=1e-6)
    assert np.log(np.min(b.tension_out_n[1:] / b.tension_in_n[1:])) == pytest.approx(-0.55, abs=1e-6)


def test_on_the_command_line(tmp_path):
    _register()
    file = tmp_path / "two.toml"
    text = (
        'schema = "sstl.scenario/1"\nsampling_hz = 50.0\n[[configurations]]\nid = "c1"\ntheta = 0.5\n'
        '[[trajectories]]\nkind = "ramp_hold"\nduration_s = 20.0\nsystems = ["sstl", "act"]\n[[tendons]]\nid = "A"\n'
    )
    words = ["simulate", "--scenario", str(file), "--effect", "tendon_crosstalk:c_bend_per_n=0.01", "--out", str(tmp_path / "o.parquet")]
    file.write_text(text)
    done = CliRunner().invoke(app, words)
    assert "E721" in str(done.exception) and "[[tendons]]" in str(done.exception)
    file.write_text(text + '[[tendons]]\nid = "B"\ndelay_s = 5.0\n')
    assert CliRunner().invoke(app, words).exit_code == 0
    assert [r.tendon for r in read_runs(tmp_path / "o.parquet")] == [None, "A", "B"]


def test_movement_helper():
    time, path = command("ramps", shift_s=7.0)
    assert path[time < 7.0] == pytest.approx(2.0)
