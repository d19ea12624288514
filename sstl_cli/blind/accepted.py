"""An accepted simulator applied to recordings: its error on fresh ones, and recordings made from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.records import Record, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission.model import Active, activate, observed_output

Array = NDArray[np.float64]
# length of the stretches of residual that are put together anew, longer than the noise remembers (s)
BLOCK_S = 2.0


def audible(scenario: Scenario) -> dict[str, dict[str, float]]:
    """Return the effects of a scenario that a prediction of the output tension can carry."""
    return {k: dict(v) for k, v in scenario.effects.items() if get(k).fitted and get(k).channel == "out"}


def predictions(scenario: Scenario, runs: Sequence[Run], started_by: Scenario | None = None) -> list[tuple[Record, Array]]:
    """Return each usable run with the output (N) that the scenario predicts for its measured input.

    The output starts where it was measured; with ``started_by`` it starts from the true tension that this other
    scenario sees behind the measured one, as it must where the recording was not made by ``scenario``.
    """
    problem = prepare(runs)
    theta = np.array([scenario.theta_of(c) for c in problem.configs])
    if started_by is not None:
        before, after = activate(audible(started_by)), activate(audible(scenario))
        records = tuple(replace(r, start_n=_restarted(r, before, after, float(theta[r.config]))) for r in problem.records)
        problem = replace(problem, records=records)
    sim = Simulator(problem, scenario.rig.mechanics(), audible(scenario))
    return list(zip(problem.records, sim.predict_fine(theta, {}), strict=True))


def _restarted(r: Record, before: Active, after: Active, theta: float) -> float:
    """Return the first reading (N) under other sensor effects, for the same true tension."""

    def seen(value: float, active: Active) -> float:
        return float(observed_output(r.system, r.dt_s, r.u[:2], np.full(2, value), active, theta)[0])

    true = 2.0 * r.start_n - seen(r.start_n, before)
    return seen(true, after)


def rms_n(scenario: Scenario, runs: Sequence[Run]) -> float:
    """Return the RMS error (N) of a scenario on recordings, faulty samples left out."""
    square = weight = 0.0
    for record, prediction in predictions(scenario, runs):
        w = record.weight_fine[: len(prediction)]
        square += float(np.sum(w * (record.y_fine[: len(prediction)] - prediction) ** 2))
        weight += float(w.sum())
    return float(np.sqrt(square / max(weight, 1.0)))


def retuned(sim: Scenario, theta: Mapping[str, float]) -> Scenario:
    """Return the simulator as stated, with the theta that the diagnosis re-tuned."""
    configurations = tuple(
        c.model_copy(update={"theta": min(max(float(theta[c.id]), 0.0), 5.0)}) if c.id in theta else c for c in sim.configurations
    )
    return sim.model_copy(update={"configurations": configurations})


def realised_shrink_pct(base: Scenario, accepted: Scenario, fresh: Sequence[Run]) -> float | None:
    """Return by how many per cent the error on a fresh recording falls from base to accepted; None at zero error."""
    before = rms_n(base, fresh)
    return 100.0 * (1.0 - rms_n(accepted, fresh) / before) if before > 0.0 else None


def remade(scenario: Scenario, residual_of: Scenario, runs: Sequence[Run], seed: int) -> list[Run]:
    """Return recordings that a scenario would have made: recorded input, its own output, and real residuals.

    The residuals of ``residual_of`` are drawn anew in blocks within each run (Kuensch 1989), so that what
    a real recording holds beyond any model stays in, while its place is shuffled.

    Raises
    ------
    SstlError
        If a run has no sound residuals.
    """
    made = []
    pairs = zip(predictions(scenario, runs, residual_of), predictions(residual_of, runs), strict=True)
    for (record, output), (_, usual) in pairs:
        n = len(output)
        residual = record.y_fine[:n] - usual
        # the error of a masked stretch (a clipped top, a spike) is no noise
        sound = residual[record.weight_fine[:n] > 0]
        block = max(2, round(BLOCK_S / record.dt_s))
        if sound.size < 2 * block:
            raise SstlError("fewer than 4 s of sound samples", where=f"run {record.run_id}", code="E958")
        rng = stream(seed, "blocks", record.run_id)
        starts = rng.integers(0, sound.size - block + 1, n // block + 1)
        noise = np.concatenate([sound[s : s + block] for s in starts])[:n]
        raw = record.raw
        grid = raw.time_s[0] + (np.arange(n) + 0.5) * record.dt_s - 0.5 * raw.dt_s
        on_grid = {
            name: np.interp(grid, raw.time_s, value)
            for name in ("tension_in_n", "position_in_mm", "tension_ref_n")
            if (value := getattr(raw, name)) is not None
        }
        made.append(replace(raw, time_s=grid, tension_out_n=output + noise, extra={}, **on_grid))
    return made
