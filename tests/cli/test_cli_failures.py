"""How the program fails: one line, an exit code, and nothing left behind; what it prints stays whole."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import typer
from cli_calls import run_here, sstl
from short_sample import write

from sstl_cli.cli import app as program
from sstl_cli.cli.render import Screen
from sstl_cli.core.documents.mapping import EvaluateDocument
from sstl_cli.core.tables import COMMAND

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"


@pytest.mark.parametrize("error", [RuntimeError("odd\nvalue\x1b[31m"), RecursionError(), KeyError("x"), OSError("disk")])
def test_internal_error_is_one_line(error, monkeypatch, capsys) -> None:
    from sstl_cli.physics import effects

    def broken() -> None:
        raise error

    monkeypatch.delenv("SSTL_DEBUG", raising=False)
    monkeypatch.setattr(effects, "catalogue", broken)
    assert run_here(monkeypatch, "effects", "list") == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and err.isprintable() is False and "\x1b" not in err
    assert err.startswith(f"sstl: [E003] internal error, {type(error).__name__}") and "Traceback" not in err


@pytest.mark.parametrize("words", [["info"], ["check"], ["diagnose", "--max-effects", "1"], ["import", "--out", "new.parquet"]])
def test_a_name_that_is_no_text_is_told(words, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    named = os.path.join(os.fsencode(tmp_path), b"a\xff.parquet")
    with open(named, "wb") as file:
        file.write(SAMPLE.read_bytes())
    assert run_here(monkeypatch, *words, os.fsdecode(named)) == 1
    err = capsys.readouterr().err
    assert (
        err.count("\n") == 1 and err.startswith("sstl: [E005]") and err.rstrip().endswith("have to have; rename it") and "a\\udcff" in err
    )


def test_an_output_whose_name_is_no_text_is_told_by_its_own_name(tmp_path, monkeypatch, capsys) -> None:
    named = os.fsdecode(os.path.join(os.fsencode(tmp_path), b"a\xff.parquet"))
    assert run_here(monkeypatch, "segment", str(SAMPLE), "--out", named) == 1
    err = capsys.readouterr().err
    assert err.startswith("sstl: [E005]") and "/a\\udcff.parquet: its name" in err and not list(tmp_path.iterdir())


def test_debug_shows_the_internal_error(monkeypatch) -> None:
    from sstl_cli.physics import effects

    monkeypatch.setenv("SSTL_DEBUG", "1")
    monkeypatch.setattr(effects, "catalogue", lambda: 1 / 0)
    monkeypatch.setattr(sys, "argv", ["sstl", "effects", "list"])
    with pytest.raises(ZeroDivisionError):
        program.main()


IN_COMPILED_CODE = SystemError("returned a result with an exception set")
IN_COMPILED_CODE.__cause__ = KeyboardInterrupt()


@pytest.mark.parametrize(("error", "code"), [(MemoryError(), "E002"), (KeyboardInterrupt(), "E001"), (IN_COMPILED_CODE, "E001")])
def test_memory_and_interruption_have_their_own_line(error, code, monkeypatch, capsys) -> None:
    from sstl_cli.physics import effects

    def broken() -> None:
        raise error

    monkeypatch.setattr(effects, "catalogue", broken)
    assert run_here(monkeypatch, "effects", "list") == 1
    assert capsys.readouterr().err.startswith(f"sstl: [{code}] ")


def test_control_characters_in_names_do_not_reach_the_terminal(tmp_path) -> None:
    done = sstl("info", "no\x1b[31m\nfile")
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert r"no\x1b[31m\nfile" in done.stderr and "\x1b" not in done.stderr


def test_ctrl_c_leaves_no_file(tmp_path) -> None:
    out = tmp_path / "big.parquet"
    # a machine that stalls the test may let the program end first; then its file must be whole, and we try again
    for _ in range(5):
        code, err = interrupt_while_writing(out)
        if code != 0:
            break
        assert sstl("check", out).returncode == 0
        out.unlink()
    assert (code, err) == (1, "sstl: [E001] interrupted; nothing half-written was left behind\n")
    assert list(tmp_path.iterdir()) == []


def interrupt_while_writing(out) -> tuple[int, str]:
    command = [sys.executable, "-m", "sstl_cli", "simulate", "--scenario", "paper-150", "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        # the temporary file tells that writing has begun
        deadline = time.monotonic() + 60
        while not list(out.parent.iterdir()) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
    return process.returncode, err


def test_reader_that_goes_away_is_quiet() -> None:
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "sstl_cli", "effects", "list"]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(write)
    assert done.returncode == 1 and done.stderr == ""


def test_effects_list_through_head() -> None:
    line = f"{sys.executable} -m sstl_cli effects list | head -1"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "effects" in done.stdout and done.stderr == ""


@pytest.mark.parametrize("command", ["check", "info", "segment"])
@pytest.mark.parametrize(
    ("body", "says"), [(b"", "is empty"), (b"time,x\n0,1\n", "sstl import"), (b"PAR1" + b"\0" * 60, "cut off or damaged")]
)
def test_files_that_are_no_tables(command, body, says, tmp_path, monkeypatch, capsys) -> None:
    # a long folder would fold the message in its column
    monkeypatch.setenv("COLUMNS", "300")
    path = tmp_path / "x.parquet"
    path.write_bytes(body)
    more = ["-o", tmp_path / "o.parquet"] if command == "segment" else []
    assert run_here(monkeypatch, command, path, *more) == 1
    printed = capsys.readouterr()
    assert says in printed.err + printed.out and not (tmp_path / "o.parquet").exists()


def test_misspelt_column_reaches_the_user_with_its_neighbour(tmp_path, monkeypatch, capsys) -> None:
    table = pq.read_table(SAMPLE)
    path = tmp_path / "x.parquet"
    pq.write_table(table.rename_columns(["tension_inn" if n == "tension_in_n" else n for n in table.column_names]), path)
    assert run_here(monkeypatch, "segment", path, "-o", tmp_path / "o.parquet") == 1
    assert "did you mean 'tension_inn'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("diagnose", "absent.parquet"), "not found"),
        (("simulate", "--scenario", "defaut", "--out", "x.parquet"), "did you mean 'default'"),
        (("simulate", "--effect", "puley_friction", "--out", "x.parquet"), "did you mean 'pulley_friction'"),
        (("simulate", "--effect", "pulley_friction:m_p=9", "--out", "x.parquet"), "outside 0..0.25"),
        (("simulate", "--effect", "slack", "--out", "x.parquet"), "position_in_mm"),
        (("simulate", "--out", "no/such/folder/x.parquet"), "folder does not exist"),
    ],
)
def test_errors_are_one_line_and_leave_nothing(words, says, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    # a value that no log can make right is wrong usage
    wrong_usage = "did you mean 'pulley" in says or "outside" in says
    assert run_here(monkeypatch, *words) == (2 if wrong_usage else 1)
    err = capsys.readouterr().err
    assert says in err and err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("gate", ["--max-rmse", "--max-gap-pct"])
@pytest.mark.parametrize("bound", ["nan", "-1"])
def test_a_gate_that_nothing_or_everything_misses_is_wrong_usage(gate, bound, monkeypatch, capsys) -> None:
    """No number is above nan: the gate was met by any."""
    assert run_here(monkeypatch, "diagnose", SAMPLE, gate, bound) == 2
    assert gate in capsys.readouterr().err


@pytest.mark.parametrize(
    "more", [("--save-sim", "x.toml"), ("--next-out", "x.csv"), ("--junit", "x.xml"), ("--max-rmse", "0.1"), ("--position",)]
)
def test_a_plan_says_what_it_has_nothing_for(more, tmp_path, monkeypatch, capsys) -> None:
    """No file was written, and no word said."""
    monkeypatch.chdir(tmp_path)
    assert run_here(monkeypatch, "diagnose", "--plan", "sample", *more) == 2
    assert f"a plan has nothing for {more[0]}" in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize("more", [("--save-sim", "x.toml"), ("--sim", "sample"), ("--expect", "none"), ("--effects", "zero_offset")])
def test_a_command_stream_says_what_it_has_nothing_for(more, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    row = {c.name: ["a"] if c.type == pa.string() else [1.0] for c in COMMAND.columns}
    pq.write_table(pa.table(row).replace_schema_metadata({"sstl": '{"schema": "sstl.command", "schema_version": 1}'}), "c.parquet")
    assert run_here(monkeypatch, "diagnose", "c.parquet", *more) == 2
    assert f"a command stream has nothing for {more[0]}" in capsys.readouterr().err and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("more", [("--model", "sample"), ("--plant", "zero_offset")])
def test_what_is_put_into_recordings_goes_with_no_model(more, monkeypatch, capsys) -> None:
    assert run_here(monkeypatch, "blind", "real", SAMPLE, "--inject", "all", *more) == 2
    assert f"{more[0]} has no meaning with --inject" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("export", SAMPLE, "-f", "csv", "--dt", "5", "-o", "x"), "a log as csv has nothing for --dt"),
        (("export", SAMPLE, "-f", "mat", "--method", "DI", "--no-doubled", "-o", "x"), "a log as mat has nothing for --method, --doubled"),
        (("export", SAMPLE, "-f", "mcap", "--config-id", "A", "-o", "x"), "a log as mcap has nothing for --config-id"),
        (("export", SAMPLE, "-f", "onnx", "--t-max", "5", "-o", "x"), "a mapping as onnx has nothing for --t-max"),
        (("export", SAMPLE, "-f", "json", "--real", "float", "-o", "x"), "a controller as json has nothing for --real"),
        (("export", SAMPLE, "-f", "c", "--beta-p", "1", "-o", "x"), "without --model has nothing for --beta-p"),
        (("compensate", "--theta", SAMPLE, "--bias-theta", SAMPLE), "without --model has nothing for --bias-theta"),
        (("compensate", "--theta", SAMPLE, "--presliding", "0.5"), "--reversal paper has nothing for --presliding"),
        (("compensate", "--theta", SAMPLE, "--timeout", "1"), "without --stream has nothing for --timeout"),
        (("compensate", "--theta", SAMPLE, "--recorded", SAMPLE, "--cycles", "3"), "a recorded input has nothing for --cycles"),
        (("compensate", "--theta", SAMPLE, "--stream", "--loop-tau", "1"), "a stream has nothing for --loop-tau"),
        (("train", SAMPLE, "-o", "x", "--leave-out", "ND", "--test-share", "0.5"), "--leave-out has nothing for --test-share"),
        (("import", SAMPLE, "--guess", "--on-gap", "fill"), "a proposal has nothing for --on-gap"),
        (("watch", SAMPLE, "--no-diagnose", "--name-after", "3"), "--no-diagnose has nothing for --name-after"),
        (("watch", SAMPLE, "--once", "--poll", "3"), "--once has nothing for --poll"),
        (
            ("batch", "info", SAMPLE, "--out-dir", "d", "--scheduler", "tcp://x:1", "--workers", "2"),
            "--scheduler has nothing for --workers",
        ),
    ],
)
def test_options_without_effect_are_refused(words, says, tmp_path, monkeypatch, capsys) -> None:
    """They were read, and nothing was done with them."""
    monkeypatch.chdir(tmp_path)
    assert run_here(monkeypatch, *words) == 2
    err = capsys.readouterr().err
    assert says in err and "[E006]" in err and err.count("\n") == 1 and list(tmp_path.iterdir()) == []


def test_defaults_of_many_calls_may_be_without_effect(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SSTL_EXPORT_REAL", "float")
    Path("rig.toml").write_text("t_max = 60.0\n")
    assert run_here(monkeypatch, "export", SAMPLE, "-f", "csv", "--config", "rig.toml", "-o", "x.csv") == 0


def test_a_recording_that_is_not_proposed_is_told(tmp_path, monkeypatch, capsys) -> None:
    """Nothing was written, and no word said; what another call had left looked like the answer."""
    monkeypatch.chdir(tmp_path)
    Path("next.toml").write_text("old")
    few = ("--effects", "pulley_friction", "--max-effects", "1", "--next-out", "next.toml", "--force")
    assert run_here(monkeypatch, "diagnose", write(tmp_path / "log.parquet"), *few) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "no recording is proposed" in said and "next.toml was not written, and the file there is from before" in said


def test_an_existing_output_needs_force(tmp_path, monkeypatch, capsys) -> None:
    out = tmp_path / "x.parquet"
    out.write_text("old")
    assert run_here(monkeypatch, "simulate", "--scenario", "sample", "--out", out) == 1
    assert "--force" in capsys.readouterr().err and out.read_text() == "old"


def test_a_missed_gate_is_4(tmp_path, monkeypatch, capsys) -> None:
    few = ("--effects", "pulley_friction", "--max-effects", "1")
    assert run_here(monkeypatch, "diagnose", write(tmp_path / "log.parquet"), "--expect", "none", *few) == 4
    assert "gate missed: --expect: expected none" in capsys.readouterr().err


def test_data_set_aside_is_3(tmp_path, monkeypatch, capsys) -> None:
    table = pq.read_table(SAMPLE)
    short = table.slice(0, 3)
    path = tmp_path / "short.parquet"
    pq.write_table(short, path)
    assert run_here(monkeypatch, "segment", path, "-o", tmp_path / "t.parquet") == 3
    assert "1 of 1 runs set aside" in capsys.readouterr().err


# the renderer


def test_numbers_are_never_folded(monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    rows = [("CP-020-0-trapezoid-act" * 2, -0.003098, 12345678, None), ("b", 1e-12, 2, 3.5)]
    Screen().table("Title", ("run", "beta_p", "n", "x"), rows, "a note")
    text = capsys.readouterr().out
    assert all(number in text.split() for number in ("-0.003098", "12345678", "1e-12", "-", "3.5"))
    assert max(map(len, text.splitlines())) <= 50 and text.endswith("a note\n")


def test_a_pipe_is_not_folded_at_80(monkeypatch, capsys) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    Screen().table("", ("text",), [("x" * 120,)])
    assert "x" * 120 in capsys.readouterr().out


def test_json_keeps_stdout_for_the_document(capsys) -> None:
    import json

    screen = Screen(as_json=True)
    screen.line("hidden")
    screen.table("hidden", ("a",), [(1,)])
    screen.note("told\x1b")
    with pytest.raises(typer.Exit) as end:
        known = {"schema": "sstl.evaluate/1", "set_aside": 0, "set_aside_runs": []}
        screen.finish(EvaluateDocument.joined(**known, rmse_total=np.float64("nan"), rows=pa.scalar(1).as_py()), 3)
    printed = capsys.readouterr()
    assert end.value.exit_code == 3 and json.loads(printed.out) == {**known, "rmse_total": None, "rows": 1}
    assert printed.err == "told\\x1b\n"


def test_a_log_is_no_simulator_of_itself(monkeypatch, capsys) -> None:
    """A sensor was said to be stuck: what was left is the base, which rests in its backlash without noise."""
    assert run_here(monkeypatch, "diagnose", SAMPLE, "--against", SAMPLE) == 1
    err = capsys.readouterr().err
    assert "[E911]" in err and "both logs hold the same output" in err and err.count("\n") == 1


def test_a_working_folder_that_is_gone_is_told(tmp_path, monkeypatch, capsys) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert run_here(monkeypatch, "info", str(SAMPLE)) == 1
    assert capsys.readouterr().err == "sstl: [E007] .: the working folder is gone; change to one that is there\n"


@pytest.mark.parametrize("option", ["--expect", "--effects", "--sim"])
def test_an_option_with_an_empty_text_is_told(option, monkeypatch, capsys) -> None:
    # a script whose variable is not set would pass its gate, or be told of another simulator
    assert run_here(monkeypatch, "diagnose", str(SAMPLE), option, "") == 2
    assert capsys.readouterr().err == f"sstl: [E008] {option}: is empty; give a value, or leave it out\n"


def test_an_output_with_a_slash_at_its_end_is_a_folder(tmp_path, monkeypatch, capsys) -> None:
    assert run_here(monkeypatch, "segment", str(SAMPLE), "--out", f"{tmp_path}/new/") == 2
    assert capsys.readouterr().err == f"sstl: [E101] --out {tmp_path}/new/: is a folder; give a file name\n"
    assert not (tmp_path / "new").exists()
