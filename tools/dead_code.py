"""Find what nothing uses: functions, classes, methods and constants of the package that no other line names.

``python tools/dead_code.py`` lists them and ends with 1 if there are any. A name is used where it stands as a name, an
attribute, an import or a word in a text: of the package, its templates, tools, benchmarks or tests.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "sstl_cli"
_WORD = re.compile(r"[A-Za-z_]\w*")
# found by name at run time, or by a library
HOOKS = {"register", "model_config", "program", "_repr_html_"}
PLAIN = {"property", "staticmethod", "classmethod", "njit", "dataclass", "cache", "contextmanager", "cached_property"}
# models of documents are found by their base class
FOUND_BY_BASE = {"Document"}
USERS = ("sstl_cli", "tools", "benchmarks", "tests")


def defined(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Yield name and line of every function, class, method and module constant."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            # what an unknown decorator takes (a command, a validator) is used by it
            known = all(_name(d) in PLAIN for d in node.decorator_list)
            based = isinstance(node, ast.ClassDef) and any(_name(b) in FOUND_BY_BASE for b in node.bases)
            if known and not based:
                yield node.name, node.lineno
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        for target in targets:
            if isinstance(target, ast.Name):
                yield target.id, node.lineno


def _name(node: ast.expr) -> str:
    node = node.func if isinstance(node, ast.Call) else node
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def used(tree: ast.Module) -> Counter[str]:
    """Return how often each name is read, imported, or stands in a text that is no docstring."""
    found: Counter[str] = Counter()
    docstrings = {
        id(n.body[0].value)
        for n in ast.walk(tree)
        if isinstance(n, (ast.Module, ast.ClassDef, ast.FunctionDef)) and n.body and isinstance(n.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            found[node.id] += 1
        elif isinstance(node, ast.Attribute):
            found[node.attr] += 1
        elif isinstance(node, ast.keyword) and node.arg:
            found[node.arg] += 1
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            found.update(_WORD.findall(node.value))
    return found


def dead() -> list[str]:
    """Return ``file:line name`` of everything that nothing uses."""
    trees = {p: ast.parse(p.read_text(encoding="utf-8")) for p in sorted(PACKAGE.rglob("*.py"))}
    uses: Counter[str] = Counter()
    for folder in USERS:
        for path in (ROOT / folder).rglob("*.py"):
            uses.update(used(trees.get(path) or ast.parse(path.read_text(encoding="utf-8"))))
    for path in PACKAGE.rglob("*.j2"):
        uses.update(_WORD.findall(path.read_text(encoding="utf-8")))
    return [
        f"{path.relative_to(ROOT)}:{line} {name}"
        for path, tree in trees.items()
        for name, line in sorted(set(defined(tree)), key=lambda d: d[1])
        if not uses[name] and name not in HOOKS and not (name.startswith("__") and name.endswith("__"))
    ]


if __name__ == "__main__":
    found = dead()
    print("\n".join(found))
    sys.exit(1 if found else 0)
