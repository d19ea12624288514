"""Functions fit a screen and files a sitting, or a line beside them says why not."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINES, FILE_LINES = 60, 400


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return how many lines a function has without its decorators and its docstring."""
    first = function.body[0]
    told = ast.get_docstring(function) is not None
    return function.end_lineno - function.lineno + 1 - (first.end_lineno - first.lineno + 1 if told else 0)


def excused(function: ast.FunctionDef | ast.AsyncFunctionDef, lines: list[str]) -> bool:
    """Tell whether the comment above a function begins with ``long:`` and a reason."""
    above = min([function.lineno, *(d.lineno for d in function.decorator_list)]) - 2
    while above >= 0 and lines[above].lstrip().startswith("#"):
        if lines[above].lstrip("# ").startswith("long: "):
            return True
        above -= 1
    return False


def long_functions(text: str) -> Iterator[tuple[str, int]]:
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            n = body_lines(node)
            if n > LINES and not excused(node, lines):
                yield node.name, n


def sources() -> Iterator[Path]:
    for top in ("sstl_cli", "tests", "tools", "benchmarks"):
        yield from sorted((ROOT / top).rglob("*.py"))


def test_no_function_is_longer_than_a_screen_without_a_reason() -> None:
    found = {}
    for path in sources():
        for name, n in long_functions(path.read_text(encoding="utf-8")):
            found[f"{path.relative_to(ROOT)}: {name}"] = n
    assert found == {}


def test_no_file_is_longer_than_a_sitting() -> None:
    counted = {p.relative_to(ROOT): len(p.read_text(encoding="utf-8").splitlines()) for p in sources()}
    assert {str(p): n for p, n in counted.items() if n > FILE_LINES} == {}


def test_the_count_sees_what_is_long_and_what_says_why() -> None:
    body = "    x = 1\n" * LINES
    assert list(long_functions(f"def f():\n{body}")) == [("f", LINES + 1)]
    assert list(long_functions(f"def f():\n    '''Why\n    and how.'''\n{body[10:]}")) == []
    assert list(long_functions(f"# long: one table\n@cached\ndef f():\n{body}")) == []
    assert list(long_functions(f"# one table\ndef f():\n{body}")) == [("f", LINES + 1)]
