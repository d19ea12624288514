"""The rounding of coarse converters as noise: white in slides, one error throughout in a rest without noise to spread it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sstl_cli.diagnosis.constants import UNSEEN, WINDOWS_S
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.white import averaged, least_white, typical
from sstl_cli.diagnosis.whitening import Noise, Sensor


def with_rounding(sensor: Sensor, faults: Sequence[Faults]) -> Sensor:
    """Return a sensor with the rounding of a coarse converter: without noise to spread it, a rest has one error throughout."""
    rounding = _rests(faults)
    if rounding == 0.0:
        return sensor
    # the error of a rest lasts as long as the shortest one at least
    return Sensor(sensor.white_n, float(np.hypot(sensor.coloured_n, rounding)), max(sensor.correlation_s, WINDOWS_S[-1]))


def _rests(faults: Sequence[Faults]) -> float:
    """Return the RMS (N) of the rounding that a rest keeps as one error throughout, 0 where noise spreads it."""
    rounding = float(np.median([f.rounding_n for f in faults]))
    return 0.0 if float(np.median([f.noise_n for f in faults])) > rounding else rounding


def at_least_rounding(records: Sequence[Record], measured: Noise) -> bool:
    """Return whether an output has no noise beyond rounding, its own or the model's: how much of that there is nobody measures."""
    own = {s: typical([least_white(r, "tension_out_n") for r in records if r.system == s]) for s in measured.output}
    return any(sensor.white_n <= own[s] for s, sensor in measured.output.items())


def unrounded(records: Sequence[Record], noise: Noise) -> Noise:
    """Return the noise that the sensors would have without the steps of their converters: white in slides, an error throughout in rests."""

    def of(sensor: Sensor, faults: Sequence[Faults], averaged: float) -> Sensor:
        white = float(np.median([f.rounding_n for f in faults])) / averaged
        return replace(sensor, white_n=_without(sensor.white_n, white), coloured_n=_without(sensor.coloured_n, _rests(faults)))

    mine = {system: [r for r in records if r.system == system] for system in noise.output}
    into = {k: of(s, [r.faults_in for r in mine[k]], 1.0) for k, s in noise.input.items()}
    return replace(
        noise, input=into, output={k: of(s, [r.faults_out for r in mine[k]], averaged(mine[k])) for k, s in noise.output.items()}
    )


def _without(sd_n: float, part_n: float) -> float:
    return float(np.sqrt(max(sd_n**2 - part_n**2, (UNSEEN * sd_n) ** 2)))
