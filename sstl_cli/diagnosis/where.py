"""Where the gap lies: exact shares of the held-out squared error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.diagnosis import Band, Place, TensionBand
from sstl_cli.diagnosis.constants import FAST_PCT, HELD, STILL_N, TABLE_HZ, TABLE_SINCE_S
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]
PHASES = ("PB", "PP", "RB", "RP")


def phases(sim: Simulator, prediction: Array) -> NDArray[np.int64]:
    """Return the phase of each sample (0 PB, 1 PP, 2 RB, 3 RP) by the direction of the input and the model's output."""
    codes = np.empty(len(prediction), np.int64)
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        u = r.u.reshape(-1, r.factor).mean(axis=1)
        du = np.gradient(u)
        moving = np.abs(du) > HELD * max(np.percentile(np.abs(du), FAST_PCT), 1e-12)
        # a hold belongs to the movement before it
        last = np.maximum.accumulate(np.where(moving, np.arange(len(u)), -1))
        first = int(np.argmax(moving)) if moving.any() else 0
        pulling = du[np.where(last < 0, first, last)] > 0
        held = np.abs(np.gradient(prediction[s])) < STILL_N
        codes[s] = np.where(pulling, 1, 3) - held.astype(int)
    return codes


def shares(sim: Simulator, error: Array, code: NDArray[np.int64]) -> list[Place]:
    """Return the share of the squared error by system, phase and configuration, largest first; they sum to 100."""
    systems = sim.problem.systems
    of_run = np.array([systems.index(r.system) for r in sim.problem.records])
    configs = len(sim.problem.configs)
    key = (of_run[sim.run] * 4 + code) * configs + sim.config
    squared = sim.weight * error**2
    sums = np.bincount(key, squared, len(systems) * 4 * configs)
    counts = np.bincount(key, sim.weight, len(systems) * 4 * configs)
    total = max(float(sums.sum()), 1e-300)
    rows = [
        Place(
            system=systems[k // (4 * configs)],
            phase=PHASES[k // configs % 4],
            config_id=sim.problem.configs[k % configs],
            share_pct=100.0 * float(sums[k]) / total,
            rmse_n=float(np.sqrt(sums[k] / counts[k])),
        )
        for k in np.flatnonzero(counts)
    ]
    return sorted(rows, key=lambda place: -place.share_pct)


def bands(sim: Simulator, error: Array) -> dict[str, list[Band]]:
    """Return shares of the squared error by tension, rate, direction, time since reversal, time and frequency."""
    u, rate, since, time = [], [], [], []
    for r in sim.problem.records:
        here = r.u.reshape(-1, r.factor).mean(axis=1)
        slope = r.rate.reshape(-1, r.factor).mean(axis=1)
        step = r.dt_s * r.factor
        turns = np.concatenate(([True], np.diff(np.sign(slope)) != 0))
        last = np.maximum.accumulate(np.where(turns, np.arange(len(here)), 0))
        u.append(here)
        rate.append(slope)
        since.append((np.arange(len(here)) - last) * step)
        time.append(np.linspace(0.0, 1.0, len(here)))
    squared = sim.weight * error**2
    speed = np.concatenate(rate)
    out = {
        "tension_n": _of_tension(np.concatenate(u), squared),
        "rate_n_s": _of_tension(np.abs(speed), squared),
        "direction": _named({"release": speed < 0, "pull": speed >= 0}, squared),
        "time_since_reversal_s": _by(np.concatenate(since), squared, np.array(TABLE_SINCE_S)),
        "time_in_run": _by(np.concatenate(time), squared, np.array([0, 0.25, 0.5, 0.75, 1.0])),
        "frequency_hz": _frequencies(sim, error),
    }
    return out


def _of_tension(x: Array, squared: Array) -> list[Band]:
    """Return the share of each quarter of the samples, by tension (N) or its rate (N/s)."""
    return [TensionBand(low=b.low, high=b.high, share_pct=b.share_pct) for b in _by(x, squared, np.quantile(x, [0, 0.25, 0.5, 0.75, 1.0]))]


def _by(x: Array, squared: Array, edges: Array) -> list[Band]:
    bins = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    return _ranges(edges, np.bincount(bins, squared, len(edges) - 1).astype(float))


def _named(groups: dict[str, NDArray[np.bool_]], squared: Array) -> list[Band]:
    total = max(float(squared.sum()), 1e-300)
    return [Band(name=k, share_pct=100.0 * float(squared[m].sum()) / total) for k, m in groups.items()]


def _frequencies(sim: Simulator, error: Array) -> list[Band]:
    """Return shares by frequency band; by Parseval's theorem they sum to the whole squared error."""
    edges = np.array(TABLE_HZ)
    power = np.zeros(len(edges) - 1)
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        x = error[s] * sim.weight[s]
        spectrum = np.abs(np.fft.rfft(x)) ** 2 / len(x)
        spectrum[1 : (len(x) + 1) // 2] *= 2.0
        frequency = np.fft.rfftfreq(len(x), r.dt_s * r.factor)
        power += np.bincount(np.searchsorted(edges, frequency, side="right") - 1, spectrum, len(power))
    return _ranges(edges, power)


def _ranges(edges: Array, squared: Array) -> list[Band]:
    """Return the share of each range between two edges, shape (n + 1,), of a squared error, shape (n,)."""
    total = max(float(squared.sum()), 1e-300)
    return [
        Band(low=float(a), high=float(b), share_pct=100.0 * float(v) / total)
        for a, b, v in zip(edges[:-1], edges[1:], squared, strict=True)
    ]
