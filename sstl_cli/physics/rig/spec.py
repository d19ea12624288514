"""What is built (RigSpec) and what is run (RigRun)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sstl_cli.physics.given import FloatArray, GivenRun, require

_require = partial(require, "rig")


@dataclass(frozen=True)
class RigSpec:
    """Geometry, mechanics, drive and solver settings of the elastic-chain rig (lengths in mm, forces in N).

    Defaults describe a 2 m steel tendon of 0.45 mm (EA about 8 kN for a wire rope) in a 0.6 mm sheath. `nodes` counts
    friction nodes per pass; `bend_arc_fraction` is the bent share of a pass, centred at `bend_centres[location]`.
    `load_k1_n_per_mm` is the spring at the output end, stretched by `pretension_n` at rest. `stick_breakaway_mm` is
    the elastic slip before a node breaks away; it is tiny, so that the base is Coulomb. `friction_memory_s` is the lag
    with which rate-dependent friction follows the sliding speed (2-9 ms measured by Hess and Soom 1990);
    `weakening_mm` is the slip over which a broken contact loses its static excess (Rabinowicz 1951: 1-100 um) and
    `healing_mm` over the stick-slip speed v_c the time in which it comes back. The tension loop is a PID acting on
    the motor position, followed by a first-order motor of time constant `motor_lag_s`.

    Raises
    ------
    ValueError
        A value is outside its range; the message names it, with unit and range.
    """

    length_mm: float = 2000.0
    ea_n: float = 8000.0
    nodes: int = 30
    bend_arc_fraction: float = 0.25
    bend_centres: dict[str, float] = field(default_factory=lambda: {"NP": 0.2, "CP": 0.5, "ND": 0.8})
    load_k1_n_per_mm: float = 8.0
    pretension_n: float = 5.0
    stick_breakaway_mm: float = 1e-4
    friction_memory_s: float = 0.005
    weakening_mm: float = 0.02
    healing_mm: float = 0.5
    pid_kp_mm_per_n: float = 0.05
    pid_ki_mm_per_n_s: float = 4.0
    pid_kd_mm_s_per_n: float = 0.0
    motor_lag_s: float = 0.02
    max_substeps: int = 64
    max_iterations: int = 120
    tolerance_n: float = 1e-8

    def __post_init__(self) -> None:
        positive = ("length_mm", "ea_n", "load_k1_n_per_mm", "stick_breakaway_mm", "friction_memory_s", "weakening_mm")
        for name in (*positive, "healing_mm", "tolerance_n"):
            value = getattr(self, name)
            _require(np.isfinite(value) and value > 0.0, name, value, "finite and > 0")
        for name in ("pretension_n", "pid_kp_mm_per_n", "pid_ki_mm_per_n_s", "pid_kd_mm_s_per_n", "motor_lag_s"):
            value = getattr(self, name)
            _require(np.isfinite(value) and value >= 0.0, name, value, "finite and >= 0")
        _require(4 <= self.nodes <= 400, "nodes", self.nodes, "in 4..400 per pass")
        _require(0.0 < self.bend_arc_fraction <= 1.0, "bend_arc_fraction", self.bend_arc_fraction, "in (0, 1]")
        _require(self.max_substeps >= 1, "max_substeps", self.max_substeps, ">= 1")
        _require(self.max_iterations >= 5, "max_iterations", self.max_iterations, ">= 5")
        for key, centre in self.bend_centres.items():
            _require(0.0 <= centre <= 1.0, f"bend_centres[{key!r}]", centre, "in 0..1 of the pass")


class RigRun(GivenRun):
    """One run to record, driven by tension, position or loop."""

    simulator = "rig"


def bend_weights(spec: RigSpec, system: str, location: str | None) -> FloatArray:
    """Share of the bend angle of one pass carried by each friction node; the way back is mirrored.

    Returns
    -------
    shape (nodes,) for "act", (2 * nodes + 1,) for "sstl" with the (unbent) pulley node in the middle; sums to 1 or 2.

    Raises
    ------
    ValueError
        `location` is not one of `spec.bend_centres`.
    """
    key = "CP" if location is None else location
    if key not in spec.bend_centres:
        raise ValueError(f"rig: location = {location!r} must be None or one of {', '.join(spec.bend_centres)}")
    half = 0.5 * spec.bend_arc_fraction
    # A bend cannot hang over the end of the sheath: shift it inwards instead of cutting it.
    centre = min(max(spec.bend_centres[key], half), 1.0 - half)
    edges = np.linspace(0.0, 1.0, spec.nodes + 1)
    covered = np.clip(np.minimum(edges[1:], centre + half) - np.maximum(edges[:-1], centre - half), 0.0, None)
    one_pass: FloatArray = covered / covered.sum()
    if system == "act":
        return one_pass
    return np.concatenate([one_pass, [0.0], one_pass[::-1]])
