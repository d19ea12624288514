"""What the bristle simulator has code for: one file, one effect; a new file beside these is found by itself."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from sstl_cli.physics.bristle.effect import Effect
from sstl_cli.physics.given import Bounds, Values, discovered, resolved


@cache
def catalogue() -> Mapping[str, Effect]:
    """Return the effects by id, in the order in which they act."""
    return discovered(Effect, __name__, __path__)


def parameters() -> Mapping[str, Mapping[str, Bounds]]:
    """Return neutral value and range of every parameter by effect."""
    return {name: effect.parameters for name, effect in catalogue().items()}


def resolve_effects(effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect, neutral where `effects` is silent; ValueError where one is unknown or out of range.

    Examples
    --------
    >>> resolve_effects({"stribeck": {"ratio": 1.2}})["stribeck"]
    {'ratio': 1.2, 'v_s_mm_s': 1.0}
    """
    return resolved("bristle", parameters(), effects)
