"""How logs, mappings and file names write the two systems."""

from __future__ import annotations

from sstl_cli.core.errors import SstlError

# in small letters, and the name that a log has for it; each is understood in any letters
SYSTEM_OF = {"act": "act", "sstl": "sstl", "actuation": "act", "sensing": "sstl"}


def known_system(text: object) -> str:
    """Return ``act`` or ``sstl`` for a label as it is written, an empty text where it is neither.

    Examples
    --------
    >>> known_system("SSTL")
    'sstl'
    """
    return SYSTEM_OF.get(str(text).strip().lower(), "")


def system_of(text: object, where: str) -> str:
    """Return the same; SstlError (E334) where it is neither."""
    found = known_system(text)
    if not found:
        raise SstlError(f"system is {text!r}", where=where, fix="it must be 'act' or 'sstl'", code="E334")
    return found
