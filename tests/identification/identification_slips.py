"""A log of three bends in both systems, and slips in it that only the order, the shape or the company of its samples tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from identification_loops import multisine, play

from sstl_cli.core.runs import Run

BENDS = {"b020": 0.2, "b050": 0.4, "b080": 0.6}


def lines(wrap: float) -> tuple[float, float, float, float]:
    return float(np.exp(-wrap)), 0.0, float(np.exp(wrap)), 0.0


def bend(name: str, theta: float, system: str, seed: int, sd: float = 0.02, movement: int = 7) -> Run:
    t, x = multisine(movement, 3.0, 26.0, seconds=90.0)
    # three times as fast
    t, x = t[: len(t) // 3], x[::3]
    y = play(x, lines(theta * (2 if system == "sstl" else 1)))
    noise = sd * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(f"{system}-{name}", system, t, x + noise[0], y + noise[1], config_id=name, trajectory="rand")


def rig(factor: float = 1.0, seed: int = 0) -> list[Run]:
    """Return a sound log of three bends in both systems."""
    return [
        bend(name, factor * theta, system, seed + 10 * i + len(system))
        for i, (name, theta) in enumerate(BENDS.items())
        for system in ("act", "sstl")
    ]


def changed(change: Callable[[Run], Run], *which: str) -> list[Run]:
    return [change(r) if r.run_id in which or r.system in which or not which else r for r in rig()]


def of_one_bend(change: Callable[[Run], Run]) -> list[Run]:
    """Return both systems of the middle bend, changed: what all runs have alike is seen in two."""
    return [change(r) for r in rig() if r.config_id == "b050"]


def limited(r: Run) -> Run:
    noise = 0.004 * np.random.default_rng(3).standard_normal(len(r))
    return replace(r, tension_in_n=np.minimum(r.tension_in_n, 18.0 + noise))


def overflowing(r: Run) -> Run:
    return replace(r, tension_out_n=np.where(r.tension_out_n > 12.0, r.tension_out_n - 24.0, r.tension_out_n))


def folded(r: Run) -> Run:
    return replace(r, tension_out_n=np.abs(r.tension_out_n - 8.0))


def amplified(r: Run) -> Run:
    return replace(r, tension_out_n=np.where(np.arange(len(r)) < len(r) // 2, 1.0, 2.0) * r.tension_out_n)


def zeroed_midway(r: Run) -> Run:
    return replace(r, tension_out_n=r.tension_out_n + np.where(np.arange(len(r)) < len(r) // 2, 0.0, 3.5))


def humming(r: Run) -> Run:
    return replace(r, tension_out_n=r.tension_out_n + 1.5 * np.sin(2.0 * np.pi * 0.21 * np.arange(len(r))))


def shuffled(r: Run) -> Run:
    at = np.random.default_rng(5).permutation(len(r))
    return replace(r, tension_in_n=r.tension_in_n[at], tension_out_n=r.tension_out_n[at])


def backwards(r: Run) -> Run:
    return replace(r, tension_in_n=r.tension_in_n[::-1].copy(), tension_out_n=r.tension_out_n[::-1].copy())


def smoothed(r: Run) -> Run:
    """Return a run whose output comes behind a low-pass of 0.5 s."""
    period = float(r.time_s[1] - r.time_s[0])
    state, out = r.tension_out_n[0], []
    for v in r.tension_out_n.tolist():
        state += (1.0 - np.exp(-period / 0.5)) * (v - state)
        out.append(state)
    return replace(r, tension_out_n=np.array(out) + 0.01 * np.random.default_rng(4).standard_normal(len(r)))


def interpolated(r: Run) -> Run:
    keep = (r.time_s < 9.0) | (r.time_s > 11.5)
    x, y = (np.interp(r.time_s, r.time_s[keep], v[keep]) for v in (r.tension_in_n, r.tension_out_n))
    return replace(r, tension_in_n=x, tension_out_n=y)


def renewed_slowly(r: Run) -> Run:
    return replace(r, tension_out_n=r.tension_out_n[np.arange(len(r)) // 15 * 15])


def lost_rows(r: Run) -> Run:
    """Return a run whose output lacks 60 rows in the middle, those behind them moved up."""
    n = len(r) - 60
    y = np.delete(r.tension_out_n, np.s_[1200:1260])
    return replace(r, time_s=r.time_s[:n], tension_in_n=r.tension_in_n[:n], tension_out_n=y)


def quiet(v: np.ndarray) -> np.ndarray:
    """Return a channel without its noise."""
    return np.convolve(np.pad(v, 4, mode="edge"), np.ones(9) / 9, "valid")


def with_position(r: Run) -> Run:
    """Return a run whose columns of output and position (0.3 mm a newton) were exchanged."""
    noise = 0.01 * np.random.default_rng(8).standard_normal(len(r))
    return replace(r, tension_out_n=0.3 * quiet(r.tension_in_n) + noise, position_in_mm=r.tension_out_n)


def dahl(x: np.ndarray, wrap: float, path: float = 3.0, state: float = 0.4) -> np.ndarray:
    """Return the output of friction that builds up over ``path`` times n theta in the logarithm of tension (Dahl's law), step by step."""
    u, y = np.log(x), np.empty(len(x))
    for k in range(len(x)):
        step = u[k] - u[k - 1] if k else 0.0
        # a hundredth of the path at the most in each
        parts = 1 + int(abs(step) / (0.01 * path * wrap))
        for _ in range(parts):
            state += step / parts / (path * wrap) * (1.0 - state * np.sign(step))
        y[k] = np.exp(u[k] - wrap * state)
    return y


def slow_to_build_up(thetas: tuple[float, ...] = (0.1, 0.3, 0.5, 0.8), sd: float = 0.02, movement: int = 11) -> list[Run]:
    """Return a sound log whose presliding is longer than its movement."""
    found = []
    t, x = multisine(movement, 3.0, 26.0, seconds=75.0)
    t, x = t[: len(t) // 3], x[::3]
    for i, theta in enumerate(thetas):
        for passes, system in ((1, "act"), (2, "sstl")):
            noise = sd * np.random.default_rng(50 + 2 * i + passes).standard_normal((2, len(t)))
            name = f"b{round(10 * theta):02d}0"
            found.append(
                Run(f"{system}-{name}", system, t, x + noise[0], dahl(x, passes * theta) + noise[1], config_id=name, trajectory="rand")
            )
    return found


def exchanged() -> list[Run]:
    other = {"sstl-b020": "b080", "sstl-b080": "b020"}
    return [replace(r, config_id=other.get(r.run_id, r.config_id)) for r in rig()]


def two() -> list[Run]:
    return [*rig(), *(replace(r, run_id=f"{r.run_id}-B") for r in rig(1.8, 100))]


CAUSES: dict[str, Callable[[], list[Run]]] = {
    "limit": lambda: changed(limited, "sstl"),
    "limit (output)": lambda: changed(lambda r: replace(r, tension_out_n=np.minimum(r.tension_out_n, 14.0)), "act"),
    "overflow": lambda: changed(overflowing, "act"),
    "folded": lambda: changed(folded, "act-b050"),
    "gain_change": lambda: changed(amplified, "act-b050"),
    "hum": lambda: of_one_bend(humming),
    "order": lambda: changed(shuffled, "act-b050"),
    "zero_change": lambda: changed(zeroed_midway, "act-b050"),
    "filled": lambda: changed(interpolated, "act-b050"),
    "refresh": lambda: changed(renewed_slowly, "act"),
    "slow": lambda: changed(smoothed, "act"),
    "reversed_time": lambda: changed(backwards, "act-b050"),
    "exchanged": exchanged,
    "two_rigs": two,
    "normalised": lambda: of_one_bend(
        lambda r: replace(r, tension_out_n=(r.tension_out_n - r.tension_out_n.min()) / np.ptp(r.tension_out_n))
    ),
    "curved": lambda: changed(lambda r: replace(r, tension_out_n=16.0 * np.tanh(r.tension_out_n / 16.0)), "act-b050"),
    "energy": lambda: changed(lambda r: replace(r, tension_out_n=quiet(r.tension_in_n) - 0.5 * r.tension_out_n)),
    "mixed": lambda: of_one_bend(lambda r: replace(r, tension_out_n=0.5 * (r.tension_in_n + r.tension_out_n))),
    "columns": lambda: of_one_bend(with_position),
    "relabelled": lambda: [replace(r, config_id="b080") if r.run_id == "act-b010" else r for r in slow_to_build_up()],
    "unexplained": lambda: changed(lost_rows, "act-b020"),
    "crosstalk": lambda: changed(lambda r: replace(r, tension_out_n=r.tension_out_n + 0.25 * r.tension_in_n), "act-b050"),
}
