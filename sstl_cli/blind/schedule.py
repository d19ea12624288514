"""Which cases a set holds: kinds in fixed shares, effects and strengths in turn, the order shuffled."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.blind.record import DISTURBANCE
from sstl_cli.blind.simulators import NAMES
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.rng import stream
from sstl_cli.physics.effects import catalogue, get

# nothing missing; one effect; two; the true one no candidate; no catalogue holds it; poor excitation; wrong theta
SHARES = {"single": 0.5, "none": 0.16, "pair": 0.09, "excluded": 0.09, "unlisted": 0.07, "nominal": 0.05, "poor": 0.04}
KINDS = tuple(SHARES)
MIXED = "mixed"
PLAIN, LAB = "plain", "lab"


@dataclass(frozen=True)
class Entry:
    """What one case is to be: its kind, the withheld effects and the strength aimed at."""

    kind: str
    effects: tuple[str, ...] = ()
    strength: float = 0.0


@dataclass(frozen=True)
class Job:
    """One case to draw: what it is to be, its own seed, the simulator that stands in for hardware, and how it is recorded.

    An ``accepted`` one is recorded in two sessions: the model of the first is what the second is compared with. One with ``habits`` is
    of a rig that does what no law describes, and of which no model was accepted.
    """

    entry: Entry
    seed: int
    simulator: str
    quick: bool = False
    as_labs: bool = False
    accepted: bool = False
    habits: bool = False


def jobs(
    cases: int,
    seed: int,
    simulator: str,
    quick: bool = False,
    recordings: str = MIXED,
    strengths: Sequence[float] = STRENGTHS,
    nulls: int = 0,
) -> list[Job]:
    """Return the cases of a set; case k belongs to seed + k.

    ``mixed`` deals the simulators in turn within each kind, so that every kind comes from all of them. ``recordings`` are
    ``plain`` (complete, at a steady rate), as ``lab`` s make them, or ``mixed``: every other case of a kind. So many further ``nulls``
    are among them: a false alarm is rare, and takes many cases to count.

    Raises
    ------
    SstlError
        E961 for another simulator or kind of recordings, or no case at all.
    """
    for what, name, known in (("simulator", simulator, (*NAMES, MIXED)), ("kind of recordings", recordings, (PLAIN, LAB, MIXED))):
        if name not in known:
            raise SstlError(f"no {what} '{name}' ({nearest(name, known)})", fix=f"use one of {', '.join(known)}", code="E961")
    if cases < 1 or nulls < 0:
        raise SstlError(f"{cases} cases and {nulls} further nulls cannot be drawn", fix="ask for one case or more", code="E961")
    dealt: Counter[str] = Counter()
    found = []
    for k, entry in enumerate(schedule(cases, seed, strengths, nulls)):
        turn = dealt[entry.kind] + KINDS.index(entry.kind)
        name = NAMES[turn % len(NAMES)] if simulator == MIXED else simulator
        as_labs = recordings == LAB or (recordings == MIXED and turn % 2 == 1)
        dealt[entry.kind] += 1
        found.append(Job(entry, seed + k, name, quick, as_labs))
    return found


def schedule(cases: int, seed: int, strengths: Sequence[float] = STRENGTHS, nulls: int = 0) -> list[Entry]:
    """Return the cases of a set and so many further nulls in shuffled order; every effect comes once before any comes twice."""
    levels = len(strengths)
    rng = stream(seed, "schedule")
    counts = _counts(cases)
    entries = [Entry("none")] * nulls
    # a blind log has one tendon
    everything = [e for e in catalogue() if get(e).channel != "neighbour"]
    audible = [e for e in everything if get(e).channel == "out"]
    turns = {
        "single": _turns(everything, rng, levels),
        "excluded": _turns(audible, rng, levels),
        "nominal": _turns(audible, rng, levels),
        "poor": _turns([e for e in audible if get(e).fitted], rng, levels),
        "unlisted": _turns([DISTURBANCE], rng, levels),
    }
    for kind in KINDS:
        for i in range(counts[kind]):
            if kind == "none" or (kind == "nominal" and i % 2 == 0):
                entries.append(Entry(kind))
            elif kind == "pair":
                entries.append(Entry(kind, two_effects(audible, rng), strengths[(i + 2) % levels]))
            else:
                names, offsets = turns[kind]
                at = i % len(names)
                entries.append(Entry(kind, (names[at],), strengths[(i // len(names) + offsets[at]) % levels]))
    return [entries[i] for i in rng.permutation(len(entries))]


def _counts(cases: int) -> dict[str, int]:
    """Return how many cases each kind has: largest remainders of the shares."""
    exact = {k: cases * s for k, s in SHARES.items()}
    counts = {k: int(v) for k, v in exact.items()}
    for kind in sorted(KINDS, key=lambda k: (counts[k] - exact[k], KINDS.index(k)))[: cases - sum(counts.values())]:
        counts[kind] += 1
    return counts


def _turns(names: list[str], rng: np.random.Generator, levels: int) -> tuple[list[str], list[int]]:
    """Return the names in a random order, each with the strength it starts from."""
    order = [names[i] for i in rng.permutation(len(names))]
    return order, [int(k) for k in (np.arange(len(order)) + int(rng.integers(levels))) % levels]


def two_effects(audible: list[str], rng: np.random.Generator) -> tuple[str, ...]:
    """Return two fitted effects that the catalogue does not list as look-alikes of each other."""
    fitted = [e for e in audible if get(e).fitted]
    while True:
        a, b = (fitted[i] for i in rng.choice(len(fitted), 2, replace=False))
        if a not in get(b).look_alikes and b not in get(a).look_alikes:
            return a, b
