"""The play recursion of Eqs. (3) and (5) in plain Python."""

from __future__ import annotations


def play(tension: list[float], gamma_p: float, gamma_r: float, start: float) -> list[float]:
    """Return the output tension (N) sample by sample."""
    out = []
    y = start
    for t in tension:
        y = min(max(y, gamma_p * t), gamma_r * t)
        out.append(y)
    return out
