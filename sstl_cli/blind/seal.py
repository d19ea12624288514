"""Seals: salted hashes of every truth, published before anything is diagnosed, and the checks that they hold."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import dumps
from sstl_cli.core.rng import stream


@dataclass(frozen=True)
class Planned:
    """What is asked of one case: its recording by SHA-256, what is no candidate, and the simulator as stated."""

    case: str
    sha256: str
    exclude: tuple[str, ...]
    sim: Mapping[str, object]

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> Planned:
        """Return a case from its row of the plan."""
        return cls(row["case"], row["sha256"], tuple(row["exclude"]), row["sim"])


@dataclass(frozen=True)
class Truth:
    """The opened truth of a set: what it was made for, its seeds, and what was done in each case."""

    purpose: str
    seeds: tuple[int, int]
    quick: bool
    truths: Mapping[str, CaseTruth]


HASHES, TRUTH, PLAN = "sstl.blind.hashes/1", "sstl.blind.truth/1", "sstl.blind.plan/1"


def digest(salt: str, content: Any) -> str:
    """Return the SHA-256 of a salt and a document in canonical form."""
    plain = json.dumps(json.loads(dumps(content)), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(f"{salt}|{plain}".encode()).hexdigest()


def seal(truths: Mapping[str, CaseTruth], purpose: str, seeds: Sequence[int], quick: bool) -> tuple[dict[str, object], dict[str, object]]:
    """Return the hashes to publish and the truth document that stays closed.

    The salts follow from the seed, so that the same call gives the same bytes; who wants to keep the truth
    from people, and not only from the diagnosis, draws a seed that nobody guesses.
    """
    documents = {name: truth.document() for name, truth in truths.items()}
    rng = stream(seeds[0], "salt")
    salts = {name: rng.bytes(16).hex() for name in ("set", *truths)}
    facts = {"purpose": purpose, "seeds": list(seeds), "quick": quick, "cases": len(truths)}
    closed = {"schema": TRUTH, **facts, "salts": salts, "truths": documents}
    published: dict[str, object] = {
        "schema": HASHES,
        "purpose": purpose,
        "set": digest(salts["set"], facts),
        "cases": {name: digest(salts[name], truth) for name, truth in documents.items()},
    }
    return published, closed


def verify(published: Mapping[str, Any], closed: Mapping[str, Any], where: str) -> Truth:
    """Return the opened truth; raise SstlError unless it is the one that was sealed, case by case."""
    salts, truths = closed.get("salts", {}), closed.get("truths", {})
    facts = {k: closed.get(k) for k in ("purpose", "seeds", "quick", "cases")}
    if set(truths) != set(published.get("cases", {})) or set(salts) != {"set", *truths}:
        raise SstlError("truth and hashes do not list the same cases", where=where, fix=_FIX, code="E952")
    if digest(salts["set"], facts) != published.get("set") or facts["purpose"] != published.get("purpose"):
        raise SstlError("purpose or seeds differ from what was sealed", where=where, fix=_FIX, code="E952")
    for name, truth in truths.items():
        if digest(salts[name], truth) != published["cases"][name]:
            raise SstlError(f"the truth of {name} differs from what was sealed", where=where, fix=_FIX, code="E952")
    return Truth(
        str(closed["purpose"]), tuple(closed["seeds"]), bool(closed["quick"]), {name: CaseTruth.of(t) for name, t in truths.items()}
    )


def require_purpose(truth: Truth, wanted: str, where: str) -> None:
    """Raise SstlError if a set was made for something else: sets of old were made for calibration, too."""
    if truth.purpose != wanted:
        raise SstlError(
            f"the set was made for {truth.purpose}, not for {wanted}", where=where, fix="make a set and score that", code="E953"
        )


def require_apart(ours: Sequence[int], theirs: Sequence[int], where: str) -> None:
    """Raise SstlError if two inclusive ranges of seeds overlap."""
    if ours[0] <= theirs[1] and theirs[0] <= ours[1]:
        raise SstlError(
            f"seeds {ours[0]}..{ours[1]} overlap with the library's {theirs[0]}..{theirs[1]}",
            where=where,
            fix="make the set with another seed",
            code="E954",
        )


_FIX = "the set was changed after it was made; make it again"
