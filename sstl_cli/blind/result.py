"""What came of one case of a withheld-effect check: its result file as far as a score asks for it."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

SCHEMA = "sstl.blind.result/1"


class _Read(BaseModel):
    """A part of a result; what a score does not ask for is left in the file."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Said(_Read):
    """The verdict: status, effects, and who is not told apart."""

    status: str
    effects: list[str]
    ambiguity_group: list[str]
    confidence: float | None
    members: dict[str, list[str]] | None = None


class Shrunk(_Read):
    """By how much the error falls with the named effects."""

    shrink_pct: float | None


class Analysed(_Read):
    """The re-tuned base by bend (theta, rad), and how many samples were analysed."""

    theta: dict[str, float] = {}
    samples: int = 0


class Told(_Read):
    """A diagnosis: what it said, what simpler rules would have said."""

    verdict: Said
    gap: Shrunk
    baselines: dict[str, str | None] = {}
    analysis: Analysed | None = None


class Result(_Read):
    """The result of one case (``sstl.blind.result/1``): of which recording, under which options, and what was said.

    ``model`` is the accepted simulator and ``rows`` what the verdict was made from, both as JSON holds them (see :mod:`.kept`); None
    where there are none, ``error`` says why.
    """

    case: str
    seconds: float = Field(description="of the diagnosis")
    error: str | None
    diagnosis: Told
    model: dict[str, object] | None
    rows: dict[str, object] | None = None
    log_sha256: str | None = None
    exclude: list[str] = []
