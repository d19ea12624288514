"""``sstl compensate`` and ``sstl export`` as a user calls them: results, exit codes, bad input."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from helpers_control import TABLE_II, paper_controller, play, theta_row, write_theta

from sstl_cli.control.controller import Options
from sstl_cli.core.documents.control import ControllerSettings
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, write_runs
from sstl_cli.steps import compensate_source

SSTL_LINES = (0.271, 0.033, 3.314, 4.366)


@pytest.fixture
def theta(tmp_path):
    rows = [theta_row("a", "CP-1", "act", TABLE_II), theta_row("b", "CP-1", "sstl", SSTL_LINES)]
    return write_theta(tmp_path / "theta.parquet", rows)


def test_a_parameter_file_is_read_once_for_its_options_and_its_lines(sstl, theta, tmp_path, monkeypatch):
    stored, out = tmp_path / "stored.json", tmp_path / "c.parquet"
    assert sstl("export", theta, "--format", "json", "--t-max", "33", "--out", stored)[0] == 0
    read, seen = compensate_source.read_json, []

    def counted(path, schema):
        seen.append(path)
        return read(path, schema)

    monkeypatch.setattr(compensate_source, "read_json", counted)
    for words in (("compensate", "--theta", stored, "--out", out), ("export", stored, "--format", "c", "--out", tmp_path / "c")):
        seen.clear()
        code, _, err = sstl(*words)
        assert code == 0 and seen == [stored], err
    assert pq.read_table(out).to_pandas()["tension_cmd_n"].max() <= 33.0


def test_scores_commands_and_json_agree(sstl, theta, tmp_path):
    out, scores = tmp_path / "c.parquet", tmp_path / "s.parquet"
    code, text, _ = sstl("compensate", "--theta", theta, "--out", out, "--scores", scores, "--json")
    document = json.loads(text)
    assert code == 0 and document["schema"] == "sstl.compensate/1"
    assert document["methods"] == ["none", "no-bias", "DI"] and "proposed" in document["left_out_methods"]
    assert document["worst_rmse_n"] < 1e-6
    commands = pq.read_table(out).to_pandas()
    rows = pq.read_table(scores).to_pandas().set_index(["method", "window"])
    none = commands[commands["method"] == "none"]
    start = TABLE_II[0] * 10.0 + TABLE_II[1]
    expected = np.array(play(none["tension_ref_n"], TABLE_II, start))
    np.testing.assert_allclose(none["tension_out_n"], expected, atol=1e-9)
    rmse = float(np.sqrt(np.mean((none["tension_ref_n"] - expected) ** 2)))
    assert rows.loc[("none", "all"), "rmse_n"] == pytest.approx(rmse)
    steady = rows.xs("without first cycle", level="window")
    assert steady.loc["no-bias", "reduction_pct"] == pytest.approx(100 * (1 - 1.258 / 4.448), abs=0.1)
    assert set(commands["phase"]) == {"PB", "PP", "RB", "RP"}


def test_same_seed_gives_the_same_bytes(sstl, theta, tmp_path):
    files = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        path = tmp_path / name / "s.parquet"
        args = ("--theta", theta, "--reference", "random", "--methods", "DI", "--dt", "0.02", "--seed", "3")
        assert sstl("compensate", *args, "--scores", path)[0] == 0
        files.append(path.read_bytes())
    assert files[0] == files[1]


def test_bounds_state_what_they_cost(sstl, theta):
    args = ("--theta", theta, "--methods", "DI", "--max-rate", "5", "--reference", "random", "--json")
    code, text, _ = sstl("compensate", *args)
    assert code == 0 and json.loads(text)["runs"][0]["bound_cost_n"] > 0.1


def test_simulated_plant_and_other_truth(sstl, theta, tmp_path):
    truth = write_theta(tmp_path / "truth.parquet", [theta_row("x", "CP-1", "act", (0.56, -1.4, 1.75, -1.0))])
    code, text, _ = sstl("compensate", "--theta", theta, "--plant", truth, "--methods", "DI", "--json")
    assert code == 0 and 0.2 < json.loads(text)["worst_rmse_n"] < 1.0
    scenario = tmp_path / "rig.toml"
    scenario.write_text('schema = "sstl.scenario/1"\n[[configurations]]\nid = "CP-1"\ntheta = 0.53\n')
    args = ("--theta", theta, "--plant-sim", scenario, "--methods", "none", "--json")
    code, text, _ = sstl("compensate", *args)
    # one theta and no bias: pull line exp(-0.53) T, release line exp(0.53) T
    done = json.loads(text)["scores"][0]
    reference = 10 + 5 * np.sin(2 * np.pi * 0.01 * np.arange(100_000) * 0.002)
    lines = (np.exp(-0.53), 0.0, np.exp(0.53), 0.0)
    expected = np.array(play(reference, lines, lines[0] * 10.0))
    assert code == 0 and done["rmse_n"] == pytest.approx(float(np.sqrt(np.mean((reference - expected) ** 2))))


def test_recorded_input_drives_the_controller(sstl, theta, tmp_path):
    n = 4000
    reference = 10 + 5 * np.sin(np.arange(n) * 0.005)
    noise = np.random.default_rng(0).standard_normal(n) * 0.02
    measured = np.clip((reference + 1.4) / 0.6, 0, 60) + noise
    run = Run("r", "act", np.arange(n) * 0.01, measured, reference + 0.3, "CP-1", "CP", tension_ref_n=reference)
    write_runs(tmp_path / "log.parquet", [run], Provenance("test"))
    out = tmp_path / "c.parquet"
    args = ("--theta", theta, "--recorded", tmp_path / "log.parquet", "--methods", "DI", "--out", out, "--json")
    code, text, _ = sstl("compensate", *args)
    scores = {s["method"]: s for s in json.loads(text)["scores"] if s["window"] == "all"}
    assert code == 0 and scores["recorded"]["rmse_n"] == pytest.approx(0.3)
    table = pq.read_table(out).to_pandas()
    commanded = table[table["method"] == "DI"]
    wanted, phases = paper_controller(reference, measured, TABLE_II)
    np.testing.assert_allclose(commanded["tension_cmd_n"], wanted, atol=1e-9)
    assert commanded["phase"].tolist() == phases


def test_reference_from_a_file(sstl, theta, tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("time_s,tension_ref_n\n" + "".join(f"{k * 0.1},{8 + k % 40 * 0.1}\n" for k in range(200)))
    code, text, _ = sstl("compensate", "--theta", theta, "--reference", path, "--json")
    assert code == 0 and json.loads(text)["summary"][0]["trajectory"] == "mine"


def test_gate_missed_is_exit_4(sstl, theta):
    args = ("--theta", theta, "--methods", "DI", "--loop-tau", "0.5", "--reference", "random", "--max-rmse", "0.01")
    code, _, err = sstl("compensate", *args)
    assert code == 4 and "E411" in err


def test_rows_set_aside_are_exit_3(sstl, tmp_path):
    rows = [
        theta_row("a", "CP-1", "act", TABLE_II),
        theta_row("b", "CP-2", "act", (None,) * 4, "no propagation reached"),
        theta_row("c", "CP-3", "act", (1.7, 0.0, 0.6, 0.0)),
        theta_row("d", "CP-4", "sstl", SSTL_LINES),
    ]
    code, text, err = sstl("compensate", "--theta", write_theta(tmp_path / "t.parquet", rows), "--json")
    aside = json.loads(text)["set_aside"]
    assert code == 3 and "set aside" in err
    assert aside["CP-2 (b)"] == "no propagation reached"
    assert "pull slope" in aside["CP-3"] and "no plant" in aside["CP-4"]


@pytest.mark.parametrize(
    ("args", "exit_code", "said"),
    [
        (["--methods", "DJ"], 2, "did you mean 'DI'"),
        (["--methods", ""], 2, "E008"),
        (["--methods", ","], 2, "E404"),
        (["--methods", "proposed"], 2, "--model"),
        (["--reference", "sinsoid"], 2, "did you mean 'sinusoid'"),
        (["--dt", "-1"], 2, "dt_s"),
        (["--presliding", "2"], 2, "presliding"),
        (["--config-id", "CP-2"], 1, "CP-1"),
        (["--t-max", "12"], 1, "E408"),
        (["--plant", "x", "--plant-sim", "y"], 2, "exclude"),
        (["--plant", "missing.parquet"], 1, "not found"),
        (["--scores", "/no/such/folder/s.parquet"], 1, "E103"),
        (["--stream", "--out", "x.parquet"], 2, "no meaning"),
        (["--stream", "--methods", "DI,none"], 2, "one method"),
    ],
)
def test_bad_options_end_in_one_line(sstl, theta, args, exit_code, said):
    code, out, err = sstl("compensate", "--theta", theta, *args)
    last = err.strip().splitlines()[-1]
    assert code == exit_code and said in last and "Traceback" not in err and out == ""


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("t.parquet", b"not parquet", "is text, not a table of sstl"),
        ("t.json", b"{}", "E112"),
        ("t.json", b'{"schema": "sstl.controller/1", "configurations": []}', "configurations"),
        (
            "t.json",
            b'{"schema": "sstl.controller/1", "configurations": [{"config_id": "a", "theta": {"gamma_p": -1, '
            b'"beta_p": 0, "gamma_r": 2, "beta_r": 0}}]}',
            "E401",
        ),
    ],
)
def test_bad_theta_files(sstl, tmp_path, name, content, said):
    path = tmp_path / name
    path.write_bytes(content)
    for command in (("compensate", "--theta", path), ("export", path, "--out", tmp_path / "o.json")):
        code, _, err = sstl(*command)
        assert code == 1 and said in err
    assert sorted(p.name for p in tmp_path.iterdir()) == [name]


@pytest.mark.parametrize(
    ("text", "said"), [("time_s,tension\n0,1\n1,2\n", "tension_ref_n"), ("time_s,tension_ref_n\n0,a\n1,b\n", "text"), ("", "CSV")]
)
def test_bad_reference_files(sstl, theta, tmp_path, text, said):
    (tmp_path / "r.csv").write_text(text)
    code, _, err = sstl("compensate", "--theta", theta, "--reference", tmp_path / "r.csv")
    assert code == 1 and said in err and "E407" in err


def stream(theta, text, *args):
    command = [sys.executable, "-m", "sstl_cli", "compensate", "--stream", "--theta", str(theta), *args]
    return subprocess.run(command, input=text, capture_output=True, text=True, timeout=60)


def test_a_pipe_is_no_reference(theta, tmp_path):
    """It was waited for, without an end."""
    os.mkfifo(tmp_path / "r.csv")
    words = [sys.executable, "-m", "sstl_cli", "compensate", "--theta", theta, "--methods", "DI", "--reference", tmp_path / "r.csv"]
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "[E114]" in done.stderr


def test_stream_answers_as_the_offline_algorithm(theta):
    reference = (10 + 5 * np.sin(np.arange(300) * 0.05)).tolist()
    measured = ((np.array(reference) + 1.4) / 0.6).tolist()
    wanted, phases = paper_controller(reference, measured, TABLE_II)
    done = stream(theta, "t_ref,t_in\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(reference, measured, strict=True)))
    assert done.returncode == 0
    header, *lines = done.stdout.splitlines()
    assert header == "t_cmd,phase"
    assert [float(line.split(",")[0]) for line in lines] == pytest.approx(wanted, abs=1e-9)
    assert [line.split(",")[1] for line in lines] == phases


def test_stream_survives_anything_on_its_input(theta):
    lines = [
        '{"t_ref": 10, "t_in": 19.6}',
        '{"t_ref": null, "t_in": 19.6}',
        '{"t_ref": "x", "t_in": 1}',
        "{",
        "[1,2]",
        "",
        "nan,nan",
        "10",
        "10,20,30",
        "1e999,3",
        '{"t_ref": 1e400, "t_in": true}',
        "\x00\x1b[31m",
        "10.0,19.6",
    ]
    done = stream(theta, "\n".join(lines))
    answers = done.stdout.splitlines()
    assert done.returncode == 0 and len(answers) == len(lines)
    first = json.loads(answers[0])
    assert first == {"t_cmd": pytest.approx((10 + 1.444) / 0.583), "phase": "PP"}
    assert all("SAFE" in a for a in answers[1:-1])
    assert answers[-1] == f"{first['t_cmd']!r},PP"
    assert "reference lost" in done.stderr and "not valid JSON" in done.stderr and "sound again" in done.stderr
    assert "Traceback" not in done.stderr and "\x1b" not in done.stderr


def test_stream_answers_each_line_at_once_and_silence_with_the_safe_command(theta):
    command = [sys.executable, "-m", "sstl_cli", "compensate", "--stream", "--theta", str(theta), "--timeout", "0.3"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as p:
        assert p.stderr.readline().startswith(b"DI on CP-1")
        os.write(p.stdin.fileno(), b"10,19.6\n")
        # silence may be answered while this test starts; the sample's own answer comes first or after it
        answers = [p.stdout.readline() for _ in range(4)]
        time.sleep(0.1)
        assert any(b"PP" in a for a in answers)
        assert answers[-1].strip().endswith(b"SAFE")
        commands = [float(a.split(b",")[0]) for a in answers if b"SAFE" in a]
        assert commands[-1] < commands[-2] < (10 + 1.444) / 0.583
        p.stdin.close()
        p.stdin = None
        assert p.wait(10) == 0


def test_json_parameters_drive_the_same_controller(sstl, theta, tmp_path):
    path = tmp_path / "p.json"
    args = ("--format", "json", "--lead", "0.2", "--reversal", "play")
    assert sstl("export", theta, *args, "--out", path)[0] == 0
    document = json.loads(path.read_text())
    assert document["schema"] == "sstl.controller/1" and document["options"]["lead_s"] == 0.2
    assert document["configurations"][0]["theta"]["gamma_r"] == 1.688
    code, text, _ = sstl("compensate", "--theta", path, "--methods", "DI", "--t-max", "60", "--json")
    options = json.loads(text)["options"]
    assert code == 0 and (options["lead_s"], options["reversal"], options["t_max_n"]) == (0.2, "play", 60.0)


def test_c_source_is_written_to_a_folder_or_a_name(sstl, theta, tmp_path):
    assert sstl("export", theta, "--format", "c", "--out", tmp_path)[0] == 0
    assert (tmp_path / "sstl_controller.c").read_text().count("0x1.2a7ef9db22d0ep-1") == 1
    assert sstl("export", theta, "--format", "c", "--out", tmp_path / "mine.c", "--real", "float")[0] == 0
    assert '#include "mine.h"' in (tmp_path / "mine.c").read_text()
    assert "typedef float sstl_real;" in (tmp_path / "mine.h").read_text()
    assert sstl("export", theta, "--format", "c", "--out", tmp_path / "mine.c")[0] == 1
    assert sstl("export", theta, "--format", "c", "--out", tmp_path / "mine.c", "--force")[0] == 0


@pytest.mark.parametrize(
    ("args", "exit_code", "said"),
    [
        (["--format", "c", "--out", "x.txt"], 2, "E412"),
        (["--format", "c", "--out", "a b.c"], 2, "portable"),
        (["--format", "java", "--out", "x"], 2, "java"),
        (["--format", "json", "--method", "proposed", "--out", "x.json"], 1, "E405"),
        (["--format", "json"], 2, "--out"),
    ],
)
def test_bad_export_options(sstl, theta, args, exit_code, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = sstl("export", theta, *args)
    assert code == exit_code and said in err and "Traceback" not in err


def test_c_source_goes_beside_no_device(sstl, theta, tmp_path):
    """Its two files have other endings than the name that was given: written beside a pipe they would be in nobody's way."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    code, _, err = sstl("export", theta, "--format", "c", "--out", pipe, "--force")
    assert code == 1 and "E108" in err and [p.name for p in tmp_path.iterdir() if p.name.startswith("pipe")] == ["pipe"]


def test_c_needs_one_configuration(sstl, tmp_path):
    rows = [theta_row(n, n, "act", TABLE_II) for n in ("A", "B")]
    theta = write_theta(tmp_path / "t.parquet", rows)
    code, _, err = sstl("export", theta, "--format", "c", "--out", tmp_path / "x.c")
    assert code == 1 and "A, B" in err and not Path(tmp_path / "x.c").exists()
    assert sstl("export", theta, "--format", "c", "--config-id", "B", "--out", tmp_path / "x.c")[0] == 0


def test_documents_tell_every_setting_of_the_controller(sstl, theta, tmp_path):
    assert list(ControllerSettings.model_fields) == list(Options.model_fields)
    code, text, _ = sstl("export", theta, "--format", "json", "--max-rate", "5", "--out", tmp_path / "c.json", "--json")
    assert code == 0 and json.loads(text)["options"] == json.loads((tmp_path / "c.json").read_text())["options"]
    assert ControllerSettings.model_validate(Options().model_dump(mode="json")).plain() == Options().model_dump(mode="json")
