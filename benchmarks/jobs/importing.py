"""A CSV of 200 MB (75 runs of 60 000 samples) into a log table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

from benchmarks.harness import Row, faster, seconds
from sstl_cli.core.provenance import Provenance, inputs_of
from sstl_cli.core.runs import write_runs
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps import import_ as step

RUN = 60_000


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare with pyarrow reading the CSV and writing the Parquet: block by block, and whole in memory."""
    rows, repeat = (4 * RUN, 1) if quick else (75 * RUN, 5)
    source, out = folder / "log.csv", folder / "log.parquet"
    _write(source, rows)

    def ours() -> None:
        found = step.run([source], Mapping())
        write_runs(out, found.runs, Provenance("benchmark", None, inputs_of([source])), force=True)

    def blocks() -> None:
        with pc.open_csv(source) as reader, pq.ParquetWriter(folder / "peer.parquet", reader.schema) as writer:
            for batch in reader:
                writer.write_batch(batch)

    def whole() -> None:
        pq.write_table(pc.read_csv(source), folder / "peer.parquet")

    ours()
    assert pq.read_metadata(out).num_rows == rows
    own, peer, held = [], [], []
    for _ in range(repeat):
        own.append(seconds(ours))
        peer.append(seconds(blocks))
        held.append(seconds(whole))
    job = f"import {source.stat().st_size / 1e6:.0f} MB of CSV"
    times = {"ours": min(own), "peer": min(peer)}
    return [
        Row(
            "importing/blocks",
            job,
            "time of pyarrow reading the CSV and writing the Parquet, block by block",
            1.3,
            faster(peer, own),
            at_least=False,
            seconds=times,
            note="ours checks, repairs, counts and hashes as well",
        ),
        Row(
            "importing/whole",
            job,
            "the same with the whole table in memory",
            1.3,
            faster(held, own),
            at_least=False,
            seconds={"ours": min(own), "peer": min(held)},
        ),
    ]


def _write(path: Path, rows: int) -> None:
    rng = np.random.default_rng(0)
    time = np.arange(rows) * 0.002
    tension = np.round(10 - 8 * np.cos(time) + rng.normal(0, 0.02, rows), 6)
    columns = {
        "time_s": np.round(time, 3),
        "tension_in_n": tension,
        "tension_out_n": np.round(0.7 * tension + rng.normal(0, 0.02, rows), 6),
        "system": pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int8)), pa.array(["act"])).cast(pa.string()),
        "run_id": pa.array([f"r{i // RUN:05d}" for i in range(rows)]),
    }
    pc.write_csv(pa.table(columns), path)
