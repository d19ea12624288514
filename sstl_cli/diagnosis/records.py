"""Recorded runs made ready for fitting: checked, masked, averaged to the analysis rate, smoothed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.clock import Corners, before, blurred, hiding, on_grid, paced, since_first
from sstl_cli.diagnosis.constants import ANALYSIS_HZ, MIN_SAMPLES, MIN_SPAN_N, MIN_SPAN_SIGMA, ROUNDINGS, SIMULATION_HZ
from sstl_cli.diagnosis.driven import WITHIN, Input, at_corners, input_of, known_input
from sstl_cli.diagnosis.jitter import Piece, unstamped
from sstl_cli.diagnosis.kalman import MEAN_NEW, TURN
from sstl_cli.diagnosis.latent import Latent, Slow, Told, block_mean, nats_of
from sstl_cli.diagnosis.means import bridged, latent_means, of_readings, readings_of, unread_n, white_of
from sstl_cli.diagnosis.motion import slip_of
from sstl_cli.diagnosis.readings import agreed, folded, gaps, known, renewed, scanned, switched, unfolded
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.wander import Wander

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Start:
    """Where a model begins anew: place on the grid of the simulation, the output there (N) and its standard deviation (N)."""

    at: int
    output_n: float
    error_n: float


@dataclass(frozen=True)
class Passes:
    """An input that passes its samples at corners, behind a drive of some lag (s); ``doubt`` is the mean square of what that leaves open of them."""

    lag_s: float
    doubt: float


@dataclass(frozen=True)
class Record:
    """One run made ready; tensions in N.

    Simulation runs at the rate of ``u`` (latent input), ``y_smooth`` and ``rate``, shape
    (n * factor,), and so does ``slip`` where a motion drives the run; residuals live at the analysis rate of ``y`` (measured
    output) and ``weight`` (0 where the record says nothing), shape (n,), like ``error_n``, the standard deviation of what is not known of the
    input, ``error_law``, shape (n, 36), by which that error moves on (see ``smoother``; ``told_n`` and ``told_s`` are the slow noise of the sensor that this one was told of, 0 if none), and ``readings``, of how many
    readings of its sensor ``y`` is the mean, and ``share``, shape (n * factor,), of how much each step of the simulation counts in it;
    ``start_n`` is the output before the first sample, with its standard deviation; ``again`` is where a model has to begin
    anew, because the input may have turned unseen; ``corner`` is where the input may have passed
    ``u`` between samples, None where it has nowhere (``passes``: ``u`` goes there; ``rounded``: over how many samples ``u`` was smoothed as rounded at corners, ``rounds`` by how many nats the readings like each of ``ROUNDINGS`` better than sharp ones). ``raw`` is the run on its own grid. ``known`` is what an accepted simulator
    is known to leave of the output (N, shape (n * factor,)), ``misfit_n`` the standard deviation about it (N, shape (n,)) and ``misfit_s`` its correlation time, ``tail`` the degrees of freedom of its jerks (see misfit); ``wander`` is how the rig is
    known to vary (see wander); None where nothing is. ``louder`` and ``slower`` are white and slow noise of its output over its system's.
    It ``begun_s`` after the first run of its session, where one clock went through all of it, its tendon having gone ``gone_n``.
    """

    run_id: str
    system: str
    config: int
    location: str | None
    trajectory: str
    dt_s: float
    factor: int
    time_s: Array
    u: Array
    y: Array
    y_smooth: Array
    rate: Array
    weight: Array
    start_n: float
    start_error_n: float
    raw: Run
    faults_in: Faults
    faults_out: Faults
    raw_weight: Array
    y_fine: Array
    weight_fine: Array
    error_n: Array
    error_law: Array
    readings: Array
    share: Array
    slip: Array | None = None
    known: Array | None = None
    misfit_n: Array | None = None
    misfit_s: Array | float = 1.0
    tail: float = float("inf")
    wander: Wander | None = None
    again: tuple[Start, ...] = ()
    corner: Corners | None = None
    told_n: float = 0.0
    told_s: float = 1.0
    rounded: float = 0.0
    rounds: Array = field(default_factory=lambda: np.zeros(len(ROUNDINGS)))
    passes: Passes | None = None
    jitter_s: float = 0.0
    louder: float = 1.0
    slower: float = 1.0
    begun_s: float = 0.0
    gone_n: float = 0.0
    # its input behind drives that round corners, by width in samples: what smoothing costs is paid once
    behind: dict[float, Input] = field(default_factory=dict, compare=False)

    def __len__(self) -> int:
        return len(self.y)

    @property
    def thin(self) -> int:
        """Samples of the recording in one step of the simulation."""
        return max(1, round(self.dt_s / self.raw.dt_s))

    def averaged(self, column: str) -> int:
        """Return of how many readings of a channel one step of the simulation holds the mean."""
        return self.thin if known(self.raw, column).all() else 1


@dataclass(frozen=True)
class Problem:
    """All records of a diagnosis, with the configurations that share a theta and the runs set aside.

    ``unit_n`` is what one N of the records is in the recording (see scaling).
    """

    records: tuple[Record, ...]
    configs: tuple[str, ...]
    set_aside: dict[str, str]
    analysis_hz: float
    unit_n: float = 1.0

    @property
    def systems(self) -> tuple[str, ...]:
        return tuple(sorted({r.system for r in self.records}))

    @property
    def samples(self) -> int:
        return sum(len(r) for r in self.records)

    @property
    def scatters(self) -> bool:
        """Whether the simulator is known to leave more in some places than in others: one that was accepted before."""
        return any(r.misfit_n is not None for r in self.records)


def starts_of(r: Record) -> tuple[Start, ...]:
    """Return where a model of a record begins, first and anew."""
    return (Start(0, r.start_n, r.start_error_n), *r.again)


def prepare(runs: Sequence[Run], unit_n: float = 1.0, made: Mapping[str, Record] = MappingProxyType({})) -> Problem:
    """Return the problem that a set of runs poses.

    Parameters
    ----------
    made : mapping of run to Record
        Records of the same runs in the same units from an earlier call, perhaps beside others: smoothing is most of the work.

    Raises
    ------
    SstlError
        If no run can be used; the line gives the reasons.
    """
    aside: dict[str, str] = {}
    usable: list[tuple[Run, Faults, Faults]] = []
    for run in sorted(runs, key=lambda r: r.run_id):
        reason, checked = _usable(run)
        if checked is None:
            aside[run.run_id] = reason
        else:
            usable.append(checked)
    aside |= switched([run for run, _, _ in usable])
    usable = [item for item in usable if item[0].run_id not in aside]
    if not usable:
        raise SstlError(
            "no run can be diagnosed: " + ("; ".join(sorted(set(aside.values()))) or "there is none"),
            fix="record input and output over full loops",
            code="E901",
        )
    usable = agreed(usable)
    # runs without a configuration share no theta with any other
    keys = [r.config_id if r.config_id is not None else f"(run {r.run_id})" for r, _, _ in usable]
    configs = tuple(sorted(set(keys)))
    records = tuple(_made(made.get(item[0].run_id), *item, configs.index(key)) for item, key in zip(usable, keys, strict=True))
    if any(r.slip is not None for r in records):
        for r in records:
            if r.slip is None:
                aside[r.run_id] = "too short to show that its motion drives it, as it does in other runs"
        records = tuple(r for r in records if r.slip is not None)
        used = sorted({r.config for r in records})
        records = tuple(replace(r, config=used.index(r.config)) for r in records)
        configs = tuple(configs[c] for c in used)
    late = unstamped([p for r in records for p in _about_clock(r)])
    begun = since_first([r.raw for r in records])
    gone = before([float(np.abs(np.diff(r.u)).sum()) for r in records], begun, [r.system for r in records])
    records = tuple(replace(r, jitter_s=late, begun_s=s, gone_n=w) for r, s, w in zip(records, begun, gone, strict=True))
    return Problem(records, configs, aside, 1.0 / max(r.dt_s * r.factor for r in records), unit_n)


def _about_clock(r: Record) -> list[Piece]:
    """Return what the smoothed input of a record leaves of its readings, where a sensor was read at every instant of an even clock."""
    run = r.raw
    if r.slip is not None or not known(run, "tension_in_n").all():
        return []
    used = block_mean(known_input(run, r.faults_in).astype(float), r.thin)[: len(r.u)] == 1.0
    left = block_mean(run.tension_in_n, r.thin)[: len(r.u)] - r.u
    return [Piece(r.system, left[used], r.rate[used], r.dt_s)]


def _usable(run: Run) -> tuple[str, tuple[Run, Faults, Faults] | None]:
    finite = np.isfinite(run.tension_in_n) & np.isfinite(run.tension_out_n) & np.isfinite(run.time_s)
    if finite.sum() < MIN_SAMPLES:
        return f"fewer than {MIN_SAMPLES} samples", None
    time = run.time_s[finite]
    if np.any(np.diff(time) <= 0):
        return "time is not strictly increasing", None
    whole, ranges = unfolded(paced(run, finite), finite)
    run = folded(on_grid(renewed(whole, finite), finite), ranges)
    faults_in, faults_out = scanned(run, "tension_in_n"), scanned(run, "tension_out_n")
    good = ~(faults_in.bad | faults_out.bad)
    if good.sum() < MIN_SAMPLES:
        return "nearly all samples are recorder faults", None
    span = np.ptp(run.tension_in_n[~faults_in.bad])
    if span < max(MIN_SPAN_SIGMA * faults_in.noise_n, MIN_SPAN_N):
        return f"the input hardly moves: by {span:.3g}, beside a noise of {faults_in.noise_n:.2g}", None
    return "", (run, faults_in, faults_out)


def _made(before: Record | None, run: Run, faults_in: Faults, faults_out: Faults, config: int) -> Record:
    """Return the record of a run: the one made before, unless the limits of its sensors are others beside other runs."""
    if before is None or not (before.faults_in.same(faults_in) and before.faults_out.same(faults_out)):
        return _record(run, faults_in, faults_out, config)
    return replace(before, config=config)


def _record(run: Run, faults_in: Faults, faults_out: Faults, config: int) -> Record:
    thin = max(1, round(1.0 / (run.dt_s * SIMULATION_HZ)))
    dt = run.dt_s * thin
    factor = max(1, int(1.0 / (dt * ANALYSIS_HZ) + 0.5))
    n = len(run) // (thin * factor) * factor
    gap = gaps(run)
    good = (~(faults_in.bad | faults_out.bad)) & (gap == 0)
    fresh_out = known(run, "tension_out_n")
    fine_out = block_mean(bridged(run.tension_out_n, ~faults_out.bad), thin)[:n]
    into = input_of(run, faults_in, thin, factor, n, dt)
    out = latent_means(bridged(run.tension_out_n, ~faults_out.bad), good, fresh_out, faults_out.rounding_n, thin, n, dt)
    raw_weight = (good & ~(faults_in.clipped | faults_out.clipped)).astype(float)
    # a clipped input turns unseen, as it may in a gap; where the output is not known either, the model waits for it
    lost = block_mean(gap, thin)[:n] > 0
    turned = hiding(lost, into.u, into.rate * dt, faults_in.noise_n) + stretches(block_mean(faults_in.clipped.astype(float), thin)[:n] > 0)
    ready = (np.arange(n) % factor == 0) & (block_mean(raw_weight, thin)[:n] > 0.5)
    read = block_mean((good & fresh_out).astype(float), thin)[:n] > 0.0
    again = _starts(sorted(turned), ready, out, read)
    for end, start in again:
        raw_weight[end * thin : start.at * thin] = 0.0
    raw_weight[: n * thin][np.repeat(blurred(run, out.rate, thin) > faults_out.noise_n, thin)] = 0.0
    weight = (block_mean(raw_weight, thin * factor)[: n // factor] > 0.5).astype(float)
    # between two readings of a slow sensor there is nothing to compare
    weight *= block_mean(fresh_out.astype(float), thin * factor)[: n // factor] > 0.0
    slip = slip_of(run, thin, n)
    if slip is not None:
        # while the motion turns, friction can have any value between its two lines
        weight[np.abs(block_mean(slip, factor)) < 1.0] = 0.0
    y, readings, share = of_readings(run.tension_out_n, fine_out, good, fresh_out, thin, factor)
    return Record(
        run.run_id,
        run.system,
        config,
        run.location,
        run.trajectory or "",
        dt,
        factor,
        run.time_s[0] + (np.arange(len(y)) + 0.5) * dt * factor,
        into.u,
        y,
        out.value,
        into.rate,
        weight,
        float(out.value[0]),
        unread_n(out, read, 0),
        run,
        faults_in,
        faults_out,
        raw_weight,
        fine_out,
        (block_mean(raw_weight, thin)[:n] > 0.5).astype(float),
        into.error_n,
        into.error_law,
        readings,
        share,
        slip,
        again=tuple(dict.fromkeys(start for _, start in again if start.at < n)),
        corner=into.corner,
        rounds=into.rounds,
    )


def sampled_nats(r: Record, every: int, most: int, slow: Slow) -> float:
    """Return minus the log likelihood (nats) of every so many readings of a record's input, at most so many of them, beside slow noise.

    Of slow noise a sample is a sample; a mean of several would be smoother.
    """
    run, faults, dt_s = r.raw, r.faults_in, r.raw.dt_s * every
    good, fresh = known_input(run, faults), known(run, "tension_in_n")
    signal = bridged(run.tension_in_n, ~faults.bad)
    if not fresh.all():
        means, white, use = readings_of(signal, good, fresh, faults.rounding_n, every, min(len(run) // every, most), dt_s, slow)
        return nats_of(means, dt_s, white, use, slow)
    white, part = white_of(signal, good, faults.rounding_n, run.dt_s, slow), slice(0, every * most, every)
    return nats_of(signal[part], dt_s, white, good[part], slow)


def told(problem: Problem, slow: Mapping[str, Slow]) -> Problem:
    """Return a problem whose inputs are smoothed again, told of the slow noise of input sensors, by system."""

    def again(r: Record) -> Record:
        return r if r.system not in slow else _smoothed(r, Told(slow[r.system], r.rounded))

    return replace(problem, records=tuple(again(r) for r in problem.records))


def rounded(problem: Problem, width: float) -> Problem:
    """Return a problem whose inputs are smoothed again, as driven by something that rounds corners over so many samples."""
    return replace(problem, records=tuple(_smoothed(r, Told(rounded=width)) for r in problem.records))


def _smoothed(r: Record, how: Told) -> Record:
    """Return a record whose input is smoothed again."""
    into = _input_told(r, how)
    new = replace(r, **vars(into), rounded=how.rounded, passes=None, told_n=how.slow.sd_n, told_s=how.slow.correlation_s)
    return new if r.passes is None else _passing(new, r.passes)


def _input_told(r: Record, how: Told) -> Input:
    """Return the input of a record, smoothed as told; what hangs on the width alone is kept."""
    kept = how == Told(rounded=how.rounded)
    if kept and how.rounded in r.behind:
        return r.behind[how.rounded]
    into = input_of(r.raw, r.faults_in, r.thin, r.factor, len(r.u), r.dt_s, how)
    if kept:
        r.behind[how.rounded] = into
    return into


def _starts(turned: Sequence[tuple[int, int]], ready: Mask, out: Latent, read: Mask) -> list[tuple[int, Start]]:
    """Return the ends of stretches in which the input may have turned, and where a model begins anew behind each.

    A step of the analysis begins with a known output where it is ``ready``, shape (n,); without one behind a stretch the run ends there.
    """
    n, found = len(ready), []
    for _, end in turned:
        at = end + int(np.argmax(ready[end:])) if ready[end:].any() else n
        k = min(at, n - 1)
        found.append((end, Start(at, float(out.value[k]), unread_n(out, read, k))))
    return found


def passing(problem: Problem, how: Passes) -> Problem:
    """Return a problem whose input passes its samples at corners."""
    return replace(problem, records=tuple(_passing(r, how) for r in problem.records))


def _passing(r: Record, how: Passes) -> Record:
    """Return a record whose input goes on to its corners; anywhere between sample and corner leaves a third of the square open."""
    if r.corner is None:
        return replace(r, passes=how)
    law, (blur, shown) = r.error_law.copy(), at_corners(np.abs(r.corner.beyond), r.factor)
    less = (WITHIN - how.doubt) * blur**2
    law[:, MEAN_NEW] -= shown**2 * less
    law[:, TURN] -= (1.0 - shown**2) * less
    error_n = np.sqrt(np.maximum(r.error_n**2 - less, 0.0))
    return replace(r, u=r.u + r.corner.moved(how.lag_s), error_law=law, error_n=error_n, passes=how)


def content(r: Record) -> tuple[int, float, float]:
    """Return what orders records whatever they are called, in any unit: length, and means of what was read."""
    return len(r), float(np.mean(r.raw.tension_in_n)), float(np.mean(r.raw.tension_out_n))


def representatives(problem: Problem) -> Problem:
    """Return a smaller problem with every system and trajectory, over a few configurations.

    Both systems of a configuration stay together, because they share its theta. Names decide nothing.
    """
    ordered = sorted(problem.records, key=content)
    trajectories = list(dict.fromkeys(r.trajectory for r in ordered))
    keep: set[tuple[int, str]] = set()
    for turn, name in enumerate(trajectories):
        configs = list(dict.fromkeys(r.config for r in ordered if r.trajectory == name))
        keep.add((configs[turn % len(configs)], name))
    records = [r for r in problem.records if (r.config, r.trajectory) in keep]
    used = sorted({r.config for r in records})
    renumbered = tuple(replace(r, config=used.index(r.config)) for r in records)
    return replace(problem, records=renumbered, configs=tuple(problem.configs[c] for c in used), set_aside={})
