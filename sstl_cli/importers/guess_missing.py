"""Numbers that recorders write where they have no reading (-9999): far outside of everything else, and again and again the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# of the largest reading, how far outside a code lies: no tendon's tension jumps there and back between samples
OUTSIDE = 10.0


def without_code(values: Array) -> tuple[Array, float | None, int]:
    """Return finite readings without those that are a code for a missing one, the code (None: there is none), and how often it stands there.

    Examples
    --------
    >>> without_code(np.array([3.5, -9999.0, 3.9, -9999.0]))
    (array([3.5, 3.9]), -9999.0, 2)
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return finite, None, 0
    code = float(finite[np.argmax(np.abs(finite))])
    same = finite == code
    rest = finite[~same]
    # a lone one is a spike; a number that was measured has decimals
    known = int(same.sum()) > 1 and code == round(code) and len(rest) > 1 and np.ptp(rest) > 0
    if not known or abs(code) < OUTSIDE * float(np.max(np.abs(rest))):
        return finite, None, 0
    return rest, code, int(same.sum())
