"""What a movement could tell before it is recorded: scaling, excitation, and the option of ``diagnose``."""

from __future__ import annotations

import json

import pytest
import typer
from typer.testing import CliRunner

from sstl_cli.cli import diagnose
from sstl_cli.core.documents import get
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis import planning
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.limit import distance2, least_shown
from sstl_cli.diagnosis.weights import learned
from sstl_cli.physics.scenario import Configuration, NoiseSection, OutputScale, Scenario, Trajectory
from sstl_cli.steps import diagnose_plan, simulate

EFFECTS = ("viscous", "zero_offset", "const_friction", "gain_error", "asymmetric_friction")
FAST = Trajectory(kind="trapezoid", duration_s=6.0, cycles=2, drive="tension")
SLOW = FAST.model_copy(update={"duration_s": 60.0})


def scenario(*movements, white_n=0.02, bends=(0.45, 0.6), coloured_n=0.0):
    return Scenario(
        sampling_hz=50.0,
        noise=NoiseSection(white_n=white_n, coloured_n=coloured_n),
        configurations=tuple(Configuration(id=f"c{i}", theta=t) for i, t in enumerate(bends)),
        trajectories=movements,
    )


def rows(*movements, **given):
    return {r.effect: r.plain() for r in diagnose_plan.run(scenario(*movements, **given), EFFECTS).effects}


def test_what_shows_grows_with_the_noise():
    quiet, loud = rows(FAST), rows(FAST, white_n=0.06)
    for e in EFFECTS:
        assert loud[e]["least_size"] == pytest.approx(3.0 * quiet[e]["least_size"], rel=0.35)
        assert loud[e]["gap_n"] < 0.06


def test_a_plan_for_a_model_of_another_unit_is_in_newtons():
    own = scenario(FAST).model_copy(update={"output": OutputScale(unit="V", per_n={"act": 3.0, "sstl": 3.0}, origin={"act": 5.0})})
    assert diagnose_plan.run(own, EFFECTS[1:2]) == diagnose_plan.run(scenario(FAST), EFFECTS[1:2])


def test_friction_of_speed_wants_speed_and_an_offset_wants_time():
    fast, slow = rows(FAST), rows(SLOW)
    # ten times the samples at a tenth of the speed
    assert slow["viscous"]["least_size"] > 2.0 * fast["viscous"]["least_size"]
    assert slow["zero_offset"]["least_size"] < fast["zero_offset"]["least_size"]


def test_one_bend_on_one_range_cannot_tell_what_two_can():
    one, two = rows(FAST, bends=(0.5,)), rows(FAST)
    assert two["gain_error"]["told_size"] is not None
    assert one["gain_error"]["told_size"] is None or one["gain_error"]["told_size"] > 1.2 * two["gain_error"]["told_size"]
    for r in two.values():
        assert r["told_size"] is None or (r["told_size"] >= r["least_size"] and r["d2"] >= 0.75 * DECIDABLE)


def test_the_size_that_is_told_is_one_at_which_the_rival_was_refitted():
    """Of a delay and a low-pass D^2 grows with the fourth power of the size: by its square the search flew past it, and gave what it had not tried."""
    given = scenario(FAST, Trajectory(kind="chirp", duration_s=20.0, drive="tension"))
    effects = ("channel_delay", "channel_lowpass", "viscous")
    found, _ = planning._planned(list(simulate.run(given, {}, 0)), given)
    found.singles.update({e: (planning._least(found, e),) for e in effects})
    shown = least_shown(found, learned().shows_d2)
    told = {s.effect: t for s, t in planning.told_apart(found, shown)}
    assert told["channel_delay"].rival == "channel_lowpass" and told["channel_lowpass"].rival == "channel_delay"
    assert told["channel_delay"].size > 3.0 * next(s.size for s in shown if s.effect == "channel_delay")
    for s in shown:
        t = told[s.effect]
        truth = planning._sized(found.sim, found.singles[s.effect][0].fit, s.parameter, t.size)
        assert distance2(found.sim, truth, found.singles[t.rival][0].fit) == pytest.approx(t.d2)
        assert t.settled and (t.size == s.size or t.d2 < 1.5 * DECIDABLE)


def test_where_nothing_else_is_asked_for_nothing_is_told_apart():
    (row,) = diagnose_plan.run(scenario(FAST), ("viscous",)).effects
    assert row.rival is None and row.told_size == row.least_size


def test_sensors_without_noise_are_refused():
    with pytest.raises(SstlError, match="without noise"):
        diagnose_plan.run(scenario(FAST, white_n=0.0), EFFECTS)


def call(*words):
    app = typer.Typer()
    diagnose.register(app)
    app.command("other")(lambda: None)
    found = CliRunner().invoke(app, ["diagnose", *map(str, words)])
    if isinstance(found.exception, SstlError):
        raise found.exception
    return found


def test_the_option_answers_without_a_log(tmp_path):
    file = tmp_path / "plan.json"
    assert call("--plan", "sample", "--effects", "zero_offset,viscous", "--out", file).exit_code == 0
    document = json.loads(file.read_text())
    get("diagnosis.plan").model_validate(document)
    assert {r["effect"] for r in document["effects"]} == {"zero_offset", "viscous"} and "2 of 2 effects" in document["sentence"]
    with pytest.raises(SstlError, match="no log"):
        call()
    with pytest.raises(SstlError, match="takes no log"):
        call("log.parquet", "--plan", "sample")
