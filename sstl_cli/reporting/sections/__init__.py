"""One file a section: TITLE, ORDER, what it NEEDS (any of these kinds), and ``context(inputs)`` for its template."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def find() -> list[tuple[str, ModuleType]]:
    """Return every section as (name, module) in the order of the page."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__))
    found = [(name, importlib.import_module(f"{__name__}.{name}")) for name in names]
    return sorted(found, key=lambda f: (f[1].ORDER, f[0]))
