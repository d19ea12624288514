"""Known effects put into recordings of a real rig: transformations of what was recorded, not of any model.

Each is the textbook's operation on the recorded output (and for cross-talk the recorded input), so that everything else
that the rig did stays in. The sizes are the catalogue's parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import UsageError, nearest
from sstl_cli.core.runs import Run

Array = NDArray[np.float64]
# RMS of what an effect does to the output, over its span, where no size is given
SHARE = 0.07
# a sensor that is curved by its own size at this many times the largest reading (the catalogue's 50 N for 20 N)
FULL_SCALE = 2.5
MOST = 1e9
# samples (odd) over which a reading is averaged to part it from its noise
SMOOTH = 5
# a delay of fewer samples a log hardly tells
LEAST_SAMPLES = 2.0


@dataclass(frozen=True)
class Injection:
    """An effect put in: its id and its size, in the unit of the catalogue's parameter (for outputs in N)."""

    effect: str
    size: float
    parameter: str


def _smoothed(y: Array) -> Array:
    """Return what readings (N, shape (n,)) are without their noise: means over a few of them."""
    return np.asarray(np.convolve(np.pad(y, SMOOTH // 2, mode="edge"), np.full(SMOOTH, 1.0 / SMOOTH), mode="valid"))


def _offset(r: Run, size: float, top: float) -> Array:
    return r.tension_out_n + size


def _gain(r: Run, size: float, top: float) -> Array:
    return r.tension_out_n * (1.0 + size)


def _drift(r: Run, size: float, top: float) -> Array:
    t: Array = r.time_s - r.time_s[0]
    return r.tension_out_n + size * t / max(float(t[-1]), 1e-9)


def _delay(r: Run, size: float, top: float) -> Array:
    # between two readings noise would be averaged, which no delay does: it stays that of the nearest one
    smooth, then = _smoothed(r.tension_out_n), r.time_s - size
    nearest = np.rint(np.interp(then, r.time_s, np.arange(len(smooth)))).astype(np.int64)
    return np.asarray(np.interp(then, r.time_s, smooth) + (r.tension_out_n - smooth)[nearest])


def _lowpass(r: Run, size: float, top: float) -> Array:
    # exact for readings that go straight from one to the next
    out = np.array(r.tension_out_n, np.float64)
    for i in range(1, len(out)):
        dt = float(r.time_s[i] - r.time_s[i - 1])
        slope = float(r.tension_out_n[i] - r.tension_out_n[i - 1]) / dt
        decay = float(np.exp(-dt / size)) if size > 0.0 else 0.0
        before = float(r.tension_out_n[i - 1])
        out[i] = before + slope * (dt - size) + (out[i - 1] - before + slope * size) * decay
    return out


def _crosstalk(r: Run, size: float, top: float) -> Array:
    return r.tension_out_n + size * r.tension_in_n


def _curved(r: Run, size: float, top: float) -> Array:
    y = r.tension_out_n
    return y + size * y * (1.0 - y / (FULL_SCALE * top))


def _friction(r: Run, size: float, top: float) -> Array:
    # dry friction at the output end: what arrives has to overcome it both ways (a play). The sensor reads behind it, so that its
    # noise, what a mean over a few samples leaves, stays as it was
    y = r.tension_out_n
    smooth = _smoothed(y)
    out = np.empty(len(y))
    at = float(smooth[0])
    for i, v in enumerate(smooth):
        at = min(max(at, v - size), v + size)
        out[i] = at
    return out + (y - smooth)


Operation = Callable[[Run, float, float], Array]
OPERATIONS: dict[str, tuple[Operation, str, float]] = {
    "zero_offset": (_offset, "z_out_act_n", 1.0),
    "gain_error": (_gain, "g_act", 0.01),
    "zero_drift": (_drift, "r_out_act_n", 1.0),
    "channel_delay": (_delay, "tau_act_s", 0.01),
    "channel_lowpass": (_lowpass, "tau_act_s", 0.01),
    "crosstalk": (_crosstalk, "c_in_to_out", 0.01),
    "sensor_nonlinearity": (_curved, "a_out", 0.01),
    "const_friction": (_friction, "w_end_n", 1.0),
}


def put_in(runs: Sequence[Run], injection: Injection) -> list[Run]:
    """Return runs with an effect put into the output of every one of them; a delay takes off as much of their beginning.

    Raises
    ------
    UsageError
        If there is no operation for the effect.
    """
    if injection.effect not in OPERATIONS:
        known = sorted(OPERATIONS)
        raise UsageError(
            f"{injection.effect} cannot be put into a recording ({nearest(injection.effect, known)})", where="--inject", code="E957"
        )
    made = _operated(runs, injection)
    if injection.effect != "channel_delay":
        return made
    # what a delayed channel read before the run began nobody knows
    cut = [r.cut(slice(int(np.searchsorted(r.time_s, r.time_s[0] + injection.size)), None)) for r in made]
    return [r for r in cut if len(r)]


def _operated(runs: Sequence[Run], injection: Injection) -> list[Run]:
    operation = OPERATIONS[injection.effect][0]
    top = max(float(np.nanmax(np.abs(r.tension_out_n))) for r in runs)
    return [replace(r, tension_out_n=operation(r, injection.size, top)) for r in runs]


def of_size(runs: Sequence[Run], effect: str, share: float = SHARE) -> Injection:
    """Return an injection that moves the output by a share of its span (RMS), of a delay at least two samples."""
    _, parameter, unit = OPERATIONS[effect]
    span = max(float(np.ptp(r.tension_out_n)) for r in runs)
    low, high = 0.0, unit

    def moved(size: float) -> float:
        made = _operated(runs, Injection(effect, size, parameter))
        squares = [np.mean((a.tension_out_n - b.tension_out_n) ** 2) for a, b in zip(made, runs, strict=True)]
        return float(np.sqrt(np.mean(squares)))

    while moved(high) < share * span and high < MOST:
        high *= 2.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if moved(middle) < share * span else (low, middle)
    if effect == "channel_delay":
        high = max(high, LEAST_SAMPLES * float(np.median(np.concatenate([np.diff(r.time_s) for r in runs]))))
    return Injection(effect, float(f"{high:.3g}"), parameter)


def injections(runs: Sequence[Run], asked: Mapping[str, float] | None) -> list[Injection]:
    """Return the injections asked for (effect and size), all of them at the usual share of the span where None."""
    if asked is None:
        return [of_size(runs, e) for e in OPERATIONS]
    return [Injection(e, s, OPERATIONS[e][1] if e in OPERATIONS else "") for e, s in asked.items()]


def half(r: Run, second: bool) -> Run:
    """Return the first or the second half of a run."""
    return r.cut(slice(len(r) // 2, None) if second else slice(0, len(r) // 2))
