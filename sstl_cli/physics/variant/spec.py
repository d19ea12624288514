"""What is built (VariantSpec), what is run (VariantRun), how noisy the sensors are, and the record.

Field names are those of the rig, so that a caller needs no special case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.given import require

Array = NDArray[np.float64]
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
class VariantRun:
    """One run: "act" or "sstl", theta of one pass (rad), location or None (CP), instants (s), command (N), each (n,).

    `drive` is "tension": the command is the input tension. `neighbour_n` is the summed tension (N) of other tendons;
    `friction` a factor on the friction of the bend (a disturbance), both (n,) or None.

    Raises
    ------
    ValueError
        A field is unknown, misshapen, not finite or out of range.
    """

    system: str
    theta: float
    location: str | None
    time_s: Array
    drive: str
    command: Array
    neighbour_n: Array | None = None
    friction: Array | None = None

    def __post_init__(self) -> None:
        check(self.system in ("act", "sstl"), "system", repr(self.system), "'act' or 'sstl'")
        check(self.drive == "tension", "drive", repr(self.drive), "'tension'")
        check(bool(np.isfinite(self.theta)) and 0.0 <= self.theta <= 3.0, "theta", self.theta, "in 0..3")
        time = np.ascontiguousarray(self.time_s, dtype=np.float64)
        check(time.ndim == 1 and time.size >= 2, "time_s", f"shape {time.shape}", "of two samples or more")
        ordered = bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0))
        check(ordered, "time_s", "[...]", "finite and strictly increasing, s")
        object.__setattr__(self, "time_s", time)
        for name in ("command", "neighbour_n", "friction"):
            given = getattr(self, name)
            if given is None:
                continue
            values = np.ascontiguousarray(given, dtype=np.float64)
            fits = values.shape == time.shape and bool(np.all(np.isfinite(values)))
            check(fits, name, f"shape {values.shape}", f"finite and of shape {time.shape}, as time_s")
            check(name != "friction" or bool(np.all(values > 0.0)), name, "[...]", "> 0")
            object.__setattr__(self, name, values)


@dataclass(frozen=True)
class VariantResult:
    """Record of one run, arrays of shape (n,): readings, the truth beside them, and the health of the solution.

    `position_in_mm` counts from the pretensioned rest. `unconverged` counts samples that were given up on,
    `substepped` those that were divided. Energies (J) are the work against friction and drag; that of presliding
    includes what is stored elastically. `node_tension` is (n, stations + 1), N, drive end first, when asked for.
    `laws` tells the law of every effect in force.
    """

    time_s: Array
    tension_in_n: Array
    tension_out_n: Array
    position_in_mm: Array
    true_tension_in_n: Array
    true_tension_out_n: Array
    true_position_in_mm: Array
    unconverged: int
    substepped: int
    iterations: int
    dissipated_j: float
    min_step_dissipation_j: float
    laws: Mapping[str, str]
    node_tension: Array | None = None
