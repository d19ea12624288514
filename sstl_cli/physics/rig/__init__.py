"""Stand-in for hardware: a quasi-static elastic chain with friction at every node, its own solver, effects and sensors.

No law here is shared with the fast model that `diagnose` fits, so that a model is never judged on data it made itself.
"""

from sstl_cli.physics.given import QUIET, Bounds, NoiseSpec
from sstl_cli.physics.rig.effects import parameters, resolve_effects
from sstl_cli.physics.rig.simulate import simulate_rig
from sstl_cli.physics.rig.spec import RigRun, RigSpec, bend_weights

__all__ = [
    "QUIET",
    "Bounds",
    "NoiseSpec",
    "RigResult",
    "RigRun",
    "RigSpec",
    "bend_weights",
    "parameters",
    "resolve_effects",
    "simulate_rig",
]
