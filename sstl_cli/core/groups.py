"""Ambiguity groups as documents write them: classes have a name, their members stand beside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sstl_cli.core.documents.diagnosis import Verdict

# what samples errors are of
ANALYSED, RECORDED = "analysed", "all as recorded"


def spelled_out(group: Iterable[str], members: Mapping[str, Sequence[str]] | None) -> tuple[str, ...]:
    """Return the effects of an ambiguity group, classes replaced by their members.

    Examples
    --------
    >>> spelled_out(["a", "lag: b | c"], {"lag: b | c": ["b", "c"]})
    ('a', 'b', 'c')
    """
    known = members or {}
    return tuple(dict.fromkeys(i for e in group for i in known.get(e, [e])))


def of_samples(candidates: Iterable[Any]) -> list[tuple[str, list[str]]]:
    """Return what samples the errors of candidates are of, and whose they are; empty where all are of the same.

    Examples
    --------
    >>> from types import SimpleNamespace as S
    >>> of_samples([S(id="a", samples="analysed"), S(id="b", samples="all as recorded"), S(id="c", samples="analysed")])
    [('analysed', ['a', 'c']), ('all as recorded', ['b'])]
    >>> of_samples([S(id="a", samples="analysed")])
    []
    """
    found: dict[str, list[str]] = {}
    for c in candidates:
        if c.samples:
            found.setdefault(c.samples, []).append(c.id)
    return list(found.items()) if len(found) > 1 else []


def error_of(samples: str | None) -> str:
    """Return what an error is one of, by the samples that it is of; of the analysed ones nothing need be said.

    Examples
    --------
    >>> error_of("all as recorded"), error_of("channel tension_in (N)"), error_of("analysed"), error_of(None)
    ('all readings as recorded', 'channel tension_in (N)', '', '')
    """
    if not samples or samples == ANALYSED:
        return ""
    return "all readings as recorded" if samples == RECORDED else samples


def below(known_misfit_n: float | None) -> str:
    """Return what no model takes away of an error: noise, and of an accepted model what it was known to leave.

    Examples
    --------
    >>> below(None), below(2.1)
    ('the noise floor', 'the noise floor and the known misfit')
    """
    return "the noise floor and the known misfit" if known_misfit_n is not None and known_misfit_n > 0.0 else "the noise floor"


def rivals(verdict: Verdict) -> list[str]:
    """Return what else an ambiguity group holds beside the named effects, the parts of a combination joined.

    Documents of earlier versions do not say which effects stand together.

    Examples
    --------
    >>> from sstl_cli.core.documents.diagnosis import Verdict as V
    >>> rivals(V.model_construct(effects=["a"], causes=[["a"], ["b", "c"], ["b"]]))
    ['b + c', 'b']
    >>> rivals(V.model_construct(effects=["a"], ambiguity_group=["a", "b"]))
    ['b']
    """
    own = set(verdict.effects)
    if verdict.causes is None:
        return [e for e in spelled_out(verdict.ambiguity_group, verdict.members) if e not in own]
    return [" + ".join(c) for c in verdict.causes if set(c) != own]
