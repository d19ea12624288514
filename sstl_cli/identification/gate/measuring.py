"""A run looked at once: the numbers that the rules of the gate go by."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.runs import Run
from sstl_cli.core.sound import CHANNELS, unsound
from sstl_cli.identification.filtering import median
from sstl_cli.identification.gate.ahead import ahead_of
from sstl_cli.identification.gate.beside import (
    column_movement,
    follows_of,
    instead_of,
    off_of,
    reference_gain,
    reference_lag,
    reference_left,
    span_of,
    standstill_of,
    wrap_of,
)
from sstl_cli.identification.gate.causes import NO_CAUSES, UNKNOWN, causes_of, floor_of
from sstl_cli.identification.gate.changes import Recorded
from sstl_cli.identification.gate.clock_rate import clock_rate_of
from sstl_cli.identification.gate.curves import curve_of
from sstl_cli.identification.gate.dropouts import dropouts_of
from sstl_cli.identification.gate.evidence import NO_RANGE, Evidence, Range
from sstl_cli.identification.gate.fading import fading_of
from sstl_cli.identification.gate.filled import NOT_FILLED, filled_of, held_while
from sstl_cli.identification.gate.fingerprints import NEVER, NO_PRINTS, NO_SKETCH, again_of, copies_of, prints_of, sketch_of
from sstl_cli.identification.gate.hum import hum_of
from sstl_cli.identification.gate.jumps import channel_of
from sstl_cli.identification.gate.leaps import crossing_of, leap_of
from sstl_cli.identification.gate.lost import lost_of
from sstl_cli.identification.gate.mixing import mixed_of
from sstl_cli.identification.gate.movement import NO_MOVEMENT, both_ways, loop_work, movement_of
from sstl_cli.identification.gate.noises import line_share, noise_correlation, noise_ratio
from sstl_cli.identification.gate.playfit import PlayFit, corners, fit_play
from sstl_cli.identification.gate.seam import LEAST_JUMP, alone_at, seam_of
from sstl_cli.identification.gate.sensors import Sensor, digits_lost, sensors_of
from sstl_cli.identification.gate.sequence import disorder_of
from sstl_cli.identification.gate.shapes import NO_SHAPES, shapes_of
from sstl_cli.identification.gate.slopes import NO_SLOPES, Slopes, agreed
from sstl_cli.identification.segment import Segmentation, segment_run

Array = NDArray[np.float64]
MIN_SAMPLES = 32
# slopes, delays and loops of a recording show in this many points
MOST_POINTS = 1536
SEGMENT_POINTS = 16_384
# rows of another place from which on a jump is no seam
MISPLACED = 8


def evidence_of(run: Run) -> Evidence:
    """Return what the rules need to know of a run; a channel whose unit is not N is no tension to them."""
    tensions = tuple(name for name, unit in run.units.items() if unit == "N")
    step = np.diff(run.time_s)
    tenth = max(1, len(step) // 10)
    unknown = Evidence(
        run_id=run.run_id, config_id=run.config_id, system=run.system, location=run.location, lead_mm=run.lead_mm,
        trajectory=run.trajectory, tendon=run.tendon, samples=len(run), tensions=tensions,
        dt_s=median(step) if len(step) else math.nan,
        dt_first_s=_usual(step[:tenth]),
        dt_last_s=_usual(step[-tenth:]),
        dt_error_s=_deviation(step) / math.sqrt(tenth),
        duration_s=float(run.time_s[-1] - run.time_s[0]) if len(run) else 0.0,
        sensors=sensors_of(run),
        usable=False, loops=0, ranges=(NO_RANGE, NO_RANGE), whole_share=(0.0, 0.0), digits_lost=(0.0, 0.0), two_values=(False, False), line_share=(0.0, 0.0),
        correlation=math.nan, raw_correlation=math.nan, noise_correlation=math.nan, loop_work=math.nan, both_ways=(0.0, 0.0), extremes=((math.nan, math.nan), (math.nan, math.nan)), roughness=(0.0, 0.0), disorder="", dropouts=(None, None), hums=(None, None), copy_rms=math.nan, slopes=NO_SLOPES, play=None, causes=NO_CAUSES, curve=None, clock_rate=None, ahead=None, mixed=None, shapes=NO_SHAPES, forward_rms=math.nan,
        swapped_rms=math.nan, flipped_rms=math.nan, stuck_while_n=(0.0, 0.0), lost=(None, None),
        seam=(0.0, 0.0), seam_at_s=math.nan, seam_alone=False, leap=None, crossing=None, noise_ratio=(math.nan, math.nan), filled=NOT_FILLED, held_while=(0.0, 0.0),
        position_span_mm=math.nan, position_follows=math.nan, position_movement=NO_MOVEMENT, position_wrap_mm=math.nan, position_rest=None, instead=(UNKNOWN, UNKNOWN), off=(math.nan, math.nan), reference_gain=math.nan, reference_left=math.nan, reference_movement=NO_MOVEMENT, reference_lag=(math.nan, math.nan), movement=NO_MOVEMENT, copies=(), prints=NO_PRINTS, output_prints=NO_PRINTS, sketch=NO_SKETCH, again=NEVER,
    )  # fmt: skip
    if len(run) < MIN_SAMPLES:
        return unknown
    if not _sound(run):
        a, b = (_range(v) if not unsound(v).any() else NO_RANGE for v in (run.tension_in_n, run.tension_out_n))
        return replace(unknown, ranges=(a, b))
    return _of_readings(_of_movement(unknown, run), run)


def _usual(step: Array) -> float:
    """Return the mean of the middle half: lost samples do not count, a clock of whole milliseconds does."""
    n = len(step)
    if n == 1:
        return float(step[0])
    return float(np.mean(np.sort(step)[n // 4 : n - n // 4])) if n else math.nan


def _deviation(step: Array) -> float:
    """Return the standard deviation, NaN without a step or with one that is no number."""
    if len(step) == 1:
        return float(step[0] - step[0])
    return float(np.std(step)) if len(step) else math.nan


def _sound(run: Run) -> bool:
    if not np.all(run.time_s[1:] > run.time_s[:-1]):
        return False
    channels = (run.time_s, run.tension_in_n, run.tension_out_n)
    return all(not bool(unsound(v).any()) and float(np.ptp(v)) > 0.0 for v in channels)


def _of_movement(e: Evidence, run: Run) -> Evidence:
    """Return the evidence with what friction makes of the readings, single spikes left out."""
    sensors, raw = e.sensors, (run.tension_in_n, run.tension_out_n)
    clean = replace(run, tension_in_n=_middle_of_three(raw[0]), tension_out_n=_middle_of_three(raw[1]))
    # data that make no sense may overflow on their way to "not identified"
    with np.errstate(all="ignore"):
        found = segment_run(_thinned(clean, SEGMENT_POINTS))
    slopes = _slopes(found)
    few = _thinned(clean, MOST_POINTS)
    position = None if run.position_in_mm is None else _blocks(run.position_in_mm, MOST_POINTS)
    t, x, y = few.time_s - few.time_s[0], few.tension_in_n, few.tension_out_n
    ranges = (_range(x), _range(y))
    # without spikes a channel may be constant
    moves = float(np.std(x)) > 0.0 and float(np.std(y)) > 0.0
    correlation = float(np.corrcoef(x, y)[0, 1]) if moves else math.nan
    play, residuals = _fits(t, x, y, slopes, ranges, correlation, sensors)
    noises, steps = (sensors[0].noise_n, sensors[1].noise_n), (sensors[0].step_n, sensors[1].step_n)
    causes = causes_of(t, x, y, noises, play) if moves else NO_CAUSES
    block = -(-len(clean) // MOST_POINTS)
    renewed = (channel_of(clean.tension_in_n, sensors[0].held), channel_of(clean.tension_out_n, sensors[1].held))
    shapes = shapes_of((t, x, y), raw, Recorded(renewed, noises, block), steps, causes) if moves else NO_SHAPES
    seam, seam_at, seam_alone = _seam(e, raw, clean, ranges)
    return replace(
        _of_reference(e, run, clean.tension_in_n),
        usable=True,
        loops=found.loops,
        ranges=ranges,
        line_share=(line_share(t, x), line_share(t, y)),
        correlation=correlation,
        loop_work=loop_work(x, y, noises[0]),
        both_ways=(both_ways(x, noises[0]), both_ways(y, noises[1])),
        copy_rms=math.sqrt(max(1.0 - correlation**2, 0.0)) * float(np.std(y)) / max(ranges[1].span, 1e-300),
        slopes=agreed(slopes, play, causes, noises[1], ranges[0].span, max(floor_of(noises[1], y), steps[1]), noises[0]),
        play=play,
        causes=causes,
        curve=curve_of(x, y, float(t[-1]), causes, play) if moves else None,
        clock_rate=clock_rate_of(t, x, y, e.duration_s, noises[1], causes) if moves else None,
        ahead=ahead_of(t, x, y, sensors, block, play, causes) if moves else None,
        mixed=mixed_of(raw, (t, x, y), sensors, causes) if moves else None,
        shapes=shapes,
        forward_rms=residuals[0],
        swapped_rms=residuals[1],
        flipped_rms=residuals[2],
        lost=(lost_of(t, x, y, noises[0]), lost_of(t, y, x, noises[1])),
        seam=seam,
        seam_at_s=seam_at,
        seam_alone=seam_alone,
        leap=leap_of(run.time_s, clean.tension_in_n, (run.position_in_mm, run.tension_ref_n)),
        crossing=crossing_of(run.time_s, clean.tension_in_n, clean.tension_out_n),
        position_span_mm=span_of(run.position_in_mm),
        position_follows=follows_of(run.position_in_mm, run.tension_in_n),
        position_movement=column_movement(run.position_in_mm),
        position_wrap_mm=wrap_of(run.position_in_mm, clean.tension_in_n),
        instead=instead_of(position, (x, y), noises) if moves and not causes.enough else (UNKNOWN, UNKNOWN),
        position_rest=standstill_of(run.time_s, run.position_in_mm, clean.tension_in_n),
        off=(off_of(run.position_in_mm, run.tension_in_n), off_of(run.tension_ref_n, run.tension_in_n)),
        movement=movement_of(clean.tension_in_n),
        copies=copies_of({n: v for n in CHANNELS if (v := getattr(run, n)) is not None}),
    )


def _of_reference(e: Evidence, run: Run, x: Array) -> Evidence:
    """Return the evidence with how the input, ``x`` without its spikes, follows its reference."""
    return replace(
        e,
        reference_gain=reference_gain(run.tension_ref_n, run.tension_in_n),
        reference_left=reference_left(run.tension_ref_n, x),
        reference_movement=column_movement(run.tension_ref_n),
        reference_lag=reference_lag(run.time_s, run.tension_ref_n, run.tension_in_n),
    )


def _slopes(found: Segmentation) -> Slopes:
    """Return the lines of a run with the standard errors of their slopes, NaN where one was not found."""
    th, se = found.theta, found.theta_se
    return Slopes(
        *(math.nan if (v := th[n]) is None else float(v) for n in ("gamma_p", "beta_p", "gamma_r", "beta_r")),
        *(math.nan if (v := se[n]) is None else float(v) for n in ("gamma_p", "gamma_r")),
    )


def _seam(e: Evidence, raw: tuple[Array, Array], clean: Run, ranges: tuple[Range, Range]) -> tuple[tuple[float, float], float, bool]:
    """Return the largest jump that both channels make together (shares of their spans), when (s), and whether nothing else is like it."""
    channels, strides = (clean.tension_in_n, clean.tension_out_n), (e.sensors[0].stride, e.sensors[1].stride)
    seam, at = seam_of(clean.time_s, channels, (ranges[0].span, ranges[1].span), strides)
    if _misplaced(raw, channels, ranges) >= MISPLACED:
        seam = (0.0, 0.0)
    jumped = (seam[0] * ranges[0].span, seam[1] * ranges[1].span)
    return seam, at, min(seam) > 0.0 and alone_at(clean.time_s, channels, jumped, at, strides)


def _of_readings(e: Evidence, run: Run) -> Evidence:
    """Return the evidence with what the readings show as they are, whatever friction makes of them."""
    sensors, raw = e.sensors, (run.tension_in_n, run.tension_out_n)
    stride = max(sensors[0].stride, sensors[1].stride)
    dt, half, filled = median(np.diff(run.time_s)), len(run) // 2, filled_of(run.time_s, raw, sensors)

    def noises(i: int) -> float:
        # what was filled in has no noise
        return math.nan if filled.length_s else noise_ratio(raw[i][:half], raw[i][half:], sensors[i])

    return replace(
        e,
        whole_share=(_whole_share(raw[0]), _whole_share(raw[1])),
        digits_lost=(digits_lost(raw[0]), digits_lost(raw[1])),
        two_values=(_two_values(raw[0]), _two_values(raw[1])),
        extremes=((float(raw[0].min()), float(raw[0].max())), (float(raw[1].min()), float(raw[1].max()))),
        raw_correlation=float(np.corrcoef(*raw)[0, 1]),
        noise_correlation=noise_correlation(*raw),
        roughness=(_roughness(raw[0], sensors[0].stride), _roughness(raw[1], sensors[1].stride)),
        disorder=disorder_of(raw),
        dropouts=(dropouts_of(raw[0], raw[1]), dropouts_of(raw[1], raw[0])),
        hums=(hum_of(dt, raw[0], raw[1], raw[0], stride), hum_of(dt, raw[1], raw[0], raw[0], stride)),
        stuck_while_n=(_moved_meanwhile(run, 0, sensors[0]), _moved_meanwhile(run, 1, sensors[1])),
        noise_ratio=(noises(0), noises(1)),
        filled=filled,
        held_while=(held_while(raw[0], raw[1], sensors), held_while(raw[1], raw[0], sensors[::-1])),
        prints=prints_of(*raw),
        output_prints=prints_of(raw[1], raw[1]) if sensors[1].fine else NO_PRINTS,
        sketch=sketch_of(*raw, (sensors[0].stride, sensors[1].stride), (sensors[0].fine, sensors[1].fine)),
        # without noise a movement that repeats comes again by itself
        again=again_of(*raw) if any(s.fine and not s.computed for s in sensors) else NEVER,
    )


def _whole_share(v: Array) -> float:
    return float(np.mean(v == np.round(v)))


def _two_values(v: Array) -> bool:
    return bool(np.all((v == v.min()) | (v == v.max())))


def _roughness(v: Array, stride: int) -> float:
    return float(np.var(np.diff(v[::stride]))) / (2.0 * max(float(np.var(v[::stride])), 1e-300))


def _misplaced(raw: tuple[Array, Array], clean: tuple[Array, Array], ranges: tuple[Range, Range]) -> int:
    """Return how many samples stand off both neighbours in both channels at once, as rows of another place do."""
    off = [np.abs(v - c) > LEAST_JUMP * r.span for v, c, r in zip(raw, clean, ranges, strict=True)]
    return int(np.count_nonzero(off[0] & off[1]))


def _thinned(run: Run, most: int) -> Run:
    """Return block means of a run, at most ``most`` of them."""
    length = -(-len(run) // most)
    if length < 2:
        return run
    return Run(run.run_id, run.system, _blocks(run.time_s, most), _blocks(run.tension_in_n, most), _blocks(run.tension_out_n, most))


def _blocks(v: Array, most: int) -> Array:
    """Return block means of a channel, at most ``most`` of them."""
    length = -(-len(v) // most)
    return np.asarray(v[: len(v) // length * length].reshape(-1, length).mean(axis=1), np.float64)


def _middle_of_three(v: Array) -> Array:
    """Return a channel without single samples that leave both neighbours, and without dropouts to exactly zero."""
    zero = v == 0.0
    if 0 < np.count_nonzero(zero) < 0.1 * len(v):
        v = np.where(zero, np.interp(np.arange(len(v)), np.flatnonzero(~zero), v[~zero]), v)
    a, b, c = v[:-2], v[1:-1], v[2:]
    out = v.copy()
    out[1:-1] = np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))
    return out


def _range(v: Array) -> Range:
    low, middle, high = np.quantile(v, [0.005, 0.5, 0.995])
    return Range(float(low), float(high), float(middle))


def _fits(
    t: Array, x: Array, y: Array, slopes: Slopes, ranges: tuple[Range, Range], correlation: float, sensors: tuple[Sensor, Sensor]
) -> tuple[PlayFit, tuple[float, float, float]]:
    """Return the play fit, and residuals (share of the output's span) as recorded, exchanged, and flipped."""
    span_x, span_y = max(ranges[0].span, 1e-300), max(ranges[1].span, 1e-300)
    fit = _best(t, x, y, slopes, ranges, sensors[1].noise_n)
    forward = fit.rms_n / span_y
    leads = fit.delay_s < -3.0 * fit.delay_se and fit.delayed_rms_n < 0.8 * fit.rms_n
    doubtful = fit.explained < 0.98 or leads or not 0.0 < fit.gamma_p < fit.gamma_r
    swapped = flipped = math.nan
    if doubtful:
        faded = fading_of(y, x)[1]
        swapped = _best(t, y, x, NO_SLOPES, (ranges[1], ranges[0]), timed=False).rms_n / span_x
        swapped = min(swapped, faded / span_x) if math.isfinite(faded) else swapped
    if correlation < 0.0 or min(r.middle for r in ranges) < 0.0:
        low, high = -ranges[1].high, -ranges[1].low
        mirrored = Range(low, high, -ranges[1].middle)
        flipped = _best(t, x, -y, NO_SLOPES, (ranges[0], mirrored), timed=False).rms_n / span_y
    return fit, (forward, swapped, flipped)


def _best(t: Array, x: Array, y: Array, slopes: Slopes, ranges: tuple[Range, Range], noise_n: float = 0.0, timed: bool = True) -> PlayFit:
    """Return the play fit from the segmentation's lines, or the better one of two guesses."""
    if slopes.known and slopes.gamma_r > slopes.gamma_p:
        start = np.array([slopes.gamma_p, slopes.beta_p, slopes.gamma_r, slopes.beta_r])
        return fit_play(t, x, y, start, noise_n, timed)
    a, b = ((r.low, r.high) for r in ranges)
    return max((fit_play(t, x, y, corners(a, b, theta), noise_n, timed) for theta in (0.3, 1.0)), key=lambda f: f.explained)


def _moved_meanwhile(run: Run, channel: int, sensor: Sensor) -> float:
    """Return how far (N) the other channel moved in the longest stretch in which this one stood still."""
    if sensor.still_s <= 0.0:
        return 0.0
    other = run.tension_out_n if channel == 0 else run.tension_in_n
    a = int(np.searchsorted(run.time_s, sensor.still_at_s))
    b = int(np.searchsorted(run.time_s, sensor.still_at_s + sensor.still_s))
    return float(np.ptp(other[a:b])) if b > a else 0.0
