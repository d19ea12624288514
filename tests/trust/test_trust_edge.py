"""A mapping whose values have no type stands where a file is read or written, or a library hands one over, and nowhere between."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2] / "sstl_cli"
# what is read or written there, or comes from a library as it is
EDGE = {
    "api/diagnosis.py": "a document as the JSON that it is printed as",
    "api/installed.py": "JSON Schemas",
    "blind/kept.py": "rows of a result as JSON holds them",
    "blind/library.py": "rows and metadata of a Parquet file",
    "blind/seal.py": "published hashes, a plan and a sealed truth (JSON)",
    "blind/truth.py": "a sealed truth (JSON), old ones included",
    "cli/_gathered.py": "the arguments that typer calls a command with",
    "cli/options.py": "a configuration (TOML)",
    "control/parameters.py": "a parameter file (JSON)",
    "core/config.py": "TOML",
    "core/documents/base.py": "documents and their schemas as JSON holds them",
    "core/documents/logs.py": "provenance, as whoever wrote the file put it",
    "diagnosis/weights.py": "learned weights (JSON) and where they come from",
    "importers/inline.py": "a mapping, before it is checked",
    "importers/isolate.py": "the head of a message between processes (JSON)",
    "importers/mapping.py": "a mapping (TOML), before it is checked",
    "importers/ros_messages.py": "a message of a robot, flattened",
    "reporting/load.py": "rows of a Parquet file",
    "steps/diagnose.py": "a document as JSON holds it; odds (TOML), before they are checked",
    "steps/diagnose_tendons.py": "a document as JSON holds it",
}


def untyped(source: str) -> int:
    """Return how many mappings with text as keys have values of any type."""
    found = 0
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in ("dict", "Mapping"):
            of = [getattr(part, "id", None) for part in getattr(node.slice, "elts", ())]
            found += of == ["str", "Any"]
    return found


def test_values_without_a_type_stand_at_the_edge_alone() -> None:
    found = {str(p.relative_to(ROOT)): untyped(p.read_text(encoding="utf-8")) for p in sorted(ROOT.rglob("*.py"))}
    assert {name for name, n in found.items() if n} == set(EDGE)
    # fewer belong here
    assert sum(found.values()) <= 39


def test_they_are_found_in_whatever_they_stand() -> None:
    assert untyped("def f(x: dict[str, Any], y: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]: ...") == 3
    assert untyped("X = dict[str, object] | dict[int, Any] | list[Any]") == 0
