"""Mutated files of every kind the program reads back: the answer is a value or one SstlError, soon and small.

As a script: ``python tests/trust/fuzz_readers.py KIND|all COUNT [FIRST]``.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from trust_program import inside, write_log

from sstl_cli.core.errors import SstlError

MAX_SECONDS = 10.0
MAX_BYTES = 6 << 30
_WILD = [b"\xff" * 8, b"\x00" * 8, b"\x7f\xff\xff\xff", b"1e999", b"[[[[[[[[", b'{"a":', b"nan", b"\n", b'"', b"-1", b"99999999999999"]


def _log(path: Path) -> None:
    from sstl_cli.core.runs import read_runs

    for _ in read_runs(path):
        pass


def _theta(path: Path) -> None:
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import THETA

    open_table(path, THETA).table()


def _scenario(path: Path) -> None:
    from sstl_cli.physics.scenario import load

    load(str(path))


def _mapping(path: Path) -> None:
    from sstl_cli.importers.mapping import read_mapping

    read_mapping(path)


def _json(path: Path) -> None:
    from sstl_cli.reporting.load import load

    load([path])


def _model(path: Path) -> None:
    from sstl_cli.mapping import load_model

    load_model(path)


READERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "log": (".parquet", _log),
    "theta": (".parquet", _theta),
    "scenario": (".toml", _scenario),
    "mapping": (".toml", _mapping),
    "json": (".json", _json),
    "model": (".safetensors", _model),
}


@cache
def seed_of(kind: str) -> bytes:
    """Return a good file of a kind."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if kind == "scenario":
            from importlib import resources

            return (resources.files("sstl_cli.physics") / "scenarios" / "default.toml").read_bytes()
        if kind == "mapping":
            return (
                b'[constants]\nsystem = "act"\nlead_mm = 40.0\n[columns.time_s]\nsource = "t"\nunit = "ms"\n'
                b'[columns.tension_in_n]\nsource = "a"\n[repair]\non_gap = "split"\n'
            )
        log, theta = write_log(folder / "log.parquet", runs=2, samples=800), folder / "theta.parquet"
        if kind == "log":
            return log.read_bytes()
        if kind == "model":
            return _trained(folder)
        done = inside("segment", log, "--out", theta, "--json")
        return theta.read_bytes() if kind == "theta" else done.stdout.encode()


def _trained(folder: Path) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    rng = np.random.default_rng(0)
    rows = []
    for i in range(24):
        theta = rng.uniform(0.3, 0.9)
        for system, n in (("act", 1), ("sstl", 2)):
            lines = {"gamma_p": float(np.exp(-n * theta)), "gamma_r": float(np.exp(n * theta)), "beta_p": 0.1, "beta_r": -0.1}
            errors = {k + "_se": 0.01 for k in lines}
            label = {"run_id": f"{system}{i}", "config_id": f"c{i}", "system": system, "location": "CP"}
            quality = {"inlier_p": 1.0, "inlier_r": 1.0, "rmse_p_n": 0.1, "rmse_r_n": 0.1, "lead_mm": float(i)}
            rows.append({**label, **lines, **errors, **quality, "loops": 3, "status": "ok"})
    pq.write_table(pa.Table.from_pylist(rows), folder / "t.parquet")
    out = folder / "m.safetensors"
    done = inside("train", folder / "t.parquet", "--out", out, "--variants", "linear,plain", "--seeds", 1, "--epochs", 2)
    assert out.exists(), done.stderr
    return out.read_bytes()


def mutated(kind: str, number: int) -> bytes:
    """Return input ``number`` of a kind, the same in every run."""
    data = bytearray(seed_of(kind))
    rng = np.random.default_rng([number, *kind.encode()])
    for _ in range(int(rng.integers(1, 5))):
        if not data:
            break
        spot = int(rng.integers(0, len(data)))
        # headers and footers decide how the rest is read
        spot = (spot, spot % 300, max(0, len(data) - 1 - spot % 600))[int(rng.integers(0, 3))]
        length, how = int(rng.integers(1, 40)), int(rng.integers(0, 6))
        if how == 0:
            data[spot] ^= 1 << int(rng.integers(0, 8))
        elif how == 1:
            data[spot : spot + length] = rng.integers(0, 256, length, dtype=np.uint8).tobytes()
        elif how == 2:
            del data[spot:]
        elif how == 3:
            del data[spot : spot + length]
        elif how == 4:
            data[spot:spot] = data[spot : spot + length] * int(rng.integers(1, 20))
        else:
            wild = _WILD[int(rng.integers(0, len(_WILD)))]
            data[spot : spot + len(wild)] = wild
    return bytes(data)


def fuzz(kind: str, count: int, first: int = 0) -> dict[str, int]:
    """Read mutated files; anything but a value or an SstlError raises, and so does more than 10 s."""
    suffix, read = READERS[kind]
    answers = {"read": 0, "refused": 0}
    seed_of(kind)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"fuzz{suffix}"
        for number in range(first, first + count):
            path.write_bytes(mutated(kind, number))
            started = time.monotonic()
            try:
                read(path)
                answers["read"] += 1
            except SstlError as error:
                assert "\n" not in error.line() and len(error.line()) < 2000, (kind, number)
                answers["refused"] += 1
            except BaseException as error:
                raise AssertionError(f"{kind} input {number}: {type(error).__name__}: {error}"[:300]) from error
            assert time.monotonic() - started < MAX_SECONDS, f"{kind} input {number} hangs"
    return answers


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MAX_BYTES, MAX_BYTES))
    chosen = list(READERS) if sys.argv[1] == "all" else [sys.argv[1]]
    for kind in chosen:
        found = fuzz(kind, int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 0)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(json.dumps({"kind": kind, **found, "peak_gb": round(peak, 2)}))
