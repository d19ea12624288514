"""The two Kalman filters of a diagnosis and its smoother by statsmodels: the same models, written as matrices that vary in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from statsmodels.tsa.statespace.kalman_smoother import (
    SMOOTHER_DISTURBANCE,
    SMOOTHER_DISTURBANCE_COV,
    SMOOTHER_STATE,
    SMOOTHER_STATE_AUTOCOV,
    SMOOTHER_STATE_COV,
    KalmanSmoother,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# what a smoother of the input is asked for: states, their errors, and the steps with theirs
SMOOTHED = SMOOTHER_STATE | SMOOTHER_STATE_COV | SMOOTHER_DISTURBANCE | SMOOTHER_DISTURBANCE_COV
TURNS = SMOOTHED | SMOOTHER_STATE_AUTOCOV
# mean square of a corner within its step, and what is known before the first reading (see sstl_cli/diagnosis/smoother.py)
PART, DIFFUSE = 5.0 / 12.0, 1e6


@dataclass(frozen=True)
class Smoothed:
    """States (n, 4), variance of the value (n,), and steps of increment and change: squared means and variances (n - 1, 4)."""

    mean: Array
    variance: Array
    steps: Array


class Input:
    """The latent input: value, increment, change of that, slow noise of the sensor; both kinds of steps have variances of their own.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Readings.
    use : ndarray of bool, shape (n,)
        False where a reading says nothing.
    noise : (float, float, float)
        Variance of the white noise, of the slow one, and what a sample keeps of the latter.
    """

    def __init__(self, y: Array, use: Mask, noise: tuple[float, float, float]) -> None:
        white, slow, memory = noise
        self.fresh = slow * (1.0 - memory**2)
        # all in one pass, one reading at a time: the fastest of the library's ways for a single series
        self.model = KalmanSmoother(k_endog=1, k_states=4, filter_univariate=True)
        self.model.bind(np.where(use, y, np.nan))
        move = np.eye(4)
        move[0, 1], move[0, 2], move[1, 2], move[3, 3] = 1.0, 0.5, 1.0, memory
        self.model["transition"] = move
        self.model["selection"] = np.eye(4)
        self.model["design"] = np.array([[1.0, 0.0, 0.0, 1.0]])
        self.model["obs_cov"] = np.array([[white]])
        self.model.initialize_known(np.zeros(4), np.diag([DIFFUSE * white] * 3 + [slow]))

    def given(self, corners: Array, bends: Array) -> Any:
        """Return the model with variances of its steps, shape (n,) each."""
        n = len(corners)
        fresh = np.zeros((4, 4, n))
        # the library's entry k leads from sample k to the next one
        c, b = corners[1:], bends[1:]
        fresh[0, 0, :-1], fresh[0, 1, :-1], fresh[1, 0, :-1], fresh[1, 1, :-1], fresh[2, 2, :-1] = PART * c, 0.5 * c, 0.5 * c, c, b
        fresh[3, 3, :-1] = self.fresh
        self.model["state_cov"] = fresh
        return self.model

    def log_likelihood(self, corners: Array, bends: Array) -> float:
        return float(self.given(corners, bends).loglike())

    def smoothed(self, corners: Array, bends: Array) -> Smoothed:
        found = self.given(corners, bends).smooth(smoother_output=SMOOTHED)
        way, error = found.smoothed_state_disturbance, found.smoothed_state_disturbance_cov
        steps = np.stack((way[1] ** 2, error[1, 1], way[2] ** 2, error[2, 2]), axis=1)[:-1]
        return Smoothed(found.smoothed_state.T, found.smoothed_state_cov[0, 0], steps)

    def across(self, corners: Array, bends: Array) -> tuple[Array, Array]:
        """Return the covariance of each state (n, 4, 4), and of each with the one before (n - 1, 4, 4), given all readings."""
        found = self.given(corners, bends).smooth(smoother_output=TURNS)
        return np.moveaxis(found.smoothed_state_cov, 2, 0), np.moveaxis(found.smoothed_state_autocov, 2, 0)[:-1]


class Output:
    """The residual of a line whose phases are given: error of the input, what the line holds of it, coloured noise, and the reading.

    The reading is a state too: what is new in it is new in the others as well. Columns are those of ``Constants`` and ``Phases``.
    """

    def __init__(self, law: Array, own: Array, phases: Array, sensor: tuple[Array, Array, Mask, Mask]) -> None:
        white_n, start, keep, first = sensor
        n = len(law)
        self.keep = keep
        move, fresh = np.zeros((n, 7, 7)), np.zeros((n, 7, 7))
        slide, left, gain = phases[:, 0], phases[:, 1], phases[:, 2]
        shares = np.zeros((n, 7, 2))
        # what enters with the input's error, by its mean over the step: what is held after it, and the reading
        shares[:, 4, 0], shares[:, 6, 0] = left * gain, slide * gain
        shares[:, 4, 1], shares[:, 6, 1] = 1.0 - left, 1.0 - slide
        move[:, :4, :4] = law[:, :16].reshape(n, 4, 4)
        move[:, :, :4] += shares[:, :, :1] * law[:, None, 16:20]
        # before a record the line holds what was read there
        move[:, :, 4] = np.where(first[:, None], 0.0, shares[:, :, 1])
        move[:, 5, 5], move[:, 6, 5] = np.where(first, 0.0, own[:, 0]), np.where(first, 0.0, own[:, 2])
        upper = np.triu_indices(4)
        fresh[:, upper[0], upper[1]] = fresh[:, upper[1], upper[0]] = law[:, 20:30]
        into = shares[:, :, 0]
        both = np.zeros((n, 7))
        both[:, :4] = law[:, 30:34]
        fresh += into[:, :, None] * both[:, None, :] + both[:, :, None] * into[:, None, :]
        fresh += law[:, 34, None, None] * into[:, :, None] * into[:, None, :]
        fresh += _held(shares[:, :, 1], start + gain**2 * law[:, 34], first)
        fresh += _slips(phases, law[:, 35], first)
        fresh[:, 5, 5] += own[:, 1]
        fresh[:, 5, 6] += own[:, 3]
        fresh[:, 6, 5] += own[:, 3]
        fresh[:, 6, 6] += own[:, 4]
        # the library's entry k leads from sample k to the next one, and the first sample has a covariance of its own
        self.matrices = {
            "transition": np.asfortranarray(np.moveaxis(np.roll(move, -1, axis=0), 0, 2)),
            "state_cov": np.asfortranarray(np.moveaxis(np.roll(fresh, -1, axis=0), 0, 2)),
            "selection": np.eye(7),
            "design": np.eye(7)[6:],
            "obs_cov": (white_n**2)[None, None],
        }
        self.first = fresh[0]

    def log_likelihood(self, residual: Array) -> float:
        """Return the log likelihood of a residual, shape (n,)."""
        return float(self._of(residual).loglike())

    def _of(self, column: Array) -> Any:
        # one that has filtered keeps its readings whatever it is bound to afterwards (statsmodels 0.15): each gets a model of its own
        model = KalmanSmoother(k_endog=1, k_states=7, filter_univariate=True)
        model.bind(np.where(self.keep, column, np.nan))
        for name, matrix in self.matrices.items():
            model[name] = matrix
        model.initialize_known(np.zeros(7), self.first)
        return model

    def whitened(self, columns: Array) -> Array:
        """Return innovations over their standard deviations, shape (n, k): the library takes one column at a time."""
        out = np.zeros_like(columns)
        for j in range(columns.shape[1]):
            found = self._of(columns[:, j]).filter()
            out[:, j] = np.where(self.keep, found.forecasts_error[0] / np.sqrt(found.forecasts_error_cov[0, 0]), 0.0)
        return out


def _held(shares: Array, before: Array, first: Mask) -> Array:
    """Return the covariance that a line has at the beginning of a record by what it held before, shape (n, 7, 7)."""
    return np.where(first, before, 0.0)[:, None, None] * shares[:, :, None] * shares[:, None, :]


def _slips(phases: Array, turn: Array, first: Mask) -> Array:
    """Return what slips and slides that end leave, which the reading has as well as what is held, shape (n, 7, 7)."""
    slide, gain, slipped = phases[:, 0], phases[:, 2], phases[:, 3] ** 2 + phases[:, 4] ** 2
    earlier, ended = np.roll(slide, 1), np.roll(slipped, 1)
    left = np.maximum(slipped - (1.0 - slide) ** 2 * ended, 0.0)
    ends = slide < earlier
    share = np.divide(slide, earlier, out=np.ones_like(slide), where=ends)
    left += np.where(ends, (1.0 - share) * np.roll(gain, 1) ** 2 * np.roll(turn, 1), 0.0)
    out = np.zeros((len(slide), 7, 7))
    out[:, 4:7:2, 4:7:2] = np.where(first, slipped, left)[:, None, None]
    return out
