"""What this version saved still loads, and what another version saved says so in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from rig_logs import record
from typer.testing import CliRunner

from sstl_cli import __version__
from sstl_cli.cli.app import _register, app
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.provenance import Provenance, by_another
from sstl_cli.core.runs import read_logs, write_runs
from sstl_cli.physics.scenario import load
from sstl_cli.physics.scenario_file import dump
from sstl_cli.steps.diagnose import DiagnoseOptions, run

SAVED = Path(__file__).parent / "saved"
OLDER = "0.0.9"


@pytest.fixture
def older(tmp_path):
    """The saved model and verdict as another version would have written them."""
    for name in ("rig.toml", "diagnosis.json"):
        text = (SAVED / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace(made_by(text), OLDER), encoding="utf-8")
    return tmp_path


def made_by(text: str) -> str:
    """Return the version that a saved file names."""
    return text.split("package_version", 1)[1].split('"')[1 if "package_version = " in text else 2]


def sstl(*words: str) -> tuple[str, str]:
    _register()
    done = CliRunner().invoke(app, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    return done.stdout, done.stderr


def test_a_saved_model_loads_whole(tmp_path):
    scenario = load(str(SAVED / "rig.toml"))
    assert set(scenario.effects) == {"pulley_friction"} and scenario.misfits and scenario.dispersion
    assert scenario.package_version and scenario.theta_of("a") == pytest.approx(0.46, abs=0.01)
    (tmp_path / "again.toml").write_text(dump(scenario), encoding="utf-8")
    assert load(str(tmp_path / "again.toml")) == scenario


def test_a_saved_verdict_loads_and_makes_a_page(tmp_path):
    document = DiagnosisDocument.model_validate(json.loads((SAVED / "diagnosis.json").read_text(encoding="utf-8")))
    assert document.verdict.effects == ["pulley_friction"] and document.package_version
    sstl("report", SAVED / "diagnosis.json", "--out", tmp_path / "page.html")
    assert "pulley_friction" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_what_is_written_now_names_this_version_and_has_no_note():
    found = run(record({}, 5)[:4], DiagnoseOptions(effects=("zero_offset",), max_effects=1))
    assert found.document()["package_version"] == __version__ == found.model().package_version
    again = run(record({}, 6)[:4], DiagnoseOptions(sim=found.model(), effects=("zero_offset",), max_effects=1)).document()
    assert not [n for n in again["notes"] if "was made by" in n]


def test_a_model_of_another_version_is_noted_in_the_diagnosis(older):
    options = DiagnoseOptions(sim=load(str(older / "rig.toml")), effects=("zero_offset",), max_effects=1)
    (note,) = [n for n in run(record({}, 5)[:4], options).document()["notes"] if "was made by" in n]
    assert note.startswith(f"the simulator was made by sstl {OLDER}, this is {__version__}")


@pytest.mark.slow
def test_a_model_that_does_not_say_how_much_the_rig_varies_is_noted(tmp_path):
    options = DiagnoseOptions(sim=load(str(SAVED / "rig.toml")), effects=("zero_offset",), max_effects=1)
    log = record({}, 5)[:4]
    found = run(log, options)
    assert [n for n in found.document()["notes"] if "does not say how much the rig varies" in n]
    again = found.model()
    assert again.wander is not None
    (tmp_path / "again.toml").write_text(dump(again), encoding="utf-8")
    notes = run(log, DiagnoseOptions(sim=load(str(tmp_path / "again.toml")), effects=("zero_offset",), max_effects=1)).document()["notes"]
    assert not [n for n in notes if "varies" in n]


def test_a_model_of_another_version_is_noted_where_it_is_simulated(older):
    (older / "still.toml").write_text(
        (older / "rig.toml").read_text(encoding="utf-8") + '\n[[trajectories]]\nkind = "trapezoid"\nduration_s = 4.0\n', encoding="utf-8"
    )
    _, err = sstl("simulate", "--scenario", older / "still.toml", "--out", older / "log.parquet")
    assert f"the scenario was made by sstl {OLDER}" in err


@pytest.mark.slow
def test_a_model_that_is_kept_is_simulated_and_explains_what_it_made(tmp_path):
    """It had no movement, and simulate ended."""
    effects = ("--effects", "pulley_friction,zero_offset", "--max-effects", "1")
    log, sim, made = (tmp_path / n for n in ("log.parquet", "sim.toml", "made.parquet"))
    write_runs(log, record({"pulley_friction": {"m_p": 0.1, "m_r": 0.1}}, 5)[:4], Provenance("test"))
    sstl("diagnose", log, *effects, "--save-sim", sim)
    text = sim.read_text(encoding="utf-8")
    assert text.count("# movements of sstl within the tensions that were recorded") == 1
    sstl("simulate", "--scenario", sim, "--out", made)
    recorded, simulated = read_logs([log]), read_logs([made])
    assert {(r.system, r.config_id) for r in simulated} == {(r.system, r.config_id) for r in recorded}
    top = {r.system: max(r.tension_in_n.max(), 0.0) for r in recorded}
    assert all(r.tension_in_n.max() == pytest.approx(top[r.system], rel=0.02) for r in simulated)
    for again in (log, made):
        sstl("diagnose", again, "--sim", sim, *effects, "--expect", "none")


@pytest.mark.slow
def test_a_diagnosis_takes_a_model_as_if_it_had_no_movements():
    recorded = record({"pulley_friction": {"m_p": 0.1, "m_r": 0.1}}, 5)[:4]
    model = run(recorded, DiagnoseOptions(effects=("pulley_friction", "zero_offset"), max_effects=1)).model()
    still = model.model_copy(update={"trajectories": (), "sampling_hz": 500.0})
    found = [run(recorded, DiagnoseOptions(sim=m, effects=("zero_offset",), max_effects=1)) for m in (model, still)]
    assert found[0].document() == found[1].document()
    # what was given with movements keeps them, and needs no remark
    given = model.model_copy(update={"trajectories": model.trajectories[:1], "misfits": (), "wander": None})
    kept = run(recorded, DiagnoseOptions(sim=given, effects=("zero_offset",), max_effects=1)).bare()
    assert kept.trajectories == given.trajectories and kept.sampling_hz == given.sampling_hz


def test_a_verdict_of_another_version_is_noted_on_the_page_and_on_the_screen(older):
    _, err = sstl("report", older / "diagnosis.json", "--out", older / "page.html")
    assert f"note: diagnosis.json was made by sstl {OLDER}" in err
    assert f"this diagnosis was made by sstl {OLDER}" in (older / "page.html").read_text(encoding="utf-8")


def test_who_does_not_say_gets_no_note():
    assert by_another(None, "it") == by_another(__version__, "it") == []
    assert "\x1b" not in by_another("\x1b[31m", "it")[0]
