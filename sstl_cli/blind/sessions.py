"""A case in two sessions: the rig as it was when its model was accepted, and as it is when it is asked what has changed.

Most rigs have a habit of their own that no law describes, on both days. What is withheld comes with the second session.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sstl_cli.blind import cases
from sstl_cli.blind.cases import Case
from sstl_cli.blind.inject import half
from sstl_cli.blind.record import DISTURBANCE, Source
from sstl_cli.blind.schedule import Job
from sstl_cli.blind.truth import CaseTruth, Effects
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics import disturbances
from sstl_cli.physics.disturbances import Disturbance
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

# gap of the rig's own habit over the noise of its sensor
HABITS = (0.0, 1.0, 4.0, 16.0)
# ... or over the gap of what is withheld, where no model was accepted before: it is a small part of the squared error, or most of it
BESIDE = (0.15, 0.3, 0.5, 1.5, 4.0)


@dataclass(frozen=True)
class Sessions:
    """Recordings before and after, the simulator as the lab states it, what is no candidate, and the truth of the change."""

    before: list[Run]
    after: list[Run]
    sim: Scenario
    exclude: tuple[str, ...]
    truth: CaseTruth


def draw(job: Job) -> Sessions:
    """Return the case of a job in two sessions: the halves of one recording, or the same movements on two days.

    Raises
    ------
    SstlError
        If no bench could be simulated, or no habit reaches its gap there.
    """
    case = cases.draw(job.entry, job.seed, job.quick, job.simulator, job.as_labs)
    source, effects = cases.rebuild(case.truth)
    rng = stream(job.seed, "sessions")
    level, halves = float(rng.choice(HABITS)), bool(rng.random() < 0.5)
    habit: Effects = {}
    if level > 0.0 and DISTURBANCE not in effects:
        drawn, amplitude = _habit(source, rng, level * source.noise_n)
        source, habit = replace(source, disturbance=drawn), {DISTURBANCE: {"amplitude": amplitude}}
    before = source.record(source.bench.runs, habit)
    after = replace(source, session=1).record(source.bench.runs, {**habit, **effects})
    if halves:
        before, after = [half(r, False) for r in before], [half(r, True) for r in after]
    # what is to be told has the scatter of the habit beside it as well as the noise
    strength = case.truth.strength / float(np.hypot(1.0, level if habit else 0.0))
    truth = replace(case.truth, strength=strength, habit=level if habit else 0.0, halves=halves)
    return Sessions(before, after, case.sim, case.exclude, truth)


def with_habit(job: Job) -> Case:
    """Return the case of a job on a rig with a habit that no law describes; where that carries most of the gap nobody could name a cause.

    Faults of the recorder are seen in the readings, whatever the rig does: they have no habit beside them.

    Raises
    ------
    SstlError
        If no bench could be simulated, or nothing is withheld that the habit could stand beside.
    """
    withheld = job.entry.effects
    if not withheld or not all(e != DISTURBANCE and get(e).fitted and get(e).channel == "out" for e in withheld):
        raise SstlError("has nothing that a habit could stand beside", where=f"seed {job.seed}", code="E951")
    case = cases.draw(job.entry, job.seed, job.quick, job.simulator, job.as_labs)
    source, effects = cases.rebuild(case.truth)
    rng = stream(job.seed, "habit")
    part = float(rng.choice(BESIDE))
    level = part * case.truth.strength
    drawn, amplitude = _habit(source, rng, level * source.noise_n)
    runs = replace(source, disturbance=drawn).record(source.bench.runs, {DISTURBANCE: {"amplitude": amplitude}, **effects})
    truth = replace(case.truth, habit=level)
    if part > 1.0:
        truth = replace(truth, kind="unlisted", effects={}, strength=level, unlisted=(drawn.description,), also=drawn.listed)
    return replace(case, runs=runs, truth=truth)


def _habit(source: Source, rng: np.random.Generator, gap_n: float) -> tuple[Disturbance, float]:
    """Return a disturbance that comes back as it was, and its amplitude, by which the re-tuned base leaves a gap (N) on this bench."""

    def gap(drawn: Disturbance, amplitude: float) -> float:
        return replace(source, disturbance=drawn).gap({DISTURBANCE: {"amplitude": amplitude}})[0]

    while True:
        drawn, amplitude, _ = disturbances.draw_at(rng, gap_n, gap)
        # what goes along with the clock, or happens at random, is another one on another day
        if drawn.carriers and "time_s" not in drawn.carriers:
            return drawn, amplitude
