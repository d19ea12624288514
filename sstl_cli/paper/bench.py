"""A bench to record and to track on: the elastic rig, which stands in for hardware, or a simulator of it.

The same experiment runs on either, so that what a simulator promises can be set beside what the hardware does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from sstl_cli.control.controller import Theta
from sstl_cli.control.plant import Tendon
from sstl_cli.control.presliding import fit_widths
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run
from sstl_cli.paper.rig import DT_S, GAP, Bend, Effects, RigTendon, lines_of, recorded, slow_sine
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission import activate, measure, predict
from sstl_cli.physics.transmission.model import Active, drive_of

Array = NDArray[np.float64]
NOISE_N = 0.02
THETA_BOUNDS = (0.2, 1.2)
#: samples that one of a fit stands for: no more than ten, and fewer where less than so many would be left
EVERY, LEAST_LEFT = 10, 600
#: plays know no speed: a thousand samples of a loop are enough for their widths
WIDTHS_DT_S = 0.1


class Bench(Protocol):
    """Where recordings are made and references are tracked."""

    def record(self, bend: Bend, system: str, time_s: Array, tension_n: Array, seed: int) -> Run:
        """Return what the sensors record (N) of one movement of the input tension (N)."""

    def tendon(self, bend: Bend) -> Tendon:
        """Return the actuation tendon with its distal sensor, as the controller's plant."""


@dataclass(frozen=True)
class Cogging:
    """A force that ripples with the travel of the input, which no effect of the catalogue does.

    Twice the amplitude leaves the sensing loop's release line too short on four bends in ten to learn a mapping from.
    """

    amplitude_n: float = 0.15
    pitch_n: float = 5.0

    def __call__(self, tension_in: Array, tension_out: Array) -> Array:
        """Return the output (N) with a ripple over the input (period ``pitch_n``), which moves with the travel."""
        return np.asarray(tension_out + self.amplitude_n * np.sin(2.0 * np.pi * tension_in / self.pitch_n))


@dataclass(frozen=True)
class RigBench:
    """The elastic rig with given effects, and where asked for with one that has no name."""

    effects: Effects = field(default_factory=lambda: GAP)
    unnamed: Cogging | None = None

    def record(self, bend: Bend, system: str, time_s: Array, tension_n: Array, seed: int) -> Run:
        """Return what the rig's sensors record."""
        run = recorded(bend, system, time_s, tension_n, seed, self.effects)
        if self.unnamed is None:
            return run
        return Run(
            run.run_id,
            system,
            run.time_s,
            run.tension_in_n,
            self.unnamed(np.asarray(tension_n), run.tension_out_n),
            run.config_id,
            run.location,
        )

    def tendon(self, bend: Bend) -> Tendon:
        """Return the rig's actuation tendon."""
        own = RigTendon(bend, self.effects)
        unnamed = self.unnamed
        if unnamed is None:
            return own
        return lambda tension_in, dt_s: unnamed(tension_in, own(tension_in, dt_s))


@dataclass(frozen=True)
class ModelBench:
    """The fast model of a scenario: its mechanics and effects, at the theta of each bend."""

    scenario: Scenario

    @property
    def active(self) -> Active:
        """Effects that are not neutral; the tension loop is the bench's own."""
        return activate({k: v for k, v in self.scenario.effects.items() if k != "tension_loop_lag"})

    def with_effect(self, effect: str, values: Mapping[str, float]) -> ModelBench:
        """Return the model with the given values of one effect."""
        return ModelBench(self.scenario.model_copy(update={"effects": {**self.scenario.effects, effect: dict(values)}}))

    def output(self, system: str, location: str | None, dt_s: float, tension_n: Array, theta: float) -> Array:
        """Return what the output sensor shows (N) for an input tension (N), without noise."""
        active = self.active
        drive = drive_of(system, location, dt_s, tension_n, self.scenario.rig.mechanics())
        out = predict(drive, theta, active, start_n=float(tension_n[0]))
        return np.asarray(measure(system, dt_s, tension_n, out, active, theta=theta)[1])

    def record(self, bend: Bend, system: str, time_s: Array, tension_n: Array, seed: int) -> Run:
        """Return what sensors with 0.02 N of noise would record."""
        rng = stream(seed, "model", bend.name, system, len(time_s))
        out = self.output(system, bend.location, DT_S, tension_n, bend.theta_of(system))
        seen_in, seen_out = (v + NOISE_N * rng.standard_normal(len(v)) for v in (tension_n, out))
        return Run(f"{bend.name}-{system}", system, time_s, seen_in, seen_out, bend.name, bend.location)

    def tendon(self, bend: Bend) -> Tendon:
        """Return the actuation tendon of the model."""
        return lambda tension_in, dt_s: self.output("act", bend.location, dt_s, tension_in, bend.theta)

    def theta(self, run: Run) -> float:
        """Return theta (rad) of one pass that explains a recording best."""
        coarse = block_means(run)
        found = minimize_scalar(
            lambda t: float(np.mean(self.residual(coarse, t) ** 2)), bounds=THETA_BOUNDS, method="bounded", options={"xatol": 1e-5}
        )
        return float(found.x)

    def rmse(self, run: Run, theta: float | None = None) -> float:
        """Return the RMSE (N) that is left of a recording, by default at the theta that explains it best."""
        best = self.theta(run) if theta is None else theta
        return float(np.sqrt(np.mean(self.residual(block_means(run), best) ** 2)))

    def lines(self, bend: Bend, theta: float) -> Theta | None:
        """Return the lines of the actuation tendon that the model predicts for the slow movement of the task."""
        time, tension = slow_sine()
        out = self.output("act", bend.location, DT_S, tension, theta)
        return lines_of(segment_run(Run(bend.name, "act", time, tension, out, bend.name, bend.location)))

    def widths(self, bend: Bend, theta: float, lines: Theta) -> tuple[float, ...]:
        """Return the relative widths of the plays that the predicted loop of the actuation tendon adds up to.

        Presliding rounds the loop; ``lines`` are its propagation lines as :meth:`lines` gives them.
        """
        time, tension = slow_sine(dt_s=WIDTHS_DT_S)
        out = self.output("act", bend.location, float(time[1]), tension, theta)
        return fit_widths(lines, tension, out)

    def residual(self, run: Run, theta: float) -> Array:
        """Return what the model at a theta predicts beyond a recording (N), shape (n,)."""
        dt = float(run.time_s[1] - run.time_s[0])
        return self.output(run.system, run.location, dt, run.tension_in_n, theta) - run.tension_out_n


def block_means(run: Run) -> Run:
    """Return a run whose samples are means of up to ten: noise of the input would otherwise be rectified by the play."""
    every = min(max(len(run) // LEAST_LEFT, 1), EVERY)
    n = len(run) // every * every

    def mean(values: Array) -> Array:
        return np.asarray(values[:n].reshape(-1, every).mean(axis=1))

    return Run(run.run_id, run.system, mean(run.time_s), mean(run.tension_in_n), mean(run.tension_out_n), run.config_id, run.location)
