"""Time and memory of ``simulate`` and ``segment`` over the number of runs and of samples, as users start them."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.harness import Row, rounded

PLOT = Path(__file__).resolve().parents[2] / "docs" / "scaling.svg"
POINTS = Path(__file__).resolve().parents[1] / "scaling.json"
RATE_HZ = 500.0
SAMPLES = 10_000
COMMANDS = ("simulate", "segment")
# times the start-up, from where on a job counts
ENOUGH = 2.0


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
    counts = (4, 16) if quick else (10, 30, 100, 300, 1000)
    lengths = (100_000, 400_000) if quick else (100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
    repeats = 1 if quick else 3
    # compiled code is in its cache after the first
    _measure(folder, 1, 1000)
    start = [p for _ in range(2 * repeats + 1) for p in _measure(folder, 1, 1000)]
    by_runs = [p for _ in range(repeats) for n in counts for p in _measure(folder, n, SAMPLES)]
    by_length = [p for _ in range(repeats) for n in lengths for p in _measure(folder, 1, n)]
    rows = []
    for command in COMMANDS:
        idle = [p.cpu_s for p in start if p.command == command]
        for what, points in (("samples", by_length), ("runs", by_runs)):
            spent: dict[int, list[float]] = {}
            for p in points:
                if p.command == command:
                    spent.setdefault(p.runs * p.samples, []).append(p.cpu_s)
            low, middle, high, used = exponent(spent, idle)
            rows.append(
                Row(
                    f"scaling/{command}-{what}",
                    f"{command}, time over {what}",
                    "exponent of the fit, 95 % interval",
                    1.05,
                    (low, middle, high),
                    at_least=False,
                    unit="(exponent)",
                    seconds={"start": median(idle), **{str(n): median(s) for n, s in spent.items()}},
                    note=f"from {used[0]} to {used[-1]} samples, {repeats} times each",
                )
            )
        few, many = (max(p.memory_mb for p in by_runs if p.command == command and p.runs == n) for n in (counts[0], counts[-1]))
        rows.append(
            Row(
                f"scaling/{command}-memory",
                f"{command}, memory at {counts[-1]} runs",
                f"over that at {counts[0]} runs of the same length",
                1.5,
                (many / few,),
                at_least=False,
                unit="(ratio)",
                note=f"{few:.0f} MB and {many:.0f} MB",
            )
        )
    if not quick:
        _store([*by_runs, *by_length], {c: median([p.cpu_s for p in start if p.command == c]) for c in COMMANDS})
    return rows


def exponent(spent: dict[int, list[float]], start: list[float], draws: int = 2000) -> tuple[float, float, float, list[int]]:
    """Return the slope of log time over log size, its 95 % interval around it, and the sizes it was fitted to.

    ``spent`` are the repeated times (s) of every size, start-up included. A size counts where it takes at least twice
    as long as the start-up: below, the difference of the two says more of their scatter than of the work. The
    interval is that of fits to one repeat of every size and of the start-up, drawn at random.
    """
    sizes = sorted(n for n, s in spent.items() if median(s) >= ENOUGH * median(start))
    sizes = sizes if len(sizes) > 1 else sorted(spent)[-2:]
    rng = np.random.default_rng(0)
    slopes = []
    for _ in range(draws):
        work = np.array([rng.choice(spent[n]) for n in sizes]) - rng.choice(start)
        slopes.append(float(np.polyfit(np.log(sizes), np.log(np.maximum(work, 1e-3)), 1)[0]))
    best = float(np.polyfit(np.log(sizes), np.log([max(median(spent[n]) - median(start), 1e-3) for n in sizes]), 1)[0])
    low, high = np.quantile(slopes, (0.025, 0.975))
    return min(float(low), best), best, max(float(high), best), sizes


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


def _store(points: list[Point], start: dict[str, float]) -> None:
    body = [{**p.__dict__, "cpu_s": rounded(p.cpu_s), "memory_mb": round(p.memory_mb)} for p in points]
    document = {"schema": "sstl.bench-scaling/1", "start_s": {c: rounded(s) for c, s in start.items()}, "points": body}
    POINTS.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "sstl"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    for command, colour in zip(COMMANDS, ("tab:blue", "tab:orange"), strict=True):
        for many, mark in ((False, "o-"), (True, "s--")):
            own = [p for p in points if p.command == command and (p.runs > 1) == many]
            size = sorted({p.runs * p.samples for p in own})
            spent, memory = (
                [median(getattr(p, of) for p in own if p.runs * p.samples == n) for n in size] for of in ("cpu_s", "memory_mb")
            )
            label = f"{command}, {'runs of 10 000 samples' if many else 'one run'}"
            axes[0].loglog(size, spent, mark, color=colour, label=label)
            axes[1].loglog(size, memory, mark, color=colour)
        axes[0].axhline(start[command], color=colour, linewidth=0.7, linestyle=":")
    axes[0].set(xlabel="samples", ylabel="processor time (s), dotted: start-up")
    axes[1].set(xlabel="samples", ylabel="largest memory (MB)")
    axes[0].legend(fontsize=8)
    figure.savefig(PLOT, metadata={"Date": None})
    plt.close(figure)
