"""The effects that are at work, with their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sstl_cli.physics.effect import Effect, Values
from sstl_cli.physics.effects import get


@dataclass(frozen=True)
class Active:
    """Effects with their values, ready to simulate; built once and used for every run."""

    items: tuple[tuple[Effect, Values], ...]

    def of_hook(self, name: str) -> list[tuple[Effect, Values]]:
        """Return the effects that have the hook, in the order in which a signal meets them."""
        return [(e, v) for e, v in self.items if getattr(e, name) is not None]


def activate(effects: Mapping[str, Values]) -> Active:
    """Return the effects that are not neutral, checked against their bounds and in sensor order."""
    items = []
    for effect_id, values in effects.items():
        effect = get(effect_id)
        full = effect.complete(values)
        if effect.active(full):
            items.append((effect, full))
    return Active(tuple(sorted(items, key=lambda item: (item[0].order, item[0].id))))
