"""Data for the table of coverages: loops from a plain play operator, and rig recordings with a drawn effect."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Trajectory
from sstl_cli.steps import simulate

Array = NDArray[np.float64]
PARAMETERS = ("gamma_p", "beta_p", "gamma_r", "beta_r")
# strengths from about two to fifteen times the noise, after the base is re-tuned
STRENGTH = {
    "const_friction": {"w_l_n": (0.05, 0.3)},
    "viscous": {"c_l_n_s_per_mm": (0.014, 0.045)},
    "asymmetric_friction": {"a": (0.01, 0.08)},
    "pulley_friction": {"m_p": (0.01, 0.08), "m_r": (0.01, 0.08), "f0_n": (0.05, 0.3)},
    "channel_delay": {"tau_act_s": (0.02, 0.06), "tau_sstl_s": (0.02, 0.06)},
    "zero_offset": {"z_in_act_n": (0.1, 0.4), "z_out_act_n": (0.1, 0.4), "z_in_sstl_n": (0.1, 0.4), "z_out_sstl_n": (0.1, 0.4)},
}  # fmt: skip
RIVAL = {e: ("viscous" if e == "const_friction" else "const_friction") for e in STRENGTH}
MOVEMENTS = (
    Trajectory(kind="trapezoid", drive="tension", duration_s=12.0),
    Trajectory(kind="trapezoid", label="slow trapezoid", drive="tension", duration_s=36.0),
    Trajectory(kind="random", duration_s=40.0, low_n=2.0),
    Trajectory(kind="minor_loops", duration_s=30.0),
)


def coloured(n: int, rate_hz: float, sd: float, rng: np.random.Generator, seconds: float = 0.3) -> Array:
    """Return AR(1) noise of a correlation time."""
    phi = float(np.exp(-1.0 / (rate_hz * seconds)))
    drive = rng.standard_normal(n) * np.sqrt(1 - phi**2)
    out, v = np.empty(n), float(rng.standard_normal())
    for k in range(n):
        v = phi * v + drive[k]
        out[k] = v
    return sd * out


def loop(lines: tuple[float, ...], rng: np.random.Generator, colour: bool) -> Run:
    """Return a noisy recording of a play operator between known lines: three trapezoids of 12 s, or 90 s of sines."""
    gp, bp, gr, br = lines
    rate = 100.0
    if rng.random() < 0.5:
        t = np.arange(3600) / rate
        x = np.interp(t % 12.0, [0, 4.8, 5.4, 11.4, 12.0], [5.0, 30.0, 30.0, 5.0, 5.0])
    else:
        t = np.arange(9000) / rate
        waves = [rng.uniform(0.4, 1.0) * np.sin(2 * np.pi * rng.uniform(0.02, 0.12) * t + rng.uniform(0, 6.28)) for _ in range(5)]
        w = np.sum(waves, axis=0)
        x = 2.0 + 28.0 * (w - w.min()) / np.ptp(w)
    y, held = np.empty(len(t)), gp * x[0] + bp
    for k, v in enumerate(x.tolist()):
        held = min(max(held, gp * v + bp), gr * v + br)
        y[k] = held
    sd = rng.uniform(0.01, 0.05)
    noise = [coloured(len(t), rate, sd, rng) if colour else sd * rng.standard_normal(len(t)) for _ in range(2)]
    return Run("loop", "act", t, x + noise[0], y + noise[1])


def loops(count: int, colour: bool, seed: int) -> Iterator[tuple[tuple[float, ...], Run]]:
    """Yield drawn lines with their recordings."""
    rng = np.random.default_rng([seed, int(colour)])
    for _ in range(count):
        lines = (rng.uniform(0.3, 0.85), rng.uniform(-1.0, 0.2), rng.uniform(1.2, 2.2), rng.uniform(0.0, 1.0))
        yield lines, loop(lines, rng, colour)


@dataclass(frozen=True)
class Case:
    """One rig: what it is, the effect it has (none for the null), and how noisy it is."""

    scenario: Scenario
    effects: dict[str, dict[str, float]]
    seed: int

    def record(self, again: int = 0) -> list[Run]:
        """Return recordings of the rig, fresh ones for every ``again``."""
        return list(simulate.run(self.scenario, self.effects, self.seed + 1_000_003 * again))

    def nominal(self) -> Scenario:
        """Return the simulator as a user would state it: thetas a tenth off, no effect."""
        off = tuple(c.model_copy(update={"theta": 1.1 * (c.theta or 0.0)}) for c in self.scenario.configurations)
        return self.scenario.model_copy(update={"configurations": off, "simulator": "transmission"})


def case(effect: str | None, number: int, seed: int, simulator: Literal["rig", "transmission"] = "rig") -> Case:
    """Return a drawn case; half of them have coloured noise as well as white."""
    rng = np.random.default_rng([seed, number, *(effect or "null").encode()])
    theta = rng.uniform(0.35, 0.75, 2)
    scenario = Scenario(
        simulator=simulator, sampling_hz=100.0,
        noise=NoiseSection(white_n=0.02, coloured_n=0.0 if number % 2 else 0.01),
        configurations=tuple(Configuration(id=f"c{i}", location="CP", theta=float(v)) for i, v in enumerate(theta)),
        trajectories=MOVEMENTS,
    )  # fmt: skip
    strength: dict[str, Any] = {}
    if effect is not None:
        strength = {
            name: float(np.exp(rng.uniform(*np.log(span)))) * (rng.choice([-1, 1]) if effect == "zero_offset" else 1)
            for name, span in STRENGTH[effect].items()
        }
    return Case(scenario, {effect: strength} if effect else {}, int(rng.integers(1, 2**31)))
