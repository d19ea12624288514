"""Where a file came from: version, command line, seed and the SHA-256 of every input."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from sstl_cli import __version__
from sstl_cli.core.errors import printable
from sstl_cli.core.files import require_regular


@dataclass(frozen=True)
class Provenance:
    """What made a file; it holds nothing that changes between identical calls (no date, no host)."""

    command: str
    seed: int | None = None
    inputs: dict[str, str] = field(default_factory=dict)
    extra: dict[str, object] = field(default_factory=dict)

    def metadata(self, schema_id: str, schema_version: int) -> dict[str, str]:
        """Return the table metadata stored under the key ``sstl``."""
        body = {"schema": schema_id, "schema_version": schema_version, "package_version": __version__, **asdict(self)}
        return {"sstl": json.dumps(body, sort_keys=True)}


def by_another(version: object, what: str) -> list[str]:
    """Return a note where ``what`` was made by another version of sstl than this; none where it does not say by which.

    Examples
    --------
    >>> by_another("0.0.1", "the simulator")  # doctest: +ELLIPSIS
    ['the simulator was made by sstl 0.0.1, this is ...: make it again where its numbers matter']
    >>> by_another(None, "the simulator")
    []
    """
    if version is None or version == __version__:
        return []
    return [f"{what} was made by sstl {printable(str(version))}, this is {__version__}: make it again where its numbers matter"]


def sha256(path: Path | str) -> str:
    """Return the SHA-256 of a file as hexadecimal text, reading it in blocks."""
    require_regular(path)
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def inputs_of(paths: list[Path]) -> dict[str, str]:
    """Return ``{file name: sha256}``; names only, so that a moved folder gives the same bytes.

    Files of one name in several folders are told apart by a number: ``log.parquet``, ``log.parquet (2)``.
    """
    found: dict[str, str] = {}
    for name, digest in sorted({(Path(p).name, sha256(p)) for p in paths}):
        number = 1 + sum(n == name or n.startswith(f"{name} (") for n in found)
        found[name if number == 1 else f"{name} ({number})"] = digest
    return found
