"""``sstl simulate`` and ``sstl effects`` as a user runs them: bytes, provenance, bad input, a dropped-in effect."""

from __future__ import annotations

import hashlib
import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pyarrow.parquet as pq
import pytest

from sstl_cli.cli import app as program
from sstl_cli.core.runs import read_runs
from sstl_cli.diagnosis.scale import given, in_newtons
from sstl_cli.physics import effects as package
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.scenario import load

SCENARIO = """
schema = "sstl.scenario/1"
sampling_hz = 100.0
[[configurations]]
id = "one"
location = "CP"
theta = 0.5
[[trajectories]]
kind = "ramp_hold"
duration_s = 12.0
record_position = true
record_reference = true
"""


def sstl(*words, cwd):
    """Run the program in this process: same entry point, same exit code, no start-up time."""
    out, err = io.StringIO(), io.StringIO()
    folder, argv, columns = os.getcwd(), sys.argv, os.environ.get("COLUMNS")
    code = 0
    try:
        os.chdir(cwd)
        sys.argv, os.environ["COLUMNS"] = ["sstl", *map(str, words)], "200"
        with redirect_stdout(out), redirect_stderr(err):
            try:
                program.main()
            except SystemExit as end:
                code = end.code or 0
    finally:
        os.chdir(folder)
        sys.argv = argv
        if columns is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = columns
    assert "Traceback" not in err.getvalue() + out.getvalue()
    return subprocess.CompletedProcess(words, code, out.getvalue(), err.getvalue())


@pytest.fixture(autouse=True, scope="module")
def registered_once():
    program._register()
    keep, program._register = program._register, lambda: None
    yield
    program._register = keep


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rig.toml").write_text(SCENARIO)
    return tmp_path


def refused(folder, *words, code=1):
    """Return the one line of a refusal; nothing may be written."""
    done = sstl("simulate", "--out", "log.parquet", *words, cwd=folder)
    assert done.returncode == code, done.stderr
    assert not (folder / "log.parquet").exists()
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert len(lines) == 1, done.stderr
    return lines[0]


@pytest.mark.parametrize("simulator", ["transmission", "rig", "bristle"])
def test_same_seed_same_bytes(folder, simulator):
    words = ("simulate", "--scenario", "rig.toml", "--simulator", simulator, "--seed", "7", "--out", "log.parquet")
    words = (*words, "--effect", "acquisition_faults:spike_pct=0.5,jitter_pct=1", "--effect", "const_friction:w_l_n=0.2")
    assert sstl(*words, cwd=folder).returncode == 0
    first = (folder / "log.parquet").read_bytes()
    assert sstl(*words, "--force", cwd=folder).returncode == 0
    again = (folder / "log.parquet").read_bytes()
    # the command line, and so --force, is part of the provenance; the recordings are the same
    assert pq.read_table(folder / "log.parquet").equals(pq.read_table(io.BytesIO(first)))
    assert sstl(*words, "--force", cwd=folder).returncode == 0
    assert (folder / "log.parquet").read_bytes() == again
    other = [*words, "--force"]
    other[other.index("7")] = "8"
    assert sstl(*other, cwd=folder).returncode == 0
    assert not pq.read_table(folder / "log.parquet").equals(pq.read_table(io.BytesIO(first)))


def test_provenance_and_document(folder):
    done = sstl("simulate", "--scenario", "rig.toml", "--seed", "3", "--out", "log.parquet", "--json", cwd=folder)
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.simulate/1" and document["seed"] == 3 and document["runs"] == 2
    origin = json.loads(pq.read_schema(folder / "log.parquet").metadata[b"sstl"])
    assert origin["schema"].startswith("sstl.log") and origin["seed"] == 3
    assert "simulate" in origin["command"] and "--scenario rig.toml" in origin["command"]
    assert origin["inputs"] == {"rig.toml": hashlib.sha256(SCENARIO.encode()).hexdigest()}
    runs = list(read_runs(folder / "log.parquet"))
    assert sum(len(r) for r in runs) == document["samples"] == 2400
    assert {r.system for r in runs} == {"act", "sstl"}
    assert all(r.position_in_mm is not None and r.tension_ref_n is not None for r in runs)


@pytest.mark.parametrize("other", ["rig", "bristle"])
def test_simulators_agree_without_effects(folder, other):
    logs = []
    for simulator in ("transmission", other):
        name = f"{simulator}.parquet"
        words = ("--scenario", "rig.toml", "--simulator", simulator, "--noise-n", "0", "--out", name)
        assert sstl("simulate", *words, cwd=folder).returncode == 0
        logs.append(list(read_runs(folder / name)))
    for a, b in zip(*logs, strict=True):
        # after the first full stroke the start is forgotten
        late = a.time_s > 6.0
        assert np.sqrt(np.mean((a.tension_out_n - b.tension_out_n)[late] ** 2)) < 0.01


def test_bad_values_name_parameter_unit_and_range(folder):
    line = refused(folder, "--scenario", "rig.toml", "--effect", "pulley_friction:f0_n=3", code=2)
    assert "E702" in line and "f0_n = 3 N" in line and "0..2 N" in line
    assert "did you mean 'pulley_friction'" in refused(folder, "--effect", "puley_friction", code=2)
    assert "did you mean 'f0_n'" in refused(folder, "--effect", "pulley_friction:f0=1", code=2)
    assert "param=value" in refused(folder, "--effect", "pulley_friction:f0_n", code=2)
    assert "did you mean 'default'" in refused(folder, "--scenario", "defualt")


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_values_that_are_no_numbers_are_refused(folder, value):
    assert "0..2 N" in refused(folder, "--effect", f"pulley_friction:f0_n={value}", code=2)


@pytest.mark.parametrize("effect", ["tendon_elasticity", "load_spring", "slack", "tension_loop_lag"])
def test_a_missing_channel_is_named(folder, effect):
    (folder / "bare.toml").write_text(SCENARIO.replace("= true", "= false"))
    line = refused(folder, "--scenario", "bare.toml", "--effect", effect)
    channel = "tension_ref_n" if effect == "tension_loop_lag" else "position_in_mm"
    assert effect in line and channel in line and "ramp_hold" in line and "record_" in line


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("[rig]\nlength_mm = 1", "length_mm"),
        ("[rig]\nea_n = -5", "ea_n"),
        ("[rig]\nnodes = 2", "nodes"),
        ("[rig]\narc_fraction = 0.9\nbend_centres = { CP = 0.2 }", "leaves the tube"),
        ("[noise]\nwhite_n = -9", "white_n"),
        ("[effects.viscous]\nc_l_n_s_per_mm = -1", "N s/mm"),
    ],
)
def test_impossible_rigs_are_refused(folder, entry, said):
    (folder / "odd.toml").write_text(SCENARIO + entry + "\n")
    assert said in refused(folder, "--scenario", "odd.toml")


def test_what_only_the_rig_refuses_is_one_line(folder):
    (folder / "odd.toml").write_text(SCENARIO.replace("theta = 0.5", "theta = 4.0"))
    line = refused(folder, "--scenario", "odd.toml", "--simulator", "rig")
    assert "E720" in line and "theta" in line and "0..3" in line
    (folder / "odd.toml").write_text(SCENARIO.replace('location = "CP"', 'location = "XX"'))
    assert "location" in refused(folder, "--scenario", "odd.toml", "--simulator", "rig")


def test_effects_list_and_show(folder):
    listed = json.loads(sstl("effects", "list", "--json", cwd=folder).stdout)
    assert listed["schema"] == "sstl.effects/1"
    assert [e["id"] for e in listed["effects"]] == sorted(catalogue())
    text = sstl("effects", "list", cwd=folder).stdout
    assert all(i in text for i in catalogue())
    shown = json.loads(sstl("effects", "show", "viscous", "--json", cwd=folder).stdout)
    assert shown["schema"] == "sstl.effect/1" and shown["parameters"][0]["unit"] == "N s/mm"
    text = sstl("effects", "show", "slack", cwd=folder).stdout
    assert "gap_mm" in text and "position_in_mm" in text and "saturation" in text
    wrong = sstl("effects", "show", "viscos", cwd=folder)
    assert wrong.returncode == 2 and "did you mean 'viscous'" in wrong.stderr


def test_a_dropped_in_effect_is_listed_and_simulated(folder, monkeypatch):
    (folder / "square_gain.py").write_text(
        "from sstl_cli.physics.effect import INSTRUMENT, Effect, Parameter\n"
        "EFFECT = Effect(id='square_gain', title='Gain', stage=INSTRUMENT, equation='T g', source='test',\n"
        "    parameters=(Parameter('g', '1', 1.0, 0.5, 2.0, 'gain'),), excitation='any',\n"
        "    output=lambda t, other, run, v: t * v['g'])\n"
    )
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    catalogue.cache_clear()
    try:
        assert "square_gain" in sstl("effects", "list", cwd=folder).stdout
        shared = ("simulate", "--scenario", "rig.toml", "--noise-n", "0")
        assert sstl(*shared, "--out", "plain.parquet", cwd=folder).returncode == 0
        assert sstl(*shared, "--effect", "square_gain:g=2", "--out", "twice.parquet", cwd=folder).returncode == 0
        for a, b in zip(read_runs(folder / "plain.parquet"), read_runs(folder / "twice.parquet"), strict=True):
            assert np.array_equal(2.0 * a.tension_out_n, b.tension_out_n)
    finally:
        monkeypatch.undo()
        catalogue.cache_clear()
        sys.modules.pop("sstl_cli.physics.effects.square_gain", None)


def test_a_model_of_another_unit_records_in_it(tmp_path):
    """A saved model of a recording in deg wrote its output in N without a word."""
    (tmp_path / "newtons.toml").write_text(SCENARIO)
    output = '[output]\nunit = "deg"\nper_n = { "act" = 3.0, "sstl" = 0.5 }\norigin = { "act" = 5.0, "sstl" = -2.0 }\n'
    (tmp_path / "deg.toml").write_text(SCENARIO.replace("[[configurations]]", output + "[[configurations]]"))
    for simulator in ("transmission", "rig"):
        logs = []
        for name in ("newtons", "deg"):
            words = ("--scenario", f"{name}.toml", "--simulator", simulator, "--seed", 1, "--out", f"{name}.parquet", "--force")
            assert sstl("simulate", *words, cwd=tmp_path).returncode == 0
            logs.append(list(read_runs(tmp_path / f"{name}.parquet")))
        plain, own = logs
        assert {r.unit_out for r in plain} == {"N"} and {r.unit_out for r in own} == {"deg"}
        model = load(str(tmp_path / "deg.toml"))
        scale = given(own, model.output)
        assert scale is not None
        for a, b in zip(plain, in_newtons(own, scale), strict=True):
            assert np.allclose(a.tension_out_n, b.tension_out_n) and np.array_equal(a.tension_in_n, b.tension_in_n)
        by = {"act": (3.0, 5.0), "sstl": (0.5, -2.0)}
        for a, b in zip(plain, own, strict=True):
            assert np.allclose(b.tension_out_n, by[a.system][0] * a.tension_out_n + by[a.system][1])


def test_a_model_without_a_factor_for_a_system_stays_in_newtons_and_says_so(tmp_path):
    output = '[output]\nunit = "deg"\nper_n = { "act" = 3.0 }\norigin = { "act" = 5.0 }\n'
    (tmp_path / "deg.toml").write_text(SCENARIO.replace("[[configurations]]", output + "[[configurations]]"))
    told = sstl("simulate", "--scenario", "deg.toml", "--seed", 1, "--out", "a.parquet", cwd=tmp_path)
    assert "the output is in N: the scenario has no deg a newton of sstl" in told.stderr
    assert {r.unit_out for r in read_runs(tmp_path / "a.parquet")} == {"N"}
    # where that system is not recorded there is nothing to be said
    act = (tmp_path / "deg.toml").read_text().replace('kind = "ramp_hold"', 'kind = "ramp_hold"\nsystems = ["act"]')
    (tmp_path / "deg.toml").write_text(act)
    told = sstl("simulate", "--scenario", "deg.toml", "--seed", 1, "--out", "b.parquet", cwd=tmp_path)
    assert "newton" not in told.stderr and {r.unit_out for r in read_runs(tmp_path / "b.parquet")} == {"deg"}
