"""Logs: loops by phase with fitted lines, time plots and the sampling check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sstl_cli.reporting import drawing
from sstl_cli.reporting.figures import loop, overview, time
from sstl_cli.reporting.inputs import Inputs, RunView
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Logs", 20, ("log",)
# beyond this many runs the large pictures are of an even choice; the overview shows them all
DETAILED = 8


def context(inputs: Inputs) -> dict[str, object]:
    """Return pictures of at most DETAILED runs, an overview of all, and the sampling of every run."""
    runs = inputs.log
    places = np.unique(np.linspace(0, len(runs) - 1, min(DETAILED, len(runs))).astype(int))
    pairs = []
    for place in places:
        run = runs[place]
        phases = inputs.phases.get(run.run_id)
        pairs.append(
            (
                run.run_id,
                drawing.picture(loop, loop.data(run, phases, loop.fit_of(inputs, run)), f"loop-{place}"),
                drawing.picture(time, time.data(run, phases), f"time-{place}"),
            )
        )
    small = None
    if len(runs) > DETAILED:
        small = drawing.picture(overview, overview.data(runs, inputs.phases), "overview")
    uneven = sum(r.remark != "even" for r in runs)
    return {
        "pairs": pairs,
        "overview": small,
        "sampling": _sampling(runs),
        "runs": len(runs),
        "uneven": uneven,
        "left_out": sum(inputs.left_out.values()),
        "samples": sum(r.samples for r in runs),
        "phased": sum(r.run_id in inputs.phases for r in runs),
    }


def _sampling(runs: Sequence[RunView]) -> Any:
    """Return the table of how every run was sampled."""
    header = [
        "run",
        "configuration",
        "system",
        "location",
        "trajectory",
        ("lead", "mm"),
        ("samples", "1"),
        ("duration", "s"),
        ("rate", "Hz"),
        ("jitter", "%"),
        ("largest step", "s"),
        ("input from", "N"),
        ("input to", "N"),
        ("output from", "N"),
        ("output to", "N"),
        "sampling",
    ]
    rows = (
        [
            r.run_id,
            r.config_id,
            r.system,
            r.location,
            r.trajectory,
            r.lead_mm,
            r.samples,
            r.duration_s,
            1 / r.period_s if r.period_s > 0 else None,
            r.jitter_pct,
            r.gap_s,
            *r.input_range_n,
            *r.output_range_n,
            r.remark,
        ]
        for r in runs
    )
    return table("Sampling check", header, rows)
