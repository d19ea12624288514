"""Parameters of a test that every run of the suite asks, and those that are left to the slow one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import pytest


def asked(values: Iterable[Any], *now: Any, several: bool = False) -> list[Any]:
    """Return what a test is asked, ``several`` arguments at a time or one; what is not among ``now`` is slow."""
    return [v if v in now else pytest.param(*(v if several else (v,)), marks=pytest.mark.slow) for v in values]


def thin(items: Iterable[pytest.Item]) -> None:
    """Mark as slow, of each test marked ``each_once``, all but as many as it takes to ask every value of every parameter once."""
    tests: dict[str, list[pytest.Function]] = {}
    for item in items:
        if isinstance(item, pytest.Function) and hasattr(item, "callspec") and item.get_closest_marker("each_once"):
            tests.setdefault(item.nodeid.split("[")[0], []).append(item)
    for alike in tests.values():
        now = {i for i, item in enumerate(alike) if not item.get_closest_marker("slow")}
        kept = covering([set(given(alike[i])) for i in sorted(now)])
        for i in now - {sorted(now)[k] for k in kept}:
            alike[i].add_marker(pytest.mark.slow)


def given(item: pytest.Function) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield for every parametrize of a test what this item has of it: the same objects in all its items."""
    for mark in item.iter_markers("parametrize"):
        names = mark.args[0].split(",") if isinstance(mark.args[0], str) else mark.args[0]
        yield str(mark.args[0]), tuple(id(item.callspec.params[n.strip()]) for n in names)


def covering(sets: Sequence[set[Any]]) -> set[int]:
    """Return which of some sets hold together all that they all do, the one that adds the most first.

    Examples
    --------
    >>> sorted(covering([{1, "a"}, {1, "b"}, {2, "a"}, {2, "b"}]))
    [0, 3]
    """
    left, chosen = set().union(*sets), set()
    while left:
        best = max(range(len(sets)), key=lambda i: (len(sets[i] & left), -i))
        chosen.add(best)
        left -= sets[best]
    return chosen
