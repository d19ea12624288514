"""What the rules of the gate look at: a few numbers of every run, measured once and kept without the samples."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sstl_cli.identification.gate.ahead import Ahead
from sstl_cli.identification.gate.beside import Standstill
from sstl_cli.identification.gate.causes import APIECE, Cause, Causes
from sstl_cli.identification.gate.clock_rate import ClockRate
from sstl_cli.identification.gate.curves import Curve
from sstl_cli.identification.gate.dropouts import Dropouts
from sstl_cli.identification.gate.filled import Filled
from sstl_cli.identification.gate.fingerprints import Again, Prints, Sketch
from sstl_cli.identification.gate.hum import Hum
from sstl_cli.identification.gate.leaps import Crossing, Leap
from sstl_cli.identification.gate.lost import Lost
from sstl_cli.identification.gate.mixing import Mixed
from sstl_cli.identification.gate.movement import WAY, Movement
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.sensors import Sensor
from sstl_cli.identification.gate.sequence import MOVES, Disorder
from sstl_cli.identification.gate.shapes import Shapes
from sstl_cli.identification.gate.slopes import AGREED_EXPLAINED, AGREED_SHARE, LEAST_REACH, Slopes

DRIVEN = 0.15
# part of the input's span over which a pull must be seen to tell friction without a release
PULLED = 0.5
# and where, as a part of the largest output, its line must meet no tension
PULLED_FROM = 0.12
# part of the output's span that friction may leave for its size to be known to some percent, and how far (logarithm) any slip beside it may move that
ABOUT_LEFT, ABOUT = 0.03, 0.2
# what friction that fades may leave of what a bundle of plays leaves for its lines not to be believed
FADES = 0.3
# what sound sensors may add to a law: logarithm of their gain, and their zero (N, and as a part of the span)
SOUND_GAIN, SOUND_ZERO_N, SOUND_ZERO = 0.1625, 2.0, 0.1
# n theta beyond which no bend goes: more is a gain
MOST_WRAP = 2.3
# logarithm of highest over lowest input: twice n theta of a usual bend of one pass
BACKLASH = 1.0
# how far (logarithm) the slope of a pull may be from that of friction that leaves but noise
ALONG = 0.3
# slope over that of the pull of an output at rest
RESTS = 0.1


@dataclass(frozen=True)
class Range:
    """Extremes of a channel (N), spikes left out, and its median."""

    low: float
    high: float
    middle: float

    @property
    def span(self) -> float:
        return self.high - self.low

    @property
    def largest(self) -> float:
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class Evidence:
    """One run as the rules see it. Times in s, tensions in N, positions in mm.

    ``dt_first_s`` and ``dt_last_s`` are the sampling periods of the first and last tenth, ``dt_error_s`` what jitter makes of such a mean.

    ``slopes`` are those on which phases and play operator agree, ``causes`` what friction leaves of the output, alone and with one slip, ``curve`` behind a curve of the output, ``clock_rate`` with another rate of its clock, ``ahead`` by how much the output leads, ``mixed`` the part of the input that it holds, ``shapes`` what a channel shows that is no tension. ``tensions`` are the channels that hold tensions, by name. ``whole_share`` is the part of samples that are whole
    numbers, ``digits_lost`` the part that lack a digit, ``two_values`` whether a channel takes two values and no others, ``line_share`` how much of a channel is a straight line in time (both input, output).
    ``correlation`` is that of input and output, ``noise_correlation`` that of their fast parts,
    ``loop_work`` what closed loops give (share of the input's way times the output's span; friction takes), ``both_ways`` the part of its span that each channel goes up as well as down, ``extremes`` the smallest and largest reading of each channel,
    ``copy_rms`` what a straight line from input to output leaves (share of the output's span). ``swapped_rms`` and
    ``flipped_rms`` are residuals (share of the output's span) of the play operator with input and output
    exchanged, and with the output's sign changed; ``forward_rms`` as recorded (NaN where there was no need to look).
    ``reference_left`` is what its reference leaves of the input's movement, ``reference_movement`` how it moves, ``reference_lag`` is that of the input behind its reference, and its standard error (s), ``movement`` how the input moves sample by sample.
    ``position_follows`` is the correlation of position and input, ``position_movement`` how the position moves sample by sample, ``position_wrap_mm`` by how much it jumps from end to end of its range, ``position_rest`` where it stands still, ``instead`` what friction makes of it (leaving a share of the span) with the position in the place of the input and of the output, ``off`` by how much position and reference read beside the input (share of its span), ``copies`` are the pairs of columns that hold the same numbers.
    ``filled`` is a stretch that was interpolated, ``held_while`` what the other channel moves by while a slow one is held (N).
    ``disorder`` tells how the rows were put in another order, ``dropouts`` are readings of one level that replace missing ones (input, output),
    ``roughness`` are the steps from one sample to the next over those between samples in any order, ``raw_correlation`` is that of all samples,
    ``hums`` are lines of one frequency, ``lost`` are stretches of nothing but noise (input, output). ``seam`` is the largest jump that both channels make together (shares of their spans), ``seam_alone`` whether nothing else in the run is like it, ``leap`` is one of the input alone, ``crossing`` where both channels change places, ``noise_ratio`` the noise of
    the second half over that of the first. ``prints`` are fingerprints of short stretches of both channels, ``output_prints`` of the output where its noise shows, ``sketch`` is the noise of both channels, which survives a
    change of unit and a rounding, ``again`` what of a run comes in it twice.
    """

    run_id: str
    config_id: str | None
    system: str
    location: str | None
    lead_mm: float | None
    trajectory: str | None
    tendon: str | None
    samples: int
    usable: bool
    tensions: tuple[str, ...]
    dt_s: float
    dt_first_s: float
    dt_last_s: float
    dt_error_s: float
    duration_s: float
    loops: int
    sensors: tuple[Sensor, Sensor]
    ranges: tuple[Range, Range]
    whole_share: tuple[float, float]
    digits_lost: tuple[float, float]
    two_values: tuple[bool, bool]
    line_share: tuple[float, float]
    correlation: float
    raw_correlation: float
    noise_correlation: float
    loop_work: float
    both_ways: tuple[float, float]
    extremes: tuple[tuple[float, float], tuple[float, float]]
    roughness: tuple[float, float]
    disorder: Disorder
    dropouts: tuple[Dropouts | None, Dropouts | None]
    hums: tuple[Hum | None, Hum | None]
    copy_rms: float
    slopes: Slopes
    play: PlayFit | None
    causes: Causes
    curve: Curve | None
    clock_rate: ClockRate | None
    ahead: Ahead | None
    mixed: Mixed | None
    shapes: Shapes
    forward_rms: float
    swapped_rms: float
    flipped_rms: float
    stuck_while_n: tuple[float, float]
    lost: tuple[Lost | None, Lost | None]
    seam: tuple[float, float]
    seam_at_s: float
    seam_alone: bool
    leap: Leap | None
    crossing: Crossing | None
    noise_ratio: tuple[float, float]
    filled: Filled
    held_while: tuple[float, float]
    position_span_mm: float
    position_follows: float
    position_movement: Movement
    position_wrap_mm: float
    position_rest: Standstill | None
    instead: tuple[Cause, Cause]
    off: tuple[float, float]
    reference_gain: float
    reference_left: float
    reference_movement: Movement
    reference_lag: tuple[float, float]
    movement: Movement
    copies: tuple[tuple[str, str], ...]
    prints: Prints
    output_prints: Prints
    sketch: Sketch
    again: Again

    @property
    def passes(self) -> int:
        return 2 if self.system == "sstl" else 1

    @property
    def wrap(self) -> float:
        """Return n theta: half the logarithm of release over pull, or that of a pull alone where no output is lost to a gain."""
        p = self.play
        if self.slopes.known or p is None:
            return self.slopes.friction
        alone = self.causes.friction
        shown = p.shares[0] > AGREED_SHARE and p.reaches[0] > LEAST_REACH and alone.size < PULLED_FROM * self.ranges[1].largest
        # an output that never leaves its backlash rests along a line that is none of friction
        shown = shown and abs(math.log(max(p.gamma_p, 1e-9)) + alone.wrap) < ALONG
        if self.causes.enough and alone.wrap < MOST_WRAP and shown:
            # friction alone leaves but noise: then a line seen over a part of the pull tells it
            return alone.wrap
        seen = p.explained > AGREED_EXPLAINED and p.reaches[0] > PULLED and p.shares[0] > AGREED_SHARE
        # the line of a pull goes to nothing with the tension; that of presliding does not
        # on the way back an output rests, and then falls faster than its input
        back = p.gamma_r > 1.0 or abs(p.gamma_r) < RESTS * p.gamma_p
        friction = 0.0 < p.gamma_p < 1.0 and back and abs(p.beta_p) < PULLED_FROM * self.ranges[1].largest
        # where the input is highest a zero of either sensor counts least
        passed = p.gamma_p + p.beta_p / max(self.ranges[0].high, 1e-300)
        return -math.log(passed) if seen and friction and passed > 0.0 else math.nan

    @property
    def wrap_about(self) -> float:
        """Return n theta to some percent: ``wrap``, or where presliding or drag hides all lines that of the law of friction which leaves least, if no slip beside it leaves much less."""
        c, (a, b) = self.causes, self.ranges
        faded = math.isfinite(c.fading.rms_n) and c.left(c.fading.rms_n) < FADES * c.left(c.friction.rms_n)
        if (self.wrap > 0.0 and not faded) or not self.tendon_like:
            return self.wrap
        laws = [v for v in (c.friction, c.speed, c.fading) if math.isfinite(v.rms_n)]
        if not laws or c.enough:
            return math.nan
        best = min(laws, key=lambda v: v.rms_n)
        # a slip that takes much away is another story
        beside = [v for v in (c.gain, c.zero_in, c.zero_out, c.slow, c.creep) if math.isfinite(v.rms_n)]
        small = best.rms_n < ABOUT_LEFT * b.span and (
            c.noise_alone(best.rms_n) or all(c.left(best.rms_n) < APIECE * c.left(v.rms_n) for v in beside)
        )
        # of a law that never slides the run shows no more than how it builds up
        leaves = best is c.fading or (a.low > 0.0 and math.log(a.high / a.low) > 2.0 * best.wrap)
        if best is c.friction:
            small = small and all(v.wrap > 0.0 and abs(math.log(v.wrap / best.wrap)) < ABOUT for v in beside if best.wrap > 0.0)
        # speed adds from nothing at the turns to all of it in between
        wrap = best.wrap * (1.0 + 0.5 * best.size) if best is c.speed else best.wrap
        return wrap if small and leaves and wrap > 0.0 else math.nan

    @property
    def wraps(self) -> tuple[float, float]:
        """Return the least and the largest n theta that laws of friction with sound sensors allow: of all that explain the run about as well as the best of them.

        Lines of presliding are steeper or flatter than those of friction; what they tell is one answer of several. Of a run that friction alone explains it is that, and its lines.
        """
        c = self.causes
        if c.enough or not self.tendon_like:
            told = [v for v in (self.wrap_about, c.friction.wrap if c.enough else math.nan) if v > 0.0]
            return (min(told), max(told)) if told else (math.nan, math.nan)
        zero_n = min(SOUND_ZERO_N, SOUND_ZERO * self.ranges[0].span)
        sound = [c.friction, c.speed, c.fading]
        sound += [v for v, most in ((c.gain, SOUND_GAIN), (c.zero_in, zero_n), (c.zero_out, zero_n)) if abs(v.size) < most]
        likely = c.likely(APIECE, (v for v in sound if v.wrap > 0.0))
        # speed adds from nothing at the turns to all of it in between
        told = [v.wrap for v in likely] + [v.wrap * (1.0 + 0.5 * v.size) for v in likely if v is c.speed]
        return (min(told), max(told)) if told else (self.wrap_about, self.wrap_about)

    @property
    def both_tensions(self) -> bool:
        return len(self.tensions) == 2

    @property
    def loop_s(self) -> float:
        """Duration of a loop (of the run where it has none)."""
        return self.duration_s / max(1, self.loops)

    @property
    def wide(self) -> bool:
        """Whether the input goes over more than the backlash of a usual bend: within it presliding is all there is, and follows no line."""
        r = self.ranges[0]
        return r.low <= 0.0 or math.log(r.high / r.low) > BACKLASH

    @property
    def loaded(self) -> bool:
        """Whether the input is driven over a part of its level; what follows a constant input is another movement."""
        return self.ranges[0].span > DRIVEN * self.ranges[0].largest

    @property
    def propagates_back(self) -> bool:
        """Whether the output was seen to go both ways over most of what it goes: on one line friction, gain, zero and a curve are not told apart."""
        return self.both_ways[1] >= WAY

    @property
    def comes_back(self) -> bool:
        """Whether the input goes over most of its way both ways: what one direction takes shows beside the other one only."""
        return self.both_ways[0] >= WAY

    @property
    def one_way(self) -> bool:
        """Whether a run is only pulled, or its output goes one way: then it shows one line."""
        return not (self.comes_back and self.propagates_back)

    @property
    def passed(self) -> float:
        """Return the logarithm of the highest output over the highest input, NaN where one is no tension: at the end of a pull every law of friction slides."""
        a, b = self.ranges
        return math.log(b.high / a.high) if min(a.high, b.high) > 0.0 else math.nan

    def but_noise(self, i: int) -> bool:
        """Whether a channel (0 input, 1 output) shows no movement behind its noise: then it has no loops and no level of its own."""
        return self.roughness[i] > MOVES

    @property
    def tendon_like(self) -> bool:
        """Whether both channels are tensions that pull: a tendon cannot push, a difference of two or a rod can."""
        return self.usable and self.both_tensions and all(r.low > -0.25 * r.high for r in self.ranges)


NO_RANGE = Range(0.0, 0.0, 0.0)
