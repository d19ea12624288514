"""The JSON lines of ``sstl watch``: one a loop, one an alarm, one at the end."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class LoopDocument(Document):
    """One completed loop: Theta, gap, and where the charts stand."""

    schema_id: Literal["sstl.watch.loop/1"] = Field(alias="schema")
    loop: int
    run_id: str
    config_id: str | None
    system: str
    tendon: str | None
    start_s: float
    end_s: float
    gamma_p: float | None
    beta_p: float | None
    gamma_r: float | None
    beta_r: float | None
    gamma_p_se: float | None = None
    beta_p_se: float | None = None
    gamma_r_se: float | None = None
    beta_r_se: float | None = None
    status: str
    mapped: dict[str, float] | None
    range: str | None
    gap_n: float | None
    gap_against: str
    learning: bool
    chart: float | None = Field(description="share of the alarm limit that the charts have reached")


class NamedChange(Part):
    """What a diagnosis makes of the loops since a change; theta (rad) of one pass before and since."""

    status: str
    effects: list[str]
    ambiguity_group: list[str]
    confidence: float | None
    theta_before: float | None
    theta_now: float | None
    why: str


class AlarmDocument(Document):
    """Something to act on: inputs outside the trained range, or a change."""

    schema_id: Literal["sstl.watch.alarm/1"] = Field(alias="schema")
    kind: str
    loop: int
    began_with_loop: int
    stream: str
    config_id: str | None
    why: str
    before: float | None
    now: float | None
    likely: NamedChange | None = Field(default=None, description="the effect that a diagnosis of the change names")


class WatchDocument(Document):
    """What a watch saw in all; its last line."""

    schema_id: Literal["sstl.watch/1"] = Field(alias="schema")
    loops: int
    samples: int
    breaks: int
    alarms: list[AlarmDocument]
    set_aside: dict[str, int]
    not_armed: dict[str, int] | None = Field(default=None, description="loops so far of the streams that are still learning")
    learn: int | None = Field(default=None, description="loops that a stream learns from")
