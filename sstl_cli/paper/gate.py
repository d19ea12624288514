"""Does what was recomputed lie within the committed spread? A reproduction that can fail."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.paper.spread import Draw, Key, Spread

#: standard errors of the difference between the recomputed mean and the committed one; beyond it an entry fails
LIMIT = 5.0
# six digits are committed
ROUNDING = 1e-5


@dataclass(frozen=True)
class Outside:
    """One entry whose recomputed mean does not lie within the committed spread (``distance`` in standard errors)."""

    block: str
    key: Key
    recomputed: float | None
    committed: float | None
    distance: float

    def text(self) -> str:
        """Return the entry in words."""
        name = f"{self.block}: Table {' '.join(self.key)}"
        if self.recomputed is None or self.committed is None:
            return f"{name} is {'not recomputed' if self.recomputed is None else 'not in the committed table'}"
        return f"{name} is {self.recomputed:.4g}, committed {self.committed:.4g} ({self.distance:.0f} standard errors off)"


def outside(draws: Sequence[Draw], committed: Spread) -> list[Outside]:
    """Return the entries outside, the farthest first; an entry on one side only is outside too.

    Parameters
    ----------
    draws : sequence
        Entries of the recomputed data seeds by block.
    committed : Spread
        Mean and standard deviation over the committed data seeds.
    """
    found = []
    for block in dict.fromkeys([*committed.blocks, *(b for d in draws for b in d)]):
        known = committed.of(block)
        for key in dict.fromkeys([*known, *(k for d in draws for k in d.get(block, {}))]):
            values = [d[block][key] for d in draws if key in d.get(block, {})]
            mean = float(np.mean(values)) if len(values) == len(draws) else None
            if key not in known or mean is None:
                found.append(Outside(block, key, mean, known[key][0] if key in known else None, math.inf))
                continue
            centre, sd = known[key]
            error = sd * math.sqrt(1.0 / len(draws) + 1.0 / committed.seeds) + ROUNDING * abs(centre)
            distance = abs(mean - centre) / error if error > 0.0 else (0.0 if mean == centre else math.inf)
            if not distance <= LIMIT:
                found.append(Outside(block, key, mean, centre, distance))
    return sorted(found, key=lambda o: -o.distance)
