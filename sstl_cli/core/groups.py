"""Ambiguity groups as documents write them: classes have a name, their members stand beside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def spelled_out(verdict: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the effects of an ambiguity group, classes replaced by their members.

    Examples
    --------
    >>> spelled_out({"ambiguity_group": ["a", "lag: b | c"], "members": {"lag: b | c": ["b", "c"]}})
    ('a', 'b', 'c')
    """
    members = verdict.get("members")
    known = members if isinstance(members, Mapping) else {}
    return tuple(dict.fromkeys(i for e in verdict.get("ambiguity_group") or [] for i in known.get(e, [e])))
