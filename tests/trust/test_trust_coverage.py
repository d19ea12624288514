"""What the tests run is added up part by part."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import coverage_table


def test_parts_are_added_up_and_all_of_them_too() -> None:
    def file(run: int, lines: int, taken: int, branches: int) -> dict[str, dict[str, int]]:
        return {"summary": {"covered_lines": run, "num_statements": lines, "covered_branches": taken, "num_branches": branches}}

    files = {"sstl_cli/core/a.py": file(3, 4, 1, 2), "sstl_cli/core/b/c.py": file(3, 8, 0, 0), "sstl_cli/__init__.py": file(1, 1, 0, 0)}
    assert coverage_table.table({"files": files})[2:] == [
        "| (top) | 1 | 100.0 | 0 | - |",
        "| core | 12 | 50.0 | 2 | 50.0 |",
        "| all | 13 | 53.8 | 2 | 50.0 |",
    ]
