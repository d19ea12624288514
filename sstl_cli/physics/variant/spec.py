"""What is built (VariantSpec), what is run (VariantRun), and the record.

Field names are those of the rig, so that a caller needs no special case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType

import numpy as np

from sstl_cli.physics.given import FloatArray, GivenRun, Recorded, require

PLACES = MappingProxyType({"NP": 0.2, "CP": 0.5, "ND": 0.8})


check = partial(require, "variant")


@dataclass(frozen=True)
class VariantSpec:
    """Tube, tendon, load and laws of the rig of law variants (lengths in mm, forces in N).

    `nodes` stations a pass, half of them in the bend. `laws` names the law of an effect where it is not to be drawn;
    the others, and every number that a law leaves open, are drawn from `law_seed` (None: from the seed of the run,
    so that runs of one rig must share `law_seed`).

    Raises
    ------
    ValueError
        A value is outside its range; the message names it.
    """

    length_mm: float = 2000.0
    ea_n: float = 8000.0
    nodes: int = 30
    bend_arc_fraction: float = 0.25
    bend_centres: Mapping[str, float] = field(default_factory=lambda: dict(PLACES))
    load_k1_n_per_mm: float = 8.0
    pretension_n: float = 5.0
    max_substeps: int = 64
    max_iterations: int = 40
    tolerance_n: float = 1e-8
    laws: Mapping[str, str] = field(default_factory=dict)
    law_seed: int | None = None

    def __post_init__(self) -> None:
        for name in ("length_mm", "ea_n", "load_k1_n_per_mm", "tolerance_n"):
            value = getattr(self, name)
            check(bool(np.isfinite(value)) and value > 0.0, name, value, "finite and > 0")
        check(bool(np.isfinite(self.pretension_n)) and self.pretension_n >= 0.0, "pretension_n", self.pretension_n, ">= 0 N")
        check(4 <= self.nodes <= 400, "nodes", self.nodes, "in 4..400 a pass")
        check(0.0 < self.bend_arc_fraction <= 1.0, "bend_arc_fraction", self.bend_arc_fraction, "in (0, 1]")
        check(self.max_substeps >= 1, "max_substeps", self.max_substeps, ">= 1")
        check(self.max_iterations >= 5, "max_iterations", self.max_iterations, ">= 5")
        for key, centre in self.bend_centres.items():
            check(0.0 <= centre <= 1.0, f"bend_centres[{key!r}]", centre, "in 0..1 of the pass")


@dataclass(frozen=True)
class VariantRun(GivenRun):
    """One run to record, driven by tension; `friction` is a factor (n,) on that of the bend (a disturbance), or None."""

    simulator = "variant"
    drives = ("tension",)
    signals = (*GivenRun.signals, "friction")

    friction: FloatArray | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check(self.friction is None or np.all(self.friction > 0.0), "friction", "[...]", "> 0")


@dataclass(frozen=True)
class VariantResult(Recorded):
    """Record of one run; `laws` tells the law of every effect in force. Work against presliding includes what is stored elastically."""

    laws: Mapping[str, str] = field(default_factory=dict)
