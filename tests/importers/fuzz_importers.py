"""Mutated recordings for every importer: whatever the bytes, the answer is runs or one SstlError.

As a script: ``python tests/importers/fuzz_importers.py IMPORTER|all COUNT [FIRST_SEED]``.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
import warnings
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))

from byte_damage import WILD, strike
from seeds import SHORT, WRITERS, seed_bytes
from spent import spent_s

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.inline import inline_mapping
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps.import_ import run

MAX_SECONDS = 20.0
_WILD = [b"\xff" * 8, b"\x00" * 8, b"\x7f\xff\xff\xff", b"\xff\xff\xff\x7f", b"\x80\x00\x00\x00", b"1e999", b"\n\n", b",,,", b'"']


@cache
def _seed(importer_id: str) -> tuple[bytes, str]:
    return seed_bytes(importer_id)


def mutated(importer_id: str, number: int) -> bytes:
    """Return input ``number`` of an importer, the same in every run."""
    data = bytearray(_seed(importer_id)[0])
    rng = np.random.default_rng([number, sum(importer_id.encode())])
    for _ in range(int(rng.integers(1, 5))):
        if not data:
            break
        at = int(rng.integers(0, len(data))) if rng.random() < 0.6 else int(rng.integers(0, min(len(data), 600)))
        how = int(rng.integers(0, 7))
        length = int(rng.integers(1, 40))
        if how <= WILD:
            strike(data, at, length, how, rng, _WILD)
        else:
            other = int(rng.integers(0, len(data)))
            data[at : at + length] = data[other : other + length]
    return bytes(data)


def fuzz_one(importer_id: str, data: bytes) -> bool:
    """Return whether ``data`` was read as the format; anything but runs or an SstlError, a reader that hangs, or over 20 s, raises."""
    mapping = inline_mapping(SHORT[importer_id]) if importer_id in SHORT else Mapping()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"fuzz{_seed(importer_id)[1]}"
        path.write_bytes(data)
        started, read = spent_s(), True
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                for piece in run([path], mapping, wanted=importer_id).runs:
                    assert len(piece) <= 2_000_000
        except SstlError as error:
            assert error.code.startswith("E") and "\n" not in error.line()
            assert "gives no value within" not in error.line()
            read = False
        assert spent_s() - started < MAX_SECONDS
    return read


def main(words: list[str]) -> None:
    """Run a long campaign and print how it went."""
    names = list(WRITERS) if words[0] == "all" else [words[0]]
    count, first = int(words[1]), int(words[2]) if len(words) > 2 else 0
    for name in names:
        started = time.monotonic()
        worst = 0.0
        for number in range(first, first + count):
            before = time.monotonic()
            try:
                fuzz_one(name, mutated(name, number))
            except BaseException:
                print(f"{name}: input {number} fails")
                raise
            worst = max(worst, time.monotonic() - before)
        spent = time.monotonic() - started
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{name}: {count} inputs, {spent:.1f} s, slowest {worst:.2f} s, peak memory {peak:.0f} MiB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
