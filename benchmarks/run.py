"""Run the comparisons: print ratios, write results.json and the table, fail where a ratio fell by more than 30 %.

python benchmarks/run.py [--only JOB ...] [--quick] [--accept]
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pkgutil
import platform
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

from benchmarks import jobs, show  # noqa: E402
from benchmarks.harness import Row, fell  # noqa: E402

RESULTS = HERE / "results.json"
PAGES = (ROOT / "docs" / "performance.md",)
ORDER = ("segment", "importing", "simulate", "rig", "train", "compensate", "streaming", "diagnose", "algebra", "start", "scaling")
PACKAGES = ("numpy", "scipy", "scikit-learn", "pandas", "pyarrow", "numba", "torch", "mujoco", "lmfit", "statsmodels")


def names() -> list[str]:
    """Return the jobs there are, in the order of the work."""
    found = [m.name for m in pkgutil.iter_modules(jobs.__path__) if not m.name.startswith("_")]
    return sorted(found, key=lambda n: (ORDER.index(n) if n in ORDER else len(ORDER), n))


def measure(chosen: list[str], quick: bool) -> list[Row]:
    """Run the jobs one after the other in this process."""
    rows: list[Row] = []
    for name in chosen:
        began = time.perf_counter()
        with tempfile.TemporaryDirectory(prefix="sstl-bench-") as folder:
            found = importlib.import_module(f"benchmarks.jobs.{name}").run(quick, Path(folder))
        rows += found
        for row in found:
            state = {True: "met", False: "MISSED", None: ""}[row.met]
            print(f"{row.id}: {row.median:.3g} ({min(row.values):.3g} to {max(row.values):.3g}) {row.unit} {state}", flush=True)
            print(f"    {row.seconds} {row.note}", flush=True)
        print(f"  ({name}: {time.perf_counter() - began:.0f} s)", flush=True)
    return rows


def machine() -> dict[str, Any]:
    """Return what the numbers depend on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "cores": cores,
        "processor": platform.machine(),
        "python": platform.python_version(),
        "packages": {p: version(p) for p in PACKAGES},
    }


def merged(stored: list[dict[str, Any]], fresh: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the stored rows with those of the jobs that ran replaced, in the order of the jobs."""
    ran = {row["id"].partition("/")[0] for row in fresh}
    kept = [row for row in stored if row["id"].partition("/")[0] not in ran]
    order = names()
    return sorted(kept + fresh, key=lambda r: order.index(r["id"].partition("/")[0]))


def main(words: list[str] | None = None) -> int:
    """Return the exit code: 1 where a ratio fell, 0 else (a missed goal is shown, not an error)."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=names(), metavar="JOB", help=", ".join(names()))
    parser.add_argument("--quick", action="store_true", help="small sizes, nothing is written or compared")
    parser.add_argument("--accept", action="store_true", help="store the results even where a ratio fell")
    given = parser.parse_args(words)
    fresh = [row.document() for row in measure(given.only or names(), given.quick)]
    print()
    print(show.table(fresh))
    if given.quick:
        return 0
    old = json.loads(RESULTS.read_text(encoding="utf-8"))["rows"] if RESULTS.is_file() else []
    before = {row["id"]: row for row in old}
    worse = [row for row in fresh if row["id"] in before and fell(row, before[row["id"]])]
    for row in worse:
        print(f"fell: {row['id']}: {row['median']:g}, stored {before[row['id']]['median']:g}", file=sys.stderr)
    if worse and not given.accept:
        # storing them would let the next run pass
        return 1
    rows = merged(old, fresh)
    body = {"schema": "sstl.bench/1", "machine": machine(), "rows": rows}
    temporary = RESULTS.with_suffix(".tmp")
    temporary.write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, RESULTS)
    for page in PAGES:
        if not show.put(page, show.table(rows)):
            print(f"{page.name} has no place for the table ({show.BEGINS})", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
