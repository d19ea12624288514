"""Same input, seed and version: the same bytes in any folder, for any hash seed and any number of workers."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
from fuzz_seeds import theta_rows
from trust_program import write_csv

SCENARIO = "--scenario sample --effect quantisation --effect stribeck --seed 5"
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
        f"diagnose log.parquet --effects viscous,stribeck --max-effects 1 --workers {workers} --out diagnosis.json",
        "train pairs.parquet --out mapping.safetensors --variants linear,plain --seeds 2 --epochs 3 --history history.parquet",
        "evaluate mapping.safetensors --theta pairs.parquet --out evaluation.parquet",
        "report log.parquet theta.parquet diagnosis.json --out report.html",
        "export log.parquet --format csv --out log.csv",
        f"batch segment log.parquet imported.parquet --out-dir many --workers {workers}",
    )
    return [line.split() for line in lines]


def test_same_bytes_for_any_hash_seed_folder_and_number_of_workers(tmp_path: Path) -> None:
    running = []
    for seed, workers in (("0", 1), ("424242", 3)):
        folder = tmp_path / seed
        folder.mkdir()
        write_csv(folder / "r.csv")
        pq.write_table(pa.Table.from_pylist(theta_rows()), folder / "pairs.parquet")
        words = [sys.executable, "-c", SCRIPT, str(Path(__file__).parents[1]), json.dumps(commands(workers))]
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        running.append(subprocess.Popen(words, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True))
    told = [process.communicate(timeout=300)[1] for process in running]
    assert [p.returncode for p in running] == [0, 0], told
    first, second = (
        {str(p.relative_to(f)): p.read_bytes() for p in f.rglob("*") if p.is_file() and ".batch" not in p.parts}
        for f in (tmp_path / "0", tmp_path / "424242")
    )
    assert len(first) == 14 and sorted(first) == sorted(second)
    assert [name for name in first if first[name] != second[name]] == []
