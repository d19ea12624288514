"""What the options of the commands do, functions in Python do with the same numbers."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from matplotlib.figure import Figure
from program import inside
from short_sample import SAMPLE, short, write

import sstl_cli as sstl
from sstl_cli.core.documents.diagnosis import NextExperiment, Verdict
from sstl_cli.core.errors import SstlError
from sstl_cli.reporting import drawing
from sstl_cli.reporting.load import load
from sstl_cli.steps.plot import run as choose

ONE = ("--methods", "DI", "--cycles", 1, "--config-id", "CP-020")
SAME = {"methods": ["DI"], "cycles": 1, "config_id": "CP-020"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("options")
    # of a mapping, so that there are rows of both systems
    sstl.simulate("sample-40", seed=1).write(made / "many.parquet")
    assert inside("segment", made / "many.parquet", "--out", made / "many-theta.parquet").returncode == 0
    assert inside("segment", SAMPLE, "--out", made / "theta.parquet").returncode == 0
    words = ("--variants", "linear", "--seeds", 2, "--out", made / "m.safetensors")
    assert inside("train", made / "many-theta.parquet", *words).returncode == 0
    return made


@pytest.fixture(scope="module")
def theta() -> pd.DataFrame:
    return sstl.read(SAMPLE).segment()


@pytest.fixture(scope="module")
def named() -> sstl.Diagnosis:
    return sstl.diagnose(short(), effects=["pulley_friction"], max_effects=1)


def told(*words: object) -> dict:
    """Return what a call prints as JSON."""
    done = inside(*words, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def driven(folder: Path, *words: object) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return scores and commands of a call."""
    done = inside("compensate", *words, "--scores", folder / "s.parquet", "--out", folder / "c.parquet", "--force")
    assert done.returncode == 0, done.stderr
    return pq.read_table(folder / "s.parquet").to_pandas(), pq.read_table(folder / "c.parquet").to_pandas()


def test_the_controller_acts_as_the_options_say(folder: Path, theta: pd.DataFrame) -> None:
    words = ("--t-max", 40, "--max-rate", 30, "--max-jump", 1, "--lead", 0.02, "--reversal", "play", "--presliding", 0.2, "--dt", 0.01)
    scores, commands = driven(folder, "--theta", folder / "theta.parquet", *ONE, *words, "--no-doubled", "--loop-tau", 0.05)
    options = sstl.ControllerOptions(
        t_max_n=40, max_rate_n_s=30, max_jump_n=1, lead_s=0.02, reversal="play", presliding=0.2, dt_s=0.01, doubled=False
    )
    how = {**SAME, "options": options, "loop_tau_s": 0.05}
    pd.testing.assert_frame_equal(sstl.compensate(theta, **how), scores)
    pd.testing.assert_frame_equal(sstl.compensate(theta, **how, commands=True), commands)
    assert not scores.equals(sstl.compensate(theta, **SAME))
    with pytest.raises(SstlError, match="is no time"):
        sstl.compensate(theta, loop_tau_s=-1.0)
    with pytest.raises(SstlError, match="CP-20"):
        sstl.compensate(theta, config_id="CP-20")


def test_a_controller_that_is_stepped_answers_as_the_stream_does(folder: Path, theta: pd.DataFrame) -> None:
    t = 0.01 * np.arange(400)
    wished = 8.0 + 6.0 * np.sin(2.0 * t)
    measured = 1.3 * np.concatenate([wished[:3], wished[:-3]])
    # a sample lost and one out of range among them
    measured[120], measured[260] = np.nan, -50.0
    words = ["compensate", "--stream", "--theta", folder / "theta.parquet", "--config-id", "CP-020", "--dt", 0.01, "--t-max", 40]
    lines = "".join(f"{a!r},{b!r}\n" for a, b in zip(wished.tolist(), measured.tolist(), strict=True))
    done = subprocess.run([sys.executable, "-m", "sstl_cli", *map(str, words)], input=lines, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    rig = sstl.controller(theta, config_id="CP-020", options=sstl.ControllerOptions(dt_s=0.01, t_max_n=40))
    answers = [rig.step(a, b) for a, b in zip(wished.tolist(), measured.tolist(), strict=True)]
    assert [f"{command!r},{phase}" for command, phase in answers] == done.stdout.split()
    assert {phase for _, phase in answers} >= {"PP", "RP", "SAFE"} and rig.fault == ""
    with pytest.raises(SstlError, match="CP-020"):
        sstl.controller(theta)
    with pytest.raises(SstlError, match="not possible for CP-020"):
        sstl.controller(theta, method="proposed", config_id="CP-020")
    assert sstl.controller(theta, method="none", config_id="CP-020").step(5.0, 0.0)[0] == 5.0


def test_a_mapping_drives_with_the_biases_that_are_given(folder: Path, theta: pd.DataFrame) -> None:
    mapping = sstl.Mapping.load(folder / "m.safetensors")
    words = ("--theta", folder / "theta.parquet", "--model", folder / "m.safetensors", "--methods", "proposed", "--cycles", 1)
    how = {"methods": ["proposed"], "cycles": 1}
    own = sstl.compensate(theta, mapping, **how)
    given = sstl.compensate(theta, mapping, **how, biases=sstl.Biases(beta_p=0.3, beta_r=0.1))
    pd.testing.assert_frame_equal(given, driven(folder, *words, "--beta-p", 0.3, "--beta-r", 0.1)[0])
    of_these = sstl.compensate(theta, mapping, **how, biases=theta)
    pd.testing.assert_frame_equal(of_these, driven(folder, *words, "--bias-theta", folder / "theta.parquet")[0])
    assert not given.equals(own) and not of_these.equals(own) and not given.equals(of_these)


def test_a_simulator_a_parameter_file_and_another_plant(folder: Path, theta: pd.DataFrame) -> None:
    model = folder / "model.toml"
    model.write_text('[[configurations]]\nid = "CP-020"\ntheta = 0.3\n')
    scores, _ = driven(folder, "--sim", model, *ONE)
    pd.testing.assert_frame_equal(sstl.compensate(model, **SAME), scores)
    scores, _ = driven(folder, "--theta", folder / "theta.parquet", *ONE)
    pd.testing.assert_frame_equal(sstl.compensate(folder / "theta.parquet", **SAME), scores)
    assert inside("export", folder / "theta.parquet", "-f", "json", "--t-max", 40, "--out", folder / "p.json").returncode == 0
    scores, _ = driven(folder, "--theta", folder / "p.json", *ONE, "--plant", folder / "theta.parquet")
    pd.testing.assert_frame_equal(sstl.compensate(folder / "p.json", plant=theta, **SAME), scores)
    scores, _ = driven(folder, "--theta", folder / "theta.parquet", *ONE, "--plant-sim", model)
    bent = sstl.Scenario(configurations=({"id": "CP-020", "theta": 0.3},))
    pd.testing.assert_frame_equal(sstl.compensate(theta, plant=bent, **SAME), scores)


def test_references_of_tables_files_and_recordings(folder: Path, theta: pd.DataFrame) -> None:
    t = np.arange(0.0, 8.0, 0.01)
    wanted = pd.DataFrame({"time_s": t, "tension_ref_n": 8.0 - 3.0 * np.cos(t)})
    wanted.to_csv(folder / "slow.csv", index=False)
    words = ("--theta", folder / "theta.parquet", *ONE)
    scores, _ = driven(folder, *words, "--reference", folder / "slow.csv")
    assert len(scores) > 0
    pd.testing.assert_frame_equal(sstl.compensate(theta, references=[folder / "slow.csv"], **SAME), scores)
    pd.testing.assert_frame_equal(sstl.compensate(theta, references={"slow": wanted}, **SAME), scores)
    with pytest.raises(SstlError, match="misses column tension_ref_n"):
        sstl.compensate(theta, references={"slow": wanted.rename(columns={"tension_ref_n": "wanted"})}, **SAME)
    frame = sstl.read(SAMPLE).frame()
    recorded = sstl.Log.from_frame(frame.assign(tension_ref_n=0.8 * frame["tension_out_n"]))
    recorded.write(folder / "recorded.parquet", force=True)
    words = ("--theta", folder / "theta.parquet", "--methods", "DI", "--config-id", "CP-020")
    scores, _ = driven(folder, *words, "--recorded", folder / "recorded.parquet")
    pd.testing.assert_frame_equal(sstl.compensate(theta, methods=["DI"], config_id="CP-020", recorded=recorded), scores)


def test_tables_and_predictions_of_a_mapping(folder: Path) -> None:
    many = pq.read_table(folder / "many-theta.parquet").to_pandas()
    words = ("evaluate", folder / "m.safetensors", "--theta", folder / "many-theta.parquet", "--tables")
    document = told(*words, "--predictions", folder / "predictions.parquet")
    correlation, slopes = sstl.relate(many)
    assert correlation.set_index("direction").to_dict("index") == document["table_i"]
    for system, rows in document["table_ii"].items():
        assert slopes[slopes["system"] == system].drop(columns="system").set_index("quantity").to_dict("index") == rows
    made = sstl.Mapping.load(folder / "m.safetensors").predictions(many)
    pd.testing.assert_frame_equal(made, pq.read_table(folder / "predictions.parquet").to_pandas())


def test_a_proposed_mapping_is_that_of_the_program(folder: Path) -> None:
    rows = [f"{20 * k},{5 + k % 50},{3 + k % 50 / 2}" for k in range(200)]
    (folder / "bend.csv").write_text("\n".join(["t_ms,T_in,T_out", *rows]))
    document, found = told("import", folder / "bend.csv", "--guess"), sstl.guess(folder / "bend.csv")
    assert found.toml == document["mapping"] and found.reasons == document["reasons"] and found.preview == document["preview"]
    assert [q.line for q in found.questions] == [q["line"] for q in document["questions"]] != []


@pytest.mark.slow
def test_a_plan_and_the_stages_are_those_of_the_program(folder: Path, theta: pd.DataFrame) -> None:
    document = told("diagnose", "--plan", "sample", "--effects", "zero_offset")
    assert sstl.plan("sample", ["zero_offset"]).plain() == document
    _, commands = driven(folder, "--theta", folder / "theta.parquet", *ONE, "--loop-tau", 0.05)
    assert sstl.stages(commands).plain() == told("diagnose", folder / "c.parquet")
    with pytest.raises(SstlError, match="phase"):
        sstl.stages(commands.drop(columns="phase"))


@pytest.mark.slow
def test_what_a_diagnosis_is_asked_beside_the_log(folder: Path) -> None:
    log = sstl.read(write(folder / "brief.parquet"))
    (folder / "prior.toml").write_text("const_friction = 50.0\n")
    few = ("--effects", "pulley_friction,const_friction", "--max-effects", 1)
    words = ("diagnose", folder / "brief.parquet", *few, "--prior", folder / "prior.toml", "--max-tension", 12, "--max-rate", 4)
    document = told(*words, "--save-sim", folder / "program.toml")
    asked = {"effects": ["pulley_friction", "const_friction"], "max_effects": 1}
    found = sstl.diagnose(log, **asked, prior={"const_friction": 50.0}, max_tension_n=12.0, max_rate_n_per_s=4.0)
    # the program names the file of the odds as an input, too
    assert found.to_dict() | {"inputs": None} == document | {"inputs": None} and found.verdict.confidence is None
    found.save_model(folder / "python.toml")
    assert (folder / "python.toml").read_text() == (folder / "program.toml").read_text()
    for wrong in ({"pulley_frictoin": 2.0}, {"viscous": -1.0}):
        with pytest.raises(SstlError):
            sstl.diagnose(log, **asked, prior=wrong)


def test_of_many_runs_that_are_too_short_a_diagnosis_looks_at_as_many_as_the_program(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sstl_cli.core.runs.LISTED", 3)
    log = sstl.read(SAMPLE)
    short = [replace(log.runs[0].cut(slice(0, 5)), run_id=f"short-{i}") for i in range(9)]
    sstl.Log((*log.runs[:2], *short)).write(tmp_path / "log.parquet")
    with pytest.warns(UserWarning, match="run short-3: .* and 5 more") as told_of:
        found = sstl.diagnose(sstl.read(tmp_path / "log.parquet"), effects=["pulley_friction"], max_effects=1)
    assert len([w for w in told_of if "short-" in str(w.message)]) == 1
    done = inside("diagnose", tmp_path / "log.parquet", "--effects", "pulley_friction", "--max-effects", 1, "--json")
    there = json.loads(done.stdout)
    assert done.returncode == 3 and len(there["data_set_aside"]) == 6
    assert sorted(there["analysis"]["set_aside"]) == ["short-0", "short-1", "short-2"]
    assert found.to_dict()["analysis"] == there["analysis"] and found.verdict.model_dump() == Verdict(**there["verdict"]).model_dump()


def test_nothing_has_changed_since_a_log_of_the_same_rig(named: sstl.Diagnosis) -> None:
    log = short()
    found = sstl.diagnose(log, before=log, effects=["pulley_friction"], max_effects=1)
    # what the rig had before is no change
    assert found.verdict.status == "none" and named.verdict.effects == ["pulley_friction"]


def test_the_recording_to_make_next_is_a_scenario_and_a_table(named: sstl.Diagnosis) -> None:
    moved = sstl.Scenario(
        configurations=({"id": "A", "theta": 0.3},), trajectories=({"kind": "trapezoid", "low_n": 2.0, "high_n": 8.0},), sampling_hz=50.0
    )
    said = NextExperiment(
        separates=["a", "b"], trajectory="trapezoid", why="", scenario=moved.model_dump(mode="json", by_alias=True), tension_factor=2.0
    )
    assert named.proposed() is None and named.proposed_tensions() is None, "what is named needs no further recording"
    found = sstl.Diagnosis(named.log, named.document.model_copy(update={"next_experiment": said}), named.accepted)
    assert found.proposed() == moved
    table = found.proposed_tensions()
    assert table is not None and table.columns.tolist() == ["system", "time_s", "tension_in_n"]
    # in the unit of the recording, of which one N is two
    assert table["tension_in_n"].min() == pytest.approx(4.0) and table["tension_in_n"].max() == pytest.approx(16.0)
    assert np.diff(table["time_s"][table["system"] == "act"]) == pytest.approx(0.02)


def test_a_log_draws_what_the_program_draws() -> None:
    log = sstl.read(SAMPLE)
    for kind, run_id in ((None, None), ("loop", log.runs[1].run_id), ("time", log.runs[1].run_id)):
        choice = choose(load([SAMPLE]), kind, run_id)
        drawn = [lines_of(figure) for figure in (log.plot(kind, run_id), drawing.drawn(choice.module, choice.data, choice.title))]
        assert len(drawn[0]) == len(drawn[1]) > 0
        for own, programs in zip(*drawn, strict=True):
            np.testing.assert_array_equal(own, programs)
    with pytest.raises(SstlError, match="unknown figure"):
        log.plot("nothing")


def lines_of(figure: Figure) -> list[np.ndarray]:
    return [line.get_xydata() for axes in figure.axes for line in axes.lines]


def test_a_log_is_told_run_by_run_as_the_program_tells_it() -> None:
    told = json.loads(inside("info", SAMPLE, "--json").stdout)["files"][0]["runs"]
    made = sstl.read(SAMPLE).summary()
    pd.testing.assert_frame_equal(made, pd.DataFrame(told)[list(made.columns)])
    assert len(made) == 8 and made["samples"].sum() == 16800
    assert list(sstl.Log(()).summary().columns) == list(made.columns)
