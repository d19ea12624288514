"""The laws: for every effect one or more other laws than the first of the catalogue, with their sources.

A law may leave one number open (an exponent, a time constant); it is drawn between two published or plausible values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from math import exp, log
from zlib import crc32

import numpy as np


@dataclass(frozen=True)
class Law:
    """One law of one effect: id, equation, source, and the range of its open number (logarithmic if both > 0)."""

    id: str
    equation: str
    source: str
    low: float = 1.0
    high: float = 1.0


@dataclass(frozen=True)
class Chosen:
    """The law in force: its id, its place among the laws of the effect, and its open number."""

    id: str
    code: int
    shape: float


def draw(effect: str, laws: tuple[Law, ...], name: str | None, seed: int) -> Chosen:
    """Return the law of this name, else one drawn from a seed, and its open number; ValueError where there is none of the name."""
    rng = np.random.default_rng([seed, crc32(effect.encode())])
    code = int(rng.integers(len(laws)))
    place = float(rng.random())
    if name is not None:
        names = [law.id for law in laws]
        if name not in names:
            raise ValueError(f"variant: {effect} has no law {name!r}{hint(name, names)} (known: {', '.join(names)})")
        code = names.index(name)
    law = laws[code]
    return Chosen(law.id, code, exp(log(law.low) + place * (log(law.high) - log(law.low))))


def hint(name: str, known: Iterable[str]) -> str:
    """Return a question after the nearest of the known names, or nothing."""
    near = get_close_matches(name, list(known), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""
