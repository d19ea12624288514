"""What is built (BristleSpec) and what is run (BristleRun)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sstl_cli.physics.given import FloatArray, GivenRun, require

POSITIVE = (
    "length_mm", "ea_n", "load_k1_n_per_mm", "line_density_g_per_m", "bristle_mm", "renewal_mm", "film_mm",
    "healing_mm", "finest_step_s", "tolerance_n",
)  # fmt: skip
NOT_NEGATIVE = ("pretension_n", "pid_kp_mm_per_n", "pid_ki_mm_per_n_s", "pid_kd_mm_s_per_n", "motor_lag_s")


_check = partial(require, "bristle")


@dataclass(frozen=True)
class BristleSpec:
    """Geometry, mechanics, contact, drive and solver of the bristle simulator (lengths in mm, forces in N).

    Defaults describe a 2 m tendon of 0.45 mm in a 0.6 mm sheath, EA about 8 kN: a wire rope, but for its mass, that
    of a polyethylene fibre as stiff (0.15 g/m); with steel (1.25 g/m) momentum alone moves the output by 20 mN at a
    sudden stop. `nodes` counts friction nodes per pass; `bend_arc_fraction` is the bent share of a pass, centred at
    `bend_centres[location]`. `load_k1_n_per_mm` is the spring at the output end, at rest under `pretension_n`.
    `bristle_mm` is the deflection at which a bristle carries Coulomb friction; tiny, so that the base is Coulomb.
    `renewal_mm` is the slip that renews an asperity contact (Dieterich 1979: 1-100 um), `film_mm` that which renews
    the film under it (from the lags of Hess and Soom 1990, 2-9 ms, at their speeds), and `healing_mm` over the
    stick-slip speed v_c the rest after which half of the static excess is back. The tension loop is a PID on the
    motor position and a first-order motor of `motor_lag_s`. `finest_step_s` is the step below which nothing is
    resolved, `max_iterations` what a step may take beyond two a node.

    Raises
    ------
    ValueError
        A value is outside its range; the message names it.
    """

    length_mm: float = 2000.0
    ea_n: float = 8000.0
    nodes: int = 30
    bend_arc_fraction: float = 0.25
    bend_centres: dict[str, float] = field(default_factory=lambda: {"NP": 0.2, "CP": 0.5, "ND": 0.8})
    load_k1_n_per_mm: float = 8.0
    pretension_n: float = 5.0
    line_density_g_per_m: float = 0.15
    bristle_mm: float = 2e-5
    renewal_mm: float = 0.03
    film_mm: float = 0.06
    healing_mm: float = 0.35
    pid_kp_mm_per_n: float = 0.05
    pid_ki_mm_per_n_s: float = 4.0
    pid_kd_mm_s_per_n: float = 0.0
    motor_lag_s: float = 0.02
    finest_step_s: float = 1e-5
    max_iterations: int = 60
    tolerance_n: float = 1e-7

    def __post_init__(self) -> None:
        for name in POSITIVE:
            value = getattr(self, name)
            _check(np.isfinite(value) and value > 0.0, name, value, "finite and > 0")
        for name in NOT_NEGATIVE:
            value = getattr(self, name)
            _check(np.isfinite(value) and value >= 0.0, name, value, "finite and >= 0")
        _check(4 <= self.nodes <= 400, "nodes", self.nodes, "in 4..400 per pass")
        _check(0.0 < self.bend_arc_fraction <= 1.0, "bend_arc_fraction", self.bend_arc_fraction, "in (0, 1]")
        _check(self.max_iterations >= 10, "max_iterations", self.max_iterations, ">= 10")
        for place, centre in self.bend_centres.items():
            _check(0.0 <= centre <= 1.0, f"bend_centres[{place!r}]", centre, "in 0..1 of the pass")


class BristleRun(GivenRun):
    """One run to record, driven by tension, position or loop."""

    simulator = "bristle"


def bend_weights(spec: BristleSpec, system: str, location: str | None) -> FloatArray:
    """Share of the bend angle of one pass carried by each friction node; the way back is mirrored.

    The curvature rises and falls as sin^2 over the bent arc, as a body does that is bent by moments, not by a mandrel.

    Returns
    -------
    shape (nodes,) for "act", (2 * nodes + 1,) for "sstl" with the (unbent) pulley node in the middle; sums to 1 or 2.

    Raises
    ------
    ValueError
        `location` is not one of `spec.bend_centres`.
    """
    key = location or "CP"
    _check(key in spec.bend_centres, "location", repr(location), f"None or one of {', '.join(spec.bend_centres)}")
    arc = spec.bend_arc_fraction
    # A bend cannot hang over the end of the sheath: it is shifted inwards.
    start = min(max(spec.bend_centres[key] - 0.5 * arc, 0.0), 1.0 - arc)
    along = np.clip((np.linspace(0.0, 1.0, spec.nodes + 1) - start) / arc, 0.0, 1.0)
    there = np.diff(along - np.sin(2.0 * np.pi * along) / (2.0 * np.pi))
    return there if system == "act" else np.concatenate([there, [0.0], there[::-1]])
