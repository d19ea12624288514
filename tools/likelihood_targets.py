"""What was asked of the likelihood beside what was measured: the first table of docs/likelihood.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from page_part import table
from scipy.stats import binom, chi2

OFF, LAG, SAMPLES, KEPT = 0.02, 0.02, 20_000, 0.95
RATIO = (1.0, 1.3)
BEYOND = 0.05
# chance brings one candidate of twenty beyond its own 95 % point: a count is judged at 5 % for all candidates together
FAMILY = 0.05
# a mean is biased where it is further from nothing than this many standard errors
SURE = 1.96
# strengths of a refitted effect: of one sensor, or of both
STRENGTHS = 2


@dataclass(frozen=True)
class Measured:
    """What the page has measured: chi^2 per sample by row and phase, samples of the least phase of a noise setting, correlation of neighbours,
    holds (mean, standard error in mN), variance of log ratios over theory, candidates (recordings, beyond the 95 % point), twice
    the gain of refitted effects (median, largest, recordings), and the median D^2 that is kept case by case.
    """

    chi2: Mapping[str, float]
    samples: int
    neighbours: float
    holds: Mapping[str, tuple[float, float]]
    ratios: Mapping[str, float]
    chance: Mapping[str, tuple[int, int]]
    refitted: Mapping[str, tuple[float, float, int]]
    kept: Sequence[float]


def targets(m: Measured) -> list[str]:
    """Return the lines of the table: what was asked, what was measured, met or missed."""
    off = [name for name, value in m.chi2.items() if abs(value - 1.0) > OFF]
    worst = max(m.chi2, key=lambda name: abs(m.chi2[name] - 1.0))
    least = FAMILY / max(len(m.chance), 1)
    above = [i for i, (n, k) in m.chance.items() if binom.sf(k - 1, n, BEYOND) < least]
    biased = [name for name, (mean, spread) in m.holds.items() if abs(mean) > SURE * spread]
    low, high = RATIO
    beside = [name for name, value in m.ratios.items() if not low <= value <= high]
    # the largest of so many draws of chi^2 is beyond this in 5 of 100 such pages (Wilks 1938)
    draws = sum(n for _, _, n in m.refitted.values())
    nothing = float(chi2.ppf((1.0 - FAMILY) ** (1.0 / draws), STRENGTHS))
    gained = [i for i, (_, most, _) in m.refitted.items() if most > nothing]
    enough = sum(k >= KEPT for k in m.kept)
    rows = [
        (f"chi^2 of each phase within {100 * OFF:.0f} %, median over recordings", f"{len(m.chi2) - len(off)} of {len(m.chi2)} rows and phases; "
         f"furthest {m.chi2[worst]:.3f} ({worst})", not off),
        (f"at least {SAMPLES} samples a phase and noise", f"{m.samples} and more", m.samples >= SAMPLES),
        (f"correlation of neighbours below {LAG}", f"{m.neighbours:.3f}", abs(m.neighbours) < LAG),
        ("means of holds at 500 Hz unbiased", "; ".join(f"{a:+.2f} +- {b:.2f} mN after the {name}" for name, (a, b) in m.holds.items()), not biased),
        (f"variance of log ratios over theory {low}-{high}", "; ".join(f"{name} {v:.2f}" for name, v in m.ratios.items()), not beside),
        (f"no candidate gains more than chance: beyond its 95 % point in {100 * BEYOND:.0f} % of nulls",
         "more often than chance: " + ", ".join(f"{i} {100 * m.chance[i][1] / m.chance[i][0]:.0f} %" for i in above) if above else "none more often",
         not above),
        (f"refitted, twice the gain no larger than chance ({nothing:.1f} in {draws} refits)",
         "; ".join(f"{i} {most:.1f} at most" for i, (_, most, _) in m.refitted.items()), not gained),
        (f"D^2 kept at least {100 * KEPT:.0f} % of the exact one, median response", f"{enough} of {len(m.kept)} cases; least {min(m.kept):.2f}",
         enough == len(m.kept)),
    ]  # fmt: skip
    text = table(["asked", "measured", ""], [(asked, found, "met" if met else "**missed**") for asked, found, met in rows])
    return ["What was asked and what is measured:", "", *text.splitlines()]
