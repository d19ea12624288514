"""What a model leaves: tests that anything unmodelled must fail, whatever it is.

A right model's whitened residual is independent and normal. Means and spreads are compared over phase and tension, phase and
time since reversal, speed and direction, run and time in the run; the spectrum over frequency; single samples by their
fourth moment. None of the tests knows a particular disturbance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import BANDS_HZ, FEW, PARTS, SINCE_S, TESTS
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.where import PHASES, phases

Array = NDArray[np.float64]
Index = NDArray[np.int64]
LINE, SINGLE = "one line of the spectrum", "one sample"


@dataclass(frozen=True)
class Misfit:
    """One test of a residual: the excess of its statistic over chance in standard deviations, and in nats.

    ``dispersion`` is the statistic over its expectation, where chance alone makes 1.
    """

    name: str
    z: float
    nats: float
    peak: str
    dispersion: float = 1.0


@dataclass(frozen=True)
class Leftover:
    """What a model leaves: chi^2 per sample, correlation of neighbours, fourth moment, and the tests by name."""

    samples: int
    chi2: float
    lag_one: float
    kurtosis: float
    skewness: float
    tests: tuple[Misfit, ...]

    @property
    def excess(self) -> float:
        """RMS of what is left beyond the noise, over the noise."""
        return float(np.sqrt(max(self.chi2 - 1.0, 0.0)))

    def worst(self) -> Misfit:
        """Return the test that fails most clearly."""
        return max(self.tests, key=lambda t: t.z)

    def told(self) -> list[Misfit]:
        """Return the tests that fail most clearly; what chance makes now and then is not left over."""
        return [t for t in sorted(self.tests, key=lambda t: -t.z)[:TESTS] if t.z > 2.0]


def leftover(sim: Simulator, f: Fit, at_most: bool = False) -> Leftover:
    """Return what a fitted model leaves; where the noise is known to be ``at_most`` as stated, less of it is no sign of anything."""
    z = f.whiten.left(f.residual)
    keep = f.whiten.scale > 0
    code = phases(sim, f.prediction)
    kept = z[keep]
    n = max(len(kept), 1)
    compared = z
    if sim.problem.scatters:
        # the known scatter is that of parts of the record left out: to leave less is no sign of anything, so spreads are
        # compared with what is left; a mean is still one of what was known
        compared = z / min(1.0, max(float(np.sqrt(kept @ kept / n)), 1e-6))
        kept = compared[keep]
    both = keep[1:] & keep[:-1]
    power = max(float(kept @ kept) / n, 1e-100)
    along = np.where(code == 1, 1.0, -1.0) * np.where((code == 1) | (code == 3), z, 0.0) * keep
    moving = max(int(np.count_nonzero(along)), 1)
    names = _names(sim)
    tests = [
        t
        for name, index in _partitions(sim, code).items()
        for t in _binned(name, z, compared, keep, index, names[name], sim.dispersion, at_most)
    ]
    tests += [_spectrum(sim, compared, keep, at_most), *_lines(sim, z, keep)]
    return Leftover(
        n,
        power,
        float(compared[1:][both] @ compared[:-1][both]) / n / power,
        float(np.mean(kept**4)) / power**2 - 3.0,
        float(np.sum(along**3)) / moving / max(float(along @ along) / moving, 1e-100) ** 1.5,
        tuple(tests),
    )


def _partitions(sim: Simulator, code: Index) -> dict[str, Index]:
    """Return the bins of each partition, shape (samples,)."""
    system = np.array([sim.problem.systems.index(r.system) for r in sim.problem.records])[sim.run]
    tension, speed, since, part = [], [], [], []
    for r in sim.problem.records:
        u, v = (x.reshape(-1, r.factor).mean(axis=1) for x in (r.u, r.rate))
        step = r.dt_s * r.factor
        turn = np.concatenate(([True], np.diff(np.sign(v)) != 0))
        last = np.maximum.accumulate(np.where(turn, np.arange(len(u)), 0))
        tension.append(_quartile(u))
        speed.append(_quartile(np.abs(v)))
        since.append(np.searchsorted(SINCE_S, (np.arange(len(u)) - last) * step))
        part.append(np.arange(len(u)) * PARTS // len(u))
    a, b, c, d = (np.concatenate(x) for x in (tension, speed, since, part))
    key = system * 4 + code
    return {
        "phase and tension": key * PARTS + a,
        "phase and time since reversal": key * (len(SINCE_S) + 1) + c,
        "phase and speed": key * PARTS + b,
        "run": sim.run,
        "run and time in the run": sim.run * PARTS + d,
        "configuration and phase": sim.config * 8 + key,
    }


def _names(sim: Simulator) -> dict[str, list[str]]:
    """Return what the bins of each partition are called, in their order."""
    systems, records = sim.problem.systems, sim.problem.records
    heads = [f"{system} {phase}" for system in systems for phase in PHASES]
    quarters = [f"{i + 1} of {PARTS}" for i in range(PARTS)]
    edges = [f"{a:g}-{b:g} s" for a, b in zip([0.0, *SINCE_S], [*SINCE_S, np.inf], strict=True)]
    # configurations are laid out for two systems
    padded = heads + [""] * (8 - len(heads))
    return {
        "phase and tension": [f"{h}, quarter {q} of the tension" for h in heads for q in quarters],
        "phase and time since reversal": [f"{h}, {e} after a reversal" for h in heads for e in edges],
        "phase and speed": [f"{h}, quarter {q} of the speed" for h in heads for q in quarters],
        "run": [f"run {r.run_id}" for r in records],
        "run and time in the run": [f"run {r.run_id}, quarter {q}" for r in records for q in quarters],
        "configuration and phase": [f"{c}, {h}" for c in sim.problem.configs for h in padded],
    }


def _quartile(x: Array) -> Index:
    return np.searchsorted(np.quantile(x, [0.25, 0.5, 0.75]), x).astype(np.int64)


def _binned(
    name: str, z: Array, compared: Array, keep: NDArray[np.bool_], index: Index, names: list[str], known: Mapping[str, float], at_most: bool
) -> list[Misfit]:
    """Return the tests of equal means and of equal spreads over bins: means of ``z``, spreads of ``compared``."""
    bins = int(index.max()) + 1
    count = np.bincount(index, keep, bins)
    used = count > FEW
    found = []
    for what, x, variance in (("mean", z, 1.0), ("spread", (compared**2 - 1.0) * keep, 2.0)):
        total = np.bincount(index, x * keep, bins)
        if what == "spread" and at_most:
            total = np.maximum(total, 0.0)
        chi2 = np.where(used, total**2 / np.maximum(count * variance, 1.0), 0.0)
        dof = max(int(used.sum()), 1)
        worst = int(np.argmax(chi2))
        found.append(_tested(f"{what} by {name}", float(chi2.sum()), dof, names[worst], known))
    return found


def _tested(name: str, chi2: float, dof: int, peak: str, known: Mapping[str, float]) -> Misfit:
    """Return a test of a statistic with so many degrees of freedom, over what it is known to exceed chance by."""
    usual = max(known.get(name, 1.0), 1.0)
    excess = chi2 / usual - dof
    # a statistic that bursts make large is itself known to no better than its own size
    chance = np.sqrt(2.0 * dof + dof**2 * (1.0 - 1.0 / usual))
    return Misfit(name, float(excess / chance), 0.5 * excess, peak, chi2 / dof)


def _spectrum(sim: Simulator, z: Array, keep: NDArray[np.bool_], at_most: bool) -> Misfit:
    """Return the test of equal power over broad bands of frequency."""
    power, count = np.zeros(len(BANDS_HZ) + 1), np.zeros(len(BANDS_HZ) + 1)
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        x = z[s] * keep[s]
        density = np.abs(np.fft.rfft(x))[1:] ** 2 / max(float(keep[s].sum()), 1.0)
        band = np.searchsorted(BANDS_HZ, np.fft.rfftfreq(len(x), r.dt_s * r.factor)[1:])
        power += np.bincount(band, density, len(power))
        count += np.bincount(band, minlength=len(power))
    used = count > 0
    # exponential densities have unit variance over their mean
    excess = np.maximum(power - count, 0.0) if at_most else power - count
    chi2 = np.where(used, excess**2 / np.maximum(count, 1.0), 0.0)
    dof = max(int(used.sum()), 1)
    edges = [0.0, *BANDS_HZ, np.inf]
    worst = int(np.argmax(chi2))
    return _tested("power by frequency", float(chi2.sum()), dof, f"{edges[worst]:g}-{edges[worst + 1]:g} Hz", sim.dispersion)


def _lines(sim: Simulator, z: Array, keep: NDArray[np.bool_]) -> list[Misfit]:
    """Return the tests of the highest line of the spectrum, and of the largest sample, against chance."""
    high, where, bins = 0.0, "", 0
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        x = z[s] * keep[s]
        density = np.abs(np.fft.rfft(x * np.hanning(len(x))))[1:] ** 2
        density /= max(float(np.sum((np.hanning(len(x)) * keep[s]) ** 2)), 1e-300)
        bins += len(density)
        if len(density) and density.max() > high:
            high = float(density.max())
            where = f"{np.fft.rfftfreq(len(x), r.dt_s * r.factor)[1 + int(np.argmax(density))]:.3g} Hz in run {r.run_id}"
    chance, usual = float(np.log(max(bins, 2))), sim.dispersion
    line = high / max(usual.get(LINE, 1.0), 1.0) - chance
    top = float(np.max(np.abs(z * keep), initial=0.0))
    at = int(np.argmax(np.abs(z * keep)))
    run = sim.problem.records[int(sim.run[at])]
    least = float(np.log(max(keep.sum(), 2)))
    single = 0.5 * top * top / max(usual.get(SINGLE, 1.0), 1.0) - least
    moment = f"{run.time_s[at - int(sim.edges[int(sim.run[at])])]:.4g} s of run {run.run_id}"
    return [Misfit(LINE, line, line, where, high / chance), Misfit(SINGLE, single, single, moment, 0.5 * top * top / least)]
