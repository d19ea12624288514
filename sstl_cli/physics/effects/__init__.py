"""The catalogue: one file, one effect; a new file beside these is found by itself."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.physics.effect import Effect


@cache
def catalogue() -> Mapping[str, Effect]:
    """Return all effects by id, in the order of their ids."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__))
    found = [importlib.import_module(f"{__name__}.{name}").EFFECT for name in names]
    return {effect.id: effect for effect in found}


def get(effect_id: str) -> Effect:
    """Return one effect; SstlError with the nearest id if there is none."""
    known = catalogue()
    if effect_id not in known:
        raise SstlError(f"unknown effect '{effect_id}' ({nearest(effect_id, known)})", code="E700")
    return known[effect_id]


def parse(text: str) -> tuple[str, dict[str, float]]:
    """Return the id and values of ``ID[:param=value,...]`` as typed on a command line."""
    effect_id, _, rest = text.partition(":")
    effect = get(effect_id.strip())
    values: dict[str, float] = {}
    for item in filter(None, (s.strip() for s in rest.split(","))):
        name, equals, number = item.partition("=")
        try:
            if not equals:
                raise ValueError
            values[name.strip()] = float(number)
        except ValueError:
            raise SstlError(f"'{item}' is not param=value", where=f"effect {effect.id}", code="E703") from None
    return effect.id, effect.complete(values if values else typical(effect), usual=True)


def typical(effect: Effect) -> dict[str, float]:
    """Return a clearly visible strength: the first parameter a third of the way to its upper bound."""
    first = effect.parameters[0]
    start = {p.name: p.start for p in effect.parameters if p.start is not None}
    return {first.name: first.neutral + (first.high - first.neutral) / 3.0, **start}
