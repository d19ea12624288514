"""What the rig of law variants has code for: one file, one effect; a new file beside these is found by itself."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from sstl_cli.physics.given import Bounds, Values, discovered, resolved
from sstl_cli.physics.variant.effect import Effect
from sstl_cli.physics.variant.laws import Chosen, Law, draw, hint


@cache
def catalogue() -> Mapping[str, Effect]:
    """Return the effects by id, in the order in which they act."""
    return discovered(Effect, __name__, __path__)


def parameters() -> Mapping[str, Mapping[str, Bounds]]:
    """Return neutral value and range of every parameter by effect."""
    return {name: effect.parameters for name, effect in catalogue().items()}


def known_laws() -> Mapping[str, tuple[Law, ...]]:
    """Return the laws of every effect."""
    return {name: effect.laws for name, effect in catalogue().items()}


def resolve_effects(effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect, neutral where `effects` is silent; ValueError where one is unknown or out of range.

    Examples
    --------
    >>> resolve_effects({"stribeck": {"ratio": 1.2}})["stribeck"]
    {'ratio': 1.2, 'v_s_mm_s': 1.0}
    """
    return resolved("variant", parameters(), effects)


def choose(given: Mapping[str, str], seed: int) -> dict[str, Chosen]:
    """Return the law of every effect: as given, else drawn from a seed.

    Raises
    ------
    ValueError
        An effect or a law is unknown.
    """
    known = known_laws()
    for effect in given:
        if effect not in known:
            raise ValueError(f"variant: laws name the unknown effect {effect!r}{hint(effect, known)}")
    return {effect: draw(effect, laws, given.get(effect), seed) for effect, laws in known.items()}
