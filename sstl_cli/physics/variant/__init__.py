"""Rig of law variants: every effect by another published law than the catalogue's, in twice its range.

Its own equations (tensions marched along the tube, see `cascade`), its own laws (`effects`) and sensors. No law here is
shared with the fast model that `diagnose` fits, nor with the other simulators.
"""

from sstl_cli.physics.given import QUIET, Bounds, NoiseSpec
from sstl_cli.physics.variant.effects import known_laws, parameters, resolve_effects
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.simulate import VariantTruth, laws_of, march_variant, read_variant, simulate_variant
from sstl_cli.physics.variant.spec import VariantResult, VariantRun, VariantSpec

__all__ = [
    "QUIET",
    "Bounds",
    "Chosen",
    "Law",
    "NoiseSpec",
    "VariantResult",
    "VariantRun",
    "VariantSpec",
    "VariantTruth",
    "known_laws",
    "laws_of",
    "march_variant",
    "parameters",
    "read_variant",
    "resolve_effects",
    "simulate_variant",
]
