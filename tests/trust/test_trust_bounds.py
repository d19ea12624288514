"""What the fuzzer found: a column twice, bytes that are no text, a reference of endless length, numbers at their ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from program import inside
from trust_program import write_log

from sstl_cli.control import reference_file
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import read_runs


def test_a_column_twice(tmp_path: Path) -> None:
    log = pq.read_table(write_log(tmp_path / "a.parquet"))
    pq.write_table(log.append_column("tension_in_n", log.column("tension_in_n")), tmp_path / "b.parquet")
    with pytest.raises(SstlError, match=r"E137.*tension_in_n.*2 times"):
        list(read_runs(tmp_path / "b.parquet"))


def test_text_that_is_none(tmp_path: Path) -> None:
    log = pq.read_table(write_log(tmp_path / "a.parquet", runs=1, samples=50))
    wrong = pa.Array.from_buffers(pa.string(), 1, [None, pa.py_buffer(np.array([0, 2], np.int32)), pa.py_buffer(b"\xff\xfe")])
    column = pa.concat_arrays([wrong] * 50)
    pq.write_table(log.set_column(log.column_names.index("run_id"), "run_id", column), tmp_path / "b.parquet")
    with pytest.raises(SstlError, match="E13[35]"):
        list(read_runs(tmp_path / "b.parquet"))


@pytest.mark.parametrize("end", [1e300, 1e12, 1e-9])
def test_a_reference_of_any_length(end: float, tmp_path: Path) -> None:
    pq.write_table(pa.table({"time_s": [0.0, end], "tension_ref_n": [1.0, 2.0]}), tmp_path / "r.parquet")
    with pytest.raises(SstlError, match="E407"):
        reference_file.read(tmp_path / "r.parquet", 0.01)


def test_a_reference_column_that_is_no_number_or_twice(tmp_path: Path) -> None:
    time = pa.array([0.0, 1.0])
    for i, table in enumerate(
        (
            pa.table({"time_s": time, "tension_ref_n": [[1.0], [2.0]]}),
            pa.table([time, time, time], names=["time_s", "tension_ref_n", "time_s"]),
        )
    ):
        pq.write_table(table, tmp_path / f"{i}.parquet")
        with pytest.raises(SstlError, match="E407"):
            reference_file.read(tmp_path / f"{i}.parquet", 0.01)


NUMBERS = [
    ("segment log.parquet --out x --cutoff-hz 5e-324", 2, "E210"),
    ("compensate --theta theta.parquet --dt 5e-324", 2, "E403"),
    ("compensate --theta theta.parquet --dt 1e308", 2, "E403"),
    ("compensate --theta theta.parquet --dt 50000", 1, "E407"),
    ("compensate --theta theta.parquet --reference random --dt 50000", 1, "E407"),
    # half a billion samples would take the memory of the machine
    ("compensate --theta theta.parquet --cycles 10000", 1, "E407"),
    ("compensate --theta theta.parquet --reference trapezoid --dt 1e-6", 1, "E407"),
    ("export theta.parquet --format c --real float --dt 5e-324 --out x.c", 2, "E403"),
    ("export theta.parquet --format c --real float --t-max 1e300 --out x.c", 2, "E403"),
]


@pytest.mark.parametrize(("line", "code", "said"), NUMBERS)
def test_options_at_the_ends_of_the_numbers(line: str, code: int, said: str, tmp_path: Path) -> None:
    write_log(tmp_path / "log.parquet", runs=1)
    assert inside("segment", "log.parquet", "--out", "theta.parquet", cwd=tmp_path).returncode == 0
    done = inside(*line.split(), cwd=tmp_path)
    assert done.returncode == code and f"[{said}]" in done.stderr and done.stderr.count("sstl: ") == 1, done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.parquet", "theta.parquet"]


SCENARIO = """simulator = "transmission"
[[configurations]]
id = "20"
{configuration}
[[trajectories]]
kind = "sinusoid"
systems = ["act"]
duration_s = 2.0
{trajectory}
"""


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("configuration", "trajectory", "said"),
    [
        ("theta = 0.5", "frequency_hz = 1e308", "E723"),
        ("theta = 0.5", "speed = 5e-324", "E711"),
        ("act = { gamma_p = 0.6, beta_p = 1e308, gamma_r = 1.4, beta_r = 0.0 }", "", "E723"),
        ("act = { gamma_p = 0.6, beta_p = 0.0, gamma_r = 1e300, beta_r = 1e300 }", "", "E723"),
    ],
)
def test_a_scenario_at_the_ends_of_the_numbers(configuration: str, trajectory: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(SCENARIO.format(configuration=configuration, trajectory=trajectory))
    done = inside("simulate", "--scenario", "s.toml", "--out", "x.parquet", cwd=tmp_path)
    assert done.returncode == 1 and f"[{said}]" in done.stderr, done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["s.toml"]
