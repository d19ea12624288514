"""Hand-made recordings: a play operator in plain Python and simple movements, independent of the package."""

from __future__ import annotations

import numpy as np

from sstl_cli.core.runs import Run

ACT = (0.58, -1.44, 1.69, -1.04)
SSTL = (0.27, 0.03, 3.3, 4.4)
NAMES = ("gamma_p", "beta_p", "gamma_r", "beta_r")


def play(x, lines, start=None):
    """Return out[k] = min(max(out[k-1], Gp x + bp), Gr x + br)."""
    gp, bp, gr, br = lines
    y = gp * x[0] + bp if start is None else start
    out = []
    for v in np.asarray(x, dtype=float).tolist():
        y = min(max(y, gp * v + bp), gr * v + br)
        out.append(y)
    return np.array(out)


def trapezoid(low=5.0, high=30.0, rate=500.0, cycles=1, seconds=12.0):
    t = np.arange(round(seconds * cycles * rate)) / rate
    return t, np.interp(t % seconds, [0, 0.4 * seconds, 0.45 * seconds, 0.95 * seconds, seconds], [low, high, high, low, low])


def multisine(seed, low=1.0, high=30.0, rate=100.0, seconds=400.0):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    waves = zip(rng.uniform(0.02, 0.15, 8), rng.uniform(0.4, 1, 8), rng.uniform(0, 6.28, 8), strict=True)
    w = sum(a * np.sin(2 * np.pi * f * t + p) for f, a, p in waves)
    return t, low + (high - low) * (w - w.min()) / (w.max() - w.min())


def coloured(n, rate, rng, sd, seconds=0.3):
    """Return AR(1) noise with the given correlation time."""
    phi = float(np.exp(-1.0 / (rate * seconds)))
    drive = rng.standard_normal(n) * np.sqrt(1 - phi**2)
    out, v = np.empty(n), rng.standard_normal()
    for k in range(n):
        v = phi * v + drive[k]
        out[k] = v
    return sd * out


def record(t, x, lines, seed=0, sd=0.02, colour=False, run_id="r", y=None):
    rng = np.random.default_rng(seed)
    rate = 1.0 / (t[1] - t[0])
    y = play(x, lines) if y is None else y
    make = (lambda: coloured(len(t), rate, rng, sd)) if colour else (lambda: sd * rng.standard_normal(len(t)))
    return Run(run_id, "act", t, x + make(), y + make())
