"""The program as a user starts it, and small logs made without it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

SSTL = [sys.executable, "-m", "sstl_cli"]


def sstl(*words: object, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run ``sstl`` in a process of its own."""
    return subprocess.run(
        [*SSTL, *map(str, words)], capture_output=True, text=True, cwd=cwd, env={**os.environ, **environment}, timeout=120, check=False
    )


def document(done: subprocess.CompletedProcess[str]) -> Any:
    """Return the JSON document of a run with ``--json``."""
    return json.loads(done.stdout)


def loop(samples: int = 1200, gamma_p: float = 0.6, gamma_r: float = 1.6, seed: int = 0) -> dict[str, np.ndarray]:
    """Return time, input and output of a hysteresis loop by the plain play recursion, with noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(samples) * 0.01
    pull = 5.0 - 4.0 * np.cos(2 * np.pi * time / 4.0)
    out = np.empty(samples)
    held = gamma_p * pull[0]
    for k, tension in enumerate(pull):
        held = min(max(held, gamma_p * tension), gamma_r * tension)
        out[k] = held
    noise = rng.normal(0, 0.02, (2, samples))
    return {"time_s": time, "tension_in_n": pull + noise[0], "tension_out_n": out + noise[1]}


def write_log(path: Path, runs: int = 2, samples: int = 1200, seed: int = 0, names: list[str] | None = None) -> Path:
    """Write a log of ``runs`` loops with pyarrow alone."""
    pieces = []
    for i in range(runs):
        columns = loop(samples, seed=seed * 1000 + i)
        label = names[i] if names else f"run-{i}"
        n = len(columns["time_s"])
        pieces.append(pa.table({"run_id": [label] * n, "system": ["act"] * n, **columns}))
    pq.write_table(pa.concat_tables(pieces), path)
    return path


def write_csv(path: Path, samples: int = 1200, seed: int = 0) -> Path:
    """Write a recording as CSV in the columns of the log table."""
    columns = loop(samples, seed=seed)
    rows = zip(*columns.values(), strict=True)
    text = "".join(f"r{seed},act,{t:.6f},{a:.6f},{b:.6f}\n" for t, a, b in rows)
    path.write_text("run_id,system,time_s,tension_in_n,tension_out_n\n" + text)
    return path
