"""An output that rests where friction would move it: a sensor that stopped, or one that ends there.

The stretches in which an output stays where it is are left out, friction is fitted to the rest, and asked what it makes of them: in
backlash it rests as well, behind a dead sensor it does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, quantile
from sstl_cli.identification.gate.causes import GAIN_BESIDE, Causes, bundled, floor_of, modelled

Array = NDArray[np.float64]
# noises, part of the span and steps within which an output rests; part of the span that is too coarse to tell
NOISES, SHARE, STEPS, COARSE = 8.0, 2e-3, 1.01, 0.1
# least points and part of the run of a rest, and part of its span that the input must move by meanwhile
LEAST_POINTS, LEAST_SHARE, DRIVEN = 12, 0.03, 0.05
# parts of its span that friction must move the output by in a rest, and away from it
MOVED, AWAY = 0.12, 0.1
# n theta, constant friction, gain and zero of the output: the same with and without the rests
FREE = bundled(GAIN_BESIDE)
# part of a run that an output may be moved by for what is left to count
FAR = 0.2
# part of the run that must remain, what may be left of it (part of the span), and of what any other explanation leaves
REMAINS, LITTLE, LESS = 0.15, 0.03, 0.3


@dataclass(frozen=True)
class Rest:
    """The longest of the stretches in which an output rests against friction: when and how long (s), at what level (N), which of its
    levels that is, and by what friction moves it meanwhile (N).
    """

    at_s: float
    length_s: float
    share: float
    level_n: float
    where: Literal["highest", "lowest", "between"]
    moved_n: float


def rest_of(t: Array, x: Array, y: Array, noise: tuple[float, float], step: float, causes: Causes) -> Rest | None:
    """Return where an output rests against friction, None where friction explains its rests, or any other slip does."""
    span, n = float(np.ptp(y)), len(y)
    band = max(NOISES * noise[1], STEPS * step, SHARE * span)
    if causes.enough or band > COARSE * span:
        return None
    rests = [
        (a, b) for a, b in stretches(y, band, max(LEAST_POINTS, int(LEAST_SHARE * n))) if float(np.ptp(x[a:b])) > DRIVEN * float(np.ptp(x))
    ]
    floor = floor_of(noise[1], y)
    if not rests or _known(rests, n) < REMAINS:
        return None
    found, model = modelled(x, _without(y, rests), FREE, floor)
    odd = [(a, b) for a, b in rests if _against(model[a:b], y[a:b], span, found.rms_n)]
    if not odd:
        return None
    if len(odd) < len(rests):
        found, model = modelled(x, _without(y, odd), FREE, floor)
        odd = [(a, b) for a, b in odd if _against(model[a:b], y[a:b], span, found.rms_n)]
    far = abs(causes.moved.size) > FAR * float(t[-1] - t[0])
    others = [c.rms_n for c in (*causes.slips, causes.reversed) if not (far and c is causes.moved)]
    others.append(modelled(x, y, FREE, floor)[0].rms_n)
    if not odd or found.rms_n > LITTLE * span or causes.left(found.rms_n) > LESS * min(causes.left(v) for v in others):
        return None
    known = np.ones(len(y), np.bool_)
    for a, b in odd:
        known[a:b] = False
    missed = _missed(min(others), found.rms_n, float(np.mean(~known)))
    if missed < 3.0 * max(found.rms_n, causes.noise_n) or not _both(model, known, span):
        return None
    a, b = max(odd, key=lambda r: r[1] - r[0])
    levels = np.array([median(y[i:j]) for i, j in odd])
    high, low = quantile(y, 0.999), quantile(y, 0.001)
    where: Literal["highest", "lowest", "between"] = "between"
    # the end of a range is met more than once, or friction takes the output beyond it all the while; a sensor stops anywhere
    if np.all(levels > high - band) and (len(odd) > 1 or _beyond(model[a:b], -1.0, y[a:b], found.rms_n)):
        where = "highest"
    elif np.all(levels < low + band) and (len(odd) > 1 or _beyond(model[a:b], 1.0, y[a:b], found.rms_n)):
        where = "lowest"
    # the samples are means of some; the last one lasts as long as any
    period = float(t[-1] - t[0]) / (n - 1)
    return Rest(float(t[a]), (b - a) * period, 1.0 - _known(odd, n), median(y[a:b]), where, float(np.ptp(model[a:b])))


@njit(cache=True, nogil=True)
def _ends(y: Array, band: float) -> NDArray[np.int64]:
    """Return for every sample how far on (first sample outside) a channel stays within a band (N) from there."""
    ends = np.empty(y.size, np.int64)
    for a in range(y.size):
        low = high = y[a]
        b = a + 1
        while b < y.size and max(high, y[b]) - min(low, y[b]) <= band:
            low, high = min(low, y[b]), max(high, y[b])
            b += 1
        ends[a] = b
    return ends


def stretches(y: Array, band: float, least: int) -> list[tuple[int, int]]:
    """Return the stretches in which a channel stays within a band (N), the longest first taken out."""
    ends, found, pieces = _ends(y, band), [], [(0, len(y))]
    while pieces:
        first, last = pieces.pop()
        if last - first < least:
            continue
        lengths = np.minimum(ends[first:last], last) - np.arange(first, last)
        a = first + int(np.argmax(lengths))
        b = a + int(lengths[a - first])
        if b - a >= least:
            found.append((a, b))
            pieces += [(first, a), (b, last)]
    return sorted(found)


def _missed(other_n: float, rms_n: float, share: float) -> float:
    """Return by how much (N RMS) what leaves ``other_n`` of a run misses its rests, a ``share`` of it, if it explains all else as well as ``rms_n``."""
    return float(np.sqrt(max(other_n**2 - (1.0 - share) * rms_n**2, 0.0) / share))


def _both(model: Array, known: NDArray[np.bool_], span: float) -> bool:
    """Whether friction moves an output both ways in what is known of it: on one line alone friction, gain and zero are one number."""
    step = np.diff(model)[known[1:] & known[:-1]]
    return min(float(np.sum(step[step > 0.0])), -float(np.sum(step[step < 0.0]))) > AWAY * span


def _known(rests: list[tuple[int, int]], n: int) -> float:
    """Return the part of a run that lies outside of its rests."""
    return 1.0 - sum(b - a for a, b in rests) / n


def _without(y: Array, rests: list[tuple[int, int]]) -> Array:
    out = y.copy()
    for a, b in rests:
        out[a:b] = np.nan
    return out


def _against(model: Array, y: Array, span: float, rms_n: float) -> bool:
    """Whether friction moves an output that rests, and away from where it rests."""
    away = float(np.sqrt(np.mean((model - median(y)) ** 2)))
    return float(np.ptp(model)) > MOVED * span and away > max(AWAY * span, 3.0 * rms_n)


def _beyond(model: Array, sign: float, y: Array, rms_n: float) -> bool:
    """Whether friction behind a sensor that ends at this level (``sign`` 1 below, -1 above) explains a rest as well as it does the rest of the run."""
    cut = np.maximum(sign * model, sign * median(y)) - sign * y
    return float(np.sqrt(np.mean(cut**2))) < 3.0 * rms_n
