"""How logs, mappings and file names write the two systems."""

from __future__ import annotations

from sstl_cli.core.errors import SstlError

# in small letters, and the name that a log has for it; each is understood in any letters
SYSTEM_OF = {"act": "act", "sstl": "sstl", "actuation": "act", "sensing": "sstl"}
# how a label says it by the tendon's way; as words of a file's name they may be of something else
WAY_OF = {
    **dict.fromkeys(
        ("single", "single pass", "one pass", "one way", "actuate", "actuating", "einfach", "einzeln", "sencillo", "singolo"), "act"
    ),
    **dict.fromkeys(("loop", "double", "double pass", "two pass", "two way", "round trip", "sense"), "sstl"),
    **dict.fromkeys(("doppelt", "doppel", "schleife", "doble", "doppio", "boucle"), "sstl"),
}

# beside such a word these say nothing more
_BESIDE = frozenset(("self", "mode", "system", "tendon", "sheath"))


def known_system(text: object) -> str:
    """Return ``act`` or ``sstl`` for a label as it is written, an empty text where it is neither.

    Examples
    --------
    >>> known_system("SSTL"), known_system("double-pass"), known_system("tip"), known_system("self-sensing loop"), known_system("no loop")
    ('sstl', 'sstl', '', 'sstl', '')
    """
    parts = str(text).lower().replace("_", " ").replace("-", " ").split()
    plain = " ".join(parts)
    if whole := SYSTEM_OF.get(plain) or WAY_OF.get(plain):
        return whole
    # sensing loop: every word that says one says the same, and none something else
    told = {SYSTEM_OF.get(p) or WAY_OF.get(p, "") for p in parts if p not in _BESIDE}
    return told.pop() if len(told) == 1 else ""


def system_of(text: object, where: str) -> str:
    """Return the same; SstlError (E334) where it is neither."""
    found = known_system(text)
    if not found:
        raise SstlError(f"system is {text!r}", where=where, fix="it must be 'act' or 'sstl'", code="E334")
    return found
