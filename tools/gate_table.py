"""Judge wrong recordings, each spoilt by one slip, and sound ones by the physics gate; fills docs/gate.md.

Slips, their sizes, rigs, sensors and movements are drawn from the seed. ``--fixed`` takes the slips of fixed size on the
rigs of one kind that the rules were first written with.

Usage: python tools/gate_table.py [--seed 1] [--sound 40] [--fixed] [--only words] [--publish]
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
from slips.drawn import Drawn, draw  # noqa: E402
from slips.fresh import ALL  # noqa: E402
from slips.sound import draw as draw_alike  # noqa: E402
from slips.wide import wide  # noqa: E402
from slips.wrong import SLIPS  # noqa: E402

from sstl_cli.identification.gate import Remark, remarks  # noqa: E402


@dataclass(frozen=True)
class Row:
    """What was said of one wrong recording; ``right`` where the first remark is in the right words and names a spoilt run."""

    name: str
    said: tuple[Remark, ...]
    right: bool


def fixed(seed: int) -> Iterator[Drawn]:
    """Yield the slips of fixed size, each on a log of its own."""
    for number, slip in enumerate(SLIPS):
        log = draw_alike(1000 * seed + number, 1, slip.leads, slip.systems)
        yield Drawn(slip.name, slip.rules, log, slip.spoil(log, np.random.default_rng((seed, number))))


def judged(slips: Iterator[Drawn], only: str = "") -> Iterator[Row]:
    """Yield a row for every slip whose name has one of the words ``only`` (a|b)."""
    for one in slips:
        if not any(word in one.name for word in only.split("|")):
            continue
        before = {r.run_id: r for r in one.sound}
        touched = {r.run_id for r in one.wrong if before.get(r.run_id) is not r}
        said = remarks(one.wrong)
        # of two rigs in one log neither is the wrong one
        named = bool(said) and (one.name.startswith("two rigs") or bool(touched & set(said[0].run_ids)))
        yield Row(one.name, said, named and said[0].rule in one.rules)


def sound(seed: int, count: int, alike: bool) -> Iterator[tuple[Remark, ...]]:
    """Yield what was said of sound logs: none, one or two effects of plausible size."""
    for i in range(count):
        number = 500_000 + 1000 * seed + i
        yield remarks(draw_alike(number, i % 3) if alike else wide(10 * number))


def main() -> None:
    """Judge, print what went amiss, and fill the page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sound", type=int, default=40)
    parser.add_argument("--fixed", action="store_true")
    parser.add_argument("--only", default="", help="words of slips, a|b")
    parser.add_argument("--publish", action="store_true")
    given = parser.parse_args()
    rows, clean = [], []
    for row in judged(fixed(given.seed) if given.fixed else draw(given.seed, ALL), given.only):
        rows.append(row)
        if not row.right:
            print(f"MISSED {row.name}: " + ("; ".join(r.line() for r in row.said)[:300] or "nothing said"), flush=True)
    for i, said in enumerate(sound(given.seed, given.sound, given.fixed)):
        clean.append(said)
        for r in said:
            print(f"SOUND {i}: {r.line()[:300]}", flush=True)
    told = sum(r.right for r in rows)
    remarked, failed = sum(bool(s) for s in clean), sum(any(r.failed for r in s) for s in clean)
    what = f"{told} of {len(rows)} wrong recordings were told in the right words; {remarked} of {len(clean)} sound ones were remarked on, {failed} failed (seed {given.seed})."
    print(what)
    if given.publish:
        lines = [
            [r.name, "yes" if r.right else "no", ", ".join(dict.fromkeys(f"{s.rule}{' (failure)' if s.failed else ''}" for s in r.said)) or "nothing"]
            for r in rows
        ]  # fmt: skip
        put("gate.md", "slips", what + "\n\n" + table(["slip", "told", "said"], lines))


if __name__ == "__main__":
    main()
