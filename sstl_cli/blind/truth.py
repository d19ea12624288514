"""What was done in one case: the document that goes under seal, and is opened to score or to learn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from typing import Any

from sstl_cli.core.errors import SstlError

Effects = dict[str, dict[str, float]]
# told of some cases only
SOMETIMES = ("scale", "shares", "habit", "halves")


@dataclass(frozen=True, kw_only=True)
class CaseTruth:
    """What was withheld in a case, how strong it shows, and how the case was drawn; fields in the order of the document.

    Strengths and gaps in N are RMS; ``band`` is the nominal strength, None where nothing shows. ``unlisted`` describes a
    disturbance that no catalogue has, ``also`` names what it is by the catalogue's words all the same. ``poor`` says why
    the movements tell little. Fields with a default are not in older sets, ``attempt`` is what a case is drawn again by.
    """

    kind: str
    effects: Effects
    strength_target: float
    strength: float
    band: float | None
    channel: str
    gap_n: float
    gap_null_n: float
    noise_n: float
    excluded: bool
    unlisted: tuple[str, ...]
    also: tuple[str, ...] = ()
    wrong_nominal: bool
    poor: str | None
    theta: tuple[float, ...]
    theta_retuned: tuple[float, ...]
    nominal: tuple[float, ...]
    seed: int
    attempt: int | None = None
    quick: bool = False
    rate_hz: float
    recording: str | None = None
    noise: Mapping[str, float]
    nodes: int
    # there were no others in older sets
    simulator: str = "rig"
    scale: float | None = None
    shares: Mapping[str, float] | None = None
    habit: float | None = None
    halves: bool | None = None

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> CaseTruth:
        """Return the truth of a sealed document, old ones included.

        Raises
        ------
        SstlError
            If a field is missing that every set has.
        """
        lacking = [f.name for f in fields(cls) if f.default is MISSING and f.name not in document]
        if lacking:
            raise SstlError(f"the truth of a case has no {lacking[0]}", fix="make the set again", code="E952")
        known = {f.name: document[f.name] for f in fields(cls) if f.name in document}
        told: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in known.items()}
        return cls(**told)

    def document(self) -> dict[str, object]:
        """Return the document that is sealed."""
        return {k: v for k, v in asdict(self).items() if v is not None or k not in SOMETIMES}
