"""Small faults put into a module, one at a time: other operators, other numbers, turned conditions.

Left out is only what is no calculation: annotations, decorators (compiler options, not what is compiled), messages of
errors and formatted text, and ``strict=`` of zip, which guards against lengths that the code before it makes equal.
Faults that change no answer (``<`` for ``<=`` between floats that never meet, an initial value that is overwritten) cannot
be told from others by a program, stay in and count as survivors.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

COMPARE = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==", ast.Is: "is not",
    ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip
BINARY = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Pow: "*", ast.FloorDiv: "/", ast.Mod: "*",
    ast.BitAnd: "|", ast.BitOr: "&",
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A fault: the characters from ``start`` to ``end`` of a file become ``text``."""

    file: str
    line: int
    column: int
    start: int
    end: int
    old: str
    text: str

    def apply(self, source: str) -> str:
        """Return the source with the fault."""
        return source[: self.start] + self.text + source[self.end :]

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: `{self.old}` -> `{self.text}`"


def mutants(path: Path, name: str) -> list[Mutant]:
    """Return every fault this tool knows for one module, in the order of the source."""
    source = path.read_text(encoding="utf-8")
    raw = source.encode()
    starts = [0]
    for line in raw.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    tree = ast.parse(source)
    for node, text in _changes(tree, source):
        a = len(raw[: starts[node.lineno - 1] + node.col_offset].decode())
        b = len(raw[: starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)].decode())
        column = a - source.rfind("\n", 0, a)
        found.append(Mutant(name, node.lineno, column, a, b, source[a:b], text))
    # what a linter or the compiler would refuse is no test of the tests
    return sorted((m for m in found if "\n" not in m.old and _compiles(m.apply(source))), key=lambda m: (m.start, m.text))


def _compiles(source: str) -> bool:
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


def _changes(tree: ast.AST, source: str) -> Iterator[tuple[ast.expr, str]]:
    def text(node: ast.AST) -> str:
        return ast.get_source_segment(source, node) or ""

    for node in _code(tree):
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARE:
            yield node, f"{text(node.left)} {COMPARE[type(node.ops[0])]} {text(node.comparators[0])}"
        elif isinstance(node, ast.BinOp) and type(node.op) in BINARY and not _is_text(node):
            yield node, f"({_inner(node.left, text)} {BINARY[type(node.op)]} {_inner(node.right, text)})"
        elif isinstance(node, ast.BoolOp) and len(node.values) == 2:
            word = "or" if isinstance(node.op, ast.And) else "and"
            yield node, f"({text(node.values[0])} {word} {text(node.values[1])})"
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
            yield node, f"({text(node.operand)})"
        elif isinstance(node, ast.Constant):
            new = _number(node.value)
            if new is not None:
                yield node, new
        elif isinstance(node, (ast.If, ast.While, ast.IfExp)):
            yield node.test, f"(not ({text(node.test)}))"


def _inner(node: ast.AST, text: object) -> str:
    """Return an operand's text in brackets, so that precedence stays."""
    return f"({text(node)})"  # type: ignore[operator]


def _number(value: object) -> str | None:
    if isinstance(value, bool):
        return str(not value)
    if isinstance(value, int):
        return str(value + 1)
    if isinstance(value, float):
        return "1.0" if value == 0.0 else repr(1.5 * value)
    return None


def _is_text(node: ast.BinOp) -> bool:
    return any(isinstance(n, (ast.JoinedStr,)) or (isinstance(n, ast.Constant) and isinstance(n.value, str)) for n in ast.walk(node))


def _code(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that run: no annotations, decorators, messages of errors or formatted text."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list") or (
            isinstance(tree, (ast.Raise, ast.JoinedStr, ast.Subscript)) and name in ("exc", "values")
        ):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue
            if isinstance(child, ast.AST):
                yield child
                yield from _code(child)
