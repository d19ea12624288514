"""Where the noise enters: a Kalman filter that follows the play, and turns residuals into independent unit normals.

The model is driven by the smoothed input, which differs from the true one by an error e. While the line slides the output
error is the gain times e; while it holds, the error is the one of the extreme that was reached, one number until the next
slide. The output sensor adds white and first-order coloured noise. Given the phases all of this is linear and Gaussian::

    e'   = error of the smoothed input, by the law that the smoother states (four numbers), averaged over the step
    h'   = (1 - left) h + left gain e' + slip + turn
    c'   = first-order coloured noise of the output sensor
    residual = (1 - slide) h + slide gain e' + slip + turn + mean of c over the step + white noise

where the smoother has not been told of the slow noise of the input's sensor, that noise is the last number of the error, and
on its own. Sensors are read many times a step: of slow noise a step has the mean, which is smoother than a sample (a
first-order noise of 0.05 s keeps 77 % from one mean over 0.02 s to the next, not 67). ``slip`` stands for a hold that nearly
slid: whether the true input slipped there is not known, and what it left stays. ``turn`` comes where a slide ends: a line holds the
error of the extreme, which is that of one moment and not of the mean over a step. Where the model breaks away the true line may hold
on, or may have slid before: that follows from what it is known to hold (see kalman), and what it leaves is taken off the residual first.
A line that jumps may rest while the model slides: then what the model was where the rest began is compared with it.
So the innovations of the filter, over their standard deviations, are the whitened residual, and the sum of the logarithms
is its log-determinant (Harvey 1989, section 3.4). The filter depends on phases and noise, and on what the model left where it was last
judged: a residual and all columns of a Jacobian pass through it in one go.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import tails
from sstl_cli.diagnosis.kalman import DECAY, FRESH, MEAN, STATES, STEP, Places, filtered, gains
from sstl_cli.diagnosis.smoother import MOVES
from sstl_cli.diagnosis.wander import Levels, Turned, turned

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Sensor:
    """Noise of one tension sensor: white and coloured standard deviations (N) and correlation time (s)."""

    white_n: float
    coloured_n: float
    correlation_s: float


@dataclass(frozen=True)
class Noise:
    """Noise of the two sensors of each system; ``smoother`` is the true error of the smoothed input over the stated one.

    ``spread`` has the standard errors of the logarithms, by system and by ``input.coloured_n`` and the like; ``open`` is by what
    (natural logarithm) the coloured noise of a system's output may be off where it has not been estimated yet, ``loose`` the white;
    ``wanders`` is the evidence (nats) that its slow noise lasts longer than that of any sensor.
    """

    input: Mapping[str, Sensor]
    output: Mapping[str, Sensor]
    smoother: Mapping[str, float]
    spread: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    open: Mapping[str, float] = field(default_factory=dict)
    loose: Mapping[str, float] = field(default_factory=dict)
    wanders: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Phases:
    """How the model's output follows its input, shape (samples,): share of the mean over a step that does, and gain.

    The rest is what was held before the step; ``left`` is the share that the end of the step, which the next one holds, has of the
    input. ``doubt_n`` is the standard deviation (N) of what is not linear in the input's error: of a hold that nearly slid.
    ``jumps_n`` is that of what a line jumps by at every step of a slide, and keeps in a hold. ``breaks``, shape (samples, 4), has
    by how much (N) a sliding line moves to the end of a step and on average, NaN where that is not the question, how far (N) a line that
    will slide lies beyond what is held, and its gain (see slides).
    """

    slide: Array
    left: Array
    gain: Array
    doubt_n: Array
    jumps_n: Array | None = None
    breaks: Array | None = None

    @cached_property
    def columns(self) -> Array:
        """The same side by side, shape (samples, 9); kept, since several shares of a law's own error are tried at the same phases."""
        jumps_n = np.zeros(len(self.slide)) if self.jumps_n is None else self.jumps_n
        breaks = np.full((len(self.slide), 4), np.nan) if self.breaks is None else self.breaks
        return np.column_stack((self.slide, self.left, self.gain, self.doubt_n, jumps_n, breaks))

    def at(self, rows: NDArray[np.intp] | slice) -> Phases:
        """Return the phases of some samples."""
        jumps_n, breaks = (None if x is None else x[rows] for x in (self.jumps_n, self.breaks))
        return Phases(self.slide[rows], self.left[rows], self.gain[rows], self.doubt_n[rows], jumps_n, breaks)

    def jumping(self, more_n: Array) -> Phases:
        """Return the phases of a line that jumps by more (N, shape (samples,)) than it does."""
        return replace(self, jumps_n=more_n if self.jumps_n is None else np.hypot(self.jumps_n, more_n))


@dataclass(frozen=True)
class Own:
    """Coloured noise of the output's sensor, per step, shape (samples, 5): what is kept of it and variance of what is new in it;
    weight of the value before in the mean over the step, covariance of what is new in both, variance of what is new in the mean.
    """

    columns: Array

    @property
    def decay(self) -> Array:
        return self.columns[:, DECAY]

    @property
    def fresh(self) -> Array:
        return self.columns[:, FRESH]

    @property
    def mean(self) -> Array:
        return self.columns[:, MEAN]


@dataclass(frozen=True)
class Step:
    """The same of first-order noise of unit variance over a step of several readings; ``variance`` is that of the mean."""

    kept: float
    shown: float
    both: float
    mean: float

    @property
    def variance(self) -> float:
        return self.shown**2 + self.mean

    @property
    def lasting(self) -> float:
        """Covariance of the means of two steps in a row."""
        return self.shown * (self.kept * self.shown + self.both)


def step_of(readings: float, length: float) -> Step:
    """Return what first-order noise does over a step of so many readings, ``length`` correlation times long."""
    m = max(round(readings), 1)
    one = float(np.exp(-length / m))
    powers = one ** np.arange(m)
    # what a reading's own kick, k readings before the end, adds to the sum
    sums = np.cumsum(powers)
    fresh = 1.0 - one * one
    return Step(one**m, one * float(sums[-1]) / m, fresh * float(sums @ powers) / m, fresh * float(sums @ sums) / m**2)


@dataclass(frozen=True)
class Whitener:
    """Innovations filter of a problem; ``log_det`` is the log-determinant of the covariance over kept samples.

    ``trust`` is the square root of the precision of each innovation; ``beyond``, shape (samples,), what that and moments that a line
    chooses add to ``log_det``.
    ``shift_n`` (N, shape (samples,)) is what a residual is expected to be: columns do not have it. A line that rests while the
    model slides is compared with what the model was at its ``place``, shape (samples,).
    """

    moves: Array
    own: Own
    weights: Array
    scale: Array
    phases: Array
    first: Mask
    log_det: float
    known: tuple[Turned, ...] = ()
    trust: Array | None = None
    beyond: Array | None = None
    shift_n: Array | None = None
    place: Places | None = None

    def left(self, residual: Array) -> Array:
        """Return a whitened residual, shape (samples,)."""
        return self.beside(residual, np.empty((len(residual), 0)))[:, 0]

    def beside(self, residual: Array, columns: Array) -> Array:
        """Return a whitened residual and Jacobian columns in one pass, shape (samples, 1 + k)."""
        x = self._placed(np.column_stack((residual, columns)))
        if self.shift_n is not None:
            x[:, 0] -= self.shift_n
        return self._passed(x)

    def trusting(self, residual: Array, tail: Array) -> Whitener:
        """Return this whitener with the precision that each innovation of a residual shows (see tails).

        Its Gaussian cost of that residual is the cost by Student's distribution; of any other it is no less.
        """
        z = self.left(residual)
        kept = self.scale > 0.0
        heavy = kept & np.isfinite(tail)
        precision = np.ones(len(z))
        precision[heavy] = tails.trust(z[heavy], tail[heavy])
        more = np.zeros(len(z))
        more[heavy] = 2.0 * tails.nats(z[heavy], tail[heavy]) - precision[heavy] * z[heavy] ** 2
        beyond = more if self.beyond is None else self.beyond + more
        return replace(self, trust=np.sqrt(precision), beyond=beyond, log_det=self.log_det + float(more.sum()))

    def __call__(self, columns: Array) -> Array:
        """Return whitened residuals or Jacobian columns, shape (samples,) or (samples, k); 0 where nothing is known."""
        flat = columns.ndim == 1
        x = np.ascontiguousarray(columns[:, None] if flat else columns, np.float64)
        out = self._passed(self._placed(x))
        return out[:, 0] if flat else out

    def _placed(self, x: Array) -> Array:
        return x if self.place is None else x[self.place]

    def _passed(self, x: Array) -> Array:
        """Return columns, shape (samples, k), as independent unit normals."""
        out = filtered(x, self.moves, self.own.columns, self.weights, self.scale, self.phases, self.first)
        for turn in self.known:
            out = turn(out)
        if self.trust is not None:
            out = out * self.trust[:, None]
        return out


class _White(Whitener):
    """The whitener of independent noise: nothing is carried from sample to sample."""

    def _passed(self, x: Array) -> Array:
        return x * (self.scale if self.trust is None else self.scale * self.trust)[:, None]


def white(scale_n: float, keep: Array, starts: Sequence[int]) -> Whitener:
    """Return the whitener of independent noise of one standard deviation (N)."""
    n = len(keep)
    scale = np.where(keep > 0, 1.0 / scale_n, 0.0)
    first = np.zeros(n, np.bool_)
    first[list(starts)] = True
    log_det = 2.0 * float(np.sum(keep > 0)) * float(np.log(scale_n))
    return _White(np.zeros((n, MOVES)), Own(np.zeros((n, 5))), np.zeros((n, STATES)), scale, np.zeros((n, 9)), first, log_det)


@dataclass(frozen=True)
class Constants:
    """What the noise is whatever the model does, per sample: coloured noise of the output, white noise (N), law of the input's
    error (n, 36), variance of the output before a record, whether the sample counts, whether a record begins, and how a known rig varies.
    """

    own: Own
    white_n: Array
    error_law: Array
    moves: Array
    start: Array
    keep: Mask
    first: Mask
    jitter_n: Array
    wander: Levels | None = None


def whitener(
    c: Constants, phases: Phases, discrepancy_n: Array | None = None, residual: Array | None = None, output: Array | None = None
) -> Whitener:
    """Return the innovations filter of records whose model slides and holds as ``phases`` say.

    Parameters
    ----------
    c : Constants
        Those of the records, laid end to end, and of the noise; ``phases`` has one entry for each of their samples.
    discrepancy_n : ndarray, shape (samples,), optional
        Standard deviation of what the model's law may be off (N).
    residual : ndarray, shape (samples,), optional
        What the model leaves (N), which tells when the true line breaks away; the line breaks away with the model where it is not given.
    output : ndarray, shape (samples,), optional
        Readings (N), which tell where the line comes to rest between jumps (see kalman); it does not where they are not given.
    """
    # both readings of an instant are late together: what slides differs by as much from what the smooth input makes of it
    white_n = np.hypot(c.white_n, phases.slide * phases.gain * c.jitter_n)
    white_n = white_n if discrepancy_n is None else np.hypot(white_n, discrepancy_n)
    columns = phases.columns.copy()
    if residual is None:
        columns[:, STEP], residual = np.nan, np.zeros(len(columns))
    readings = residual, np.empty(0) if output is None else output
    weights, scale, log_det, beyond, shift_n, place = gains(
        columns, c.error_law, c.own.columns, white_n, c.keep, c.first, c.start, readings
    )
    plain = Whitener(c.moves, c.own, weights, scale, columns, c.first, log_det, shift_n=shift_n)
    plain = plain if output is None else replace(plain, beyond=beyond, place=place)
    return plain if c.wander is None else _varied(plain, c.wander)


def _varied(plain: Whitener, wander: Levels) -> Whitener:
    """Return a whitener that knows how the rig varies, level by level."""
    found = plain
    for columns, blocks in wander:
        known = turned(found(columns), blocks)
        found = replace(found, known=(*found.known, known), log_det=found.log_det + known.log_det)
    return found
