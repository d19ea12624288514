"""Compiled functions on disk under names that say what they hold, so that processes that share them cannot mix them up.

numba numbers the files of a function's signatures and writes the index that names them first. Two first runs at once may
both take number 1 for signatures of their own, and one that is killed in between, or read in between, leaves the index
pointing to machine code of an older version of the source. numba does not notice: code for another layout of an array reads
the wrong numbers from it.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

MODULE = "numba.core.caching"


def guard() -> None:
    """Change how numba keeps compiled functions, at once or when it is imported (which takes a while, and few calls need it)."""
    if MODULE in sys.modules:
        name_by_content(sys.modules[MODULE])
    elif not any(isinstance(finder, _Waiting) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Waiting())


class _Waiting(MetaPathFinder):
    """Waits for the import of numba's caches."""

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return the usual place of that one module, with our change to follow its execution."""
        if fullname != MODULE:
            return None
        sys.meta_path.remove(self)
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            loader: Any = spec.loader
            execute = loader.exec_module

            def then_change(module: ModuleType) -> None:
                execute(module)
                name_by_content(module)

            loader.exec_module = then_change
        return spec


def name_by_content(caching: Any) -> None:
    """Let ``IndexDataCacheFile`` of numba's module write each signature to a file of its own, and that file before the index."""

    def save(self: Any, key: Any, data: Any) -> None:
        what = repr((self._version, self._source_stamp, key)).encode()
        name = f"{self._index_name.removesuffix('.nbi')}.{hashlib.sha256(what).hexdigest()[:16]}.nbc"
        self._save_data(name, data)
        # of two that write the index at once the later stays; what it lacks is compiled once more
        self._save_index({**self._load_index(), key: name})

    caching.IndexDataCacheFile.save = save
