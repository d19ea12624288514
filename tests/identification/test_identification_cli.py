"""``sstl segment``, ``check`` and ``info`` as a user runs them: outputs, exit codes, bad input."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from identification_loops import ACT, record, trapezoid

from sstl_cli.cli import app as program
from sstl_cli.core.parquet import open_table, write_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import run_table, write_runs
from sstl_cli.core.tables import LOG, PHASES, THETA

ORIGIN = Provenance("test", 0)
GOOD = [record(*trapezoid(rate=100.0), ACT, s, run_id=f"run-{s}") for s in range(3)]


def sstl(*words, cwd=None):
    """Run the program in this process: same entry point, same exit code, no start-up time."""
    out, err = io.StringIO(), io.StringIO()
    folder, argv, columns = os.getcwd(), sys.argv, os.environ.get("COLUMNS")
    code = 0
    try:
        os.chdir(cwd or folder)
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
def log(tmp_path):
    path = tmp_path / "log.parquet"
    write_runs(path, GOOD, ORIGIN)
    return path


def raw(path, run=GOOD[0], **columns):
    """Write a log table with columns replaced or, where None, removed."""
    table = run_table(run)
    for name, values in columns.items():
        at = table.column_names.index(name)
        table = table.remove_column(at) if values is None else table.set_column(at, name, values)
    write = table.replace_schema_metadata(ORIGIN.metadata(LOG.id, LOG.version))
    pq.write_table(write, path)
    return path


def test_segment_writes_theta_and_phases(log, tmp_path):
    out, phases = tmp_path / "theta.parquet", tmp_path / "phases.parquet"
    done = sstl("segment", log, "--out", out, "--phases", phases, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.segment/1" and document["runs"] == 3 and document["set_aside"] == 0
    theta = open_table(out, THETA).table().to_pylist()
    assert [r["run_id"] for r in theta] == ["run-0", "run-1", "run-2"]
    assert all(abs(r["gamma_p"] - 0.58) < 0.006 and r["status"] == "ok" for r in theta)
    labels = open_table(phases, PHASES).table()
    assert labels.num_rows == sum(len(r) for r in GOOD)
    assert set(labels.column("phase").unique().to_pylist()) <= {"PB", "PP", "RB", "RP"}


def test_same_input_gives_same_bytes_and_run_order_does_not_matter(log, tmp_path):
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        done = sstl("segment", log, "--out", "t.parquet", "--phases", "p.parquet", "--seed", "5", cwd=folder)
        assert done.returncode == 0
    for name in ("t.parquet", "p.parquet"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    backwards = tmp_path / "backwards.parquet"
    write_runs(backwards, GOOD[::-1], ORIGIN)
    done = sstl("segment", backwards, "--out", tmp_path / "back.parquet", "--seed", "5")
    assert done.returncode == 0
    forward = open_table(tmp_path / "a" / "t.parquet", THETA).table().to_pylist()
    back = open_table(tmp_path / "back.parquet", THETA).table().to_pylist()
    assert back[::-1] == forward


def test_segment_sets_runs_aside_with_exit_3(tmp_path):
    bad = replace(GOOD[0], run_id="bad", tension_in_n=np.full(len(GOOD[0]), 5.0))
    one = replace(GOOD[0], run_id="one", time_s=np.zeros(1), tension_in_n=np.ones(1), tension_out_n=np.ones(1))
    log = tmp_path / "log.parquet"
    write_runs(log, [*GOOD, bad, one], ORIGIN)
    done = sstl("segment", log, "--out", tmp_path / "t.parquet", "--json")
    assert done.returncode == 3
    assert "2 of 5 runs" in done.stderr
    document = json.loads(done.stdout)
    assert {r["run_id"]: r["status"] for r in document["set_aside_runs"]} == {
        "bad": "tension_in_n is constant",
        "one": "too few samples (1)",
    }
    rows = {r["run_id"]: r for r in open_table(tmp_path / "t.parquet", THETA).table().to_pylist()}
    assert rows["bad"]["gamma_p"] is None and rows["bad"]["gamma_p_se"] is None


def test_segment_refuses_an_existing_output_and_force_overwrites(log, tmp_path):
    out = tmp_path / "theta.parquet"
    out.write_bytes(b"mine")
    done = sstl("segment", log, "--out", out)
    assert done.returncode == 1 and "--force" in done.stderr and out.read_bytes() == b"mine"
    assert sstl("segment", log, "--out", out, "--force").returncode == 0
    assert open_table(out, THETA).rows == 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--cutoff-hz", "-1"], "cutoff-hz"),
        (["--cutoff-hz", "50"], "half the sampling rate"),
        (["--ransac-trials", "0"], "ransac-trials"),
        (["--seed", "-1"], "seed"),
        (["--nonsense"], "nonsense"),
        (["--phases", "theta.parquet"], "same file"),
    ],
)
def test_segment_usage_errors(log, tmp_path, words, message):
    done = sstl("segment", log, "--out", "theta.parquet", *words, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert message in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["log.parquet"]


def test_options_may_come_from_a_file_and_a_wrong_key_is_named(log, tmp_path):
    config = tmp_path / "c.toml"
    config.write_text("[segment]\ncutoff-hz = 50.0\n")
    done = sstl("segment", log, "--out", tmp_path / "t.parquet", "--config", config)
    assert done.returncode == 2 and "E212" in done.stderr
    config.write_text("[segment]\ncutof-hz = 5.0\n")
    done = sstl("segment", log, "--out", tmp_path / "t.parquet", "--config", config)
    assert done.returncode == 2 and "cutoff-hz" in done.stderr


def bad_files(folder: Path):
    n = len(GOOD[0])
    nan = pa.array(np.where(np.arange(n) == 3, np.nan, GOOD[0].tension_in_n))
    null = pa.array(np.where(np.arange(n) == 3, np.nan, GOOD[0].tension_in_n), from_pandas=True)
    text = pa.array(["abc"] * n)
    (folder / "empty.parquet").write_bytes(b"")
    (folder / "text.parquet").write_text("time_s,tension_in_n\n0,1\n")
    whole = raw(folder / "whole.parquet").read_bytes()
    (folder / "cut.parquet").write_bytes(whole[: len(whole) // 2])
    pq.write_table(pq.read_table(folder / "whole.parquet").slice(0, 0), folder / "norows.parquet")
    table = pq.read_table(folder / "whole.parquet").replace_schema_metadata(ORIGIN.metadata(LOG.id, 99))
    pq.write_table(table, folder / "version.parquet")
    table = pq.read_table(folder / "whole.parquet").rename_columns(
        ["tension_inn" if c == "tension_in_n" else c for c in pq.read_table(folder / "whole.parquet").column_names]
    )
    pq.write_table(table, folder / "misspelt.parquet")
    raw(folder / "nan.parquet", tension_in_n=nan)
    raw(folder / "null.parquet", tension_in_n=null)
    raw(folder / "words.parquet", tension_in_n=text)
    raw(folder / "system.parquet", system=pa.array(["both"] * n))


# file, exit code and words of `segment`, words of `check`
BAD = [
    ("missing", 1, "file not found", "not found"),
    ("empty", 1, "is empty", "is empty"),
    ("text", 1, "sstl import text.parquet --out text-log.parquet", "import with a mapping"),
    ("cut", 1, "cut off or damaged; copy it again", "cut off or damaged"),
    ("norows", 1, "holds no run", "no rows"),
    ("version", 1, "version 99", "version 99"),
    ("misspelt", 1, "'tension_in_n' (did you mean 'tension_inn'?)", "tension_inn"),
    ("nan", 3, "1 of 1200 samples: 1 not a number in tension_in_n", "not a number"),
    ("null", 1, "1 empty values", "empty values"),
    ("words", 1, "tension_in_n", "wrong type"),
    ("system", 1, "'both'", "unknown system"),
]


@pytest.mark.parametrize(("name", "code", "said", "checked"), BAD, ids=[b[0] for b in BAD])
def test_bad_input_ends_in_one_clear_line(tmp_path, name, code, said, checked):
    bad_files(tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    done = sstl("segment", tmp_path / f"{name}.parquet", "--out", tmp_path / "theta.parquet")
    assert done.returncode == code and said in done.stderr
    if code == 1:
        assert sorted(p.name for p in tmp_path.iterdir()) == before
        assert len(done.stderr.strip().splitlines()) == 1
    done = sstl("check", tmp_path / f"{name}.parquet", "--json")
    assert done.returncode == 1
    document = json.loads(done.stdout)
    assert document["ok"] is False and checked in done.stdout


def test_check_lists_every_failure_of_every_file(log, tmp_path):
    run = GOOD[0]
    n = len(run)
    time = run.time_s.copy()
    time[50], time[100], time[300:] = time[49], time[98], time[300:] + 5.0
    values = run.tension_in_n.copy()
    values[[5, 6]] = np.nan
    bad = raw(tmp_path / "bad.parquet", time_s=pa.array(time), tension_in_n=pa.array(values), tension_out_n=pa.array(np.full(n, 3.0)))
    done = sstl("check", log, bad, tmp_path / "absent.parquet", "--json")
    assert done.returncode == 1
    found = {(Path(f["file"]).name, f["what"]): f for f in json.loads(done.stdout)["findings"] if f["level"] == "failure"}
    for what, count in (("time repeats", 1), ("time runs backwards", 1), ("gaps", 1), ("not a number", 2)):
        assert found["bad.parquet", what]["count"] == count
        assert found["bad.parquet", what]["run_id"] == "run-0" and found["bad.parquet", what]["fix"]
    assert ("absent.parquet", "unreadable") in found
    assert not [k for k in found if k[0] == "log.parquet"]


def test_check_reads_runs_that_come_in_two_pieces(tmp_path):
    tables = [run_table(r) for r in (GOOD[0], GOOD[1], replace(GOOD[0], time_s=GOOD[0].time_s + 100))]
    write_table(tmp_path / "split.parquet", pa.concat_tables(tables), LOG, ORIGIN)
    done = sstl("check", tmp_path / "split.parquet", "--json")
    assert done.returncode == 1
    # brought together the run has a pause of its own
    assert [f["what"] for f in json.loads(done.stdout)["findings"]] == ["runs in pieces", "gaps"]
    done = sstl("segment", tmp_path / "split.parquet", "--out", tmp_path / "t.parquet")
    assert done.returncode == 1 and "two pieces" in done.stderr and not (tmp_path / "t.parquet").exists()


def test_check_of_a_log_sorted_by_time_is_one_finding(log, tmp_path):
    table = pq.read_table(log)
    pq.write_table(table.sort_by("time_s"), tmp_path / "sorted.parquet")
    done = sstl("check", tmp_path / "sorted.parquet", "--json")
    [finding] = [f for f in json.loads(done.stdout)["findings"] if f["level"] == "failure"]
    runs = len(set(table["run_id"].to_pylist()))
    assert done.returncode == 1 and finding["what"] == "runs in pieces" and finding["count"] == runs
    assert "sort by run_id" in finding["fix"] and "sorted by time?" in finding["detail"]


def test_check_lists_the_first_of_many_alike_and_counts_the_rest(tmp_path):
    n = 120
    ids = [f"r{i:03d}" for i in range(n) for _ in range(2)]
    columns = {"time_s": [0.0, 0.1] * n, "tension_in_n": [1.0, 2.0] * n, "tension_out_n": [1.0, 2.0] * n}
    pq.write_table(pa.table({"run_id": ids, "system": ["act"] * 2 * n, **columns}), tmp_path / "many.parquet")
    found = [f for f in json.loads(sstl("check", tmp_path / "many.parquet", "--json").stdout)["findings"] if f["level"] == "failure"]
    assert len(found) == 51 and {f["what"] for f in found} == {"too few samples"}
    assert found[-1]["run_id"] is None and "70 more runs" in found[-1]["detail"]


def test_check_names_units_that_are_not_ours(tmp_path):
    table = run_table(GOOD[0])
    at = table.column_names.index("tension_in_n")
    field = table.schema.field(at).with_metadata({"unit": "lbf"})
    table = table.set_column(at, field, table.column(at)).replace_schema_metadata(ORIGIN.metadata(LOG.id, LOG.version))
    pq.write_table(table, tmp_path / "lbf.parquet")
    done = sstl("check", tmp_path / "lbf.parquet")
    assert done.returncode == 1 and "lbf" in done.stdout and "wrong unit" in done.stdout


def test_clean_tables_pass(log, tmp_path):
    sstl("segment", log, "--out", tmp_path / "t.parquet", "--phases", tmp_path / "p.parquet")
    done = sstl("check", log, tmp_path / "t.parquet", tmp_path / "p.parquet")
    assert done.returncode == 0, done.stdout
    assert "3 files: 0 failures" in done.stdout


def test_check_looks_into_theta_tables(log, tmp_path):
    sstl("segment", log, "--out", tmp_path / "t.parquet")
    table = open_table(tmp_path / "t.parquet", THETA).table()
    at = table.column_names.index("gamma_p_se")
    spoilt = table.set_column(at, table.schema.field(at), pa.array([-1.0, float("nan"), 0.1]))
    write_table(tmp_path / "bad.parquet", pa.concat_tables([spoilt, spoilt.slice(0, 1)]), THETA, ORIGIN)
    done = sstl("check", tmp_path / "bad.parquet", "--json")
    found = {f["what"]: f["count"] for f in json.loads(done.stdout)["findings"]}
    assert done.returncode == 1
    assert found == {"negative standard error": 2, "not a number": 1, "run comes twice": 2}


def test_info_shows_runs_provenance_and_a_loop(log):
    done = sstl("info", log)
    assert done.returncode == 0, done.stderr
    assert "run-2" in done.stdout and "made by: test" in done.stdout
    assert any("\u2800" < c <= "\u28ff" for c in done.stdout)
    document = json.loads(sstl("info", log, "--json").stdout)
    runs = document["files"][0]["runs"]
    assert [r["samples"] for r in runs] == [1200] * 3
    assert runs[0]["rate_hz"] == pytest.approx(100.0)
    assert runs[0]["in_max_n"] == pytest.approx(GOOD[0].tension_in_n.max())
    assert runs[0]["duration_s"] == pytest.approx(11.99)


def test_info_describes_theta(log, tmp_path):
    sstl("segment", log, "--out", tmp_path / "t.parquet")
    done = sstl("info", tmp_path / "t.parquet", "--json")
    ranges = json.loads(done.stdout)["files"][0]["ranges"]
    assert ranges["gamma_p"]["mean"] == pytest.approx(0.58, abs=0.01)
    assert ranges["status"]["counts"] == {"ok": 3}


@pytest.mark.parametrize("name", ["missing", "empty", "cut", "misspelt"])
def test_info_on_bad_files_fails_with_one_line(tmp_path, name):
    bad_files(tmp_path)
    done = sstl("info", tmp_path / f"{name}.parquet")
    assert done.returncode == 1 and len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("command", ["segment", "check", "info"])
def test_help_has_an_example_and_no_arguments_is_a_usage_error(command):
    done = sstl(command, "--help")
    assert done.returncode == 0 and f"Example: sstl {command}" in done.stdout
    assert sstl(command).returncode == 2


def test_hostile_names_do_not_reach_the_terminal_raw(tmp_path):
    evil = replace(GOOD[0], run_id="a\x1b[31mred\x07")
    write_runs(tmp_path / "evil.parquet", [evil], ORIGIN)
    for words in (["info"], ["check"], ["segment", "--out", tmp_path / "t.parquet"]):
        done = sstl(words[0], tmp_path / "evil.parquet", *words[1:])
        assert "\x1b[31m" not in done.stdout + done.stderr and "\x07" not in done.stdout + done.stderr


def test_info_imports_nothing_heavy(log):
    code = (
        "import sys; from sstl_cli.cli import app; sys.argv = ['sstl', 'info', sys.argv[1]]\n"
        "try:\n    app.main()\nexcept SystemExit:\n    pass\n"
        "heavy = {'numba', 'scipy', 'pandas', 'torch', 'matplotlib', 'sklearn'} & set(sys.modules)\n"
        "print('heavy:', sorted(heavy))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(log)], capture_output=True, text=True, timeout=60)
    assert "heavy: []" in done.stdout, done.stdout[-300:] + done.stderr
