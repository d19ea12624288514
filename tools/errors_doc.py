"""Keep docs/errors.md complete: every code the program uses, none it does not.

``python tools/errors_doc.py`` writes the page again: meaning and advice are kept from the page as it is, the codes
come from the code. ``--check`` only compares. Both end with 1 and a list if a code has no meaning yet.
"""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "errors.md"
PARTS = {
    "0": "Command line and batches",
    "1": "Files, tables and configuration",
    "2": "Identification, checking and summaries",
    "3": "Importing and exporting logs",
    "4": "Control",
    "5": "Mapping",
    "6": "Reports and figures",
    "7": "Physics and scenarios",
    "8": "The paper's tables",
    "9": "Diagnosis and blind check",
}
HEAD = """# Errors

Every failure prints one line, `sstl: [CODE] where: what; what to do`, on standard error; with `--json` also a document
`sstl.error/1` on standard output. Exit codes: 1 failed, 2 usage, 3 done with data set aside, 4 a gate was missed. This page is kept complete by `python tools/errors_doc.py`.
"""
_CODE = re.compile(r"\bE\d{3}\b")


def used() -> set[str]:
    """Return the codes that stand in the program's text constants (docstrings aside)."""
    found: set[str] = set()
    for path in sorted((ROOT / "sstl_cli").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if not _CODE.search(text):
            continue
        tree = ast.parse(text)
        docstrings = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
            and node.body
            and isinstance(node.body[0], ast.Expr)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
                found.update(_CODE.findall(node.value))
    return found


def documented(text: str) -> dict[str, tuple[str, str]]:
    """Return meaning and advice of every code in the tables of a page."""
    found: dict[str, tuple[str, str]] = {}
    for line in text.splitlines():
        cells = [c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]]
        if len(cells) == 3 and _CODE.fullmatch(cells[0]):
            found[cells[0]] = (cells[1], cells[2])
    return found


def page(known: dict[str, tuple[str, str]], codes: set[str]) -> str:
    """Return the page with one table a range of codes."""
    lines = [HEAD]
    for digit, title in PARTS.items():
        here = sorted(c for c in codes if c[1] == digit)
        if not here:
            continue
        lines += [f"## E{digit}xx: {title}", "", "| code | meaning | what to do |", "|---|---|---|"]
        lines += [f"| {c} | {known.get(c, ('', ''))[0]} | {known.get(c, ('', ''))[1]} |" for c in here]
        lines.append("")
    return "\n".join(lines)


def problems() -> list[str]:
    """Return what is wrong with the page, in words."""
    codes = used()
    known = documented(PAGE.read_text(encoding="utf-8")) if PAGE.exists() else {}
    found = [f"{c} is used, but has no meaning and advice in docs/errors.md" for c in sorted(codes) if not all(known.get(c, ("", "")))]
    return found + [f"{c} is documented, but nothing uses it" for c in sorted(set(known) - codes)]


def main(arguments: list[str]) -> int:
    """Write the page again unless ``--check`` is given; return the exit code."""
    if "--check" not in arguments:
        known = documented(PAGE.read_text(encoding="utf-8")) if PAGE.exists() else {}
        PAGE.write_text(page(known, used()), encoding="utf-8")
    found = problems()
    for line in found:
        print(line, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
