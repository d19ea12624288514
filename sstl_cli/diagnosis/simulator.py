"""The fast model applied to every record of a problem, and its derivatives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import UNSEEN_SHARE
from sstl_cli.diagnosis.drives import pieces
from sstl_cli.diagnosis.ending import Parted, held_back, parted
from sstl_cli.diagnosis.free import ASIDE, LINE, LOOP
from sstl_cli.diagnosis.kalman import TURN
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.records import Problem, Record, Start, starts_of
from sstl_cli.diagnosis.slides import SHIFT_N, STEEPEST, Grid, breakaways, phases_of
from sstl_cli.diagnosis.whitening import Constants, Noise, Phases, Whitener
from sstl_cli.physics.effect import Mechanics, Sampling
from sstl_cli.physics.effects import get
from sstl_cli.physics.filters import delayed
from sstl_cli.physics.transmission.active import activate
from sstl_cli.physics.transmission.batch import Case, laid, predict_runs
from sstl_cli.physics.transmission.model import Hooked, sensed, unsensed

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Effects = Mapping[str, Mapping[str, float]]
CEILING_N = 1e6
# outer points of a Gauss-Hermite quadrature of three (standard deviations); each weighs 1 / (2 * 3)
QUADRATURE = math.sqrt(3.0)


@dataclass(frozen=True)
class _Asked:
    """A model to simulate: ``shift_n`` is added to the input, what is known to be left counts where the ``whole`` is asked for."""

    theta: Array
    effects: Effects
    shift_n: float | Array = 0.0
    whole: bool = True


@dataclass
class Simulator:
    """Predicts the measured output of every record; records are concatenated in order.

    ``fixed`` effects are those of the user's own simulator; the same effect as a candidate is a change of its strengths.
    ``dispersion`` is by how much tests of the residual are known to exceed chance (see misfit), ``accepted`` the theta of a
    model that was accepted before, shape (configurations,), ``usual`` the standard deviation by which each of its strengths
    varies from record to record, by effect and name, ``scatters`` whether the records know what an accepted model leaves, or
    how it varies, ``behind`` whether more friction at the end than it has acts on that too (see ending), ``more_n`` and
    ``slips_n`` the standard deviations (N, shape (samples,)) of what all models have beside the sensors' noise: new at every step, or
    at every step of a slide and kept in holds (see shared), ``rests`` whether outputs are seen to rest within strokes (see sticking),
    ``zeros_n`` at which tension (N) an output in another unit reads nothing, by system.
    """

    problem: Problem
    mechanics: Mechanics
    fixed: Effects = field(default_factory=dict)
    dispersion: Mapping[str, float] = field(default_factory=dict)
    accepted: Array | None = None
    usual: Mapping[tuple[str, str], float] = field(default_factory=dict)
    behind: bool = True
    more_n: Array | None = None
    slips_n: Array | None = None
    rests: bool = False
    zeros_n: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        p = self.problem
        # where the input may have turned unseen, a run of the model ends and another begins; its clocks go on
        self._runs = laid([piece for r in p.records for piece in pieces(r, self.mechanics)])
        self._fine_edges = np.concatenate(([0], np.cumsum([len(r.u) for r in p.records]))).astype(np.int64)
        self.scatters = any(r.misfit_n is not None or r.wander is not None for r in p.records)
        self._samplings = [
            Sampling(r.system, r.dt_s, len(r.u), begin_n=r.start_n, begun_s=r.begun_s, zero_n=self.zeros_n.get(r.system, 0.0))
            for r in p.records
        ]
        self._places = np.array([r.config for r in p.records for _ in starts_of(r)])
        self.read_as(1.0, 0.0)
        self._begin = np.array([e + s.at for r, e in zip(p.records, self._fine_edges, strict=False) for s in starts_of(r)], np.int64)
        self._factors = np.array([r.factor for r in p.records])
        self._share = np.concatenate([r.share for r in p.records])
        self._driven = np.array([r.slip is not None for r in p.records])
        known = [r.known for r in p.records]
        self._known = (
            None
            if all(k is None for k in known)
            else np.concatenate([np.zeros(len(r.u)) if k is None else k for r, k in zip(p.records, known, strict=True)])
        )
        self.edges = np.concatenate(([0], np.cumsum([len(r) for r in p.records])))
        self.y = np.concatenate([r.y for r in p.records])
        self.weight = np.concatenate([r.weight for r in p.records])
        self.config = np.concatenate([np.full(len(r), r.config) for r in p.records])
        self.run = np.concatenate([np.full(len(r), i) for i, r in enumerate(p.records)])
        tail = np.concatenate([np.full(len(r), r.tail) for r in p.records])
        self._tail = tail if np.isfinite(tail).any() else None
        self._entering: tuple[Noise, Phases] | None = None
        self._constants: tuple[Noise, Constants] | None = None
        self._last_sampled: tuple[bytes, list[Sampling], list[tuple[Record, Start, Sampling]]] | None = None

    def read_as(self, gain: float, zero_n: float) -> None:
        """Let every record begin where its output reads what it does by a gain and a zero (N): NaN is midway between the lines of a model."""
        self._starts = (np.array([s.output_n for r in self.problem.records for s in starts_of(r)]) - zero_n) / (gain or 1.0)

    def _each(self, signal: Array) -> list[Array]:
        """Return a signal record by record."""
        return [signal[a:b] for a, b in zip(self._fine_edges[:-1], self._fine_edges[1:], strict=True)]

    def changed(self, effect_id: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return the values of an effect; where the user's simulator contains it, they change what is there."""
        there = self.fixed.get(effect_id)
        if there is None:
            return dict(values)
        total = get(effect_id).complete(there)
        for p in get(effect_id).parameters:
            if not p.shape and p.name in values:
                total[p.name] = min(max(total[p.name] + values[p.name] - p.neutral, p.least), p.most)
        return total

    def loop_friction(self, effects: Effects) -> float:
        """Return the friction of the sensing loop over that of the actuation tendon."""
        return self.mechanics.loop_friction * (1.0 + effects.get(LOOP.id, {}).get(LOOP.parameters[0].name, 0.0))

    def end_mm_per_n(self, system: str, values: Mapping[str, float]) -> float:
        """Return the compliance of what a system ends at: that of the load, the loop's own, or as much of the load's as in the user's simulator."""
        load, built = values["load_mm_per_n"], self.mechanics
        if system != "sstl":
            return load
        return values.get("loop_load_mm_per_n", load * built.end_mm_per_n(system) / built.end_mm_per_n("act"))

    def _ending(self, values: Mapping[str, float]) -> Mechanics:
        """Return the mechanics with what the lines of a fit end at."""
        tendon, loop = (1.0 / self.end_mm_per_n(system, values) for system in ("act", "sstl"))
        return replace(self.mechanics, load_n_per_mm=tendon, loop_load_n_per_mm=loop)

    @property
    def left(self) -> bool:
        """Whether it is known what an accepted model leaves, on which more friction at its end acts."""
        return self.behind and self._known is not None

    @property
    def load_known(self) -> bool:
        """Whether an effect along the line was accepted before, and with it how far the load gives way."""
        return any(get(i).stretches for i in self.fixed)

    @cached_property
    def read_n(self) -> tuple[float, float]:
        """Between what tensions (N) inputs and outputs were read, but for a small share at either end."""
        read = np.concatenate([self.y[self.weight > 0.0], *(r.u for r in self.problem.records)])
        low, high = np.quantile(read, [UNSEEN_SHARE, 1.0 - UNSEEN_SHARE])
        return float(low), float(high)

    def slices(self) -> list[slice]:
        """Return the slice of each record in the concatenated arrays."""
        return [slice(a, b) for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]

    def predict(self, theta: Array, effects: Effects) -> Array:
        """Return the predicted measured output (N, shape (samples,)) for one theta per configuration."""
        return self.predict_each([(theta, effects)])[0]

    def predict_each(self, models: Sequence[tuple[Array, Effects]]) -> list[Array]:
        """Return the predicted measured outputs (N, shape (samples,) each) of several models, which are simulated together."""
        fine = self._fine([_Asked(theta, effects) for theta, effects in models])
        return [_means(x, self._share, self._fine_edges, self.edges, self._factors) for x in fine]

    def by_input(self, theta: Array, effects: Effects) -> Array:
        """Return d prediction / d input (shape (samples,)): what the output makes of a shift of all that is read."""
        here, moved = self._fine([_Asked(theta, effects), _Asked(theta, effects, SHIFT_N)])
        return _means((moved - here) / SHIFT_N, self._share, self._fine_edges, self.edges, self._factors)

    def phases(self, theta: Array, effects: Effects, noise: Noise | None = None) -> Phases:
        """Return where the model slides, how steeply, and where it may have slid.

        From its answer to the latent input, to one that is shifted, and to those by the error of the input (with ``noise``
        also that of its sensor) higher and lower: a quadrature over that error with three points (Julier and Uhlmann 2004).
        """
        error = np.concatenate([np.repeat(_error_n(r, noise), r.factor) for r in self.problem.records])
        shifts = (0.0, SHIFT_N, QUADRATURE * error, -QUADRATURE * error)
        here, moved, high, low = self._fine([_Asked(theta, effects, shift, False) for shift in shifts])
        grid = Grid(self._fine_edges, self.edges, self._factors)
        slide, left, gain = phases_of(here, moved, self._runs.tension_n, self._share, grid, self._driven)
        breaks = breakaways(here, self._runs.tension_n, self._share, (slide, left, gain), (self._begin, self._starts), grid, self._driven)
        bent = 0.5 * np.nan_to_num(high + low - 2.0 * here)
        doubt = _means(np.abs(bent), self._share, self._fine_edges, self.edges, self._factors) / QUADRATURE
        return Phases(slide, left, gain, np.minimum(doubt, STEEPEST * float(error.max(initial=0.0))), breaks=breaks)

    def where_noise_enters(self, theta: Array, effects: Effects, noise: Noise) -> Phases:
        """Return the phases by which a fit is whitened: its own, or those of a model that was accepted before.

        Beside the known scatter of an accepted model noise is alike for all that are compared.
        """
        if self.accepted is None:
            return self._slipping(self.phases(theta, effects, noise))
        if self._entering is None or self._entering[0] is not noise:
            # what a model leaves does not change the noise that is alike for all
            self._entering = (noise, replace(self._slipping(self.phases(self.accepted, {}, noise)), breaks=None))
        return self._entering[1]

    def _slipping(self, phases: Phases) -> Phases:
        return phases if self.slips_n is None else phases.jumping(self.slips_n)

    def jerky(self, whiten: Whitener, residual: Array) -> Whitener:
        """Return a whitener that takes jerks for what they are known to be, by the precisions that a residual (N) shows."""
        return whiten if self._tail is None else whiten.trusting(residual, self._tail)

    def constants(self, effects: Effects, noise: Noise) -> Constants:
        """Return what the noise is whatever the model does; kept for all models that read the records as they are."""
        late = self._late_s(effects)
        if any(late):
            return self._louder(constants(self._read(late), noise))
        if self._constants is None or self._constants[0] is not noise:
            self._constants = (noise, self._louder(constants(self.problem.records, noise)))
        return self._constants[1]

    def _louder(self, c: Constants) -> Constants:
        return c if self.more_n is None else replace(c, white_n=np.hypot(c.white_n, self.more_n))

    def read_records(self, effects: Effects) -> tuple[Record, ...]:
        """Return the records with their known scatter as the output's channel reads it: it arises in the rig, before any lag."""
        return self._read(self._late_s(effects))

    def _late_s(self, effects: Effects) -> tuple[float, ...]:
        """Return by how much (s) each record is read late; all 0 where nothing is known to scatter."""
        if not self.scatters:
            return (0.0,) * len(self.problem.records)
        found = [(get(k), v) for k, v in effects.items() if k not in ASIDE]
        # of a lag that is there already less may be left
        own = [(e.late_s, {**e.complete({}), **v}) for e, v in found if e.late_s is not None]
        return tuple(sum(late_s(r.system, v) for late_s, v in own) for r in self.problem.records)

    def _read(self, late_s: Sequence[float]) -> tuple[Record, ...]:
        return tuple(_read_late(r, late) for r, late in zip(self.problem.records, late_s, strict=True))

    def predict_fine(self, theta: Array, effects: Effects) -> list[Array]:
        """Return the prediction of each record at the rate of its simulation (N, shape (n * factor,))."""
        return self._each(self._fine([_Asked(theta, effects)])[0])

    def _fine(self, asked: Sequence[_Asked]) -> list[Array]:
        """Return the predictions at the rate of the simulation, end to end.

        What the simulator is known to leave is a part of the rig like any other, which sensors read and filters pass on.
        """
        made = [self._made(a) for a in asked]
        outs = predict_runs(self._runs, [m[0] for m in made])
        return [self._seen(out, a, *m) for a, m, out in zip(asked, made, outs, strict=True)]

    def _made(self, asked: _Asked) -> tuple[Case, Array, Hooked, float]:
        """Return what is to be simulated, the input as it is read (N), what the output's sensor does, and more friction at the end (N)."""
        effects = asked.effects
        built = self._ending(effects[LINE.id]) if LINE.id in effects else None
        effects = {**self.fixed, **{k: self.changed(k, v) for k, v in effects.items() if k not in ASIDE}}
        whole = asked.whole and self.left
        effects, more = parted(effects, self.fixed) if whole else Parted(effects, 0.0)
        active = activate(effects)
        runs = self._runs
        read = runs.tension_n + asked.shift_n if np.any(asked.shift_n) else runs.tension_n
        given = read
        if undo := active.of_hook("input_inverse"):
            rows = zip(self._sampled(asked.theta)[0], self._each(read), self.problem.records, strict=True)
            given = np.concatenate([unsensed(undo, s, u, r.y_smooth) for s, u, r in rows])
        seen, starts = active.of_hook("output"), self._starts
        if seen:
            starts = np.array([_true_start(r, s, seen, at) for r, s, at in self._sampled(asked.theta)[1]])
        loop = self.loop_friction(asked.effects)
        return Case(asked.theta[self._places], active, starts, None if given is runs.tension_n else given, built, loop), read, seen, more

    def _seen(self, out: Array, asked: _Asked, case: Case, read: Array, seen: Hooked, more_n: float) -> Array:
        """Return true outputs (N) as sensors show them."""
        if asked.whole and self._known is not None:
            out = out + self._known
        if more_n > 0.0:
            out = held_back(out, more_n, self._begin, case.start_n)
        if seen:
            pairs = zip(self._sampled(asked.theta)[0], self._each(read), self._each(out), strict=True)
            out = np.concatenate([sensed(seen, s, u, y) for s, u, y in pairs])
        return out

    def _sampled(self, theta: Array) -> tuple[list[Sampling], list[tuple[Record, Start, Sampling]]]:
        """Return what sensors may know of each record, of which bend it is included, and of each start; kept for the last theta."""
        key, found = theta.tobytes(), self._last_sampled
        if found is None or found[0] != key:
            known = [replace(s, theta=float(theta[r.config])) for s, r in zip(self._samplings, self.problem.records, strict=True)]
            of = zip(known, self.problem.records, strict=True)
            begun = [(r, s, replace(k, count=len(r.u) if s.at else 2, begin_n=None)) for k, r in of for s in starts_of(r)]
            self._last_sampled = found = (key, known, begun)
        return found[1:]


@njit(cache=True, nogil=True)
def _means(fine: Array, share: Array, fine_edges: Counts, edges: Counts, factors: Counts) -> Array:
    """Return means of blocks of ``factors[i]`` samples of run i, each sample by its share."""
    out = np.empty(edges[-1])
    for i in range(factors.size):
        f, at = factors[i], fine_edges[i]
        for k in range(edges[i], edges[i + 1]):
            total = 0.0
            for _ in range(f):
                x = fine[at]
                # a fit may ask for the absurd; it must only stay a number
                total += share[at] * (CEILING_N if math.isnan(x) else min(max(x, -CEILING_N), CEILING_N))
                at += 1
            out[k] = total
    return out


def _error_n(r: Record, noise: Noise | None) -> Array:
    """Return the standard deviation (N) of what is not known of the input, at the analysis rate: at the end of a step as of its mean."""
    error = np.sqrt(r.error_n**2 + r.error_law[:, TURN])
    if noise is None:
        return error
    return np.asarray(np.hypot(noise.smoother[r.system] * error, 0.0 if r.told_n else noise.input[r.system].coloured_n))


def _read_late(r: Record, late_s: float) -> Record:
    if late_s == 0.0:
        return r
    steps = late_s / (r.dt_s * r.factor)
    scatter = None if r.misfit_n is None else delayed(r.misfit_n, steps)
    lasting = delayed(r.misfit_s, steps) if isinstance(r.misfit_s, np.ndarray) else r.misfit_s
    return replace(r, misfit_n=scatter, misfit_s=lasting, wander=None if r.wander is None else r.wander.late(steps))


def _true_start(r: Record, start: Start, hooked: Hooked, sampling: Sampling) -> float:
    """Return the true output where a model begins, at which its sensor reads what was measured (secant method; exact of a gain and a zero)."""

    def seen(output_n: float) -> float:
        return float(sensed(hooked, sampling, r.u[: sampling.count], np.full(sampling.count, output_n))[start.at])

    read = start.output_n
    there = seen(read)
    first = 2.0 * read - there
    if first == read or np.isnan(first):
        return first
    here = seen(first)
    slope = (here - there) / (first - read)
    # a sensor that does not follow says nothing of where it is
    return first + (read - here) / slope if slope > 0.0 else first
