"""A long run of damaged files over every importer and every file the program reads back; fills docs/trust.md.

``python tools/fuzz.py --count 100000 --minutes 15 [--only KIND,KIND] [--publish]``: up to ``count`` inputs a kind, each
kind in a process of its own with a limit on memory, until its share of the minutes is over. What was done is kept in
``build/fuzz.jsonl``; the next run goes on behind it, and ``--publish`` writes the sums. A kind ends at the first input
that is answered by anything but a value or one error line, and the run with 1.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from page_part import put, table

ROOT = Path(__file__).resolve().parents[1]
LIMIT_BYTES = 8 << 30
NOTHING: dict[str, Any] = {"inputs": 0, "read": 0, "slowest_s": 0.0, "peak_mib": 0.0}


def main() -> int:
    """Run one kind after another; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--minutes", type=float, default=15.0)
    parser.add_argument("--first", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--only", default="")
    parser.add_argument("--log", type=Path, default=ROOT / "build" / "fuzz.jsonl")
    parser.add_argument("--publish", action="store_true", help="write the table into docs/trust.md")
    parser.add_argument("--one", default="", help=argparse.SUPPRESS)
    given = parser.parse_args()
    sys.path[:0] = [str(ROOT / "tests" / d) for d in ("importers", "trust", ".")]
    if given.one:
        return one(given.one, given.count, given.first, given.minutes * 60)
    from fuzz_readers import READERS
    from seeds import WRITERS

    kinds = [f"import {n}" for n in WRITERS] + [f"read {n}" for n in READERS]
    kinds = [k for k in kinds if not given.only or k.split()[1] in given.only.split(",")]
    given.log.parent.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + given.minutes * 60
    bad = 0
    for i, kind in enumerate(kinds):
        first = sums(given.log).get(kind, NOTHING)["inputs"]
        count = given.count - first
        if count <= 0:
            continue
        share = max(5.0, (end - time.monotonic()) / (len(kinds) - i)) / 60
        words = ["--one", kind, "--count", str(count), "--first", str(first), "--minutes", f"{share:.4f}"]
        done = subprocess.run([sys.executable, __file__, *words], capture_output=True, text=True, check=False)
        if done.returncode:
            bad += 1
            print(f"{kind}: ended with {done.returncode}: {done.stderr.strip()[-3000:]}", file=sys.stderr, flush=True)
            continue
        line = done.stdout.splitlines()[-1]
        print(line, flush=True)
        with open(given.log, "a", encoding="utf-8") as file:
            file.write(line + "\n")
    if given.publish and not bad:
        found = sums(given.log)
        rows: list[list[object]] = [
            [k, f"{f['inputs']:,}", f"{f['read']:,}", f"{f['slowest_s']:.2f}", f"{f['peak_mib']:.0f}"] for k, f in found.items()
        ]
        total = sum(f["inputs"] for f in found.values())
        head = ["target", "inputs", "read as good", "slowest, s", "peak memory, MiB"]
        text = f"{total:,} inputs, none answered by a crash, a traceback or a hang (100,000 of each kind are wanted):\n\n"
        put("trust.md", "fuzz", text + table(head, rows))
    return 1 if bad else 0


def sums(log: Path) -> dict[str, dict[str, Any]]:
    """Return what all runs in a log did together, by kind."""
    found: dict[str, dict[str, Any]] = {}
    for line in log.read_text(encoding="utf-8").splitlines() if log.exists() else []:
        new = json.loads(line)
        old = found.get(new["kind"], NOTHING)
        added = {k: old[k] + new[k] for k in ("inputs", "read")}
        found[new["kind"]] = {**added, **{k: max(old[k], new[k]) for k in ("slowest_s", "peak_mib")}}
    return dict(sorted(found.items()))


def one(kind: str, count: int, first: int, seconds: float) -> int:
    """Fuzz one kind in this process and print how it went."""
    where, name = kind.split()
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    if where == "import":
        import fuzz_importers

        from sstl_cli.importers import isolate

        # a library that hangs is stopped after a minute; here sooner, or hangs would be all that the run meets
        isolate.TIMEOUT_S = 5.0

        def step(number: int) -> bool:
            return fuzz_importers.fuzz_one(name, fuzz_importers.mutated(name, number))
    else:
        import fuzz_readers

        def step(number: int) -> bool:
            return fuzz_readers.fuzz_one(name, fuzz_readers.mutated(name, number), f"{name} input {number}")

    inputs = read = 0
    slowest = 0.0
    step(first)
    end = time.monotonic() + seconds
    while inputs < count and time.monotonic() < end:
        before = time.monotonic()
        try:
            read += bool(step(first + inputs))
        except BaseException:
            print(f"input {first + inputs}", file=sys.stderr)
            raise
        slowest = max(slowest, time.monotonic() - before)
        inputs += 1
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"kind": kind, "inputs": inputs, "read": read, "slowest_s": slowest, "peak_mib": peak}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
