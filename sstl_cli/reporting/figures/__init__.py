"""One file a figure: ``data`` (the numbers, tested), ``figure`` (size in inch, grid of axes), ``draw``, ``alt``.

A module that ``sstl plot`` offers also says what it ``NEEDS`` and gives ``default(inputs, run)``: the data of the
first (or named) subject, or None.
"""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def find() -> dict[str, ModuleType]:
    """Return every figure module by name, in alphabetical order."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__))
    return {name: importlib.import_module(f"{__name__}.{name}") for name in names}
