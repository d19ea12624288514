"""Judge logs by physics: what cannot be right, and how every channel was sampled."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from sstl_cli.core.documents.logs import Finding
from sstl_cli.core.runs import Run
from sstl_cli.core.sound import sound
from sstl_cli.identification import gate


@dataclass(frozen=True)
class Channel:
    """How one channel of one run of a log was sampled, and its unit."""

    log: str
    run_id: str
    unit: str
    sensor: gate.Sensor


@dataclass(frozen=True)
class Judged:
    """What the gate said of all logs together, and their channels in order; ``short`` runs were too many to be looked at one by one."""

    remarks: tuple[gate.Remark, ...]
    channels: tuple[Channel, ...]
    short: int = 0


def run(runs: Iterable[tuple[str, Run]]) -> Judged:
    """Return remarks and sensors of the runs of some logs, given as (log's name, run as recorded).

    A run that two logs name alike is called ``log: run`` from its second appearance on.
    """
    evidence = gate.Witnesses()
    channels: list[Channel] = []
    seen: set[str] = set()
    for log, recorded in runs:
        for piece in sound(recorded)[0]:
            if not len(piece):
                continue
            one = evidence.add(piece, f"{log}: {piece.run_id}" if piece.run_id in seen else "")
            if one is None:
                continue
            seen.add(one.run_id)
            channels += [Channel(log, one.run_id, piece.units[s.column], s) for s in one.sensors]
    return Judged(gate.judge(evidence.log), tuple(channels), evidence.short)


def findings(judged: Judged) -> list[Finding]:
    """Return remarks as findings of ``check``, one for each run."""
    logs = {c.run_id: c.log for c in judged.channels}
    return [
        Finding(
            file=logs[run_id], run_id=run_id, level=r.severity, what=f"physics: {r.rule}", column="", count=1, detail=r.sentence, fix=r.mend
        )
        for r in judged.remarks
        for run_id in r.run_ids
    ]
