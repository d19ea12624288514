"""Compensation: reference, output and error over time for the methods, error by phase, scores."""

from __future__ import annotations

import numpy as np

from sstl_cli.core.tables import SCORE
from sstl_cli.reporting import drawing
from sstl_cli.reporting.figures import methods, phase_error, tracking
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Compensation", 50, ("command", "score")
DETAILED = 6


def context(inputs: Inputs) -> dict[str, object]:
    """Return tracking of at most DETAILED runs, evenly chosen, error by phase over all, and the scores."""
    names = list(dict.fromkeys(v.subject for v in inputs.command))
    places = np.unique(np.linspace(0, len(names) - 1, min(DETAILED, len(names))).astype(int))
    shown = [drawing.picture(tracking, tracking.default(inputs, names[i]), f"tracking-{i}") for i in places]
    pair = [
        (heading, drawing.picture(module, found, name))
        for heading, module, name in (("Error by phase", phase_error, "phase-error"), ("Scores", methods, "methods"))
        if (found := module.default(inputs, None)) is not None
    ]
    scores = None
    if inputs.score:
        scores = table(
            "Scores", [(c.name, c.unit) for c in SCORE.columns], ([getattr(r, c.name) for c in SCORE.columns] for r in inputs.score)
        )
    return {"tracking": shown, "pair": pair, "scores": scores, "runs": len(names)}
