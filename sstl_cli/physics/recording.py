"""Recordings as labs make them: rate, slow sensors, resolution, jitter, gaps, what is recorded, days between runs.

The order of use: `at_rate` puts the truth on the recorder's clock, the sensors of a simulator add effects and noise,
`apply` does what the recorder does to their readings. Recorder and sensors know nothing of each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.rng import log_uniform
from sstl_cli.core.runs import Run

Array = NDArray[np.float64]
SYSTEMS = ("act", "sstl")
# the four tension sensors, in the order of `Recording.day_zero_n`
SENSORS = (("act", "in"), ("act", "out"), ("sstl", "in"), ("sstl", "out"))
LEAST_SAMPLES = 50


@dataclass(frozen=True)
class Recording:
    """How a lab records; the defaults change nothing.

    Parameters
    ----------
    rate_hz : samples a second of the log.
    refresh_hz : refreshes a second of the output sensor, which is held between them; 0 for every sample.
    step_in_n, step_out_n : resolution of the tension readings (N); 0 for none.
    jitter : standard deviation of the sampling instants over the sampling period, below 0.3.
    stamped : whether the time stamps tell the jitter.
    gaps : start and length of missing stretches, in shares of a run.
    systems : the systems that are recorded.
    one_configuration : whether only the first bend is recorded.
    position, reference : whether these channels are recorded.
    day_zero_n : for each day, the zeros (N) of the sensors in the order of `SENSORS`.
    seed : seed of jitter and of the phase of the refreshes.
    """

    rate_hz: float = 500.0
    refresh_hz: float = 0.0
    step_in_n: float = 0.0
    step_out_n: float = 0.0
    jitter: float = 0.0
    stamped: bool = True
    gaps: tuple[tuple[float, float], ...] = ()
    systems: tuple[str, ...] = SYSTEMS
    one_configuration: bool = False
    position: bool = True
    reference: bool = True
    day_zero_n: tuple[tuple[float, float, float, float], ...] = ((0.0, 0.0, 0.0, 0.0),)
    seed: int = 0

    @property
    def description(self) -> str:
        """One line that says how the log was recorded."""
        parts = [f"{self.rate_hz:g} Hz"]
        if self.refresh_hz > 0.0:
            parts.append(f"output refreshed at {self.refresh_hz:.3g} Hz")
        if self.step_in_n > 0.0 or self.step_out_n > 0.0:
            parts.append(f"resolution {self.step_in_n:.3g} and {self.step_out_n:.3g} N")
        if self.jitter > 0.0:
            parts.append(f"jitter {100 * self.jitter:.2g} % of a period{'' if self.stamped else ', not stamped'}")
        if self.gaps:
            parts.append(f"{len(self.gaps)} missing stretches a run")
        if len(self.systems) == 1:
            parts.append(f"{self.systems[0]} only")
        if self.one_configuration:
            parts.append("one configuration")
        parts += [name for name, there in (("position", self.position), ("reference", self.reference)) if there]
        if len(self.day_zero_n) > 1:
            parts.append(f"{len(self.day_zero_n)} days")
        return ", ".join(parts)


def draw(rng: np.random.Generator) -> Recording:
    """Return a random way to record; equal generators give equal ones.

    Examples
    --------
    >>> draw(np.random.default_rng(1)) == draw(np.random.default_rng(1))
    True
    """

    def odds(share: float) -> bool:
        return bool(rng.random() < share)

    rate = float(rng.choice((50.0, 100.0, 200.0, 250.0, 500.0, 1000.0, 2000.0), p=[0.15, 0.25, 0.15, 0.15, 0.15, 0.1, 0.05]))
    refresh = min(log_uniform(rng, 10.0, 100.0), rate / 1.5) if odds(0.2) else 0.0
    fine = odds(0.3)
    steps = (log_uniform(rng, 0.001, 0.1), log_uniform(rng, 0.001, 0.1)) if fine else (0.0, 0.0)
    jitter, stamped = (float(rng.uniform(0.01, 0.15)) if odds(0.2) else 0.0), odds(0.7)
    gaps: tuple[tuple[float, float], ...] = ()
    if odds(0.2):
        starts = np.sort(rng.uniform(0.05, 0.9, int(rng.integers(1, 4))))
        gaps = tuple((float(s), log_uniform(rng, 0.003, 0.06)) for s in starts)
    kept = rng.random()
    systems = ("act",) if kept < 0.12 else (("sstl",) if kept < 0.24 else SYSTEMS)
    zeros = [(0.0, 0.0, 0.0, 0.0)]
    if odds(0.2):
        size = log_uniform(rng, 0.01, 0.15)
        drawn = [(size * rng.standard_normal(4)).tolist() for _ in range(int(rng.integers(1, 4)))]
        zeros += [(a, b, c, d) for a, b, c, d in drawn]
    return Recording(
        rate_hz=rate,
        refresh_hz=refresh,
        step_in_n=steps[0],
        step_out_n=steps[1],
        jitter=jitter,
        stamped=stamped,
        gaps=gaps,
        systems=systems,
        one_configuration=odds(0.15),
        position=odds(0.5),
        reference=odds(0.5),
        day_zero_n=tuple(zeros),
        seed=int(rng.integers(2**32)),
    )


def kept(recording: Recording, system: str, configuration: int) -> bool:
    """Whether a run of a system in a configuration (numbered from 0) is recorded."""
    return system in recording.systems and not (recording.one_configuration and configuration > 0)


def at_rate(recording: Recording, time_s: Array, *channels: Array) -> tuple[Array, ...]:
    """Return the recorder's nominal instants (s) and channels of any simulated rate at them, straight in between."""
    count = max(2, int(np.floor((time_s[-1] - time_s[0]) * recording.rate_hz + 1e-9)) + 1)
    stamps = time_s[0] + np.arange(count) / recording.rate_hz
    return (stamps, *(np.interp(stamps, time_s, c) for c in channels))


def day_of(recording: Recording, order: int, runs: int) -> int:
    """Return the day (from 0) on which run `order` of a session of `runs` is recorded."""
    return min(order * len(recording.day_zero_n) // max(runs, 1), len(recording.day_zero_n) - 1)


def apply(recording: Recording, run: Run, order: int, runs: int, truth: tuple[Array, Array] | None = None) -> Run:
    """Return a run as the lab has it; the run itself where nothing is to be done.

    Parameters
    ----------
    run : readings with noise on the nominal instants of `at_rate`.
    order, runs : place of the run in the session, and how many there are; they decide the day.
    truth : true tensions in and out (N), shape (n,), on the same instants: jitter moves them and leaves the noise.
        Without them jitter moves the stamps alone.
    """
    rng = np.random.default_rng([recording.seed, order])
    stamps, t_in, t_out = run.time_s, run.tension_in_n, run.tension_out_n
    zeros = dict(zip(SENSORS, recording.day_zero_n[day_of(recording, order, runs)], strict=True))
    t_in, t_out = t_in + zeros[run.system, "in"], t_out + zeros[run.system, "out"]
    if recording.jitter > 0.0:
        period = float(np.min(np.diff(stamps)))
        shift = period * np.clip(recording.jitter * rng.standard_normal(stamps.size), -0.45, 0.45)
        if truth is not None:
            # the first instant is the origin: nothing is known before it
            shift[0] = 0.0
            t_in = t_in + np.interp(stamps + shift, stamps, truth[0]) - truth[0]
            t_out = t_out + np.interp(stamps + shift, stamps, truth[1]) - truth[1]
        if recording.stamped:
            stamps = stamps + shift
    if recording.refresh_hz > 0.0:
        t_out = _held(stamps, t_out, recording.refresh_hz, float(rng.random()))
    t_in, t_out = _rounded(t_in, recording.step_in_n), _rounded(t_out, recording.step_out_n)
    found = replace(
        run,
        time_s=stamps,
        tension_in_n=t_in,
        tension_out_n=t_out,
        position_in_mm=run.position_in_mm if recording.position else None,
        tension_ref_n=run.tension_ref_n if recording.reference else None,
    )
    return _cut(found, recording.gaps)


def _held(stamps: Array, signal: Array, refresh_hz: float, phase: float) -> Array:
    tick = np.floor((stamps - stamps[0]) * refresh_hz + phase)
    fresh = np.concatenate(([True], tick[1:] != tick[:-1]))
    return np.asarray(signal[np.maximum.accumulate(np.where(fresh, np.arange(signal.size), 0))])


def _rounded(signal: Array, step: float) -> Array:
    return np.asarray(np.round(signal / step) * step) if step > 0.0 else signal


def _cut(run: Run, gaps: tuple[tuple[float, float], ...]) -> Run:
    """Return a run without the samples of missing stretches; a short run loses none."""
    share = (run.time_s - run.time_s[0]) / (run.time_s[-1] - run.time_s[0])
    there = np.ones(share.size, bool)
    for start, length in gaps:
        there &= (share < start) | (share > start + length)
    if there.all() or there.sum() < LEAST_SAMPLES:
        return run
    return run.cut(there)
