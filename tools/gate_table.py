"""Judge wrong recordings, each spoilt by one slip, and sound ones by the physics gate; fills docs/gate.md.

Usage: python tools/gate_table.py [--seed 1] [--sound 40] [--only words] [--publish]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "identification"), str(ROOT / "tools")]

from page_part import put, table  # noqa: E402
from slips.sound import draw  # noqa: E402
from slips.wrong import SLIPS, Slip  # noqa: E402

from sstl_cli.identification.gate import Remark, remarks  # noqa: E402


@dataclass(frozen=True)
class Row:
    """What was said of one wrong recording; ``right`` where the first remark is in the right words and names a spoilt run."""

    slip: Slip
    said: tuple[Remark, ...]
    right: bool


def wrong(seed: int, only: str = "") -> Iterator[Row]:
    """Yield a row for every slip whose name has one of the words ``only`` (a|b), each on a log of its own."""
    for number, slip in enumerate(SLIPS):
        if not any(word in slip.name for word in only.split("|")):
            continue
        log = draw(1000 * seed + number, 1, slip.leads, slip.systems)
        spoilt = slip.spoil(log, np.random.default_rng((seed, number)))
        before = {r.run_id: r for r in log}
        touched = {r.run_id for r in spoilt if before.get(r.run_id) is not r}
        said = remarks(spoilt)
        # of two rigs in one log neither is the wrong one
        named = bool(said) and (slip.name.startswith("two rigs") or bool(touched & set(said[0].run_ids)))
        right = named and said[0].rule in slip.rules
        yield Row(slip, said, right)


def sound(seed: int, count: int) -> Iterator[tuple[Remark, ...]]:
    """Yield what was said of sound logs: none, one or two effects of plausible size."""
    for i in range(count):
        yield remarks(draw(500_000 + 1000 * seed + i, i % 3))


def main() -> None:
    """Judge, print what went amiss, and fill the page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sound", type=int, default=40)
    parser.add_argument("--only", default="", help="words of slips, a|b")
    parser.add_argument("--publish", action="store_true")
    given = parser.parse_args()
    rows, clean = [], []
    for row in wrong(given.seed, given.only):
        rows.append(row)
        if not row.right:
            print(f"MISSED {row.slip.name}: " + ("; ".join(r.line() for r in row.said)[:300] or "nothing said"), flush=True)
    for i, said in enumerate(sound(given.seed, given.sound)):
        clean.append(said)
        for r in said:
            print(f"SOUND {i}: {r.line()[:300]}", flush=True)
    told = sum(r.right for r in rows)
    remarked, failed = sum(bool(s) for s in clean), sum(any(r.failed for r in s) for s in clean)
    print(f"{told} of {len(rows)} wrong recordings told in the right words; {remarked} of {len(clean)} sound ones remarked on, {failed} failed")
    if given.publish:
        head = f"{told} of {len(rows)} wrong recordings were told in the right words; {remarked} of {len(clean)} sound ones were remarked on, {failed} failed (seed {given.seed})."
        lines = [
            [r.slip.name, "yes" if r.right else "no", ", ".join(dict.fromkeys(f"{s.rule}{' (failure)' if s.failed else ''}" for s in r.said)) or "nothing"]
            for r in rows
        ]  # fmt: skip
        put("gate.md", "slips", head + "\n\n" + table(["slip", "told", "said"], lines))


if __name__ == "__main__":
    main()
