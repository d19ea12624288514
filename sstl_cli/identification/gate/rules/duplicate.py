"""The same recording twice: two runs share their samples, or their noise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.fingerprints import NO_PRINTS, Keys, Prints, Sketch, words_of
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.joined import jumps

RULE, RANK = "duplicate", 3
# half of the samples, and enough of them, must return
SHARE, LEAST = 0.5, 16
# correlation of the noise of copies that were rounded or put in another unit; words of signs that make them worth a look
ALIKE, LEAST_WORDS = 0.7, 3
# a stretch as long as this at the least belongs to another recording where a run jumps
PART = 0.9
# keys of all runs that are sorted together
AT_ONCE = 262_144


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that repeat an earlier one."""
    exact = _exact([e.prints for e in log])
    noise = _noise([e.sketch for e in log])
    seen: set[int] = set()
    for (a, b), share in sorted({**noise, **exact}.items()):
        if b in seen or (share < PART and (jumps(log[a]) or jumps(log[b]))):
            # one that jumps to another recording and goes on as that one is joined, not copied
            continue
        seen.add(b)
        same = (a, b) in exact
        what = "samples" if same else "noise (in another unit, with another zero or with fewer digits)"
        first, second = log[a].run_id, log[b].run_id
        yield Remark(
            (second,), RULE, "failure", 100.0 * share, "%",
            f"{names([second])}: {100 * share:.0f} % of its {what} are those of run {first}; one recording was probably taken twice",
            f'[constants] run_id = "{{stem}}" (and leave the copy of {first} out of the import)',
        )  # fmt: skip
    yield from _attached(log, {*noise, *exact})
    yield from _twice(log)


def _twice(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that hold one recording twice, one after the other."""
    hit = [e for e in log if e.again.share > SHARE]
    if hit:
        e = max(hit, key=lambda h: h.again.share)
        later_s = e.again.later * e.dt_s
        yield Remark(
            tuple(h.run_id for h in hit), RULE, "failure", 100.0 * e.again.share, "%",
            f"{names([h.run_id for h in hit])}: {100 * e.again.share:.0f} % of its samples are there twice, noise included, {later_s:.4g} s apart; one "
            "recording was probably put in twice, one after the other",
            f"[time] to_s = {later_s:.6g} (for this file)",
        )  # fmt: skip


def _attached(log: Sequence[Evidence], copies: set[tuple[int, int]]) -> Iterator[Remark]:
    """Yield pairs of runs that share their output and not their input: one input may have two outputs, but no output two inputs."""
    seen: set[int] = set()
    # a dead sensor holds no recording
    for (a, b), share in sorted(_exact([NO_PRINTS if e.but_noise(1) else e.output_prints for e in log]).items()):
        if (a, b) in copies or b in seen or share < PART:
            continue
        seen.add(b)
        ids = (log[a].run_id, log[b].run_id)
        yield Remark(
            ids, RULE, "failure", 100.0 * share, "%",
            f"{names(ids)}: {100 * share:.0f} % of the output are the same samples, noise included, but the inputs are two; the output of one "
            "recording was probably put beside the input of the other",
            '[files] merge = "channels", key = (the named group that tells which files belong together)',
        )  # fmt: skip


def _exact(prints: list[Prints]) -> dict[tuple[int, int], float]:
    """Return pairs of runs that share samples, with the share of the smaller one."""
    shares = {}
    for (a, b), count in _shared([p.keys for p in prints], (1, 2)).items():
        first, second = prints[a], prints[b]
        # where one run has kept a part of its own, only that part can be shared
        below = min(first.below, second.below)
        share = count / max(1, min(first.less(below), second.less(below)))
        if count >= LEAST and share > SHARE:
            shares[a, b] = share
    return shares


def _noise(sketches: list[Sketch]) -> dict[tuple[int, int], float]:
    """Return pairs of runs that share the noise of both channels, with its correlation."""
    found = {}
    for (a, b), count in _shared([words_of(s) for s in sketches], (1, 2, 3)).items():
        first, second = sketches[a], sketches[b]
        # levels of a coarse converter may be crossed alike in two runs, noise is never the same
        if count < LEAST_WORDS or not any((*first.noise, *second.noise)):
            continue
        # runs of one movement may share a reference, and two outputs an input: both channels must agree
        alike = float(np.min(np.sum(first.fast * second.fast, axis=1)))
        if alike > ALIKE:
            found[a, b] = alike
    return found


def _shared(keys: list[Keys], steps: Sequence[int]) -> Counter[tuple[int, int]]:
    """Return how many keys (ascending) pairs of runs share; of many with one key each is compared with the next few."""
    found: Counter[tuple[int, int]] = Counter()
    total = sum(map(len, keys))
    if len(keys) < 2 or not total:
        return found
    # equal keys lie in one part of their range, so that memory does not grow with the number of runs
    parts, top = -(-total // AT_ONCE), max(int(k[-1]) for k in keys if len(k)) + 1
    begin = [0] * len(keys)
    for part in range(1, parts + 1):
        end = [len(k) if part == parts else int(np.searchsorted(k, np.uint64(top * part // parts))) for k in keys]
        found.update(_met([k[i:j] for k, i, j in zip(keys, begin, end, strict=True)], steps))
        begin = end
    return found


def _met(keys: list[Keys], steps: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of runs for each key that they share."""
    every = np.concatenate(keys)
    owner = np.repeat(np.arange(len(keys)), [len(k) for k in keys])
    order = np.argsort(every, kind="stable")
    every, owner = every[order], owner[order]
    for step in steps:
        same = np.flatnonzero(every[step:] == every[:-step])
        pairs = np.sort(np.stack((owner[same], owner[same + step])), axis=0).T
        yield from ((a, b) for a, b in pairs.tolist() if a != b)
