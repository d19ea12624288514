"""How late the tension loop follows its command, found from a recording of command and measured input tension.

Both are known at the proximal end, so no distal sensor is needed. The loop is first-order with a dead time,
tau dT_in/dt = T_cmd(t - d) - T_in, which is what the controller's lead inverts (Section VI: reversals).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from sstl_cli.control.controller import loop_gain
from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
#: the longest lag the controller's lead takes (s), and the shortest that a sample can show
LONGEST_S = 10.0
MOST_DELAY_S = 0.5
LEAST_SAMPLES = 50
#: a dead time is believed where it lowers the squared error by this share; else noise would set it
DELAY_PAYS = 0.05


@dataclass(frozen=True)
class LoopLag:
    """A tension loop as found: time constant and its standard error (s), dead time (s), RMS of what is left (N)."""

    tau_s: float
    error_s: float
    delay_s: float
    rms_n: float


def identify(command_n: Array, measured_n: Array, dt_s: float) -> LoopLag:
    """Return the lag of a tension loop from its command and the measured input tension (N, shape (n,) each).

    The loop is simulated from the command and compared with the measurement; differences of the measurement would
    carry its noise twice and make the loop look faster than it is.

    Raises
    ------
    SstlError
        E416 for fewer than 50 samples, values that are not finite, or a command that does not move.
    """
    command, measured = (np.asarray(v, dtype=np.float64) for v in (command_n, measured_n))
    if len(command) != len(measured) or len(command) < LEAST_SAMPLES or not np.isfinite(command + measured).all():
        raise SstlError(
            f"the lag of a loop needs {LEAST_SAMPLES} finite samples of command and tension",
            fix="record longer, or without gaps",
            code="E416",
        )
    if float(np.ptp(command)) == 0.0:
        raise SstlError("the command does not move, so its loop shows no lag", fix="record a movement", code="E416")
    tau, squared, delay = _with_delay(command, measured, dt_s)
    variance = squared / len(command)
    step = max(1e-3 * tau, 1e-6)
    slope = (followed(command, dt_s, tau + step, delay, measured[0]) - followed(command, dt_s, tau, delay, measured[0])) / step
    error = float(np.sqrt(variance / np.sum(slope**2))) if np.any(slope) else float("inf")
    return LoopLag(tau, error, delay * dt_s, float(np.sqrt(variance)))


def followed(command_n: Array, dt_s: float, tau_s: float, delay: int, start_n: float) -> Array:
    """Return the tension (N) of a first-order loop behind a dead time of ``delay`` samples, from ``start_n`` on."""
    late = np.concatenate([np.full(delay, command_n[0]), command_n[: len(command_n) - delay]])
    gain = loop_gain(dt_s, tau_s)
    return np.asarray(lfilter([gain], [1.0, gain - 1.0], late, zi=[(1.0 - gain) * start_n])[0])


def _with_delay(command: Array, measured: Array, dt_s: float) -> tuple[float, float, int]:
    """Return time constant (s), squared error (N^2) and dead time (samples): sought on a wide grid, then between its points."""
    without = _fitted(command, measured, dt_s, 0)
    most = max(min(round(MOST_DELAY_S / dt_s), len(command) // 2), 2)
    grid = [0, *np.unique(np.round(np.geomspace(1, most, 20)).astype(int)).tolist()]
    tried = {d: _fitted(command, measured, dt_s, d) if d else without for d in grid}
    near = grid.index(min(tried, key=lambda d: tried[d][1]))
    for d in range(grid[max(near - 1, 0)], grid[min(near + 1, len(grid) - 1)] + 1):
        if d not in tried:
            tried[d] = _fitted(command, measured, dt_s, d)
    best = min(tried.values(), key=lambda fit: fit[1])
    return best if best[1] < (1.0 - DELAY_PAYS) * without[1] else without


def _fitted(command: Array, measured: Array, dt_s: float, delay: int) -> tuple[float, float, int]:
    """Return the time constant (s) that fits best behind a dead time, its squared error (N^2), and the dead time."""

    def squared(log_tau: float) -> float:
        return float(np.sum((followed(command, dt_s, float(np.exp(log_tau)), delay, measured[0]) - measured) ** 2))

    found = minimize_scalar(squared, bounds=(np.log(0.1 * dt_s), np.log(LONGEST_S)), method="bounded", options={"xatol": 1e-6})
    return float(np.exp(found.x)), float(found.fun), delay
