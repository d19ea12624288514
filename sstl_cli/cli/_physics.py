"""What the physics gate said, on the screen and in documents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.documents import gate as parts
    from sstl_cli.core.runs import Run
    from sstl_cli.identification.gate import Remark
    from sstl_cli.steps.judge import Channel, Judged

SHOWN = 12


def show(screen: Screen, remarks: Sequence[Remark]) -> None:
    """Print remarks, failures first, each with the line of the mapping that mends it."""
    for remark in remarks[:SHOWN]:
        screen.say(f"{'Physics' if remark.failed else 'Remark'} ({remark.rule}): {remark.sentence}.")
        screen.say(f"  mend: {remark.mend}")
    if len(remarks) > SHOWN:
        screen.line(f"  and {len(remarks) - SHOWN} more (--json lists all)")
    if any(r.failed for r in remarks):
        screen.line("  --no-physics goes on regardless")


def document(remarks: Sequence[Remark]) -> list[parts.Remark]:
    """Return remarks for a JSON document."""
    from sstl_cli.core.documents import gate

    return [gate.Remark(**asdict(r)) for r in remarks]


def judge(paths: Sequence[Path], screen: Screen) -> Judged:
    """Return what the gate says of the logs among some tables; what cannot be read is left to the other checks."""
    from sstl_cli.steps import judge as step

    with screen.progress("judging", None):
        return step.run(_runs(paths))


def _runs(paths: Sequence[Path]) -> Iterator[tuple[str, Run]]:
    from sstl_cli.cli._other_files import other_kind
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.kinds import kind_of
    from sstl_cli.core.parquet import schema_id_of
    from sstl_cli.core.runs import recorded_runs
    from sstl_cli.core.tables import LOG

    for path in paths:
        try:
            if other_kind(path):
                continue
            if path.is_file() and kind_of(path) == "text":
                for run in _of_text(path):
                    yield str(path), run
            elif schema_id_of(path) in (LOG.id, None):
                for run in recorded_runs(path):
                    yield str(path), run
        except SstlError:
            # the table's own checks have told it
            continue


def _of_text(path: Path) -> Iterator[Run]:
    """Yield the runs of a log written as CSV."""
    import pyarrow as pa

    from sstl_cli.core.parquet import ROWS_PER_BLOCK, conform
    from sstl_cli.core.runs import runs_of, units_of
    from sstl_cli.core.tables import LOG
    from sstl_cli.importers.text_table import TextTable

    table = TextTable(path)
    batches = (pa.Table.from_batches([b]) for b in table.iter_batches(ROWS_PER_BLOCK))
    yield from runs_of((conform(b, LOG, str(path)) for b in batches), str(path), units_of(table.schema_arrow))


def channels(judged: Judged) -> list[parts.Sensor]:
    """Return how every channel was sampled for a JSON document."""
    from sstl_cli.core.documents import gate

    return [
        gate.Sensor(file=c.log, run_id=c.run_id, unit=c.unit, rate_hz=c.sensor.rate_hz, held=c.sensor.held, **asdict(c.sensor))
        for c in judged.channels
    ]


def show_channels(screen: Screen, judged: Judged) -> None:
    """Print how the channels were sampled, runs that are alike in one row."""
    groups: dict[tuple[object, ...], list[Channel]] = {}
    for c in judged.channels:
        s = c.sensor
        alike = (c.log, s.column, c.unit, f"{s.rate_hz:.2g}", f"{s.refresh_s:.2g}", f"{s.step_n:.2g}")
        groups.setdefault(alike, []).append(c)
    rows = []
    for (log, column, unit, *_), group in groups.items():
        sensors = [c.sensor for c in group]
        held = "sample and hold" if sensors[0].held else ""
        rate, refresh, step, noise = (
            float(f"{median(values):.3g}")
            for values in zip(*((s.rate_hz, 1000.0 * s.refresh_s, s.step_n, s.noise_n) for s in sensors), strict=True)
        )
        # a reading without steps has none, not one of 0
        rows.append([Path(str(log)).name, column, len(group), rate, refresh, step or None, noise, unit, held])
    keep = [i for i in range(9) if (i != 0 or len({r[0] for r in rows}) > 1) and (i != 8 or any(r[8] for r in rows))]
    header = ("file", "channel", "runs", "rate Hz", "refresh ms", "step", "noise", "unit", "")
    if rows:
        screen.table("Sensors", [header[i] for i in keep], [[r[i] for i in keep] for r in rows], most=SHOWN)
