"""The house in numbers, at an earlier commit and now: the table of CONTRIBUTING.md.

python tools/house.py COMMIT
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import tarfile
import tempfile
from collections import Counter
from pathlib import Path

from page_part import put, table

ROOT = Path(__file__).resolve().parents[1]
# a comment above a function with the reason why it is long (tests/trust/test_trust_size.py)
REASON = re.compile(r"^# long: ")
LONG_FILE, LONG_FUNCTION, MANY_ARGUMENTS = 400, 60, 8
# words by which something is not typed, and by which a checker is told to look away
UNTYPED = {f"`dict[str, {kind}]` and `Mapping[str, {kind}]`": re.compile(rf"(?:dict|Mapping)\[str, {kind}\]") for kind in ("Any", "object")}
IGNORED = re.compile(r"# (?:noqa|type: ignore)")


def has_reason(function: ast.FunctionDef, lines: list[str]) -> bool:
    """Tell whether the comments right above a function say why it is long."""
    above = min(function.lineno, *(d.lineno for d in function.decorator_list), function.lineno) - 2
    while above >= 0 and lines[above].lstrip().startswith("#"):
        if REASON.match(lines[above].lstrip()):
            return True
        above -= 1
    return False


def counted(root: Path) -> Counter[str]:
    """Return what there is of each kind under a checkout: lines by layer, and what a reader stumbles over."""
    found: Counter[str] = Counter()
    for path in sorted((root / "sstl_cli").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        lines = text.count("\n")
        layer = path.relative_to(root / "sstl_cli").parts[0]
        found["lines in " + (layer if not layer.endswith(".py") else "the top")] += lines
        found["lines in all"] += lines
        found[f"files of more than {LONG_FILE} lines"] += lines > LONG_FILE
        for name, pattern in UNTYPED.items():
            found[name] += len(pattern.findall(text))
        found["`noqa` and `type: ignore`"] += len(IGNORED.findall(text))
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                long = (node.end_lineno or node.lineno) - node.lineno + 1 > LONG_FUNCTION
                found[f"functions of more than {LONG_FUNCTION} lines, with their docstrings"] += long
                found["of these without a reason beside them"] += long and not has_reason(node, text.splitlines())
                arguments = len(node.args.posonlyargs) + len(node.args.args) + len(node.args.kwonlyargs)
                found[f"functions of more than {MANY_ARGUMENTS} arguments"] += arguments > MANY_ARGUMENTS
    for path in (root / "tests").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        found["lines of tests"] += text.count("\n")
        found["test functions"] += len(re.findall(r"^def test_", text, re.M))
    return found


def at(commit: str, folder: Path) -> Path:
    """Return a folder with the package and the tests of a commit."""
    packed = subprocess.run(["git", "archive", commit, "sstl_cli", "tests"], cwd=ROOT, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def main() -> None:
    """Fill the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("commit")
    commit = parser.parse_args().commit
    with tempfile.TemporaryDirectory() as folder:
        before = counted(at(commit, Path(folder)))
    now = counted(ROOT)
    layers = sorted(k for k in {*before, *now} if k.startswith("lines in ") and k != "lines in all")
    kinds = [*layers, "lines in all", *(k for k in now if not k.startswith("lines in "))]
    put("../CONTRIBUTING.md", "house", table(["", commit, "now"], [[k, before[k], now[k]] for k in kinds]))


if __name__ == "__main__":
    main()
