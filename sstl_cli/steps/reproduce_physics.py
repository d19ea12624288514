"""Physics-informed mapping: fit theta of a configuration to its sensing loop, then predict the actuation tendon.

The effects are those a diagnosis of calibration recordings names; their strengths are fitted once to a few
calibration bends on which the distal tension was known. Afterwards the sensing loop alone gives theta, and the
fast model with these effects gives the lines of the actuation tendon at the speed of the task.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize_scalar

from sstl_cli.control.controller import Theta
from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run
from sstl_cli.paper.rig import Bend, lines_of, slow_sine
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.transmission import activate, measure, predict
from sstl_cli.physics.transmission.model import drive_of

Array = NDArray[np.float64]
EVERY = 10
# effect and parameter, start, low, high: those of the catalogue that the calibration recordings show
FITTED = (
    ("pulley_friction", "m_p", 0.15, 0.0, 0.25),
    ("pulley_friction", "m_r", 0.15, 0.0, 0.25),
    ("pulley_friction", "f0_n", 1.0, 0.0, 2.0),
    ("const_friction", "w_l_n", 0.1, 0.0, 0.5),
    ("zero_offset", "z_out_act_n", 0.0, -2.0, 2.0),
    ("zero_offset", "z_out_sstl_n", 0.0, -2.0, 2.0),
    ("gain_error", "g_act", 1.0, 0.85, 1.15),
    ("gain_error", "g_sstl", 1.0, 0.85, 1.15),
)


@dataclass(frozen=True)
class Diagnosed:
    """Strengths of the effects, fitted to calibration recordings, and the error that is left (N)."""

    effects: dict[str, dict[str, float]]
    rmse_n: float

    def theta(self, run: Run) -> float:
        """Return theta (rad) of one pass that explains a recording of the sensing loop best."""
        record = _Record.of(run)
        found = minimize_scalar(
            lambda t: float(np.mean(_residual(record, t, self.effects) ** 2)),
            bounds=(0.2, 1.2),
            method="bounded",
            options={"xatol": 1e-5},
        )
        return float(found.x)

    def lines(self, bend: Bend, theta: float) -> Theta | None:
        """Return the lines that the fast model predicts for the slow movement of the task."""
        time, tension = slow_sine()
        out = _output("act", bend.location, time, tension, theta, self.effects)
        return lines_of(segment_run(Run(bend.name, "act", time, tension, out, bend.name, bend.location)))


def diagnosed(runs: Sequence[Run], first_theta: float = 0.58) -> Diagnosed:
    """Fit the strengths of ``FITTED`` and one theta a bend to recordings of both systems."""
    records = [_Record.of(r) for r in runs]
    names = list(dict.fromkeys(r.config_id for r in runs))
    start = np.array([f[2] for f in FITTED] + [first_theta] * len(names))
    low = np.array([f[3] for f in FITTED] + [0.2] * len(names))
    high = np.array([f[4] for f in FITTED] + [1.2] * len(names))

    def residuals(p: Array) -> Array:
        effects = _effects(p)
        return np.concatenate(
            [
                _residual(r, p[len(FITTED) + names.index(run.config_id)], effects)
                for r, run in zip(records, runs, strict=True)
            ]
        )

    found = least_squares(
        residuals,
        start,
        bounds=(low, high),
        diff_step=np.full(len(start), 1e-4),
        x_scale=high - low,
        loss="soft_l1",
        f_scale=0.1,
    )
    return Diagnosed(_effects(found.x), float(np.sqrt(np.mean(residuals(found.x) ** 2))))


@dataclass(frozen=True)
class _Record:
    system: str
    location: str | None
    time_s: Array
    tension_in: Array
    tension_out: Array

    @classmethod
    def of(cls, run: Run) -> _Record:
        # block means: noise of the input would otherwise be rectified by the play
        n = len(run) // EVERY * EVERY

        def mean(values: Array) -> Array:
            return np.asarray(values[:n].reshape(-1, EVERY).mean(axis=1))

        return cls(run.system, run.location, mean(run.time_s), mean(run.tension_in_n), mean(run.tension_out_n))


def _effects(p: Array) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for (effect, name, *_), value in zip(FITTED, p, strict=False):
        found.setdefault(effect, {})[name] = float(value)
    return found


def _residual(record: _Record, theta: float, effects: Mapping[str, Mapping[str, float]]) -> Array:
    out = _output(record.system, record.location, record.time_s, record.tension_in, theta, effects)
    return np.asarray(out - record.tension_out)


def _output(
    system: str,
    location: str | None,
    time_s: Array,
    tension: Array,
    theta: float,
    effects: Mapping[str, Mapping[str, float]],
) -> Array:
    active, dt = activate(effects), float(time_s[1] - time_s[0])
    out = predict(drive_of(system, location, dt, tension, Mechanics()), float(theta), active, start_n=float(tension[0]))
    return np.asarray(measure(system, dt, tension, out, active)[1])
