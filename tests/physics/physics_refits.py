"""The refits of tools/effects_table.py, so that the tests check what the table in docs/effects.md was made with."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

TOOL = Path(__file__).parents[2] / "tools" / "effects_table.py"


def table() -> ModuleType:
    """Return the tool as a module."""
    if "effects_table" not in sys.modules:
        spec = importlib.util.spec_from_file_location("effects_table", TOOL)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules["effects_table"] = module
        spec.loader.exec_module(module)
    return sys.modules["effects_table"]
