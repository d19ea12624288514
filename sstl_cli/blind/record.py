"""The rig as a source of cases: true tensions of every run once, then sensors and noise on top."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind import unlisted
from sstl_cli.blind.bench import Bench, PlannedRun
from sstl_cli.blind.retune import Pair, gap_n
from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get
from sstl_cli.physics.rig import QUIET, NoiseSpec, RigRun, resolve_effects, simulate_rig
from sstl_cli.physics.rig.sensors import record

Array = NDArray[np.float64]
Values = Mapping[str, float]
Effects = Mapping[str, Values]
Truth = tuple[Array, Array, Array]
MAINS_HZ = (49.97, 50.03)


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

    def truth(self, run: PlannedRun, effects: Effects) -> Truth:
        """Return true tensions in and out (N) and position (mm) of a run.

        Raises
        ------
        SstlError
            If the rig does not converge.
        """
        strange = next((e for e in effects if e in unlisted.UNLISTED and e != "mains_hum"), None)
        mechanical = {k: v for k, v in effects.items() if k not in unlisted.UNLISTED and not at_sensor(k)}
        key = (run.run_id, run.trajectory, _key(mechanical), strange and _key({strange: effects[strange]}))
        if key not in self._known:
            if len(self._known) > 400:
                self._known.clear()
            self._known[key] = self._march(run, mechanical, strange, effects)
        return self._known[key]

    def _march(self, run: PlannedRun, mechanical: Effects, strange: str | None, effects: Effects) -> Truth:
        spec, theta, place = self.bench.spec, self.bench.theta[run.config], self.bench.locations[run.config]
        if strange is not None:
            values = dict(effects[strange])
            if strange == "moved_tube":
                theta, values = self._moved(run, theta, values)
            out, travel = unlisted.march(spec, run, theta, place, values)
            return run.command_n, out, travel
        rig_run = RigRun(run.system, theta, place, run.time_s, "tension", run.command_n)
        result = simulate_rig(spec, rig_run, {k: dict(v) for k, v in mechanical.items()}, QUIET)
        if result.unconverged > max(1, run.time_s.size // 100_000):
            raise SstlError(f"{result.unconverged} steps of the rig did not converge", where=run.run_id, code="E950")
        return result.true_tension_in_n, result.true_tension_out_n, result.true_position_in_mm

    def _moved(self, run: PlannedRun, theta: float, values: dict[str, float]) -> tuple[float, dict[str, float]]:
        """Return theta and jump of one run: the tube moves once for each bend, half-way through its recordings."""
        own = [r.run_id for r in self.bench.runs if r.config == run.config]
        if run.run_id not in own:
            return theta * (1.0 + values["jump"]), {"jump": 0.0}
        place = own.index(run.run_id) - len(own) // 2
        if place == 0:
            return theta, values
        return (theta * (1.0 + values["jump"]) if place > 0 else theta), {"jump": 0.0}

    def readings(self, run: PlannedRun, effects: Effects, noise: NoiseSpec) -> tuple[Array, Array, Array, Array]:
        """Return time stamps (s), tensions in and out (N) and position (mm) as the recorder stores them."""
        known = resolve_effects({k: v for k, v in effects.items() if k not in unlisted.UNLISTED})
        seed = int(stream(self.seed, "sensors", run.run_id, run.trajectory).integers(2**63))
        stamps, t_in, t_out, x = record(run.time_s, self.truth(run, effects), known, run.system, noise, seed)
        if "mains_hum" in effects:
            rng = stream(self.seed, "hum", run.run_id, run.trajectory)
            mains, amplitude = float(rng.uniform(*MAINS_HZ)), effects["mains_hum"]["amplitude_n"]
            t_in = t_in + unlisted.hum(stamps, 0.7 * amplitude, float(rng.uniform(0, 6.28)), mains)
            t_out = t_out + unlisted.hum(stamps, amplitude, float(rng.uniform(0, 6.28)), mains)
        return stamps, t_in, t_out, x

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

    def record(self, runs: Sequence[PlannedRun], effects: Effects) -> list[Run]:
        """Return noisy recordings under neutral names."""
        found = []
        for run in runs:
            stamps, t_in, t_out, x = self.readings(run, effects, self.bench.noise)
            found.append(
                Run(
                    run_id=run.run_id,
                    system=run.system,
                    time_s=stamps,
                    tension_in_n=t_in,
                    tension_out_n=t_out,
                    config_id=self.bench.config_id(run.config),
                    location=self.bench.locations[run.config],
                    trajectory=run.trajectory,
                    position_in_mm=x if self.bench.position else None,
                    tension_ref_n=run.command_n if self.bench.reference else None,
                )
            )
        return found

    def with_noise(self, factor: float) -> Source:
        """Return the same source with all noise scaled."""
        n = self.bench.noise
        noise = NoiseSpec(n.white_n * factor, n.coloured_n * factor, n.correlation_s, n.position_mm * factor)
        return Source(replace(self.bench, noise=noise), self.seed, self._known)

    @property
    def noise_n(self) -> float:
        """RMS noise of the output sensor (N)."""
        return float(np.hypot(self.bench.noise.white_n, self.bench.noise.coloured_n))


def _key(effects: Effects) -> tuple[object, ...]:
    return tuple((k, tuple(sorted(v.items()))) for k, v in sorted(effects.items()))
