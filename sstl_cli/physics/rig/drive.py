"""What pulls at the input end: a tension, a position, or a motor under a PID tension loop."""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TENSION, POSITION, LOOP = 0, 1, 2
DRIVE_CODES = {"tension": TENSION, "position": POSITION, "loop": LOOP}

# Entries of the motor state array.
MOTOR_MM, INTEGRAL_MM, LAST_ERROR_N = 0, 1, 2


class Motor(NamedTuple):
    """PID gains (mm/N, mm/(N s), mm s/N) and motor time constant (s)."""

    kp: float
    ki: float
    kd: float
    lag_s: float


@njit(cache=True)
def loop_line(motor: Motor, state: FloatArray, command: float, dt: float) -> tuple[float, float]:
    """Motor position at the end of the step as x = a - g T_in: the PID and the motor lag, taken implicitly.

    Taken implicitly the loop is a spring in series with the tendon, stable however stiff the stuck tendon is.
    """
    share = 1.0 if motor.lag_s == 0.0 else 1.0 - exp(-dt / motor.lag_s)
    gain = motor.kp + motor.ki * dt + motor.kd / dt
    goal = gain * command + state[INTEGRAL_MM] - motor.kd / dt * state[LAST_ERROR_N]
    a = state[MOTOR_MM] + share * (goal - state[MOTOR_MM])
    return a, share * gain


@njit(cache=True)
def loop_commit(motor: Motor, state: FloatArray, command: float, tension: float, position: float, dt: float) -> None:
    """Carry the motor position, the integral and the last error over the step just solved."""
    error = command - tension
    state[MOTOR_MM] = position
    state[INTEGRAL_MM] += motor.ki * dt * error
    state[LAST_ERROR_N] = error
