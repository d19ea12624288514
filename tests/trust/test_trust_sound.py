"""Every command that reads a log meets the same rule for samples no recorder can give, and for pauses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from program import inside
from soon import asked
from trust_program import document, loop

from sstl_cli.core.tables import THETA

Columns = dict[str, np.ndarray]


def put(column: str, value: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        columns[column][100:103] = value

    return change


def pause(seconds: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        columns["time_s"][600:] += seconds

    return change


def scaled(factor: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        columns["tension_in_n"] *= factor
        columns["tension_out_n"] *= factor

    return change


def log(path: Path, change: Callable[[Columns], None]) -> Path:
    """A good run and one that is changed."""
    pieces = []
    for i, name in enumerate(("bad", "good")):
        columns = loop(1200, seed=i)
        if name == "bad":
            change(columns)
        pieces.append(pa.table({"run_id": [name] * 1200, "config_id": [name] * 1200, "system": ["act"] * 1200, **columns}))
    pq.write_table(pa.concat_tables(pieces, promote_options="default"), path)
    return path


def labelled(column: str, value: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        columns[column] = np.full(1200, 4.0)
        columns[column][slice(None) if column == "lead_mm" else slice(100, 103)] = value

    return change


BAD = {
    "inf": (put("tension_in_n", np.inf), 3, "3 infinite in tension_in_n"),
    "-inf": (put("tension_out_n", -np.inf), 3, "3 infinite in tension_out_n"),
    "nan": (put("tension_out_n", np.nan), 3, "3 not a number in tension_out_n"),
    "1e308": (put("tension_out_n", 1e308), 3, "3 beyond any sensor (over 1e+15) in tension_out_n"),
    "x1e307": (scaled(1e307), 1200, "beyond any sensor"),
    "denormal": (scaled(1e-320), 1200, "less than any sensor shows"),
    "position": (labelled("position_in_mm", np.inf), 3, "in position_in_mm, taken as not measured"),
    "reference": (labelled("tension_ref_n", 1e308), 3, "in tension_ref_n, taken as not measured"),
    "lead": (labelled("lead_mm", -np.inf), 0, "lead_mm is -inf, taken as not given"),
    "hour": (pause(3600.0), 0, "1 pause, the longest of 3600 s"),
    "epoch": (pause(1.7e9), 0, "1 pause, the longest of 1.7e+09 s"),
}
DIAGNOSE = ["diagnose", "--max-effects", "1", "--effects", "zero_offset"]
COMMANDS = [
    ["segment", "--out", "theta.parquet"],
    ["report", "--out", "r.html"],
    ["export", "--format", "csv", "--out", "l.csv"],
    ["export", "--format", "mcap", "--out", "l.mcap"],
    DIAGNOSE,
]


@pytest.mark.parametrize("name", BAD)
def test_commands_set_the_same_samples_aside(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    change, samples, why = BAD[name]
    path = log(tmp_path / "log.parquet", change)
    commands = COMMANDS if name in ("1e308", "epoch") else COMMANDS[:4]
    for words in commands:
        done = inside(words[0], path, *words[1:], "--json")
        assert done.returncode == 3, (words, done.stderr)
        assert sum(e["samples"] for e in document(done)["data_set_aside"]) == samples, words
        assert {e["run_id"] for e in document(done)["data_set_aside"]} == {"bad"} and why in " ".join(done.stderr.split())
    done = inside("info", path, "--json")
    assert done.returncode == (3 if samples or name == "lead" else 0)
    assert "1e+308" not in done.stdout and "Infinity" not in done.stdout
    done = inside("check", path, "--json")
    found = {f["what"] for f in document(done)["findings"] if f["level"] == "failure" and f["run_id"] == "bad"}
    assert done.returncode == 1 and found & {"infinite values", "not a number", "absurd values", "gaps"}


def test_a_log_of_nothing_but_such_runs_ends_in_one_line_that_says_why(tmp_path: Path) -> None:
    path = log(tmp_path / "log.parquet", scaled(1e307))
    table = pq.read_table(path)
    pq.write_table(table.slice(0, 1200), path)
    done = inside(*DIAGNOSE, path)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert "[E901]" in done.stderr and "1200 of 1200 samples" in done.stderr and "beyond any sensor" in done.stderr


def theta(path: Path, values: dict[str, float]) -> Path:
    """Rows of ten bends, the first two of which hold these values."""
    rows = []
    for i in range(10):
        for system in ("act", "sstl"):
            row = {"run_id": f"{i}{system}", "config_id": f"C{i}", "system": system, "gamma_p": 0.6 - 0.01 * i, "gamma_r": 1.5 + 0.01 * i}
            nothing = dict.fromkeys(c.name for c in THETA.columns if c.name not in row)
            errors = {"gamma_p_se": 0.01, "beta_p": 0.1, "beta_r": 0.1}
            rows.append({**nothing, **row, **errors, "loops": 1, "status": "ok", **(values if i == 0 else {})})
    table = pa.Table.from_pylist(rows, schema=THETA.arrow())
    pq.write_table(table.replace_schema_metadata({"sstl": '{"schema": "sstl.theta", "schema_version": 1}'}), path)
    return path


@pytest.mark.parametrize(
    ("name", "value"),
    asked(
        [*((n, v) for n in ("gamma_p", "beta_r") for v in (1e308, -1e308, np.inf)), *(("gamma_p", v) for v in (5e-324, 0.0, -1.0))],
        ("gamma_p", 1e308),
        ("beta_r", -1e308),
        ("beta_r", np.inf),
        ("gamma_p", 5e-324),
        ("gamma_p", -1.0),
        several=True,
    ),
)
def test_rows_of_theta_that_no_loop_can_have_go(name: str, value: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    table = theta(tmp_path / "theta.parquet", {name: value})
    train = ["train", table, "--seeds", "1", "--epochs", "1", "--variants", "linear", "--out", "m.safetensors"]
    commands = [["compensate", "--theta", table], ["export", table, "--out", "p.json"], ["evaluate", "--theta", table, "--tables"]]
    for words in [train, *commands]:
        done = inside(*words, "--json")
        assert done.returncode == 3 and name in done.stderr, (words, done.stderr)
        assert "e+30" not in done.stdout.replace(f"{value:g}, beyond any sensor", "")
    done = inside("check", table, "--json")
    assert done.returncode == 1 and {f["column"] for f in document(done)["findings"] if f["level"] == "failure"} == {name}
    done = inside("compensate", "--theta", table, "--config-id", "C0")
    assert done.returncode == 1 and "'C0' was set aside" in done.stderr and f"{name} is" in done.stderr
    assert "C0" not in (tmp_path / "p.json").read_text()
    (tmp_path / "p.json").write_text((tmp_path / "p.json").read_text().replace("0.59", "1e300", 1))
    done = inside("compensate", "--theta", "p.json")
    assert done.returncode == 1 and "[E401]" in done.stderr


@pytest.mark.each_once
@pytest.mark.parametrize(
    "values",
    [
        {"gamma_p": 1e308},
        {"beta_r": -1e308},
        {"gamma_p_se": 1e308},
        {"gamma_p_se": -0.1},
        {"gamma_r": np.inf},
        {"gamma_p": 5e-324},
        {"lead_mm": 1e308},
    ],
)
@pytest.mark.parametrize("command", ["report", "plot"])
def test_pictures_of_theta_leave_out_what_no_loop_can_have(values: dict[str, float], command: str, tmp_path: Path) -> None:
    table = theta(tmp_path / "theta.parquet", values)
    out = tmp_path / ("r.html" if command == "report" else "r.svg")
    done = inside(command, table, "--out", out, "--json")
    assert done.returncode == 3 and out.is_file(), done.stderr
    assert [e["run_id"] for e in document(done)["data_set_aside"]] == ["0act", "0sstl"]
    assert f"{next(iter(values))} is" in done.stderr and "taken as null" in done.stderr


@pytest.mark.parametrize("command", ["import", "check"])
@pytest.mark.parametrize("name", ["position_in_mm", "tension_ref_n", "lead_mm"])
def test_import_and_check_tell_what_is_lost_of_a_column_that_may_be_empty(command: str, name: str, tmp_path: Path) -> None:
    wild = range(1200) if name == "lead_mm" else (50, 51)
    numbers = enumerate(zip(*loop(1200).values(), strict=True))
    rows = [f"r,A,act,{t:.3f},{a},{b},{'inf' if k in wild else 4.0}" for k, (t, a, b) in numbers]
    path = tmp_path / "l.csv"
    path.write_text("\n".join([f"run_id,config_id,system,time_s,tension_in_n,tension_out_n,{name}", *rows]) + "\n")
    words = [path, "--out", tmp_path / "l.parquet"] if command == "import" else [path]
    done = inside(command, *words, "--json")
    if command == "check":
        assert done.returncode == 1
        found = {(f["what"], f["column"]): f["count"] for f in document(done)["findings"]}
        assert found["infinite values", name] == len(wild)
        return
    values = 1 if name == "lead_mm" else 2
    assert done.returncode == 3 and document(done)["values_set_aside"] == {name: values}
    assert f"of {name}, infinite or beyond any sensor" in " ".join(done.stderr.split())
    assert inside("segment", tmp_path / "l.parquet", "--out", tmp_path / "t.parquet").returncode == 0


def test_check_says_that_the_lead_changes_within_a_run(tmp_path: Path) -> None:
    columns = loop(1200)
    lead = np.where(np.arange(1200) < 700, 3.0, 9.0)
    labels = {"run_id": ["r"] * 1200, "system": ["act"] * 1200, "lead_mm": lead}
    pq.write_table(pa.table({**labels, **columns}), tmp_path / "l.parquet")
    done = inside("check", tmp_path / "l.parquet", "--json")
    found = [f for f in document(done)["findings"] if f["column"] == "lead_mm" and f["what"] == "label changes within the run"]
    assert done.returncode == 0 and len(found) == 1 and "3 to 9 mm" in found[0]["detail"]


def test_import_and_watch_count_absurd_values_too(tmp_path: Path) -> None:
    rows = [f"r,A,act,{t:.3f},{a},{b}" for t, a, b in zip(*loop(1200).values(), strict=True)]
    rows[50] = "r,A,act,0.500,1e308,3.0"
    (tmp_path / "l.csv").write_text("\n".join(["run_id,config_id,system,time_s,tension_in_n,tension_out_n", *rows]) + "\n")
    done = inside("import", tmp_path / "l.csv", "--out", tmp_path / "l.parquet")
    assert done.returncode == 3 and "1 samples, dropouts" in done.stderr
    done = inside("watch", tmp_path / "l.csv", "--once")
    assert done.returncode == 3 and "set aside: 1 (beyond any sensor or clock (over 1e+15))" in done.stderr


def test_info_tells_a_clock_faster_than_any_recorder(tmp_path: Path) -> None:
    """It printed a rate of inf, and no word."""

    def change(columns: Columns) -> None:
        columns["time_s"] *= 1e-310

    done = inside("info", log(tmp_path / "log.parquet", change), "--json")
    told = document(done).get("aside", done.stderr)
    assert done.returncode == 3 and "faster than any recorder" in " ".join(str(told).split()) and "good" not in str(told)


@pytest.mark.parametrize("factor", [1e-310, 1e300])
def test_ranges_of_absurd_runs_are_short(factor: float, tmp_path: Path) -> None:
    """They had 300 digits, or stood there as nan..nan."""
    done = inside("info", log(tmp_path / "log.parquet", scaled(factor)))
    row = next(line for line in done.stdout.splitlines() if line.startswith("bad "))
    assert done.returncode == 3 and len(row) < 100 and "nan" not in row


@pytest.mark.parametrize("command", ["import", "watch"])
def test_import_and_watch_tell_a_run_that_no_sensor_has_given(command: str, tmp_path: Path) -> None:
    """They ended with 0 where info and segment set it aside."""
    rows = [
        f"{name},act,{t:.3f},{factor * a},{factor * b}"
        for name, factor in (("bad", 1e-320), ("good", 1.0))
        for t, a, b in zip(*loop(1200).values(), strict=True)
    ]
    (tmp_path / "l.csv").write_text("\n".join(["run_id,system,time_s,tension_in_n,tension_out_n", *rows]) + "\n")
    words = [tmp_path / "l.csv", *(["--once"] if command == "watch" else ["--out", tmp_path / "l.parquet"])]
    done = inside(command, *words, "--json")
    assert done.returncode == 3 and "tension_in_n never exceeds" in done.stderr and "tension_out_n never exceeds" in done.stderr
    if command == "import":
        assert {e["run_id"] for e in document(done)["data_set_aside"]} == {"bad"}


def test_a_log_in_other_units_is_refused_by_all_that_compute_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They took kilonewtons for newtons, and only check said so."""
    monkeypatch.chdir(tmp_path)
    for column, unit, end in (("tension_in_n", "kN", 1), ("time_s", "ms", 1), ("tension_out_n", "mm", 0)):
        table = pq.read_table(log(tmp_path / "good.parquet", lambda _: None))
        at = table.schema.get_field_index(column)
        schema = table.schema.set(at, table.schema.field(at).with_metadata({"unit": unit}))
        pq.write_table(table.cast(schema), "log.parquet")
        assert inside("check", "log.parquet").returncode == end
        for words in (["segment", "--out", "t.parquet"], ["plot", "--out", "l.svg"], ["export", "-f", "csv", "--out", "l.csv"], DIAGNOSE):
            done = inside(words[0], "log.parquet", *words[1:], *(["--force"] if "--out" in words else []))
            assert done.returncode == 0 if not end else (done.returncode == 1 and "[E129]" in done.stderr and unit in done.stderr), done
        if unit == "kN":
            assert inside("import", "log.parquet", "--out", "n.parquet").returncode == 0
            assert pq.read_table("n.parquet")["tension_in_n"][0].as_py() == pytest.approx(1000 * table["tension_in_n"][0].as_py())
