"""The controller over a recorded input tension: the law's step, and a quicker way for what is most of a recording.

The step keeps its state in memory, as the exported C code does, and looks after lead, bounds and lost input at each
sample. Algorithm 1 without these keeps its state in registers here. Every operation is that of the step in the same
order, so the results are the same to the last bit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.control import law

Array = NDArray[np.float64]
Codes = NDArray[np.int8]


@njit(cache=True, nogil=True)
def replay(p: Array, s: Array, t_ref: Array, t_in: Array, command: Array, phase: Codes) -> None:
    """Run the step over a recorded input tension; fills ``command`` and ``phase``.

    Parameters
    ----------
    p, s : ndarray
        Parameter and state vector of :mod:`sstl_cli.control.law`; the state is changed in place.
    t_ref, t_in : ndarray, shape (n,)
        Reference of the output tension and measured input tension in N.
    command, phase : ndarray, shape (n,)
        Commanded input tension in N and phase codes, overwritten.
    """
    plain = (
        p[law.P_FOLLOW] == 0.0
        and p[law.P_COMPENSATE] != 0.0
        and p[law.P_LOOP_GAIN] == 1.0
        and p[law.P_OBSERVER] == 0.0
        and p[law.P_STEP_MAX] == math.inf
    )
    k = 0
    while k < t_ref.size:
        if plain and s[law.S_AWAKE] != 0.0 and s[law.S_STARTED] != 0.0 and s[law.S_RETURNING] == 0.0:
            k = _sound(p, s, t_ref, t_in, command, phase, k)
            if k == t_ref.size:
                return
        command[k], phase[k] = law.step(p, s, t_ref[k], t_in[k])
        k += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _sound(p: Array, s: Array, t_ref: Array, t_in: Array, command: Array, phase: Codes, k: int) -> int:
    """Run Algorithm 1 from sample k up to the first faulty one; return where that is (n if there is none)."""
    gp, bp, gr, br = p[law.P_GP], p[law.P_BP], p[law.P_GR], p[law.P_BR]
    doubled, t_max, deadband = p[law.P_DOUBLED] != 0.0, p[law.P_T_MAX], p[law.P_DEADBAND]
    ref_low, ref_high, in_low, in_high = p[law.P_REF_LOW], p[law.P_REF_HIGH], p[law.P_IN_LOW], p[law.P_IN_HIGH]
    direction, extreme = s[law.S_DIRECTION], s[law.S_EXTREME]
    backlash, held, threshold = s[law.S_BACKLASH] != 0.0, s[law.S_OUT_REV], s[law.S_THRESHOLD]
    last, wish, model = s[law.S_CMD], s[law.S_WISH], s[law.S_MODEL]
    begun = k
    n = t_ref.size
    while k < n:
        ref, tension = t_ref[k], t_in[k]
        # false for what is not a number, as the ranges are finite
        if not (ref >= ref_low and ref <= ref_high and tension >= in_low and tension <= in_high):
            break
        before = direction
        if ref > extreme + deadband:
            direction = 1.0
        elif ref < extreme - deadband:
            direction = -1.0
        if direction != before:
            extreme = ref
        elif before > 0.0:
            extreme = max(extreme, ref)
        elif before < 0.0:
            extreme = min(extreme, ref)
        release = direction < 0.0
        gamma, beta = (gr, br) if release else (gp, bp)
        if before != 0.0 and direction != before:
            if not backlash:
                held = gp * tension + bp if release else gr * tension + br
                backlash = True
            threshold = (held - beta) / gamma
        if backlash and (tension <= threshold + law.SLACK_N if release else tension >= threshold - law.SLACK_N):
            backlash = False
        target = 2.0 * ref - held if backlash and doubled else ref
        wish = (target - beta) / gamma
        last = min(max(wish, 0.0), t_max)
        model += last - model
        command[k] = last
        phase[k] = (law.RB if backlash else law.RP) if release else (law.PB if backlash else law.PP)
        k += 1
    if k > begun:
        s[law.S_FAULT], s[law.S_LOST] = 0.0, 0.0
        s[law.S_DIRECTION], s[law.S_EXTREME] = direction, extreme
        s[law.S_BACKLASH], s[law.S_OUT_REV], s[law.S_THRESHOLD] = 1.0 if backlash else 0.0, held, threshold
        s[law.S_CMD], s[law.S_WISH], s[law.S_AIM], s[law.S_MODEL] = last, wish, wish, model
    return k
