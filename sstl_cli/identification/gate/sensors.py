"""How a channel was sampled: refresh period, quantisation step, noise, and where it stands still."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.core.sound import unsound, within
from sstl_cli.identification.filtering import median, noise_sd, quantile
from sstl_cli.identification.gate.live import Live, live_of, noisy
from sstl_cli.identification.gate.rounding import ramps, rounding_of

Array = NDArray[np.float64]
CHANNELS = ("tension_in_n", "tension_out_n")
# enough for a period and a step; a longer record says the same again
MOST_SAMPLES = 65_536
MIN_CHANGES = 12
# readings are often written with six or seven digits; how far off its grid they may put a level (steps), by chance a tenth of any are so near
DIGITS, ON_GRID = 2e-6, 0.05
# share of repeated samples above which a channel may be one that is refreshed slower than it is logged
HELD_SHARE = 0.3
# part of the changes that come at a beat; by chance it is one over the samples between two
IN_TIME = 0.98
# quantisation step over the noise of renewed samples (which is never seen below half a step) of a coarse converter
COARSE = 0.7
# share of repeated readings that a step needs; share of the changes that may be strays below it, also beside those of about a step; so many
# changes by a step and none below it are no chance (1e-6)
REPEATS, STRAYS, STRAYS_BESIDE, RARE_NATS = 0.02, 0.02, 0.1, 14.0
# part of a run over which one value must last where no noise tells a dead sensor from a resting one
LONG_SHARE = 0.15
# renewals of one value that are a stretch of it
LONG_FRESH = 8.0
# part of the span by which a sensor must jump that comes back
COMES_BACK = 0.25
# samples beside a stretch whose middle one or two spikes do not move
PASSING = 5
# samples in a block whose noise second differences measure to 13 %, fewest of them, and part of the usual noise that the quietest of thousands has by chance
BLOCK, FEW_BLOCKS, QUIETEST = 64, 16, 0.5
# share of whole tens in whole numbers (a tenth by chance) and of samples that lost a digit (a tenth), with room for few samples; decades within which
# these join their neighbours, and beyond which others stand off them
TENS, LOST, JOINS, OFF = 0.03, 0.04, 0.06, 0.3


@dataclass(frozen=True)
class Sensor:
    """How one channel of one run was sampled; forces in N (or the channel's own unit), times in s.

    ``refresh_s`` is the period at which values are renewed, ``period_s`` that of the log: where the first is longer,
    the channel is a sample-and-hold. ``step_n`` is the quantisation step, 0 where there is none. ``noise_n`` is the
    white noise of the renewed samples. ``still_s`` is the longest stretch of one value beyond what refresh, step and
    noise explain, ``still_at_s`` its beginning (0 where there is none), and ``still_share`` the part of all samples
    in such stretches; ``still_left`` whether the value jumps at the end of it, ``restless`` whether the noise is there all the while but in it, ``silent`` whether it is longer than this noise, behind this step, would have let it last. ``white`` tells whether ``noise_n`` is noise, and not the motion between slow samples;
    ``digit_n`` is the last digit where nothing but its rounding is left beside the movement, 0 for readings of a sensor.
    """

    column: str
    period_s: float
    refresh_s: float
    step_n: float
    noise_n: float
    still_s: float = 0.0
    still_at_s: float = 0.0
    still_share: float = 0.0
    white: bool = True
    still_left: bool = False
    digit_n: float = 0.0
    restless: bool = False
    silent: bool = False

    @property
    def held(self) -> bool:
        """Whether the channel is renewed more slowly than it is logged."""
        return self.refresh_s > 1.5 * self.period_s

    @property
    def stride(self) -> int:
        """Samples of the log from one renewal to the next."""
        return math.ceil(self.refresh_s / self.period_s - 0.05) if self.held else 1

    @property
    def computed(self) -> bool:
        """Whether the channel holds numbers of a program, and no readings."""
        return self.digit_n > 0.0

    @property
    def rounding_n(self) -> float:
        """What rounding adds to numbers of a program (N RMS): what their second differences show is the movement."""
        return self.digit_n / math.sqrt(12.0)

    @property
    def fine(self) -> bool:
        """Whether the noise shows, and is not that of the motion between slow samples."""
        return self.white and not self.coarse

    @property
    def coarse(self) -> bool:
        """Whether the noise hides between the levels of the converter."""
        return self.step_n > COARSE * self.noise_n

    @property
    def rate_hz(self) -> float:
        """Sampling rate of the log."""
        return 1.0 / self.period_s if self.period_s > 0 else float("nan")


def sensors_of(run: Run) -> tuple[Sensor, Sensor]:
    """Return how input and output of a run were sampled."""
    first, second = (sensor_of(name, run.time_s, getattr(run, name)) for name in CHANNELS)
    return first, second


def sensor_of(column: str, time_s: Array, values: Array) -> Sensor:
    """Return how one channel was sampled.

    Parameters
    ----------
    time_s, values : ndarray, shape (n,)
        Sampling times (s, increasing) and samples; non-finite samples count as repeats of the one before.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> fast = np.sin(np.arange(4000) / 200.0) + 0.01 * rng.standard_normal(4000)
    >>> s = sensor_of("tension_out_n", np.arange(4000) / 1000.0, np.repeat(fast[::20], 20))
    >>> round(s.refresh_s, 4), s.held
    (0.02, True)
    """
    time, v = time_s[:MOST_SAMPLES], np.asarray(values[:MOST_SAMPLES], np.float64)
    if not within(v):
        finite = ~unsound(v)
        v = v.copy()
        v[~finite] = np.interp(np.flatnonzero(~finite), np.flatnonzero(finite), v[finite]) if finite.any() else 0.0
    n = len(v)
    period = median(np.diff(time)) if n > 1 else float("nan")
    if n < 16 or float(np.ptp(v)) == 0.0:
        still = float(time[-1] - time[0]) if n else 0.0
        return Sensor(column, period, period, 0.0, 0.0, still, float(time[0]) if n else 0.0, 1.0)
    changed = np.flatnonzero(np.diff(v) != 0.0) + 1
    beat = _beat(changed)
    # what is held between two renewals is no rest: a ramp that is renewed now and then changes by no less than it goes meanwhile
    step = quantisation(v[changed] if beat else v)
    hold = float(beat) if beat else _hold(v, changed, step)
    longest = float(np.diff(np.concatenate(([0], changed, [n]))).max())
    # a long rest is no sample of the noise
    renewed = v[changed] if (hold > 1 or longest > 0.02 * n) and len(changed) > 16 else v
    noise = noise_sd(renewed)
    live = live_of(v, step)
    found = _still(v, changed, hold, step, noise, live)
    # noise may hide between levels
    digit = rounding_of(renewed) if step == 0.0 or ramps(v) else 0.0
    at = float(time[found.at]) if found.length else 0.0
    restless = found.length > 0.0 and hold == 1.0 and not ramps(v) and _restless(v, found, step, noise)
    return Sensor(
        column, period, hold * period, step, noise, found.length * period, at, found.share, noisy(renewed), found.left, digit, restless, found.silent
    )  # fmt: skip


def _restless(v: Array, rest: _Stretch, step: float, noise: float) -> bool:
    """Whether a channel has its noise in all blocks but those of a stretch: no sensor that is quiet at rest, or is sent anew when it has moved.

    A noise that shows through its levels repeats a value by chance now and then, and never for a block.
    """
    if not noise > 0.0 or step > COARSE * noise or rest.length < BLOCK:
        return False
    a, b = rest.at, rest.at + int(rest.length)
    outside = [v[:a], v[b:]]
    blocks = np.concatenate([w[: len(w) // BLOCK * BLOCK].reshape(-1, BLOCK) for w in outside])
    if len(blocks) < FEW_BLOCKS:
        return False
    second = np.diff(blocks, n=2, axis=1)
    return bool(np.min(np.sqrt(np.mean(second**2, axis=1) / 6.0)) > QUIETEST * noise)


def digits_lost(values: Array) -> float:
    """Return the share of samples that are a tenth, hundredth or thousandth of their neighbours and join them once multiplied.

    0 where other samples stand off their neighbours as well, where values are no whole numbers, or where whole tens are as many as they come by
    chance: a decimal comma that is lost with its trailing zeros ('12,34' as 1234, '12,3' as 123) leaves none.
    """
    v = values[:MOST_SAMPLES]
    whole = v[v == np.round(v)]
    if len(v) < 64 or len(whole) < 0.999 * len(v) or float(np.mean(np.mod(v, 10.0) == 0.0)) > TENS:
        return 0.0
    beside = np.median(np.stack([v[:-4], v[1:-3], v[3:-1], v[4:]]), axis=0)
    here = v[2:-2]
    known = (np.abs(here) > 0.0) & (beside * here > 0.0)
    decades = np.log10(beside[known] / here[known])
    near = np.abs(decades - np.round(decades)) < JOINS
    joined = near & (np.round(decades) >= 1.0)
    off = ~near & (np.abs(decades) > OFF)
    share = float(np.mean(joined)) if len(joined) else 0.0
    return share if share > LOST and float(np.mean(off)) < 0.5 * share else 0.0


def quantisation(values: Array) -> float:
    """Return the step (N) of a channel whose levels lie on a grid or that never changes by less, 0 where there is none.

    A grid is believed where levels repeat (fewer than half as many as samples) and nine in ten of the gaps between
    neighbouring levels are whole multiples of the smallest usual one, or where all of them are, exactly.
    """
    levels = np.unique(values)
    if len(levels) < 4:
        return 0.0
    if (least := _least_change(values)) > 0.0:
        return least
    gaps = np.diff(levels)
    tiny = 1e-9 * max(abs(float(levels[0])), abs(float(levels[-1])))
    gaps = gaps[gaps > tiny]
    if len(gaps) < 3:
        return 0.0
    # a few stray levels (spikes, interpolated samples) must not set the step
    small = quantile(gaps, 0.1)
    near = gaps[(gaps > 0.7 * small) & (gaps < 1.4 * small)]
    if not len(near):
        return 0.0
    step = median(near)
    multiple = gaps / step
    if len(levels) > 0.5 * len(values):
        # few samples of a fine converter: the grid must be exact, but for the digits that readings are written with, and be more than an even ramp
        step = float(gaps.sum() / np.round(multiple).sum())
        multiple = gaps / step
        digits = min(DIGITS * max(abs(float(levels[0])), abs(float(levels[-1]))) / step, ON_GRID)
        exact = np.abs(multiple - np.round(multiple)) < np.maximum(digits, 1e-6 * np.maximum(1.0, multiple))
        return step if bool(exact.all()) and float(np.mean(multiple > 1.5)) > 0.05 else 0.0
    whole = np.abs(multiple - np.round(multiple)) < 0.02 * np.maximum(1.0, np.sqrt(multiple))
    return step if float(np.mean(whole & (multiple > 0.5))) > 0.9 else 0.0


def _least_change(values: Array) -> float:
    """Return the size (N) below which a channel that often repeats a reading never changes it, 0 where small changes are as usual as others.

    Noise changes readings by any size, by small ones more often than by large ones. None of those below a step, but for a few
    strays, is what a converter leaves of them, also where a finer one reads it, or one that sends a value anew once it has moved by
    a step (Miskowicz 2006), whose levels lie on no grid.
    """
    sizes = np.abs(np.diff(values))
    sizes = sizes[sizes > 1e-9 * float(np.max(np.abs(values)))]
    if len(sizes) < MIN_CHANGES or len(sizes) > (1.0 - REPEATS) * len(values):
        return 0.0
    step = quantile(sizes, STRAYS)
    fewer, near = int(np.count_nonzero(sizes < 0.9 * step)), sizes[(sizes >= 0.9 * step) & (sizes < 1.8 * step)]
    if len(near) < RARE_NATS + fewer / STRAYS_BESIDE:
        return 0.0
    # on a grid the least change is one step, which a finer converter reads as one of two neighbours; on none it is the step at least
    first = near[near < 1.4 * step]
    return float(first.mean()) if len(np.unique(np.round(first / step, 6))) <= 4 else step


def _beat(changed: NDArray[np.int64]) -> int:
    """Return the samples between renewals where all changes keep time over the whole run, as no crossings of levels do; 0 elsewhere."""
    usual = round(median(np.diff(changed))) if len(changed) >= MIN_CHANGES else 0
    return usual if usual > 1 and float(np.max(np.bincount(changed % usual))) > IN_TIME * len(changed) else 0


def _hold(v: Array, changed: NDArray[np.int64], step: float) -> float:
    """Return the usual number of samples between renewals of a sample-and-hold, 1 for any other channel."""
    if len(changed) < MIN_CHANGES or 1.0 - len(changed) / len(v) < HELD_SHARE:
        return 1.0
    gaps = np.diff(changed)
    usual = median(gaps)
    if usual < 2.0:
        return 1.0
    # renewals come at a beat: hardly any sooner than half of it, and most at it (a hold of the output spans several)
    early = float(np.mean(gaps < 0.5 * usual))
    beat = float(np.mean(np.abs(gaps - usual) <= max(1.0, 0.25 * usual)))
    if early > 0.1 or beat < 0.5:
        return 1.0
    if step > 0.0:
        # a ramp through the levels of a converter changes by one level at a time; renewals change by several
        jumps = np.abs(np.diff(v))[changed - 1]
        if float(np.mean(jumps < 1.5 * step)) > 0.8:
            return 1.0
    at = gaps[np.abs(gaps - usual) <= max(1.0, 0.25 * usual)]
    return float(np.mean(at))


@dataclass(frozen=True)
class _Stretch:
    """Length (samples) and beginning of the longest stretch of one value, share of all samples in such, whether it ends in a jump, and whether it is too long for a live sensor at rest."""

    length: float = 0.0
    at: int = 0
    share: float = 0.0
    left: bool = False
    silent: bool = False


def _still(v: Array, changed: NDArray[np.int64], hold: float, step: float, noise: float, live: Live) -> _Stretch:
    """Return the stretches that repeat one value and should not."""
    edges = np.concatenate(([0], changed, [len(v)]))
    lengths = np.diff(edges)
    fresh = lengths / hold
    repeats = float(np.mean(np.minimum(fresh, 8.0) - 1.0 > 0.5)) if len(fresh) else 0.0
    held = v[edges[:-1]]
    limit = 10.0 * noise + 4.0 * quantile(np.abs(np.diff(v)), 0.98)
    before, after = _around(v, edges)
    long = fresh > LONG_FRESH
    # a sensor that stops does not stop twice at the very end of its range: what does is at its limit
    limit_again = np.zeros(len(held), np.bool_)
    for end in (v.min(), v.max()):
        there = held == end
        limit_again |= there & (np.sum(there & long) > 1)
    left = np.abs(after - held) > limit
    jump = left | (np.abs(before - held) > limit)
    white = noisy(v[changed])
    # a clipped channel rests at its extreme, which is another fault, and leaves it without a jump
    inside = (held > v.min()) & (held < v.max())
    silent = (inside | left | (edges[1:] == len(v))) & ~limit_again & (hold == 1.0) & (lengths > live.most_repeats(len(v)) + 1.0)
    if noise <= 0.0 or not white or repeats > 0.2 or (step > 0.0 and step > 3.0 * noise):
        # without noise, or with coarse levels, a value repeats for good reasons; but what rests goes on from where it is
        usual = median(np.abs(np.diff(v))[changed - 1]) if len(changed) else 0.0
        # a release that multiplies the input's steps leaves a rest fast, but not by a good part of all that was ever read
        least = max(4.0 * step, 8.0 * usual) + (10.0 * noise if white else 0.0)
        left = np.abs(after - held) > max(least, COMES_BACK * float(np.ptp(v)))
        long &= left & (lengths > LONG_SHARE * len(v)) & ~limit_again
        return _longest(long | silent, left, edges, silent)
    # chance that a fresh sample repeats the one before
    chance = max(min(0.5, step / (3.5 * noise)), min(0.5, float(np.mean(fresh > 1.5)))) if step > 0.0 else 1e-3
    need = max(8.0, 1.0 + np.log(1e-6 / len(v)) / np.log(max(chance, 1e-6)))
    long = fresh > need
    # a clip returns with every loop, a dead sensor does not come back
    dead = (edges[1:] == len(v)) & (lengths > 0.1 * len(v)) & (np.sum(long & ~inside) == 1)
    # between coarse levels an output in backlash rests and leaves without a jump
    long &= ((jump | dead) if step > COARSE * noise else (inside | jump | dead)) & ~limit_again
    return _longest(long | silent, left, edges, silent)


def _around(v: Array, edges: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return what a channel read before and after each stretch: the middle of some samples, as one or two readings that were lost are no jump."""
    beside = np.arange(PASSING)
    before = np.median(v[np.maximum(edges[:-1, None] - 1 - beside, 0)], axis=1)
    return before, np.median(v[np.minimum(edges[1:, None] + beside, len(v) - 1)], axis=1)


def _longest(long: NDArray[np.bool_], left: NDArray[np.bool_], edges: NDArray[np.int64], silent: NDArray[np.bool_]) -> _Stretch:
    if not long.any():
        return _Stretch()
    lengths = np.diff(edges)
    at = int(np.argmax(np.where(long, lengths, 0)))
    return _Stretch(float(lengths[at]), int(edges[at]), float(lengths[long].sum()) / float(edges[-1]), bool(left[at]), bool(silent[at]))
