"""What the recordings of a case could tell: distances from its truth to the base and to the nearest rival."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sstl_cli.blind import beside, distance
from sstl_cli.blind.cases import rebuild
from sstl_cli.blind.distance import Apart
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.documents.blind import BlindLimitDocument, CaseDistance
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario

LISTED = 6


def run(case: str, truth: CaseTruth, claimed: Scenario, exclude: Sequence[str]) -> CaseDistance:
    """Return the squared distances of one case from its opened truth.

    Parameters
    ----------
    claimed : Scenario
        The simulator as the lab states it: what a diagnosis starts from.
    exclude : sequence of str
        What was no candidate; only a truth that was excluded itself has to be told from the others alone.
    """
    np.seterr(all="ignore")
    effects = sorted(truth.effects)
    nothing = CaseDistance(
        case=case, effects=effects, channel=truth.channel, d2_base=None, d2_rival=None, rival=None, d2_base_known=None,
        d2_rival_known=None, d2_law=None, d2_own=None, rivals={}, decidable=False, decidable_known=False, why=None,
    )  # fmt: skip
    try:
        found = _apart(truth, claimed, exclude)
    except SstlError as error:
        return nothing.model_copy(update={"why": error.what})
    law = {"d2_law": found.law, "d2_own": found.own}
    if not effects:
        return nothing.model_copy(update={**law, "why": "nothing was withheld"})
    nearest = sorted(found.rivals, key=lambda r: (found.rivals[r], r))
    joined = min(found.joined, key=lambda r: (found.joined[r], r), default=None)
    rival_known = min(found.rivals_known.values(), default=None)
    told = {
        **law,
        "d2_base": found.base,
        "d2_base_known": found.base_known,
        "d2_rival": found.rivals[nearest[0]] if nearest else None,
        "d2_rival_known": rival_known,
        "rival": nearest[0] if nearest else None,
        "rivals": {r: found.rivals[r] for r in nearest[:LISTED]},
        "decidable": bool(min(found.base, *found.rivals.values(), np.inf) >= DECIDABLE),
        "d2_joined": None if joined is None else found.joined[joined],
        "joined": joined,
        "decidable_known": bool(min(found.base_known, *found.rivals_known.values(), np.inf) >= DECIDABLE),
    }
    return nothing.model_copy(update=told)


def _apart(truth: CaseTruth, claimed: Scenario, exclude: Sequence[str]) -> Apart:
    source, effects = rebuild(truth)
    session = distance.truth_of(source, effects, claimed)
    channels = {get(e).channel for e in effects if e in catalogue()}
    if channels == {"position"}:
        return beside.position(session)
    if channels == {"loop"}:
        return beside.loop(session)
    return distance.apart(session, tuple(exclude) if truth.excluded else ())


def document(rows: Sequence[CaseDistance], seal: str) -> BlindLimitDocument:
    """Return the distances of a set, ``sstl.blind.limit/1``."""
    judged = [r for r in rows if r.d2_base is not None]
    return BlindLimitDocument(
        schema="sstl.blind.limit/1",
        cases=len(rows),
        judged=len(judged),
        decidable=sum(r.decidable for r in judged),
        decidable_known=sum(r.decidable_known for r in judged),
        decidable_d2=DECIDABLE,
        distances=list(rows),
        seal=seal,
    )
