"""A laboratory drawn at random: tube, tendon, sensors, configurations and the movements it records."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.rng import log_uniform
from sstl_cli.physics.recording import SYSTEMS, Recording
from sstl_cli.physics.rig import NoiseSpec, RigSpec
from sstl_cli.physics.scenario import Configuration, Lines, NoiseSection, RigSection, Scenario, Trajectory
from sstl_cli.physics.trajectories import probe, tension_path

Array = NDArray[np.float64]
Rng = np.random.Generator

KINDS = ("trapezoid", "sinusoid", "random", "ramp_hold", "minor_loops", "chirp")
RATES_HZ = (100.0, 125.0, 200.0, 250.0, 500.0)
RATE_WEIGHTS = (0.3, 0.2, 0.2, 0.2, 0.1)
LOCATIONS = ("NP", "CP", "ND")
# range of samples of one case, all runs together
SAMPLES, QUICK_SAMPLES = (40_000, 80_000), (12_000, 16_000)
# a lab that records faster keeps as many samples as this at most, and its mechanics are simulated at these rates
LAB_SAMPLES, LAB_QUICK_SAMPLES = 120_000, 60_000
SLOWEST_HZ, FASTEST_HZ = 100.0, 500.0
# what a lab knows of its rig: the data sheet of the tendon and a spring that somebody measured
DATA_SHEET_ERROR = 0.1
NOMINAL_ERROR, WRONG_NOMINAL = 0.03, (0.2, 0.4)


@dataclass(frozen=True)
class PlannedRun:
    """One run to be recorded: labels, instants (s) and the commanded input tension (N), shape (n,)."""

    run_id: str
    config: int
    system: str
    trajectory: str
    time_s: Array
    command_n: Array


@dataclass(frozen=True)
class Bench:
    """A rig, its sensor noise, its configurations, its plan, and one more recording that nobody diagnoses."""

    spec: RigSpec
    noise: NoiseSpec
    rate_hz: float
    theta: tuple[float, ...]
    locations: tuple[str, ...]
    nominal: tuple[float, ...]
    known: RigSection
    runs: tuple[PlannedRun, ...]
    fresh: tuple[PlannedRun, ...]
    position: bool = False
    reference: bool = False
    hardware: str = "rig"
    lab: Recording | None = None
    poor: str | None = None

    def config_id(self, config: int) -> str:
        """Return the neutral name of a configuration."""
        return f"C{config + 1}"

    def claims(self, position_effects: dict[str, dict[str, float]]) -> Scenario:
        """Return the simulator as the lab states it: data sheet, nominal theta, and what its position model holds."""
        configurations = tuple(
            Configuration(id=self.config_id(i), location=place, theta=round(theta, 4))
            for i, (theta, place) in enumerate(zip(self.nominal, self.locations, strict=True))
        )
        return Scenario(
            sampling_hz=self.rate_hz,
            rig=self.known,
            noise=NoiseSection(white_n=0.0),
            configurations=configurations,
            effects=position_effects,
        )


def draw(
    rng: Rng, quick: bool = False, wrong_nominal: bool = False, poor: str | None = None, hardware: str = "rig", lab: Recording | None = None
) -> Bench:
    """Return a random bench; ``poor`` is ``slow`` (one slow sinusoid) or ``still`` (never out of backlash).

    ``lab`` says how it is recorded: its rate, and the systems and configurations that are recorded at all.
    """
    rate = 100.0 if quick else float(rng.choice(RATES_HZ, p=RATE_WEIGHTS))
    total = int(rng.integers(*(QUICK_SAMPLES if quick else SAMPLES)))
    configs = 1 if poor == "slow" else int(rng.integers(2, 3 if quick else 5))
    duration_s = total / rate
    systems = SYSTEMS if lab is None else lab.systems
    if lab is not None:
        rate = lab.rate_hz
        duration_s = min(duration_s, (LAB_QUICK_SAMPLES if quick else LAB_SAMPLES) / rate)
        configs = 1 if lab.one_configuration else configs
    kinds = 1 if poor or duration_s < 60 else (2 if quick or duration_s < 300 else 3)
    spec = RigSpec(
        ea_n=float(rng.uniform(5000.0, 12000.0)),
        load_k1_n_per_mm=float(rng.uniform(4.0, 16.0)),
        nodes=int(rng.integers(20, 31 if quick else 61)),
    )
    coloured = float(rng.uniform(0.005, 0.03)) if rng.random() < 0.5 else 0.0
    noise = NoiseSpec(float(rng.uniform(0.005, 0.04)), coloured, log_uniform(rng, 0.05, 1.0), float(rng.uniform(0.01, 0.03)))
    theta = tuple(float(t) for t in rng.uniform(0.3, 0.7, configs))
    locations = tuple(str(p) for p in rng.choice(LOCATIONS, configs))
    off = rng.uniform(*WRONG_NOMINAL, configs) if wrong_nominal else rng.uniform(0.0, NOMINAL_ERROR, configs)
    # a simulator that is wrong is wrong in one direction for all bends: its friction coefficient is off
    sign = np.full(configs, rng.choice((-1.0, 1.0))) if wrong_nominal else rng.choice((-1.0, 1.0), configs)
    nominal = tuple(float(t * (1.0 + s * o)) for t, s, o in zip(theta, sign, off, strict=True))
    known = RigSection(
        ea_n=round(spec.ea_n * (1.0 + rng.uniform(-1, 1) * DATA_SHEET_ERROR), 0),
        load_n_per_mm=round(spec.load_k1_n_per_mm * (1.0 + rng.uniform(-1, 1) * DATA_SHEET_ERROR), 3),
    )
    bench = Bench(spec, noise, rate, theta, locations, nominal, known, (), (), hardware=hardware, lab=lab)
    seconds = duration_s / (len(systems) * configs * kinds)
    chosen = [str(k) for k in rng.permutation(KINDS)[: kinds + 1]]
    runs: list[PlannedRun] = []
    fresh: list[PlannedRun] = []
    for place, kind in enumerate(chosen):
        last = place == len(chosen) - 1 and not poor
        trajectory = _poor(poor, seconds, rng) if poor else _trajectory(kind, seconds, rng)
        for config in range(1 if last else configs):
            for system in systems:
                movement = _fit_range(trajectory, system, rng, poor)
                planned = _plan(bench, movement, config, system, len(runs) + len(fresh) + 1, rng)
                (fresh if last else runs).append(planned)
        if poor:
            break
    return replace(bench, runs=tuple(runs), fresh=tuple(fresh))


def with_low_tension(bench: Bench) -> Bench:
    """Return the bench with movements that go slack, which is where a gap in the line shows."""

    def lowered(p: PlannedRun) -> PlannedRun:
        return replace(p, command_n=np.maximum(p.command_n - p.command_n.min() - 0.5, 0.0))

    return replace(bench, runs=tuple(map(lowered, bench.runs)), fresh=tuple(map(lowered, bench.fresh)))


def _trajectory(kind: str, seconds: float, rng: Rng) -> Trajectory:
    """Return a movement of a kind with random speed; ranges come later, by system."""
    cycles = max(1, round(seconds * float(rng.uniform(0.04, 0.15))))
    return Trajectory(
        kind=kind,
        duration_s=seconds,
        cycles=cycles if kind == "trapezoid" else None,
        frequency_hz={"sinusoid": log_uniform(rng, max(0.04, 1.5 / seconds), 0.4), "random": 0.03, "chirp": max(0.02, 1.0 / seconds)}.get(
            kind
        ),
        top_frequency_hz={"random": float(rng.uniform(0.15, 0.5)), "chirp": float(rng.uniform(0.4, 2.0))}.get(kind),
        hold_s=float(rng.uniform(0.5, 3.0)) if kind == "ramp_hold" else None,
        drive="position" if kind == "trapezoid" and rng.random() < 0.5 else "tension",
    )


def _poor(how: str | None, seconds: float, rng: Rng) -> Trajectory:
    frequency = float(rng.uniform(0.02, 0.05)) if how == "slow" else float(rng.uniform(0.05, 0.3))
    return Trajectory(kind="sinusoid", duration_s=seconds, frequency_hz=frequency, drive="tension")


def _fit_range(trajectory: Trajectory, system: str, rng: Rng, poor: str | None) -> Trajectory:
    if poor == "still":
        middle = float(rng.uniform(8.0, 16.0))
        return trajectory.model_copy(update={"low_n": 0.93 * middle, "high_n": 1.07 * middle})
    low, high = ((1.0, 3.0), (20.0, 32.0)) if system == "act" else ((0.3, 1.5), (26.0, 40.0))
    return trajectory.model_copy(update={"low_n": float(rng.uniform(*low)), "high_n": float(rng.uniform(*high))})


def _plan(bench: Bench, t: Trajectory, config: int, system: str, number: int, rng: Rng) -> PlannedRun:
    hz = bench.rate_hz if bench.lab is None else float(np.clip(bench.rate_hz, SLOWEST_HZ, FASTEST_HZ))
    time = np.arange(max(round((t.duration_s or 10.0) * hz), 200)) / hz
    if t.drive == "position":
        n, theta = (2 if system == "sstl" else 1), bench.theta[config]
        lines = Lines(gamma_p=float(np.exp(-n * theta)), beta_p=0.0, gamma_r=float(np.exp(n * theta)), beta_r=0.0)
        tendon = bench.spec.length_mm / bench.spec.ea_n
        command = probe(t, system, time, lines, tendon, 1.0 / bench.spec.load_k1_n_per_mm)
    else:
        command = tension_path(t, system, time, rng)
    return PlannedRun(f"run-{number:02d}", config, system, t.kind, time, np.maximum(command, 0.0))
