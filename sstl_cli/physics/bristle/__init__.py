"""A second stand-in for hardware: bristle friction (LuGre) on a chain with inertia, own stepping, effects and sensors.

Nothing here is shared with the fast model or with the elastic-chain rig: a diagnosis that was learned on those meets
other laws here. docs/bristle.md says which, from which sources, and how far they are apart.
"""

from sstl_cli.physics.bristle.catalogue import EFFECTS, Bounds, resolve_effects
from sstl_cli.physics.bristle.simulate import simulate_bristle
from sstl_cli.physics.bristle.spec import QUIET, BristleResult, BristleRun, BristleSpec, NoiseSpec, bend_weights

__all__ = [
    "EFFECTS",
    "QUIET",
    "Bounds",
    "BristleResult",
    "BristleRun",
    "BristleSpec",
    "NoiseSpec",
    "bend_weights",
    "resolve_effects",
    "simulate_bristle",
]
