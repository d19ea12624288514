"""The feedforward controller: parameters, options, and the object that answers sample by sample."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from sstl_cli.control import law, offline
from sstl_cli.core.config import Model
from sstl_cli.core.errors import SstlError
from sstl_cli.core.sound import FASTEST_S, LARGEST

Array = NDArray[np.float64]
PHASES = ("PB", "PP", "RB", "RP", "SAFE")
METHODS = ("none", "no-bias", "proposed", "DI")
PLAYS = 8
FAULTS = (
    (law.REF_NOT_FINITE, "reference lost (not a number)"),
    (law.REF_OUTSIDE, "reference out of range"),
    (law.IN_NOT_FINITE, "measured tension lost (not a number)"),
    (law.IN_OUTSIDE, "measured tension out of range"),
)
Positive = Annotated[float, Field(gt=0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST)]
# a day: no controller acts more seldom
LONGEST_S = 86400.0
Width = Annotated[float, Field(ge=0, le=100)]


@dataclass(frozen=True)
class Theta:
    """Propagation lines of one configuration: slopes and biases (N), Eq. (linear_model).

    Raises
    ------
    SstlError
        If a value is not finite, a slope is not positive, or the pull line is the steeper one.
    """

    gamma_p: float
    beta_p: float
    gamma_r: float
    beta_r: float

    def __post_init__(self) -> None:
        values = (self.gamma_p, self.beta_p, self.gamma_r, self.beta_r)
        if not all(abs(v) <= LARGEST for v in values) or self.gamma_p <= 0 or self.gamma_r <= 0:
            raise SstlError(f"propagation lines {values} are not finite, below {LARGEST:.0e}, with positive slopes", code="E401")
        if self.gamma_p > self.gamma_r:
            raise SstlError(
                f"pull slope {self.gamma_p:g} is above the release slope {self.gamma_r:g}",
                fix="check that tension_in and tension_out are not exchanged",
                code="E402",
            )

    def without_bias(self) -> Theta:
        """Return the lines through the origin: beta is zero in commands, thresholds and T_out_rev alike."""
        return Theta(self.gamma_p, 0.0, self.gamma_r, 0.0)

    def pull(self, tension_n: float) -> float:
        """Return the output tension in N on the pull line."""
        return self.gamma_p * tension_n + self.beta_p


IDENTITY = Theta(1.0, 0.0, 1.0, 0.0)


class Options(Model):
    """How the controller acts; tensions in N, times in s.

    ``reversal``: ``paper`` is Algorithm 1; ``play`` inverts the play exactly (in backlash straight to the
    threshold of the next line), and with ``presliding`` > 0 the plays of a rounded loop, spread evenly;
    ``observer`` is the share of the difference between the measured and the modelled tension by which the
    state behind ``lead_s`` is corrected at each sample: more bears a wrong lag, less bears noise.
    ``widths`` gives their relative widths instead, as fitted by :func:`sstl_cli.control.presliding.fit_widths`.
    """

    dt_s: Annotated[float, Field(ge=FASTEST_S, le=LONGEST_S)] = 0.002
    doubled: bool = True
    t_max_n: Positive = 80.0
    max_rate_n_s: Positive | None = None
    max_jump_n: Positive | None = None
    lead_s: Annotated[float, Field(ge=0, le=10)] = 0.0
    observer: Annotated[float, Field(ge=0, le=1)] = 0.2
    reversal: Literal["paper", "play"] = "paper"
    presliding: Annotated[float, Field(ge=0, le=1)] = 0.0
    widths: Annotated[tuple[Width, ...], Field(min_length=1, max_length=64)] | None = None
    band_n: NotNegative = 0.2
    deadband_n: NotNegative = 0.0
    tolerance_n: NotNegative = 1.0
    hold_s: NotNegative = 0.1
    ramp_n_s: Positive = 10.0

    def step_limit_n(self) -> float:
        """Return the largest change of the command in one sample in N (infinite without bounds)."""
        rate = math.inf if self.max_rate_n_s is None else self.max_rate_n_s * self.dt_s
        return min(rate, math.inf if self.max_jump_n is None else self.max_jump_n)

    def bounded(self) -> bool:
        """Tell whether the rate or the jump of the command is bounded."""
        return math.isfinite(self.step_limit_n())

    def unbounded(self) -> Options:
        """Return the same options without bounds on rate and jump."""
        return self.model_copy(update={"max_rate_n_s": None, "max_jump_n": None})

    def shares(self) -> Array:
        """Return the relative widths of the plays that the inverse follows (mean 1)."""
        if self.reversal == "paper" or (self.widths is None and self.presliding <= 0.0):
            return np.ones(1)
        if self.widths is not None:
            return normalised(np.array(self.widths, dtype=np.float64))
        quantiles = (np.arange(PLAYS) + 0.5) / PLAYS * 2.0 - 1.0
        return np.asarray(1.0 + self.presliding * quantiles)


def normalised(widths: Array) -> Array:
    """Return relative widths scaled to mean 1, so that full sliding lies on the propagation lines."""
    mean = float(widths.mean())
    if not mean > 0.0:
        raise SstlError("the widths of the plays are all zero", fix="give at least one above 0", code="E403")
    return widths / mean


def pack(theta: Theta, options: Options, compensate: bool = True) -> Array:
    """Return the parameter vector of :mod:`sstl_cli.control.law`, shape (20 + number of plays,)."""
    shares = options.shares()
    if theta.gamma_p < 1.0 and 1.0 + float(shares.max()) * (theta.gamma_p - 1.0) <= 0.0:
        raise SstlError(
            f"the widest play of presliding needs a pull slope above {1 - 1 / float(shares.max()):.3g}, found {theta.gamma_p:g}",
            fix="lower --presliding",
            code="E403",
        )
    p = np.zeros(law.P_SHARES + len(shares))
    p[:4] = theta.gamma_p, theta.beta_p, theta.gamma_r, theta.beta_r
    p[law.P_COMPENSATE] = compensate
    p[law.P_DOUBLED] = options.doubled
    p[law.P_FOLLOW] = options.reversal == "play"
    p[law.P_T_MAX] = options.t_max_n
    p[law.P_STEP_MAX] = options.step_limit_n()
    p[law.P_LOOP_GAIN] = loop_gain(options.dt_s, options.lead_s)
    p[law.P_DEADBAND], p[law.P_BAND] = options.deadband_n, options.band_n
    p[law.P_REF_LOW], p[law.P_REF_HIGH] = -options.tolerance_n, options.t_max_n + options.tolerance_n
    p[law.P_IN_LOW], p[law.P_IN_HIGH] = -options.tolerance_n, 1.25 * options.t_max_n + options.tolerance_n
    p[law.P_HOLD] = round(options.hold_s / options.dt_s)
    p[law.P_RAMP] = min(options.ramp_n_s * options.dt_s, options.step_limit_n())
    p[law.P_PLAYS] = len(shares)
    p[law.P_OBSERVER] = options.observer if options.lead_s > 0.0 else 0.0
    p[law.P_SHARES :] = shares
    return p


def loop_gain(dt_s: float, tau_s: float) -> float:
    """Return 1 - exp(-dt / tau), the share of the way a first-order loop goes in one sample."""
    return -math.expm1(-dt_s / tau_s) if tau_s > 0.0 else 1.0


class Controller:
    """Algorithm 1 for one configuration, sample by sample; offline runs call the same compiled step.

    Parameters
    ----------
    theta : Theta
        Propagation lines of the actuation tendon (already without bias for the method ``no-bias``).
    options : Options
        How to act.
    compensate : bool
        False commands the reference itself (the method ``none``); phases are still reported.

    Examples
    --------
    >>> c = Controller(Theta(0.5, -1.0, 2.0, -1.0))
    >>> c.step(9.0, 20.0)
    (20.0, 'PP')
    """

    def __init__(self, theta: Theta, options: Options | None = None, compensate: bool = True) -> None:
        self.theta, self.options, self.compensate = theta, options or Options(), compensate
        self.vector = pack(theta, self.options, compensate)
        self.state = new_state(self.vector)

    def reset(self) -> None:
        """Forget everything; the next sample is the first."""
        self.state[:] = 0.0

    def step(self, t_ref: float, t_in: float) -> tuple[float, str]:
        """Return the commanded tension (N) and the phase for one reference and measured tension (N)."""
        command, phase = law.step(self.vector, self.state, t_ref, t_in)
        return command, PHASES[phase]

    @property
    def fault(self) -> str:
        """What is wrong with the last sample; empty if nothing is."""
        return fault_text(int(self.state[law.S_FAULT]))

    def rest_tension(self, t_ref: float) -> float:
        """Return the input tension (N) that puts a tendon pulled from rest onto the reference."""
        wish = (t_ref - self.theta.beta_p) / self.theta.gamma_p if self.compensate else t_ref
        return min(max(wish, 0.0), self.options.t_max_n)

    def replay(self, t_ref: Array, t_in: Array) -> tuple[Array, NDArray[np.int8]]:
        """Return commands (N) and phase codes, shape (n,) each, for a recorded input tension."""
        command, phase = np.empty(len(t_ref)), np.empty(len(t_ref), np.int8)
        offline.replay(self.vector, self.state, _contiguous(t_ref), _contiguous(t_in), command, phase)
        return command, phase


def new_state(vector: Array) -> Array:
    """Return the state vector that belongs to a parameter vector, at rest."""
    return np.zeros(law.S_PLAY + int(vector[law.P_PLAYS]))


def fault_text(bits: int) -> str:
    """Return the reasons behind the bits of a fault."""
    return "; ".join(text for bit, text in FAULTS if bits & bit)


def _contiguous(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)
