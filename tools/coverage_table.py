"""Say which share of lines and branches the tests run, part by part, from what `make coverage` has measured."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

KINDS = (("covered_lines", "num_statements"), ("covered_branches", "num_branches"))


def table(report: dict[str, Any]) -> list[str]:
    """Return the rows of the table, one a part of the program, from the report that coverage writes as JSON."""
    sums: dict[str, list[int]] = defaultdict(lambda: [0, 0, 0, 0])
    for name, file in report["files"].items():
        inner = Path(name).parts[1:]
        part = inner[0] if len(inner) > 1 else "(top)"
        for i, key in enumerate(k for kind in KINDS for k in kind):
            sums[part][i] += file["summary"][key]
            sums["all"][i] += file["summary"][key]
    rows = ["| part | lines | run % | branches | run % |", "|---|---|---|---|---|"]
    for part in sorted(sums, key=lambda p: (p == "all", p)):
        run, lines, taken, branches = sums[part]
        rows.append(f"| {part} | {lines} | {_share(run, lines)} | {branches} | {_share(taken, branches)} |")
    return rows


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f}" if whole else "-"


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "coverage.json"
        subprocess.run([sys.executable, "-m", "coverage", "json", "--quiet", "-o", str(out)], check=True)
        print("\n".join(table(json.loads(out.read_text(encoding="utf-8")))))


if __name__ == "__main__":
    main()
