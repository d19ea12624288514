"""One good file of every kind that the program reads back, made with pyarrow and the program's own commands."""

from __future__ import annotations

import json
import struct
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from program import inside
from trust_program import write_log

MAPPING = b"""[constants]
system = "act"
lead_mm = 40.0
[columns.time_s]
column = "t"
unit = "ms"
[columns.tension_in_n]
column = "a"
[repair]
min_samples = 20
"""
CONFIG = b"""seed = 3
ransac-trials = 32
[segment]
cutoff-hz = 20.0
prominence-n = 1.0
"""


@cache
def seed_of(kind: str) -> bytes:
    """Return a good file of a kind."""
    if kind == "mapping":
        return MAPPING
    if kind == "config":
        return CONFIG
    if kind == "scenario":
        from importlib import resources

        return (resources.files("sstl_cli.physics") / "scenarios" / "default.toml").read_bytes()
    with tempfile.TemporaryDirectory() as name:
        return _MADE[kind](Path(name))


@cache
def table_of(kind: str) -> pa.Table:
    """Return the good table of a kind, for mutations of its columns."""
    return pq.read_table(pa.BufferReader(seed_of(kind)))


def _read_log(folder: Path) -> bytes:
    return write_log(folder / "log.parquet", runs=2, samples=400).read_bytes()


def _segment(folder: Path, out: str) -> bytes:
    log = write_log(folder / "log.parquet", runs=2, samples=800)
    done = inside("segment", log, "--out", folder / "theta", "--phases", folder / "phases")
    assert done.returncode == 0, done.stderr
    return (folder / out).read_bytes()


def _controller(folder: Path) -> bytes:
    lines = {"gamma_p": 0.58, "beta_p": 0.1, "gamma_r": 1.7, "beta_r": -0.1}
    entry = {"config_id": "a", "method": "DI", "theta": lines}
    return json.dumps({"schema": "sstl.controller/1", "options": {}, "configurations": [entry]}).encode()


def _reference(folder: Path) -> bytes:
    time = np.arange(300) * 0.02
    pq.write_table(pa.table({"time_s": time, "tension_ref_n": 10 + 5 * np.sin(time)}), folder / "r")
    return (folder / "r").read_bytes()


def _diagnosis(folder: Path) -> bytes:
    log = write_log(folder / "log.parquet", runs=2, samples=600)
    words = ("--effects", "viscous,const_friction", "--max-effects", "1", "--out", folder / "d.json")
    done = inside("diagnose", log, *words)
    assert done.returncode in (0, 3), done.stderr
    return (folder / "d.json").read_bytes()


def theta_rows(configurations: int = 24) -> list[dict[str, Any]]:
    """Return the rows of a Theta table in which gamma_sstl is gamma_act squared."""
    rng = np.random.default_rng(0)
    rows = []
    for i in range(configurations):
        theta = rng.uniform(0.3, 0.9)
        for system, n in (("act", 1), ("sstl", 2)):
            lines = {"gamma_p": float(np.exp(-n * theta)), "gamma_r": float(np.exp(n * theta)), "beta_p": 0.1, "beta_r": -0.1}
            errors = {k + "_se": 0.01 for k in lines}
            label = {"run_id": f"{system}{i}", "config_id": f"c{i}", "system": system, "location": "CP"}
            quality = {"inlier_p": 1.0, "inlier_r": 1.0, "rmse_p_n": 0.1, "rmse_r_n": 0.1, "lead_mm": float(i)}
            rows.append({**label, **lines, **errors, **quality, "loops": 3, "status": "ok"})
    return rows


def _model(folder: Path) -> bytes:
    pq.write_table(pa.Table.from_pylist(theta_rows()), folder / "t.parquet")
    out = folder / "m.safetensors"
    done = inside("train", folder / "t.parquet", "--out", out, "--variants", "linear,plain", "--seeds", 1, "--epochs", 2)
    assert out.exists(), done.stderr
    return out.read_bytes()


def split_model(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the JSON header of a safetensors file and what follows it."""
    (length,) = struct.unpack("<Q", data[:8])
    return json.loads(data[8 : 8 + length]), data[8 + length :]


def join_model(header: bytes, rest: bytes) -> bytes:
    """Return a safetensors file."""
    return struct.pack("<Q", len(header)) + header + rest


_MADE = {
    "log": _read_log,
    "theta": lambda folder: _segment(folder, "theta"),
    "phases": lambda folder: _segment(folder, "phases"),
    "reference": _reference,
    "controller": _controller,
    "diagnosis": _diagnosis,
    "model": _model,
}
