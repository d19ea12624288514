"""The two sets of settings under which Table IV is rebuilt: as the paper states them, and as its numbers ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from sstl_cli.control.controller import Theta

LOCATIONS = ("NP", "CP", "ND")
METHODS = ("none", "no-bias", "DI", "proposed")
TRAJECTORIES = ("sinusoid", "random")


@dataclass(frozen=True)
class Settings:
    """What Table IV was measured under.

    Parameters
    ----------
    offset_n, amplitude_n : float
        Sinusoidal reference (N).
    random_n : mapping
        Range of the random reference by location (N).
    lines : Theta, optional
        Lines of the plant at every location; by default those of each configuration.
    lag_s : float
        Time constant of the tension loop.
    mismatch : float
        Friction (rad) by which the plant exceeds what was identified, so that both lines are wider open.
    """

    name: str
    title: str
    offset_n: float = 10.0
    amplitude_n: float = 5.0
    random_n: Mapping[str, tuple[float, float]] = field(default_factory=lambda: dict.fromkeys(LOCATIONS, (5.0, 30.0)))
    lines: Theta | None = None
    lag_s: float = 0.0
    mismatch: float = 0.0


STATED = Settings("stated", "settings as the paper states them")
# The sinusoid, lines and lag are those that bring the rows without compensation and without bias to the printed
# values; the random ranges bring RMSE, STD and MAPE of the uncompensated row nearest at each location (grid of
# 0.5-8 N by 14-40 N); the mismatch gives direct identification its printed error on the sinusoid.
FITTED = Settings(
    "fitted",
    "settings fitted to Table IV",
    8.1,
    6.0,
    {"NP": (1.0, 34.0), "CP": (3.0, 32.0), "ND": (4.0, 20.0)},
    Theta(0.55, -2.8, 1.74, -1.45),
    0.3,
    0.035,
)
# parts of the fit that can be switched off one at a time
PARTS = {"reference": ("offset_n", "amplitude_n", "random_n"), "lines": ("lines",), "loop lag": ("lag_s",), "mismatch": ("mismatch",)}


def fitted_values() -> tuple[tuple[str, float], ...]:
    """Return the 14 numbers that were fitted, with their names and units."""
    assert FITTED.lines is not None
    lines = FITTED.lines
    return (
        ("sinusoid offset N", FITTED.offset_n),
        ("sinusoid amplitude N", FITTED.amplitude_n),
        *((f"random {side} {place} N", FITTED.random_n[place][i]) for place in LOCATIONS for i, side in enumerate(("low", "high"))),
        ("Gamma_p", lines.gamma_p),
        ("beta_p N", lines.beta_p),
        ("Gamma_r", lines.gamma_r),
        ("beta_r N", lines.beta_r),
        ("loop lag s", FITTED.lag_s),
        ("mismatch rad", FITTED.mismatch),
    )


def partly(parts: tuple[str, ...]) -> Settings:
    """Return the stated settings with only some parts of the fit switched on."""
    values = {name: getattr(FITTED, name) for part in parts for name in PARTS[part]}
    return replace(STATED, name="+".join(parts) or STATED.name, title=", ".join(parts) or STATED.title, **values)
