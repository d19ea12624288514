"""Every example in a docstring says what the program does."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# those of the public face are run with it, and cost a diagnosis
MODULES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in sorted((ROOT / "sstl_cli").rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8") and path.parent.name != "api" and path.name != "__init__.py"
]


def test_there_are_examples() -> None:
    assert len(MODULES) > 30 and "sstl_cli.core.numbers" in MODULES


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module(name: str) -> None:
    tried = doctest.testmod(importlib.import_module(name))
    assert tried.attempted and not tried.failed
