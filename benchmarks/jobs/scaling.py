"""Time and memory of ``simulate`` and ``segment`` over the number of runs and of samples, as users start them."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness import Row, rounded

PLOT = Path(__file__).resolve().parents[2] / "docs" / "scaling.svg"
POINTS = Path(__file__).resolve().parents[1] / "scaling.json"
RATE_HZ = 500.0
SAMPLES = 10_000
COMMANDS = ("simulate", "segment")


@dataclass(frozen=True)
class Point:
    """What one command cost: processor time (s) and largest resident memory (MB)."""

    command: str
    runs: int
    samples: int
    cpu_s: float
    memory_mb: float


def run(quick: bool, folder: Path) -> list[Row]:
    """Fit the exponents of time over samples and runs, and compare the memory of few and many runs."""
    counts = (1, 4) if quick else (1, 10, 100, 1000)
    lengths = (10_000, 40_000) if quick else (10_000, 100_000, 1_000_000, 10_000_000)
    # compiled code is in its cache after the first
    _measure(folder, 1, 1000)
    tries = [p for _ in range(3) for p in _measure(folder, 1, 1000)]
    start = {c: min((p for p in tries if p.command == c), key=lambda p: p.cpu_s) for c in COMMANDS}
    by_runs = [p for n in counts for p in _measure(folder, n, SAMPLES)]
    by_length = [p for n in lengths for p in _measure(folder, 1, n)]
    rows = []
    for command in COMMANDS:
        for what, points in (("samples", by_length), ("runs", by_runs)):
            own = [p for p in points if p.command == command]
            size = np.array([p.runs * p.samples for p in own], float)
            spent = np.array([p.cpu_s for p in own]) - start[command].cpu_s
            rows.append(
                Row(
                    f"scaling/{command}-{what}",
                    f"{command}, time over {what}",
                    "exponent of the fit",
                    1.05,
                    (exponent(size, spent),),
                    at_least=False,
                    unit="(exponent)",
                    seconds={str(int(n)): s for n, s in zip(size, spent.tolist(), strict=True)},
                )
            )
        few, many = (next(p for p in by_runs if p.command == command and p.runs == n) for n in (counts[1], counts[-1]))
        rows.append(
            Row(
                f"scaling/{command}-memory",
                f"{command}, memory at {counts[-1]} runs",
                f"over that at {counts[1]} runs of the same length",
                1.5,
                (many.memory_mb / few.memory_mb,),
                at_least=False,
                unit="(ratio)",
                note=f"{few.memory_mb:.0f} MB and {many.memory_mb:.0f} MB",
            )
        )
    if not quick:
        _store([*by_runs, *by_length], start)
    return rows


def exponent(size: np.ndarray, spent: np.ndarray) -> float:
    """Return the slope of log time over log size where the time stands clear of the start-up."""
    clear = spent > 0.3
    if clear.sum() < 2:
        clear = spent >= np.sort(spent)[-2]
    return float(np.polyfit(np.log(size[clear]), np.log(np.maximum(spent[clear], 1e-3)), 1)[0])


def _measure(folder: Path, runs: int, samples: int) -> list[Point]:
    scenario = folder / "scenario.toml"
    head = f'schema = "sstl.scenario/1"\nsampling_hz = {RATE_HZ}\n'
    tubes = "".join(f'[[configurations]]\nid = "CP-{i:04d}"\nlocation = "CP"\ntheta = {0.4 + 0.2 * i / runs:.4f}\n' for i in range(runs))
    path = f'[[trajectories]]\nkind = "sinusoid"\nsystems = ["act"]\nfrequency_hz = 0.2\nduration_s = {samples / RATE_HZ}\n'
    scenario.write_text(head + tubes + path, encoding="utf-8")
    log, theta = folder / "log.parquet", folder / "theta.parquet"
    words = {
        "simulate": ["simulate", "--scenario", str(scenario), "--out", str(log), "--force"],
        "segment": ["segment", str(log), "--out", str(theta), "--force", "--json"],
    }
    return [Point(c, runs, samples, *_cost(words[c])) for c in COMMANDS]


# the memory of a process counts what its parent held when it was made: a small one stands in between
LAUNCH = """
import json, os, subprocess, sys
p = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(p.pid, 0)
print(json.dumps([os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss]))
"""


def _cost(words: list[str]) -> tuple[float, float]:
    """Return processor time (s) and largest resident memory (MB) of one process; it must succeed."""
    told = subprocess.run(
        [sys.executable, "-c", LAUNCH, sys.executable, "-m", "sstl_cli", *words], capture_output=True, text=True, check=True
    ).stdout
    code, seconds, kilobytes = json.loads(told)
    # a run too short for a line is set aside (3)
    if code not in (0, 3):
        raise RuntimeError(f"sstl {' '.join(words)}: exit code {code}")
    return seconds, kilobytes / 1024.0


def _store(points: list[Point], start: dict[str, Point]) -> None:
    body = [{**p.__dict__, "cpu_s": rounded(p.cpu_s), "memory_mb": round(p.memory_mb)} for p in points]
    POINTS.write_text(json.dumps({"schema": "sstl.bench-scaling/1", "points": body}, indent=1) + "\n", encoding="utf-8")
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "sstl"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    for command, colour in zip(COMMANDS, ("tab:blue", "tab:orange"), strict=True):
        for many, mark in ((False, "o-"), (True, "s--")):
            own = [p for p in points if p.command == command and (p.runs > 1) == many]
            size = [p.runs * p.samples for p in own]
            label = f"{command}, {'runs of 10 000 samples' if many else 'one run'}"
            axes[0].loglog(size, [max(p.cpu_s - start[command].cpu_s, 1e-3) for p in own], mark, color=colour, label=label)
            axes[1].loglog(size, [p.memory_mb for p in own], mark, color=colour)
    axes[0].set(xlabel="samples", ylabel="processor time less start-up (s)")
    axes[1].set(xlabel="samples", ylabel="largest memory (MB)")
    axes[0].legend(fontsize=8)
    figure.savefig(PLOT, metadata={"Date": None})
    plt.close(figure)
