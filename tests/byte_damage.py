"""One blow to the bytes of a file; the fuzzers of importers and of readers choose where and how hard."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

FLIP, SCRAMBLE, CUT, DROP, REPEAT, WILD = range(6)


def strike(data: bytearray, at: int, length: int, how: int, rng: np.random.Generator, wild: Sequence[bytes]) -> None:
    """Damage ``data`` in place: a bit, a stretch, the rest, a gap, a repetition, or bytes that mean something."""
    if how == FLIP:
        data[at] ^= 1 << int(rng.integers(0, 8))
    elif how == SCRAMBLE:
        data[at : at + length] = rng.integers(0, 256, length, dtype=np.uint8).tobytes()
    elif how == CUT:
        del data[at:]
    elif how == DROP:
        del data[at : at + length]
    elif how == REPEAT:
        data[at:at] = data[at : at + length] * int(rng.integers(1, 20))
    else:
        chosen = wild[int(rng.integers(0, len(wild)))]
        data[at : at + len(chosen)] = chosen
