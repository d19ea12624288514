"""What the physics gate says, in the documents that carry it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

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
    unit: str
    rate_hz: float | None
    held: bool
    column: str
    period_s: float | None
    refresh_s: float | None
    step_n: float
    noise_n: float
    still_s: float
    still_at_s: float
    still_share: float
    white: bool = Field(default=True, description="whether the noise is noise, and not the motion between slow samples")
    still_left: bool = Field(default=False, description="whether the value jumps at the end of the stretch in which it stood still")
    restless: bool = Field(
        default=False, description="whether the channel has its noise all the while but in the stretch in which it stood still"
    )
    silent: bool = Field(
        default=False,
        description="whether it stood still for longer than its noise, behind its step, would have let a live sensor rest at a level",
    )
    digit_n: float = Field(
        default=0.0, description="last digit, where nothing but its rounding is left beside the movement (a command); 0 for readings"
    )
