"""The propagation slopes that a run holds: those on which phases, free lines and lines of friction agree."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sstl_cli.identification.gate.causes import APIECE, Causes
from sstl_cli.identification.gate.playfit import PlayFit

# residual over noise of a play operator that leaves nothing
TO_NOISE = 1.3
AGREED_EXPLAINED, AGREED_SHARE, AGREED_APART, LEAST_REACH = 0.97, 0.03, 0.15, 0.1
# times the noise of the input over which a line must be seen: twice what noise alone spans from its 2nd to its 98th percentile
ACROSS = 8.0
# part of n theta by which free lines may differ from those of friction (alone, or with one slip)
HELD, HELD_LEAST = 0.3, 0.1
# difference of the logarithms of their gains
SCALED = 0.25


@dataclass(frozen=True)
class Slopes:
    """Propagation slopes and biases (N) with standard errors of the slopes; NaN where a direction is not identified."""

    gamma_p: float
    beta_p: float
    gamma_r: float
    beta_r: float
    se_p: float
    se_r: float

    @property
    def known(self) -> bool:
        return math.isfinite(self.gamma_p) and math.isfinite(self.gamma_r)

    @property
    def friction(self) -> float:
        """Half the logarithm of release over pull: n theta, whatever the unit of the output."""
        return 0.5 * math.log(self.gamma_r / self.gamma_p) if self.known else math.nan

    @property
    def friction_se(self) -> float:
        return 0.5 * math.hypot(self.se_r / self.gamma_r, self.se_p / self.gamma_p) if self.known else math.nan

    @property
    def gain(self) -> float:
        """Root of pull x release: what output and input sensor differ by, 1 for Coulomb friction."""
        return math.sqrt(self.gamma_p) * math.sqrt(self.gamma_r) if self.known else math.nan


NO_SLOPES = Slopes(*[math.nan] * 6)


def agreed(
    found: Slopes,
    play: PlayFit | None,
    causes: Causes,
    noise_n: float = 0.0,
    span_n: float = math.inf,
    tells_n: float = 0.0,
    noise_in_n: float = 0.0,
) -> Slopes:
    """Return slopes on which phases and play operator agree; those of one where the other has none to show.

    Where an output creeps, or friction is no play, the line through a hold passes for a slope: then the two differ.

    Parameters
    ----------
    noise_n, tells_n : float
        White noise of the output, and the least that its readings tell (N).
    span_n : float
        Span of the input (N), of which the lines were seen over their reaches.
    noise_in_n : float
        White noise of the input (N).
    """
    if play is None or not play.explained > AGREED_EXPLAINED or not 0.0 < play.gamma_p < play.gamma_r:
        return NO_SLOPES
    # an output that rests goes along no line: rounding alone gives such a line a slope
    if not span_n * min(play.gamma_p * play.reaches[0], play.gamma_r * play.reaches[1]) > tells_n:
        return NO_SLOPES
    # both channels at rest on a line show nothing but the noise of the input
    if not span_n * min(play.reaches) > ACROSS * noise_in_n:
        return NO_SLOPES
    # lines seen over a small part of the loop are believed where they are those of friction, or leave noise only
    exact = play.delayed_rms_n < TO_NOISE * noise_n and min(play.reaches) > 0.5 * LEAST_REACH
    if min(play.reaches) < LEAST_REACH and not exact and abs(math.log(play.gamma_p * play.gamma_r)) > 2.0 * AGREED_APART:
        return NO_SLOPES
    if not _held(0.5 * math.log(play.gamma_r / play.gamma_p), causes):
        return NO_SLOPES
    if found.known and not _held(found.friction, causes):
        return NO_SLOPES
    if not _scaled(math.log(found.gain) if found.known else 0.5 * (math.log(play.gamma_p) + math.log(play.gamma_r)), causes):
        return NO_SLOPES
    if found.known:
        apart = (abs(math.log(a / b)) for a, b in ((found.gamma_p, play.gamma_p), (found.gamma_r, play.gamma_r)))
        return found if max(apart) < AGREED_APART else NO_SLOPES
    if min(play.shares) < AGREED_SHARE:
        return NO_SLOPES
    se = AGREED_APART / 4.0
    return Slopes(play.gamma_p, play.beta_p, play.gamma_r, play.beta_r, se * play.gamma_p, se * play.gamma_r)


def _held(wrap: float, causes: Causes) -> bool:
    """Whether the run goes along both lines: where the movement is smaller than the backlash, free lines are anything.

    Friction that leaves but noise is believed before them; else n theta must be that of friction with one slip at the most.
    """
    known = (causes.friction,) if causes.enough else causes.likely(APIECE)
    near = [c for c in known if abs(wrap - c.wrap) < max(HELD_LEAST, HELD * c.wrap)]
    return bool(near) or math.isnan(causes.friction.wrap)


def _scaled(gain: float, causes: Causes) -> bool:
    """Whether friction needs this gain (logarithm) as well: lines of presliding have one of their own."""
    return causes.enough or min(abs(gain), abs(gain - causes.gain.size)) < SCALED or math.isnan(causes.gain.size)
