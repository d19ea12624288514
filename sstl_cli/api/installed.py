"""What is installed, and what the documents of the program hold."""

from __future__ import annotations

from typing import Any

from sstl_cli.core.documents import catalogue, get
from sstl_cli.core.documents.outputs import DoctorDocument
from sstl_cli.steps import doctor as examining

__all__ = ["DoctorDocument", "doctor", "schema"]


def doctor() -> DoctorDocument:
    """Return versions, cores, extras and a self-test of a few seconds, as ``sstl doctor --json`` prints them.

    Examples
    --------
    >>> found = doctor()
    >>> found.ok, [p.name for p in found.probes]
    (True, ['packages', 'compile cache', 'self-test'])
    """
    return examining.run()


def schema(name: str | None = None) -> dict[str, Any]:
    """Return the JSON Schema of a document such as ``"diagnosis"``, or of all of them by name, as ``sstl schema`` prints it.

    Raises
    ------
    SstlError
        For a name that no document has, with the nearest.

    Examples
    --------
    >>> schema("diagnosis")["properties"]["schema"]["const"]
    'sstl.diagnosis/1'
    >>> "watch" in schema()
    True
    """
    return {known: model.json_schema() for known, model in catalogue().items()} if name is None else get(name).json_schema()
