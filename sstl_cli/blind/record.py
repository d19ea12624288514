"""The rig as a source of cases: true tensions of every run once, then sensors and noise on top."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind.bench import Bench, PlannedRun
from sstl_cli.blind.retune import Pair, gap_n
from sstl_cli.blind.simulators import Hardware
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics import disturbances, recording
from sstl_cli.physics.disturbances import Disturbance, Scene
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get
from sstl_cli.physics.recording import Recording
from sstl_cli.physics.rig import QUIET, NoiseSpec

Array = NDArray[np.float64]
Values = Mapping[str, float]
Effects = Mapping[str, Values]
Truth = tuple[Array, Array, Array]
# what no catalogue holds goes by this name; its one value is its amplitude
DISTURBANCE = "disturbance"
# zeros that move between days leave a gap of at most this share of the noise
DAY_SHARE = 0.1
# and a resolution (over the noise) rounds by a seventh of it
FINE_SHARE = 0.5


def at_sensor(effect_id: str) -> bool:
    """Whether an effect sits in the sensors or the recorder, so that the mechanics do not change with it."""
    effect = get(effect_id)
    return effect.stage == INSTRUMENT and effect.channel == "out"


@dataclass
class Source:
    """Records the runs of one bench; mechanics are simulated once for each set of mechanical effects."""

    bench: Bench
    seed: int
    _known: dict[object, Truth] = field(default_factory=dict)
    disturbance: Disturbance | None = None
    # the same bench on another day has other noise
    session: int = 0

    def truth(self, run: PlannedRun, effects: Effects) -> Truth:
        """Return true tensions in and out (N) and position (mm) of a run.

        Raises
        ------
        SstlError
            If the rig does not converge.
        """
        mechanical = {k: v for k, v in effects.items() if k != DISTURBANCE and not at_sensor(k)}
        amplitude = self._amplitude(effects)
        key = (run.run_id, run.trajectory, _key(mechanical), self.disturbance, amplitude)
        if key not in self._known:
            if len(self._known) > 400:
                self._known.clear()
            if amplitude and self.disturbance is not None and self.disturbance.in_line:
                scene = self._scene(run, mechanical)
                self._known[key] = disturbances.in_line(self.disturbance, amplitude, scene, self._march_of(run, mechanical))
            else:
                self._known[key] = self._march(run, run.command_n, mechanical, None)
        return self._known[key]

    def _amplitude(self, effects: Effects) -> float:
        return float(effects[DISTURBANCE]["amplitude"]) if DISTURBANCE in effects else 0.0

    def _march(self, run: PlannedRun, command_n: Array, mechanical: Effects, friction: Array | None) -> Truth:
        theta, place = self.bench.theta[run.config], self.bench.locations[run.config]
        return self.hardware.march(run.system, theta, place, run.time_s, command_n, mechanical, friction)

    def _march_of(self, run: PlannedRun, mechanical: Effects) -> disturbances.Simulate:
        def simulate(_: Scene, command_n: Array, friction: Array | None) -> tuple[Array, Array]:
            return self._march(run, command_n, mechanical, friction)[1:]

        return simulate

    def _scene(self, run: PlannedRun, mechanical: Effects, lab: Recording | None = None) -> Scene:
        order = [r.run_id for r in self.bench.runs].index(run.run_id) if run in self.bench.runs else len(self.bench.runs)
        return Scene(run.system, order, *self._clocked(run, self.truth(run, mechanical), lab))

    @property
    def hardware(self) -> Hardware:
        """The simulator that stands in for this bench."""
        return Hardware(self.bench.hardware, self.bench.spec, self.seed % 2**32)

    def readings(
        self, run: PlannedRun, effects: Effects, noise: NoiseSpec, lab: Recording | None = None
    ) -> tuple[Array, Array, Array, Array]:
        """Return time stamps (s), tensions in and out (N) and position (mm) as the sensors give them, at a lab's rate."""
        known = {k: v for k, v in effects.items() if k != DISTURBANCE}
        day = (self.session,) if self.session else ()
        seed = int(stream(self.seed, "sensors", run.run_id, run.trajectory, *day).integers(2**63))
        theta, amplitude = self.bench.theta[run.config], self._amplitude(effects)
        time_s, *truth = self._clocked(run, self.truth(run, effects), lab)
        stamps, t_in, t_out, x = self.hardware.read(run.system, theta, time_s, (truth[0], truth[1], truth[2]), known, noise, seed)
        if amplitude and self.disturbance is not None:
            scene = self._scene(run, {k: v for k, v in known.items() if not at_sensor(k)}, lab)
            t_in, t_out = disturbances.in_reading(self.disturbance, amplitude, scene, t_in, t_out)
        return stamps, t_in, t_out, x

    def _clocked(self, run: PlannedRun, truth: Truth, lab: Recording | None) -> tuple[Array, ...]:
        """Return instants (s) and true channels of a run on the clock of a recorder."""
        return (run.time_s, *truth) if lab is None else recording.at_rate(lab, run.time_s, *truth)

    def pairs(self, effects: Effects) -> list[Pair]:
        """Return noise-free input and output of every run, as the re-tuned base sees them."""
        found = []
        for run in self.bench.runs:
            _, t_in, t_out, _ = self.readings(run, effects, QUIET)
            if "acquisition_faults" in effects:
                # a spike of the input is no tension: the error that counts is the one of the recorded output
                t_in = self.truth(run, effects)[0]
            found.append(Pair(run.config, 2 if run.system == "sstl" else 1, t_in, t_out))
        return found

    def gap(self, effects: Effects) -> tuple[float, list[float]]:
        """Return the RMS gap (N) left by the re-tuned base on noise-free runs, and the theta it takes."""
        return gap_n(self.pairs(effects), self.bench.theta)

    def channel_gap(self, effects: Effects, channel: str) -> float:
        """Return the RMS gap in position (mm, origin and load stiffness free) or between reference and input tension (N)."""
        parts = []
        for run in self.bench.runs:
            t_in, t_out, x = self.truth(run, effects)
            if channel == "loop":
                parts.append(t_in - run.command_n)
            else:
                off = x - self.truth(run, {})[2]
                # origin and stiffness of the load are not known to anybody: a re-tuned base takes them as they fit
                own = np.stack([np.ones_like(t_out), t_out], axis=1)
                parts.append(off - own @ np.linalg.lstsq(own, off, rcond=None)[0])
        return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))

    def record(self, runs: Sequence[PlannedRun], effects: Effects, first: int = 0) -> list[Run]:
        """Return noisy recordings under neutral names; ``first`` is the place of the first one in the session."""
        found = []
        lab = self.bench.lab
        for order, run in enumerate(runs, first):
            stamps, t_in, t_out, x = self.readings(run, effects, self.bench.noise, lab)
            made = self._run(run, lab, stamps, t_in, t_out, x)
            made = replace(
                made, position_in_mm=x if self.bench.position else None, tension_ref_n=made.tension_ref_n if self.bench.reference else None
            )
            if lab is not None:
                # jitter moves what the sensors would have shown, not their noise
                quiet = self.readings(run, effects, QUIET, lab)[1:3] if lab.jitter > 0.0 else None
                made = recording.apply(lab, made, order, len(self.bench.runs), quiet)
            found.append(made)
        return found

    def clean(self, effects: Effects) -> list[Run]:
        """Return the session as sensors without noise would give it, with position and reference.

        The stretches that a lab misses are there: who computes with them leaves them out. The input of a recorder that
        spoils samples is the true one, as it is for the gap.
        """
        lab = None if self.bench.lab is None else Recording(rate_hz=self.bench.lab.rate_hz)
        found = []
        for run in self.bench.runs:
            stamps, t_in, t_out, x = self.readings(run, effects, QUIET, lab)
            if "acquisition_faults" in effects:
                t_in = self._clocked(run, self.truth(run, effects), lab)[1]
            found.append(self._run(run, lab, stamps, t_in, t_out, x))
        return found

    def _run(self, run: PlannedRun, lab: Recording | None, stamps: Array, t_in: Array, t_out: Array, x: Array) -> Run:
        return Run(
            run_id=run.run_id,
            system=run.system,
            time_s=stamps,
            tension_in_n=t_in,
            tension_out_n=t_out,
            config_id=self.bench.config_id(run.config),
            location=self.bench.locations[run.config],
            trajectory=run.trajectory,
            position_in_mm=x,
            tension_ref_n=run.command_n if lab is None else recording.at_rate(lab, run.time_s, run.command_n)[1],
        )

    def as_recorded(self) -> Source:
        """Return the source with a recorder that adds little to the gap, so that what is withheld stays what is missing.

        A coarse resolution and a zero that moves far are effects of the catalogue; here they are habits of a lab.
        """
        lab = self.bench.lab
        if lab is None:
            return self
        lab = replace(
            lab,
            step_in_n=min(lab.step_in_n, FINE_SHARE * self.noise_n),
            step_out_n=min(lab.step_out_n, FINE_SHARE * self.noise_n),
            position=self.bench.position,
            reference=self.bench.reference,
        )
        if len(lab.day_zero_n) > 1:
            still = self.pairs({})
            moved = [self._moved(lab, p, i) for i, p in enumerate(still)]
            added2 = gap_n(moved, self.bench.theta)[0] ** 2 - gap_n(still, self.bench.theta)[0] ** 2
            share = min(1.0, DAY_SHARE * self.noise_n / float(np.sqrt(max(added2, 1e-18))))
            lab = replace(lab, day_zero_n=tuple((share * a, share * b, share * c, share * d) for a, b, c, d in lab.day_zero_n))
        return replace(self, bench=replace(self.bench, lab=lab))

    def _moved(self, lab: Recording, pair: Pair, order: int) -> Pair:
        runs = self.bench.runs
        zeros = dict(zip(recording.SENSORS, lab.day_zero_n[recording.day_of(lab, order, len(runs))], strict=True))
        into, out = zeros[runs[order].system, "in"], zeros[runs[order].system, "out"]
        return replace(pair, t_in=pair.t_in + into, t_out=pair.t_out + out)

    def with_noise(self, factor: float) -> Source:
        """Return the same source with all noise scaled."""
        n = self.bench.noise
        noise = NoiseSpec(n.white_n * factor, n.coloured_n * factor, n.correlation_s, n.position_mm * factor)
        return replace(self, bench=replace(self.bench, noise=noise))

    @property
    def noise_n(self) -> float:
        """RMS noise of the output sensor (N)."""
        return float(np.hypot(self.bench.noise.white_n, self.bench.noise.coloured_n))


def _key(effects: Effects) -> tuple[object, ...]:
    return tuple((k, tuple(sorted(v.items()))) for k, v in sorted(effects.items()))
