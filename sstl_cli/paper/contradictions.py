"""Where the published tables contradict one another, worked out from the numbers themselves."""

from __future__ import annotations

import math
from collections.abc import Mapping

Key = tuple[str, str, str]
OFFSET_N, AMPLITUDE_N = 10.0, 5.0
LOCATIONS = ("NP", "CP", "ND")
METHODS = ("none", "no-bias", "DI", "proposed")


def find(numbers: Mapping[Key, float]) -> dict[Key, str]:
    """Return, for every published number that another one excludes, the reason."""
    return {**regression(numbers), **mape(numbers), **bias_free(numbers)}


def regression(numbers: Mapping[Key, float]) -> dict[Key, str]:
    """Return the fits of Table I that miss the means of Table II by more than rounding allows.

    A least-squares line passes through the means: a mean(x) + b = mean(y), with mean(x) = mean(Gamma)^2 + std^2.
    """
    found: dict[Key, str] = {}
    for row, symbol in (("pull", "gamma_p"), ("release", "gamma_r")):
        mean, std = numbers["II", f"act_{symbol}", "mean"], numbers["II", f"act_{symbol}", "std"]
        # 39/40: the printed std may be that of the sample
        squares = [mean**2 + std**2, mean**2 + std**2 * 39 / 40]
        slope, bias = numbers["I", row, "slope"], numbers["I", row, "bias"]
        target = numbers["II", f"sstl_{symbol}", "mean"]
        off = [slope * s + bias - target for s in squares]
        half = 0.0005
        margin = half * (max(squares) + 1 + 1 + 2 * slope * (mean + std))
        worst = min(off, key=abs)
        if abs(worst) > margin:
            text = (
                f"a least-squares line passes through the means, but {slope:g} x mean(act^2) {bias:+g} "
                f"misses Table II's "
                f"{target:g} by {worst:+.4f} (rounding explains {margin:.4f})"
            )
            found["I", row, "slope"] = found["I", row, "bias"] = text
    return found


def rms_inverse(offset: float = OFFSET_N, amplitude: float = AMPLITUDE_N) -> float:
    """Return rms(1/T) (1/N) over a cycle of T = o + a sin: sqrt(o) / (o^2 - a^2)^(3/4)."""
    found: float = math.sqrt(offset) / (offset**2 - amplitude**2) ** 0.75
    return found


def mape(numbers: Mapping[Key, float]) -> dict[Key, str]:
    """Return the sinusoidal MAPE entries above the bound MAPE <= RMSE rms(1/T_ref), by Cauchy and Schwarz."""
    found: dict[Key, str] = {}
    for method in METHODS:
        for place in LOCATIONS:
            row = f"sinusoid {method}"
            bound = 100.0 * (numbers["IV", row, f"rmse_{place}"] + 0.005) * rms_inverse()
            if numbers["IV", row, f"mape_{place}"] - 0.005 > bound:
                found["IV", row, f"mape_{place}"] = f"MAPE cannot exceed RMSE x rms(1/T_ref) = {bound:.2f} % for a 10 +- 5 N reference"
    return found


def bias_free(numbers: Mapping[Key, float]) -> dict[Key, str]:
    """Return the w/o-bias entries whose mean error cannot come from the biases of Section III-C3.

    Leaving the bias out of an otherwise exact inverse makes the output err by beta itself, so the mean
    error is that of beta_p and beta_r, whatever the slopes.
    """
    found: dict[Key, str] = {}
    most = max(abs(numbers["bias", f"act_beta_{d}", "mean"]) + 2 * numbers["bias", f"act_beta_{d}", "std"] for d in "pr")
    mean = 0.5 * abs(sum(numbers["bias", f"act_beta_{d}", "mean"] for d in "pr"))
    for place in LOCATIONS:
        row = "sinusoid no-bias"
        rmse, std = numbers["IV", row, f"rmse_{place}"], numbers["IV", row, f"std_{place}"]
        error = math.sqrt(max(rmse**2 - std**2, 0.0))
        if error > most:
            text = f"its mean error of {error:.2f} N cannot come from Section III-C3's biases, which give {mean:.2f} N"
            found["IV", row, f"rmse_{place}"] = found["IV", row, f"red_{place}"] = text
    return found
