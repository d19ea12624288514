"""The one place for colours: Okabe-Ito, the same for a phase or a method in every figure."""

from __future__ import annotations

BLACK, ORANGE, SKY, GREEN = "#000000", "#e69f00", "#56b4e9", "#009e73"
YELLOW, BLUE, VERMILLION, PURPLE = "#f0e442", "#0072b2", "#d55e00", "#cc79a7"
GREY = "#808080"

# Stand-ins: a saved figure shows them as they are (near black, light grey, near white); inside the
# page they become CSS variables, so that the same picture follows the light or dark theme.
INK, GRID, PAPER = "#010203", "#c8c9ca", "#fefdfc"
CSS = {INK: "var(--ink)", GRID: "var(--grid)", PAPER: "var(--paper)"}

PHASES = {"PB": ORANGE, "PP": BLUE, "RB": SKY, "RP": VERMILLION}
PHASE_NAMES = {"PB": "pull, backlash", "PP": "pull, propagation", "RB": "release, backlash", "RP": "release, propagation"}
METHODS = {"none": PURPLE, "no-bias": ORANGE, "proposed": GREEN, "DI": BLUE}
METHOD_STYLES = {"none": "-", "no-bias": "--", "proposed": "-", "DI": "-."}
LOCATIONS = {"NP": BLUE, "CP": ORANGE, "ND": GREEN}
SYSTEM_MARKERS = {"act": "o", "sstl": "s"}
# measured is ink; a simulation before and after the effect
BEFORE, AFTER, FLOOR = VERMILLION, GREEN, GREY

_SPARE = (PURPLE, SKY, VERMILLION, GREY, BLUE, ORANGE, GREEN)


def of(name: str | None, known: dict[str, str], others: list[str]) -> str:
    """Return the colour of a name: its fixed one, or a spare one by its place among ``others``."""
    if name in known:
        return known[name]
    rest = [o for o in others if o not in known]
    return _SPARE[rest.index(name) % len(_SPARE)] if name in rest else GREY
