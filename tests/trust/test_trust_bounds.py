"""What the fuzzer found: a column twice, bytes that are no text, a reference of endless length."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
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
