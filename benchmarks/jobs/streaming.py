"""How long the streaming controller takes for one sample."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness import Row
from sstl_cli.control.benchmark import python_latency


def run(quick: bool, folder: Path) -> list[Row]:
    """Give the share of steps within 20 us, and their median and 99.9 % quantile."""
    found = [python_latency(cycles=1 if quick else 4) for _ in range(2 if quick else 7)]
    job = f"streaming controller, {sum(found[0].counts)} steps"
    edges = found[0].edges_us
    total = [sum(f.counts[i] for f in found) for i in range(len(edges) - 1)]
    histogram = ", ".join(f"{a:g}-{b:g}: {n}" for a, b, n in zip(edges[:-1], edges[1:], total, strict=True))
    return [
        Row(
            "streaming/below",
            job,
            "share of steps under 20 us",
            99.9,
            tuple(f.below_20_us_pct for f in found),
            unit="%",
            note=f"histogram, us: {histogram}",
        ),
        Row("streaming/median", job, "latency, median", None, tuple(f.median_us for f in found), at_least=False, unit="us"),
        Row("streaming/tail", job, "latency, 99.9 % quantile", 20.0, tuple(f.p999_us for f in found), at_least=False, unit="us"),
    ]
