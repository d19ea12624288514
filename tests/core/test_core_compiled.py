"""Compiled functions that several processes keep in one folder are never taken for one another."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.caching import IndexDataCacheFile

import sstl_cli  # noqa: F401

FUNCTION = """
import sys
import sstl_cli
import numpy as np
from numba import njit

@njit(cache=True)
def total(x):
    s = 0.0
    for i in range(len(x)):
        s += x[i]
    return s

every = np.arange(20.0)
print(total(every[::2] if sys.argv[1] == "strided" else every))
"""


def kept(folder: Path, stamp: object = 1) -> IndexDataCacheFile:
    return IndexDataCacheFile(str(folder), "module.function", stamp)


def test_two_first_runs_at_once_keep_two_signatures_apart(tmp_path: Path) -> None:
    first, second = kept(tmp_path), kept(tmp_path)
    write = first._save_data
    # the second looked before the first had written anything, and wrote while it did
    second._load_index = dict

    def meanwhile(name: str, data: object) -> None:
        second.save("strided", "code for strided arrays")
        write(name, data)

    first._save_data = meanwhile
    first.save("contiguous", "code for contiguous arrays")
    for key in ("contiguous", "strided"):
        assert kept(tmp_path).load(key) in (None, f"code for {key} arrays")


def test_a_run_that_is_killed_leaves_no_code_of_an_older_source(tmp_path: Path) -> None:
    kept(tmp_path, stamp="old").save("key", "old code")
    killed = kept(tmp_path, stamp="new")

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    killed._save_data = stop
    with pytest.raises(KeyboardInterrupt):
        killed.save("key", "new code")
    assert kept(tmp_path, stamp="new").load("key") is None


def test_what_is_kept_is_found_again(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text(FUNCTION)

    def run(how: str) -> str:
        words = [sys.executable, str(module), how]
        done = subprocess.run(words, env={"PYTHONPATH": str(Path(__file__).parents[2])}, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert (run("whole"), run("strided")) == ("190.0", "90.0")
    made = {p: p.stat().st_mtime_ns for p in (tmp_path / "__pycache__").glob("*.nbc")}
    # a file each, and none written again
    assert len(made) == 2
    assert (run("strided"), run("whole")) == ("90.0", "190.0")
    assert {p: p.stat().st_mtime_ns for p in (tmp_path / "__pycache__").glob("*.nbc")} == made
