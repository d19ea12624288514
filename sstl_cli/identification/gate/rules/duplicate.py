"""The same recording twice: two runs share their samples, or the signs of their noise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.fingerprints import Keys
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "duplicate", 3
# half of the samples, and enough of them, must return
SHARE, LEAST, LEAST_SIGNS = 0.5, 16, 3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that repeat an earlier one."""
    exact = _pairs([e.keys for e in log], LEAST)
    signs = _pairs([e.signs for e in log], LEAST_SIGNS)
    seen: set[int] = set()
    for (a, b), share in sorted({**signs, **exact}.items()):
        if b in seen:
            continue
        seen.add(b)
        same = (a, b) in exact
        what = "samples" if same else "noise (in another unit or with another zero)"
        first, second = log[a].run_id, log[b].run_id
        yield Remark(
            (second,), RULE, "failure", 100.0 * share, "%",
            f"{names([second])}: {100 * share:.0f} % of its {what} are those of run {first}; one recording was probably taken twice",
            f'[constants] run_id = "{{stem}}" (and leave the copy of {first} out of the import)',
        )  # fmt: skip


def _pairs(keys: list[Keys], least: int) -> dict[tuple[int, int], float]:
    """Return pairs of runs that share keys, with the share of the smaller one."""
    if len(keys) < 2 or not sum(map(len, keys)):
        return {}
    every = np.concatenate(keys)
    owner = np.repeat(np.arange(len(keys)), [len(k) for k in keys])
    order = np.argsort(every, kind="stable")
    every, owner = every[order], owner[order]
    # runs are few that share a key: compare each with the next two of the same key
    found: Counter[tuple[int, int]] = Counter()
    for step in (1, 2):
        same = np.flatnonzero(every[step:] == every[:-step])
        found.update(zip(owner[same].tolist(), owner[same + step].tolist(), strict=True))
    shares = {}
    for (a, b), count in found.items():
        share = count / max(1, min(len(keys[a]), len(keys[b])))
        if a != b and count >= least and share > SHARE:
            shares[min(a, b), max(a, b)] = share
    return shares
