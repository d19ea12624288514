"""How learned weights do on a simulator that they have not seen: the table of docs/blind.md.

sstl blind learn data/library-*.parquet --out weights.json --json > learn.json; python tools/learned_table.py learn.json
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from blind_table import share
from page_part import put, table

ROWS = {
    "false_alarm": "false alarm",
    "wrong_commits": "wrong commits",
    "wrong_as_drawn": "wrong commits, cases as drawn",
    "unknown_recall": "unknown recall",
    "both_of_a_pair": "both of a pair",
    "covered": "coverage of the ambiguity set",
}


def left_out(rows: list[dict[str, Any]]) -> str:
    """Return every rate with one column a simulator, whose weights are learned from the other two; all together last."""
    lines: list[list[object]] = [["examples", *(r["cases"] for r in rows)]]
    lines += [[f"isolated at {s} x noise", *(share(r["exact"][s]) for r in rows)] for s in rows[0]["exact"]]
    lines += [[said, *(share(r[name]) for r in rows)] for name, said in ROWS.items()]
    return table(["rate, weights of the other two", *(r["simulator"] for r in rows)], lines)


def main() -> None:
    """Fill the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("learned", type=Path)
    document = json.loads(parser.parse_args().learned.read_text(encoding="utf-8"))
    parts = [left_out(document["left_out"])]
    if document.get("accepted") is not None:
        parts += ["The same of what has changed since a model was accepted:", left_out(document["accepted"])]
    put("blind.md", "learned", "\n\n".join(parts))
    print("\n\n".join(parts))


if __name__ == "__main__":
    main()
