"""A second stand-in for hardware: bristle friction (LuGre) on a chain with inertia, own stepping, effects and sensors.

No law here is shared with the fast model or with the elastic-chain rig (names, ranges and levels of noise are checked alike): a
diagnosis that was learned on those meets other laws here. docs/bristle.md says which, from which sources, and how far they are apart.
"""

from sstl_cli.physics.bristle.effects import parameters, resolve_effects
from sstl_cli.physics.bristle.simulate import simulate_bristle
from sstl_cli.physics.bristle.spec import BristleRun, BristleSpec, bend_weights
from sstl_cli.physics.given import QUIET, Bounds, NoiseSpec

__all__ = ["QUIET", "Bounds", "BristleRun", "BristleSpec", "NoiseSpec", "bend_weights", "parameters", "resolve_effects", "simulate_bristle"]
