"""What a perfect model would leave: the noise floor, how surely it is known, and what of it converters make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.hearing import columns
from sstl_cli.diagnosis.judged import Judged
from sstl_cli.diagnosis.noise import floor_n, likely
from sstl_cli.diagnosis.rounding import unrounded
from sstl_cli.diagnosis.verdict import UNDECIDED
from sstl_cli.diagnosis.whitening import Noise

# two-sided 95 % of a normal distribution
SIDES = 1.96


@dataclass(frozen=True)
class Floor:
    """A noise floor (N, RMS) with the ends of its 95 % interval, None where no spread of the noise is known."""

    value_n: float
    low_n: float | None
    high_n: float | None


def floor(g: Judged, fine_n: float) -> Floor:
    """Return the floor at the full rate; ``fine_n`` (N) is the noise above the analysis rate."""

    def whole(noise: Noise) -> float:
        return float(np.hypot(_analysed_n(g, noise), fine_n))

    noise = min(_sensors(g), key=lambda noise: _analysed_n(g, noise))
    low_n, high_n = interval(noise, whole)
    return Floor(whole(noise), low_n, high_n)


def fine_n(g: Judged, noise: Noise) -> float:
    """Return the white noise of the output above the analysis rate (N): what a mean over the readings of a sample does not hold."""
    # readings are counted in steps of the simulation; a slow sensor has one in a sample, which holds all of its noise
    coarse = [(noise.output[r.system].white_n * r.louder, r.readings[r.weight > 0]) for r in g.problem.records]
    return float(np.sqrt(np.mean([w**2 * (1.0 - float(np.mean(1.0 / np.maximum(n, 1.0)) if len(n) else 1.0)) for w, n in coarse])))


def unrounded_n(g: Judged) -> float:
    """Return what a perfect model would leave (N) beside the steps of the converters: the noise was measured on rounded readings.

    What rounding leaves of a rest may have been taken for slow noise of the input: readings alone do not say so.
    """
    records = g.problem.records
    sensors = [*_sensors(g), *([] if g.search.read is None else [g.search.read])]
    coarse = min(_analysed_n(g, unrounded(records, noise)) for noise in sensors)
    return float(np.hypot(coarse, fine_n(g, unrounded(records, g.search.noise))))


def above_noise(g: Judged, r: RecorderEffect) -> RecorderEffect:
    """Return a fault with what it can have made at most: readings that were not rounded would still be noisy."""
    if r.id != "quantisation":
        return r
    noise = sum(len(x.raw) for x in g.problem.records) * unrounded_n(g) ** 2
    return replace(r, removed_n2=min(r.removed_n2, max(r.total_n2 - noise, 0.0)))


def _analysed_n(g: Judged, noise: Noise) -> float:
    """Return what a perfect model would leave (N) at the analysis rate, by the phases of the accepted one."""
    return floor_n(g.problem.records, g.search.sim.phases(g.accepted.theta, g.accepted.effects, noise), noise)


def _sensors(g: Judged) -> list[Noise]:
    """Return what the noise of the sensors may be: as likely as can be, or as measured where an accepted model's scatter is beside it.

    The search takes what its first models leave for noise. Where the named model leaves less, that was no noise, and none of it is
    where the verdict is that no model explains it: there the readings alone say how noisy they are.
    """
    if g.problem.scatters:
        return [g.search.measured]
    if g.verdict.status == UNDECIDED and g.search.read is not None:
        return [g.search.noise, g.search.read]
    f = g.accepted
    if f is g.search.base:
        return [g.search.noise]
    phases = g.search.sim.phases(f.theta, f.effects, g.search.noise)
    return [g.search.noise, likely(g.problem.records, phases, f.residual, columns(g.search.sim, [f]), g.search.measured)[0]]


def interval(noise: Noise, floor: Callable[[Noise], float]) -> tuple[float, float] | tuple[None, None]:
    """Return the ends of the 95 % interval of a noise floor (N), None where no spread of the noise is known.

    The errors of the estimated noise are told apart by sensor and system; each moves the floor by itself, by its own logarithm.

    Parameters
    ----------
    floor : callable
        The floor (N) of a noise.
    """
    middle = floor(noise)
    moved = [np.log(floor(raised) / middle) for raised in _raised(noise) if middle > 0.0]
    spread = float(np.sqrt(np.sum(np.square(moved))))
    # none known, or one of readings without any noise
    if not 0.0 < spread < np.inf:
        return None, None
    return log_interval(middle, spread)


def log_interval(value: float, spread: float) -> tuple[float, float]:
    """Return the 95 % interval of a number whose logarithm has this standard error."""
    return float(value * np.exp(-SIDES * spread)), float(value * np.exp(SIDES * spread))


def _raised(noise: Noise) -> list[Noise]:
    """Return the noise with one of its numbers after the other larger by its standard error."""
    found = []
    for system, spread in noise.spread.items():
        for key, by in spread.items():
            side, _, name = key.partition(".")
            factor = float(np.exp(by))
            if key == "smoother":
                found.append(replace(noise, smoother={**noise.smoother, system: factor * noise.smoother[system]}))
            elif side in ("input", "output") and name:
                sensors = getattr(noise, side)
                larger = replace(sensors[system], **{name: factor * getattr(sensors[system], name)})
                found.append(replace(noise, **{side: {**sensors, system: larger}}))
    return found
