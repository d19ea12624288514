"""Probabilities after what no weight was learned for: what closes no gap, what is no candidate, what wanders, what has grown."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sstl_cli.diagnosis.constants import DECIDES_NATS, HALF, LEAST_GAP
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, Ids, Rows
from sstl_cli.diagnosis.reasons import as_large, explained

NONE: Ids = ()
UNKNOWN: Ids = ("?",)


def sizeable(rows: Rows, p: Mapping[Ids, float]) -> dict[Ids, float]:
    """Return probabilities in which an effect beside the output that closes next to no gap is nothing."""
    slight = {c.ids for c in rows.candidates if c.kind == BESIDE and gap_closed(c) < LEAST_GAP and c.ids in p}
    return {**{k: v for k, v in p.items() if k not in slight}, NONE: p[NONE] + sum(p[k] for k in slight)}


def causes(rows: Rows, p: Mapping[Ids, float]) -> dict[Ids, float]:
    """Return probabilities in which a fault of the recorder is no cause of what a model of the output explains more of.

    It is there, but carries less than half of the squared error. A model of the output explains its share of what sound samples leave beyond the noise.
    """
    reducible = 1.0 - 1.0 / max(rows.log.base_chi2, 1.0)
    explained = reducible * max((c.share for c in rows.candidates if c.kind == OUTPUT and c.evidence > DECIDES_NATS), default=0.0)
    slight = {c.ids for c in rows.candidates if c.kind == RECORDER and c.share < min(HALF, (1.0 - c.share) * explained) and c.ids in p}
    named = [k for k in p if k not in (NONE, UNKNOWN)]
    rest = sum(p[k] for k in named if k not in slight)
    if not slight or rest <= 0.0:
        return dict(p)
    whole = sum(p[k] for k in named)
    return {k: v if k in (NONE, UNKNOWN) else v * whole / rest for k, v in p.items() if k not in slight}


def barred(rows: Rows, p: Mapping[Ids, float]) -> tuple[dict[Ids, float], str]:
    """Return probabilities in which what was found but is no candidate has no name, and a sentence on it where it is likelier than not."""
    found = {k: v for k, v in p.items() if rows.barred.keys() & set(k)}
    unnamed = p[UNKNOWN] + sum(found.values())
    why = f"{explained(rows, max(found, key=lambda k: found[k]))}, and is no candidate" if unnamed - p[UNKNOWN] > HALF * unnamed else ""
    return {**{k: v for k, v in p.items() if k not in found}, UNKNOWN: unnamed}, why


def grown(rows: Rows) -> str:
    """Return a sentence on an error that has grown since a model was accepted and that one effect would take most of, empty where none has.

    Of an accepted model it is known by how much it may seem to be another one (see variation). That takes up a change of that size as well:
    then no evidence is left for it. Where most of the error was not there when the model was accepted, and an effect of a usual size takes most
    of it off, that nothing has changed is not known.
    """
    alone = [c for c in rows.candidates if c.kind == OUTPUT and len(c.ids) == 1 and not c.outside]
    best, since = max(alone, key=lambda c: c.share, default=None), rows.log.grown or 0.0
    return "" if best is None or min(since, best.share) <= HALF else as_large(best, since)


def wandering(rows: Rows, p: Mapping[Ids, float]) -> tuple[dict[Ids, float], str]:
    """Return probabilities in which an output that wanders more slowly than noise of any sensor is something, and a sentence on it."""
    nats, unnamed = rows.log.wanders or 0.0, p[NONE] + p[UNKNOWN]
    if nats <= DECIDES_NATS:
        return dict(p), ""
    why = f"the outputs wander for longer than noise of a sensor does ({nats:.0f} nats), and no candidate explains it"
    return {**p, NONE: 0.0, UNKNOWN: unnamed}, why if p[NONE] > HALF * unnamed else ""


def gap_closed(c: CandidateRow) -> float:
    """Return the gap (RMS, over the noise) that an effect beside the output closes; infinite where it closes all."""
    left = (1.0 - c.share) ** 2
    return float(np.sqrt(max(c.chi2, 1.0) * max(1.0 - left, 0.0) / left)) if left > 0.0 else float("inf")
