"""Which of our numbers were fitted to the paper's, and which are predicted.

An entry counts as fitted where a constant behind our value was set so that this entry (or the one it follows from)
comes out: agreement there shows that the fit works, not that the model is right.
"""

from __future__ import annotations

Key = tuple[str, str, str]
FITTED, PREDICTED = "fitted", "predicted"
# the generator's constants were set to Tables I and II and Section III-C3, those of NP and ND to Table III's first row
_GENERATOR = ("I", "II", "bias", "range")
# 14 numbers were set to these rows of Table IV
_SETTINGS_ROWS = ("sinusoid none", "sinusoid no-bias", "random none")


def of(block: str, key: Key) -> str:
    """Return ``fitted`` or ``predicted`` for an entry of a block (stated, fitted or rig)."""
    table, row, column = key
    if block == "rig":
        # the rig's constants give the eight means, and direct identification its error on the sinusoid
        mean = table in ("II", "bias") and column == "mean" and "product" not in row
        direct = row == "sinusoid DI" and column.startswith(("rmse", "std"))
        return FITTED if mean or direct else PREDICTED
    if table in _GENERATOR or (table == "III" and row == "linear"):
        return FITTED
    if block == "fitted" and table in ("IV", "summary"):
        direct = row == "sinusoid DI" and column.startswith("rmse")
        return FITTED if direct or (row in _SETTINGS_ROWS and not column.startswith("red")) else PREDICTED
    return PREDICTED
