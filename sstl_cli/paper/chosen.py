"""Which tables there are, and which ones ``--table`` names; imports nothing heavy."""

from __future__ import annotations

from sstl_cli.core.errors import UsageError, nearest

TABLES = ("I", "II", "III", "IV", "R", "diagnosis", "withheld", "figures", "better", "probe", "tendons", "distal")
#: what ``all`` means: the others take longer than the paper's own tables
DEFAULT = ("I", "II", "III", "IV", "R", "diagnosis", "figures")


def chosen(text: str) -> tuple[str, ...]:
    """Return the tables that ``--table`` names: one, several with commas, or ``all``.

    Raises
    ------
    UsageError
        E803 for an unknown name.
    """
    names = [n.strip() for n in text.split(",") if n.strip()]
    if names == ["all"]:
        return DEFAULT
    for name in names:
        if name not in TABLES:
            raise UsageError(f"no table '{name}' ({nearest(name, [*TABLES, 'all'])})", where="--table", code="E803")
    if not names:
        raise UsageError("no table named", where="--table", fix=f"use all, or some of {','.join(TABLES)}", code="E803")
    return tuple(t for t in TABLES if t in names)
