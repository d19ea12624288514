"""Same input, seed and version: the same bytes in any folder, for any hash seed and any number of workers."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fuzz_seeds import theta_rows
from program import inside
from trust_program import write_csv

SCENARIO = "--scenario sample --effect quantisation --effect stribeck --seed 5"
SEED = "424242"
# one process for all of them: a start costs more than the work
SCRIPT = """
import json, sys
sys.path.insert(0, sys.argv[1])
from program import inside
for words in json.loads(sys.argv[2]):
    done = inside(*words)
    assert done.returncode in (0, 3), (words, done.stderr)
"""


def commands(workers: int) -> list[list[str]]:
    """Return a chain over every kind of output."""
    lines = (
        f"simulate {SCENARIO} --out log.parquet",
        "import r.csv --out imported.parquet",
        "segment log.parquet --out theta.parquet --phases phases.parquet",
        f"diagnose log.parquet --effects viscous,zero_offset --max-effects 1 --workers {workers} --out diagnosis.json",
        "train pairs.parquet --out mapping.safetensors --variants linear,plain --seeds 2 --epochs 3 --history history.parquet",
        "evaluate mapping.safetensors --theta pairs.parquet --out evaluation.parquet",
        "report log.parquet theta.parquet diagnosis.json --out report.html",
        "export log.parquet --format csv --out log.csv",
        f"batch segment log.parquet imported.parquet --out-dir many --workers {workers}",
    )
    return [line.split() for line in lines]


@pytest.mark.slow
def test_same_bytes_for_any_hash_seed_folder_and_number_of_workers(tmp_path: Path) -> None:
    for name in ("here", "apart"):
        folder = tmp_path / name
        folder.mkdir()
        write_csv(folder / "r.csv")
        pq.write_table(pa.Table.from_pylist(theta_rows()), folder / "pairs.parquet")
    # a process that has just started against this one, whose hash seed is drawn anew and which has run other tests
    assert os.environ.get("PYTHONHASHSEED") != SEED
    words = [sys.executable, "-c", SCRIPT, str(Path(__file__).parents[1]), json.dumps(commands(3))]
    environment = {**os.environ, "PYTHONHASHSEED": SEED}
    done = subprocess.run(words, cwd=tmp_path / "apart", env=environment, stderr=subprocess.PIPE, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    for line in commands(1):
        told = inside(*line, cwd=tmp_path / "here")
        assert told.returncode in (0, 3), (line, told.stderr)
    first, second = (
        {str(p.relative_to(f)): p.read_bytes() for p in f.rglob("*") if p.is_file() and ".batch" not in p.parts}
        for f in (tmp_path / "here", tmp_path / "apart")
    )
    assert len(first) == 14 and sorted(first) == sorted(second)
    assert [name for name in first if first[name] != second[name]] == []
