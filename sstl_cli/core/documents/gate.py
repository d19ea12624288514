"""What the physics gate says, in the documents that carry it."""

from __future__ import annotations

from typing import Literal

from sstl_cli.core.documents.base import Part


class Remark(Part):
    """One sentence on data that cannot be right, the number behind it, and the line of the mapping that mends it."""

    run_ids: list[str]
    rule: str
    severity: Literal["remark", "failure"]
    number: float
    unit: str
    sentence: str
    mend: str


class Sensor(Part):
    """How one channel of one run was sampled; ``held`` where it is renewed more slowly than it is logged."""

    file: str
    run_id: str
    column: str
    unit: str
    rate_hz: float | None
    period_s: float | None
    refresh_s: float | None
    held: bool
    step_n: float
    noise_n: float
    still_s: float
    still_at_s: float
    still_share: float
