"""Which of our numbers were fitted to the paper's, and which are predicted.

An entry counts as fitted where a constant behind our value was set so that this entry (or the one it follows from)
comes out: agreement there shows that the fit works, not that the model is right.
"""

from __future__ import annotations

Key = tuple[str, str, str]
FITTED, PREDICTED = "fitted", "predicted"
# the generator's constants were set to Tables I and II and Section III-C3, those of NP and ND to what Table III prints: its
# caption's range, the error of the line, and that a curved map errs by less
_GENERATOR = ("I", "II", "bias", "III", "range")
# 14 numbers were set to these rows of Table IV
_SETTINGS_ROWS = ("sinusoid none", "sinusoid no-bias", "random none")


def _of_rig(table: str, row: str, column: str) -> bool:
    """Return whether a constant of ``paper/rig.py`` was set to an entry: lines, range of bends, scatter, lag, presliding."""
    if table in ("II", "bias"):
        # four effects give the eight means, and the bends lie between the least and the largest slope
        return "product" not in row and (column == "mean" or (table == "II" and column in ("min", "max")))
    if table == "I":
        # the scatter of equal bends
        return column in ("R", "rmse_fit")
    # presliding gives direct identification its error on the sinusoid; the lag is what the uncompensated row asks for
    return row in ("sinusoid DI", "sinusoid none", "random none") and column.startswith(("rmse", "std"))


def of(block: str, key: Key) -> str:
    """Return ``fitted`` or ``predicted`` for an entry of a block (stated, fitted or rig)."""
    table, row, column = key
    if block == "rig":
        return FITTED if _of_rig(table, row, column) else PREDICTED
    if table in _GENERATOR:
        return FITTED
    if block == "fitted" and table in ("IV", "summary"):
        direct = row == "sinusoid DI" and column.startswith("rmse")
        return FITTED if direct or (row in _SETTINGS_ROWS and not column.startswith("red")) else PREDICTED
    return PREDICTED
