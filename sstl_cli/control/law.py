"""The control law of Algorithm 1 as one compiled step; offline and streaming use both call it.

The parameters and the state are two flat float64 vectors, so that a step allocates nothing and
the exported C code can mirror it line by line.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# parameter vector; the relative widths of the plays of presliding follow at P_SHARES
P_GP, P_BP, P_GR, P_BR = 0, 1, 2, 3
P_COMPENSATE, P_DOUBLED, P_FOLLOW = 4, 5, 6
P_T_MAX, P_STEP_MAX, P_LOOP_GAIN, P_DEADBAND, P_BAND = 7, 8, 9, 10, 11
P_REF_LOW, P_REF_HIGH, P_IN_LOW, P_IN_HIGH = 12, 13, 14, 15
P_HOLD, P_RAMP = 16, 17
P_PLAYS, P_OBSERVER = 18, 19
P_SHARES = 20

# state vector; the output of each play of presliding follows at S_PLAY
S_AWAKE, S_STARTED, S_DIRECTION, S_EXTREME = 0, 1, 2, 3
S_BACKLASH, S_OUT_REV, S_THRESHOLD = 4, 5, 6
S_CMD, S_WISH, S_MODEL = 7, 8, 9
S_LOST, S_FAULT, S_RETURNING, S_AIM = 10, 11, 12, 13
S_PLAY = 14

PB, PP, RB, RP, SAFE = 0, 1, 2, 3, 4
REF_NOT_FINITE, REF_OUTSIDE, IN_NOT_FINITE, IN_OUTSIDE = 1, 2, 4, 8
SOLVE_TOLERANCE_N = 1e-12
SOLVE_STEPS = 80
# tensions this near to a threshold have reached it: backlash that ends where it began (turned twice at one measured tension) and a
# return by whole steps meet theirs exactly, and rounding, single precision's too, must not decide
SLACK_N = 1e-4


@njit(cache=True)
def fault_of(p: Array, t_ref: float, t_in: float) -> int:
    """Return the bits of what is wrong with a sample (0 is sound)."""
    fault = 0
    if not math.isfinite(t_ref):
        fault += REF_NOT_FINITE
    elif t_ref < p[P_REF_LOW] or t_ref > p[P_REF_HIGH]:
        fault += REF_OUTSIDE
    if not math.isfinite(t_in):
        fault += IN_NOT_FINITE
    elif t_in < p[P_IN_LOW] or t_in > p[P_IN_HIGH]:
        fault += IN_OUTSIDE
    return fault


@njit(cache=True)
def step(p: Array, s: Array, t_ref: float, t_in: float) -> tuple[float, int]:
    """Advance the controller by one sample (Algorithm 1, Phase II).

    Parameters
    ----------
    p, s : ndarray
        Parameter and state vector; the state is changed in place.
    t_ref : float
        Reference of the output tension in N.
    t_in : float
        Measured input tension in N, before the new command.

    Returns
    -------
    t_cmd : float
        Commanded input tension in N.
    phase : int
        PB, PP, RB, RP, or SAFE while an input is lost.
    """
    fault = fault_of(p, t_ref, t_in)
    s[S_FAULT] = fault
    if fault != 0:
        return _safe(p, s), SAFE
    s[S_LOST] = 0.0
    if s[S_AWAKE] == 0.0:
        # bounds on the command count from the tension that is there
        s[S_AWAKE] = 1.0
        s[S_CMD] = min(max(t_in, 0.0), p[P_T_MAX])
        s[S_WISH] = s[S_CMD]
        s[S_MODEL] = s[S_CMD]
        s[S_AIM] = s[S_CMD]
    # a modelled lag that is too long would overshoot every reversal: the measured tension corrects it
    s[S_MODEL] += p[P_OBSERVER] * (t_in - s[S_MODEL])
    turned = _direction(p, s, t_ref)
    if p[P_FOLLOW] != 0.0:
        phase = _follow(p, s, t_ref, t_in)
    else:
        phase = _algorithm_1(p, s, t_ref, t_in, turned)
    if p[P_COMPENSATE] == 0.0:
        s[S_WISH] = t_ref
    return _issue(p, s), phase


@njit(cache=True)
def _direction(p: Array, s: Array, t_ref: float) -> bool:
    """Follow the direction of the reference; True at a reversal. Flats keep the direction."""
    if s[S_STARTED] == 0.0:
        s[S_STARTED] = 1.0
        s[S_DIRECTION] = 0.0
        s[S_BACKLASH] = 0.0
        s[S_EXTREME] = t_ref
        # pre-pulled: every play stands on the pull line
        s[S_PLAY] = math.nan
        return False
    before = s[S_DIRECTION]
    if t_ref > s[S_EXTREME] + p[P_DEADBAND]:
        s[S_DIRECTION] = 1.0
    elif t_ref < s[S_EXTREME] - p[P_DEADBAND]:
        s[S_DIRECTION] = -1.0
    if s[S_DIRECTION] != before:
        s[S_EXTREME] = t_ref
    elif before > 0.0:
        s[S_EXTREME] = max(s[S_EXTREME], t_ref)
    elif before < 0.0:
        s[S_EXTREME] = min(s[S_EXTREME], t_ref)
    # the first direction is no reversal
    turned: bool = before != 0.0 and s[S_DIRECTION] != before
    return turned


@njit(cache=True)
def _algorithm_1(p: Array, s: Array, t_ref: float, t_in: float, turned: bool) -> int:
    """Set the wished input tension by the published rule, Eqs. (ff_cmd) to (bl_cmd2)."""
    release = s[S_DIRECTION] < 0.0
    gamma = p[P_GR] if release else p[P_GP]
    beta = p[P_BR] if release else p[P_BP]
    if turned:
        if s[S_BACKLASH] == 0.0:
            s[S_OUT_REV] = p[P_GP] * t_in + p[P_BP] if release else p[P_GR] * t_in + p[P_BR]
            s[S_BACKLASH] = 1.0
        # a reversal inside backlash keeps the held output and only turns round
        s[S_THRESHOLD] = (s[S_OUT_REV] - beta) / gamma
    if s[S_BACKLASH] != 0.0:
        # on the line, backlash is over
        reached = t_in <= s[S_THRESHOLD] + SLACK_N if release else t_in >= s[S_THRESHOLD] - SLACK_N
        if reached:
            s[S_BACKLASH] = 0.0
    target = t_ref
    if s[S_BACKLASH] != 0.0 and p[P_DOUBLED] != 0.0:
        target = 2.0 * t_ref - s[S_OUT_REV]
    s[S_WISH] = (target - beta) / gamma
    if release:
        return RB if s[S_BACKLASH] != 0.0 else RP
    return PB if s[S_BACKLASH] != 0.0 else PP


@njit(cache=True)
def _follow(p: Array, s: Array, t_ref: float, t_in: float) -> int:
    """Set the wished input tension by the exact inverse of the play, or of the plays of presliding."""
    plays = int(p[P_PLAYS])
    fresh = math.isnan(s[S_PLAY])
    release = s[S_DIRECTION] < 0.0
    output = 0.0
    settled = True
    for j in range(plays):
        c = p[P_SHARES + j]
        low = t_in + c * ((p[P_GP] - 1.0) * t_in + p[P_BP])
        high = t_in + c * ((p[P_GR] - 1.0) * t_in + p[P_BR])
        y = low if fresh else max(low, min(s[S_PLAY + j], high))
        s[S_PLAY + j] = y
        output += y
        settled = settled and y == (high if release else low)
    output /= plays
    band_up = p[P_BAND] if release else 0.0
    band_down = p[P_BAND] if s[S_DIRECTION] > 0.0 else 0.0
    if fresh or t_ref > output + band_up or t_ref < output - band_down:
        s[S_WISH] = _solve(p, s, t_ref, plays)
    if release:
        return RP if settled else RB
    return PP if settled else PB


@njit(cache=True)
def _solve(p: Array, s: Array, t_ref: float, plays: int) -> float:
    """Return the input tension at which the plays give the reference: Newton's rule inside a bracket."""
    lower, upper = 0.0, p[P_T_MAX]
    t: float = min(max(s[S_WISH], lower), upper)
    for _ in range(SOLVE_STEPS):
        y = 0.0
        slope = 0.0
        for j in range(plays):
            c = p[P_SHARES + j]
            low = t + c * ((p[P_GP] - 1.0) * t + p[P_BP])
            high = t + c * ((p[P_GR] - 1.0) * t + p[P_BR])
            held = s[S_PLAY + j]
            if held <= low:
                y += low
                slope += 1.0 + c * (p[P_GP] - 1.0)
            elif held >= high:
                y += high
                slope += 1.0 + c * (p[P_GR] - 1.0)
            else:
                y += held
        error = t_ref - y / plays
        if abs(error) <= SOLVE_TOLERANCE_N or upper - lower <= SOLVE_TOLERANCE_N:
            break
        if error > 0.0:
            lower = t
        else:
            upper = t
        middle = 0.5 * (lower + upper)
        t = t + error * plays / slope if slope > 0.0 else middle
        if not (t > lower and t < upper):
            t = middle
    return t


@njit(cache=True)
def _issue(p: Array, s: Array) -> float:
    """Return the command for the wished tension: loop-lag lead, range, and bounds on its change."""
    gain = p[P_LOOP_GAIN]
    command: float = s[S_WISH]
    if gain < 1.0 and p[P_COMPENSATE] != 0.0:
        # the modelled loop state, not the measured one: dividing by a small gain would amplify noise
        behind = s[S_AIM] - s[S_MODEL]
        lead = behind / gain
        if p[P_STEP_MAX] < math.inf:
            # no more lead than the bounded rate can take back before the wish is reached
            most = math.sqrt(2.0 * p[P_STEP_MAX] / gain * abs(behind))
            lead = min(max(lead, -most), most)
        command = s[S_MODEL] + lead + (s[S_WISH] - s[S_AIM]) / gain
    s[S_AIM] = s[S_WISH]
    command = min(max(command, 0.0), p[P_T_MAX])
    limit = p[P_STEP_MAX]
    if s[S_RETURNING] != 0.0:
        if abs(command - s[S_CMD]) <= p[P_RAMP] + SLACK_N:
            s[S_RETURNING] = 0.0
        else:
            limit = min(limit, p[P_RAMP])
    command = min(max(command, s[S_CMD] - limit), s[S_CMD] + limit)
    s[S_CMD] = command
    s[S_MODEL] += gain * (command - s[S_MODEL])
    return command


@njit(cache=True)
def _safe(p: Array, s: Array) -> float:
    """Return the safe command: hold the last one, then ramp down to zero."""
    s[S_LOST] += 1.0
    if s[S_LOST] > p[P_HOLD]:
        s[S_CMD] = max(s[S_CMD] - p[P_RAMP], 0.0)
        # where the tendon stands is no longer known: begin again with the next sound sample
        s[S_STARTED] = 0.0
    s[S_RETURNING] = s[S_AWAKE]
    command: float = s[S_CMD]
    s[S_MODEL] += p[P_LOOP_GAIN] * (command - s[S_MODEL])
    return command


class Loop(NamedTuple):
    """A tension loop: input tension before the first sample (N), gain, largest change (N) and dead time, all a sample.

    The gain is 1 - exp(-dt / tau) of the first-order loop.
    """

    start: float
    gain: float
    slew: float
    delay: int


@njit(cache=True)
def close_loop(p: Array, s: Array, t_ref: Array, noise: Array, loop: Loop, command: Array, t_in: Array, phase: NDArray[np.int8]) -> None:
    """Run the step against a tension loop; fills ``command``, ``t_in`` (true, N) and ``phase``.

    Parameters
    ----------
    noise : ndarray, shape (n,) or (0,)
        Noise of the input sensor in N.
    """
    x = loop.start
    for k in range(t_ref.size):
        seen = x + noise[k] if noise.size else x
        command[k], phase[k] = step(p, s, t_ref[k], seen)
        acting = command[k - loop.delay] if k >= loop.delay else loop.start
        x += min(max(loop.gain * (acting - x), -loop.slew), loop.slew)
        t_in[k] = x
