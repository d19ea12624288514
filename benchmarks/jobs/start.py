"""How long the program takes to start, over an empty Python."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

from benchmarks import logs
from benchmarks.harness import Row, paired


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare ``sstl --help`` and ``sstl info LOG`` with ``python -c pass``."""
    log = logs.write(folder / "log.parquet", 2, 1000)
    sstl = [sys.executable, "-m", "sstl_cli"]
    rows = []
    for name, words, goal in (("help", ["--help"], 0.3), ("info", ["info", str(log)], 0.8)):
        own, empty = paired(
            lambda w=words: _call([*sstl, *w]), lambda: _call([sys.executable, "-c", "pass"]), 2 if quick else 9, time.perf_counter
        )
        values = tuple(a - b for a, b in zip(own, empty, strict=True))
        shown = "sstl --help" if name == "help" else "sstl info LOG"
        own_cpu, empty_cpu = (statistics.median(_processor(w) for _ in range(3)) for w in ([*sstl, *words], [sys.executable, "-c", "pass"]))
        rows.append(
            Row(
                f"start/{name}",
                f"start `{shown}`",
                "over `python -c pass`, wall time",
                goal,
                values,
                at_least=False,
                unit="s",
                seconds={"ours": min(own), "peer": min(empty)},
            )
        )
        # what the wall time comes to on a machine with nothing else to do
        rows.append(
            Row(
                f"start/{name}-processor",
                f"start `{shown}`",
                "the same in processor time",
                goal,
                (own_cpu - empty_cpu,),
                at_least=False,
                unit="s",
            )
        )
    return rows


def _call(words: list[str]) -> None:
    subprocess.run(words, check=True, capture_output=True, timeout=60)


def _processor(words: list[str]) -> float:
    """Return the processor time (s) of one process."""
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return used.ru_utime + used.ru_stime
