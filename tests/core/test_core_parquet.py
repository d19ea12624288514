"""Tables with a schema: every way in which a file does not fit is one clear line."""

from __future__ import annotations

import dataclasses
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import TableWriter, open_table, schema_id_of, write_table
from sstl_cli.core.provenance import Provenance, inputs_of, sha256
from sstl_cli.core.runs import Run, read_logs, write_runs
from sstl_cli.core.tables import COMMAND, EVALUATION, LOG, PHASES, SCHEMAS, SCORE, THETA, Column
from sstl_cli.steps import check

MADE = Provenance("sstl test", 1)


def phases(n: int = 3) -> pa.Table:
    return pa.table({"run_id": ["a"] * n, "time_s": [0.1 * i for i in range(n)], "phase": ["PP"] * n})


def write_raw(path: Path, columns: dict, **metadata: object) -> Path:
    """Write as a foreign program would; ``metadata`` goes under the key ``sstl``."""
    import json

    table = pa.table(columns)
    if metadata:
        table = table.replace_schema_metadata({"sstl": json.dumps(metadata)})
    pq.write_table(table, path)
    return path


def test_units_and_schema_stand_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    write_table(path, phases(), PHASES, MADE)
    arrow = pq.read_schema(path)
    assert arrow.field("time_s").metadata[b"unit"] == b"s"
    assert schema_id_of(path) == "sstl.phases"
    reader = open_table(path, PHASES)
    assert reader.rows == 3 and reader.table().to_pydict() == phases().to_pydict()


def test_log_has_the_columns_of_the_contract() -> None:
    assert LOG.names == [
        "run_id", "config_id", "system", "location", "lead_mm", "trajectory",
        "time_s", "tension_in_n", "tension_out_n", "position_in_mm", "tension_ref_n",
    ]  # fmt: skip
    assert LOG.required == ["run_id", "system", "time_s", "tension_in_n", "tension_out_n"]
    assert set(SCHEMAS) == {s.id for s in (LOG, THETA, PHASES, COMMAND, SCORE, EVALUATION)}


def test_missing_column_names_the_nearest(tmp_path: Path) -> None:
    path = write_raw(tmp_path / "p.parquet", {"run_id": ["a"], "time": [0.0], "phase": ["PP"]})
    with pytest.raises(SstlError, match="E134.*'time_s'.*did you mean 'time'"):
        open_table(path, PHASES)


def test_every_missing_column_is_listed(tmp_path: Path) -> None:
    path = write_raw(tmp_path / "p.parquet", {"x": [1.0]})
    with pytest.raises(SstlError) as caught:
        open_table(path, PHASES)
    assert all(f"'{name}'" in caught.value.line() for name in PHASES.names)


def test_wrong_type_says_which_and_how_to_write_it(tmp_path: Path) -> None:
    path = write_raw(tmp_path / "p.parquet", {"run_id": ["a"], "time_s": ["soon"], "phase": ["PP"]})
    with pytest.raises(SstlError, match="E135.*'time_s' holds string, not double.*in s"):
        open_table(path, PHASES).table()


def test_empty_value_in_a_required_column(tmp_path: Path) -> None:
    path = write_raw(tmp_path / "p.parquet", {"run_id": ["a", "a"], "time_s": [0.0, None], "phase": ["PP", "PP"]})
    with pytest.raises(SstlError, match="E136.*'time_s' has 1 empty"):
        open_table(path, PHASES).table()


def test_integers_and_float32_are_taken_as_numbers(tmp_path: Path) -> None:
    columns = {"run_id": ["a"], "time_s": pa.array([2], pa.int32()), "phase": ["PP"], "mine": [7]}
    table = open_table(write_raw(tmp_path / "p.parquet", columns), PHASES).table()
    assert table.column("time_s").to_pylist() == [2.0] and table.column("mine").to_pylist() == [7]


def test_other_schema_and_other_version(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    write_table(path, phases(), PHASES, MADE)
    with pytest.raises(SstlError, match=r"E131.*'sstl\.phases', not 'sstl\.log'; give"):
        open_table(path, LOG)
    newer = dataclasses.replace(PHASES, version=2)
    with pytest.raises(SstlError, match="E132.*version 1, this program reads version 2"):
        open_table(path, newer)


@pytest.mark.parametrize("body", [b"", b"PAR1", b"run_id,time_s\na,0\n", b"\x00" * 4096, b"PAR1" + b"\xff" * 64 + b"PAR1"])
def test_not_parquet(tmp_path: Path, body: bytes) -> None:
    path = tmp_path / "p.parquet"
    path.write_bytes(body)
    with pytest.raises(SstlError, match=r"E130.*(sstl import|make it again|give a table that)"):
        open_table(path, LOG)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(SstlError, match="E130.*not found"):
        open_table(tmp_path / "none.parquet", LOG)
    with pytest.raises(SstlError, match="E130.*folder"):
        open_table(tmp_path, LOG)


def test_truncated_or_damaged_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    write_table(path, phases(2000), PHASES, MADE)
    whole = path.read_bytes()
    for cut in range(0, len(whole), max(1, len(whole) // 40)):
        path.write_bytes(whole[:cut])
        with pytest.raises(SstlError):
            open_table(path, PHASES).table()
    # the data pages, not the footer: found while reading
    path.write_bytes(whole[:4] + b"\xff" * 200 + whole[204:])
    with pytest.raises(SstlError, match="E13"):
        open_table(path, PHASES).table()


def test_empty_table_is_a_table(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    write_table(path, PHASES.arrow().empty_table(), PHASES, MADE)
    assert open_table(path, PHASES).table().num_rows == 0


def test_short_pieces_share_a_row_group(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    lengths = [2] * 1000 + [300, 2, 300]
    with TableWriter(path, PHASES, MADE) as writer:
        for n in lengths:
            writer.write(phases(n))
    made = pq.ParquetFile(path).metadata
    # two thousand rows of short pieces, and what begins with a piece of some length, in the order written
    assert [made.row_group(i).num_rows for i in range(made.num_row_groups)] == [256] * 7 + [208, 300, 2, 300]
    assert open_table(path, PHASES).table().column("time_s").to_pylist() == [0.1 * i for n in lengths for i in range(n)]


def test_error_while_writing_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), TableWriter(tmp_path / "p.parquet", PHASES, MADE) as writer:
        writer.write(phases())
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_extra_columns_keep_their_unit(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    table = phases(1).append_column("t_n", pa.array([1.5]))
    write_table(path, table, PHASES, MADE, extra=[Column("t_n", pa.float64(), "N")])
    assert pq.read_schema(path).field("t_n").metadata[b"unit"] == b"N"


def test_malformed_provenance_is_no_reason_to_fail(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    for text in ("{", "[1]", "null", "[" * 20_000 + "]" * 20_000):
        pq.write_table(phases().replace_schema_metadata({"sstl": text}), path)
        assert schema_id_of(path) is None and open_table(path, PHASES).rows == 3


def test_provenance_holds_what_made_it_and_nothing_else(tmp_path: Path) -> None:
    import json

    source = tmp_path / "in.bin"
    source.write_bytes(b"abc")
    body = json.loads(Provenance("sstl x", 3, inputs_of([source])).metadata("sstl.log", 1)["sstl"])
    assert body.pop("package_version")
    # FIPS 180-2, appendix B.1
    digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    expected = {"schema": "sstl.log", "schema_version": 1, "command": "sstl x", "seed": 3, "extra": {}}
    assert body == {**expected, "inputs": {"in.bin": digest}} and sha256(source) == digest


def test_same_rows_same_bytes_in_any_folder(tmp_path: Path) -> None:
    files = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        source = tmp_path / name / "in.bin"
        source.write_bytes(b"abc")
        files.append(tmp_path / name / "p.parquet")
        write_table(files[-1], phases(1000), PHASES, Provenance("sstl x", 3, inputs_of([source])))
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_pipe_is_no_table(tmp_path):
    """Opening one waited for its writer, and no signal ended that."""
    import os

    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(SstlError, match="no regular file"):
        open_table(tmp_path / "pipe", LOG)


def test_a_page_that_lost_a_bit_is_no_table(tmp_path: Path) -> None:
    """Without a checksum numbers that are one bit off read as numbers."""
    path = tmp_path / "p.parquet"
    # numbers that do not compress, so that every byte of the page is one of theirs
    table = phases(2000).set_column(1, "time_s", pa.array([(k * 0.6180339887) % 1.0 for k in range(2000)]))
    write_table(path, table, PHASES, MADE)
    column = pq.ParquetFile(path).metadata.row_group(0).column(1)
    middle = column.data_page_offset + column.total_compressed_size // 2
    whole = path.read_bytes()
    assert open_table(path, PHASES).table().num_rows == 2000
    path.write_bytes(whole[:middle] + bytes([whole[middle] ^ 4]) + whole[middle + 1 :])
    with pytest.raises(SstlError, match="E133.*is damaged.*copy it again"):
        open_table(path, PHASES).table()


# Thrift's compact form: the kind of a column (double, bytes) as one that the schema does not know it as, and sizes for a level that
# a plain column has not
FOOTERS = {
    "kind of numbers": (rb"\x15\x0a(?=\x19)", b"\x15\x1a", "E133"),
    "kind of texts": (rb"\x15\x0c(?=\x19)", b"\x15\x0e", ""),
    "sizes": (rb"(\x3c\x16[\x80-\xff]*[\x00-\x7f]\x19)\x06(?=\x19)", b"\\g<1>\x26", "E133"),
}

ONE_AFTER_THE_OTHER = """
import json, sys
from sstl_cli.cli._batch_worker import call_program
for words in json.loads(sys.argv[1]):
    print(json.dumps(call_program(words, {})), flush=True)
"""


@pytest.mark.parametrize("what", [pytest.param(w, marks=pytest.mark.slow) if w == "sizes" else w for w in FOOTERS])
def test_a_footer_that_lost_a_bit_does_not_end_the_process(what: str, tmp_path: Path) -> None:
    """Arrow's own C++ ended it where statistics were asked for that the footer made impossible."""
    path = tmp_path / "log.parquet"
    steps = np.arange(300) * 0.01
    runs = [Run(name, "act", steps, 5.0 - 4.0 * np.cos(steps), 3.0 - 2.0 * np.cos(steps)) for name in ("a", "b")]
    write_runs(path, runs, MADE)
    whole, (old, new, code) = path.read_bytes(), FOOTERS[what]
    start = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    footer, struck = re.subn(old, new, whole[start:], count=1)
    assert struck and len(footer) == len(whole) - start
    path.write_bytes(whole[:start] + footer)
    every = (["check"], ["segment", "--out", str(tmp_path / "theta")], ["export", "-f", "csv", "--out", str(tmp_path / "log.csv")])
    given = json.dumps([[*words, str(path)] for words in every])
    # one after the other in one process, which starts once
    done = subprocess.run([sys.executable, "-c", ONE_AFTER_THE_OTHER, given], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "terminate" not in done.stderr, done.stderr
    for words, (returned, _, said) in zip(every, map(json.loads, done.stdout.splitlines()), strict=True):
        assert returned in (0, 1), said
        assert not code or words == ["check"] or f"[{code}]" in said
    assert not list(tmp_path.glob(".*"))
    if not code:
        # the pages are whole: what they hold is read without the help of statistics
        assert [r.run_id for r in read_logs([path])] == ["a", "b"]


def test_bytes_that_are_no_text_are_a_finding_of_check(tmp_path: Path) -> None:
    bad = pa.StringArray.from_buffers(3, pa.py_buffer(np.arange(4, dtype=np.int32)), pa.py_buffer(b"\xff" * 3))
    for column, schema, other in (("run_id", LOG, "system"), ("system", LOG, "run_id"), ("config_id", THETA, "run_id")):
        whole = pa.Table.from_pylist([{other: "act"}] * 3, schema=pa.schema([f.with_nullable(True) for f in schema.arrow()]))
        table = whole.set_column(whole.column_names.index(column), column, bad)
        pq.write_table(table.replace_schema_metadata({"sstl": json.dumps({"schema": schema.id, "schema_version": 1})}), tmp_path / "t")
        reader = open_table(tmp_path / "t", replace(schema, columns=()))
        found = [e.finding for e in check.run(reader, schema, lambda _: None)]
        assert [f.what for f in found if "UTF8" in f.detail] == ["unreadable"], found


@pytest.mark.parametrize("column", LOG.required)
def test_a_required_column_that_holds_nothing_is_a_finding_of_check(column: str, tmp_path: Path) -> None:
    """It was sound, and what segment refused it for said that check lists it."""
    steps = np.arange(300) * 0.01
    write_runs(tmp_path / "good", [Run("a", "act", steps, 5.0 - 4.0 * np.cos(steps), 3.0 - 2.0 * np.cos(steps))], MADE)
    table = pq.read_table(tmp_path / "good")
    pq.write_table(table.set_column(table.column_names.index(column), column, pa.nulls(300)), tmp_path / "t")
    found = list(check.run(open_table(tmp_path / "t", replace(LOG, columns=())), LOG, lambda _: None))
    assert ("empty values", column) in {(e.finding.what, e.finding.column) for e in found if e.finding.level == "failure"}
    with pytest.raises(SstlError, match="E136"):
        read_logs([tmp_path / "t"])
