"""What a rule of the gate says of one or more runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["remark", "failure"]
# rank from which on rules speak only of runs that no other rule has named among a few
UNNAMED = 95


@dataclass(frozen=True)
class Remark:
    """One sentence on data that cannot be right, the number behind it, and the line of the mapping that mends it.

    Parameters
    ----------
    run_ids : tuple of str
        The runs concerned, in the order of the log.
    rule : str
        Name of the rule, as in docs/gate.md.
    severity : {"remark", "failure"}
        A failure says that no rig records this; a remark says that few do.
    number, unit : float, str
        What was measured.
    sentence : str
        What was seen and what is probably wrong.
    mend : str
        The line of the import mapping (TOML) that mends it.
    """

    run_ids: tuple[str, ...]
    rule: str
    severity: Severity
    number: float
    unit: str
    sentence: str
    mend: str

    @property
    def failed(self) -> bool:
        return self.severity == "failure"

    def line(self) -> str:
        """Return the remark as one line: severity, sentence, and what mends it."""
        return f"{self.severity} ({self.rule}): {self.sentence}; in the mapping: {self.mend}"


def names(run_ids: tuple[str, ...] | list[str], shown: int = 3) -> str:
    """Return run names for a sentence, the first few of many.

    Examples
    --------
    >>> names(["a"]), names(["a", "b", "c", "d", "e"])
    ('run a', 'runs a, b, c and 2 more')
    """
    many = list(run_ids)
    if len(many) == 1:
        return f"run {many[0]}"
    rest = len(many) - shown
    return "runs " + ", ".join(many[:shown]) + (f" and {rest} more" if rest > 0 else "")
