"""Recordings of any known format as runs of the log table, with everything that was repaired counted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.importers.clocks import ClockReport
from sstl_cli.importers.counts import Counts, Policy
from sstl_cli.importers.mapping import Mapping
from sstl_cli.importers.repair import Splitter
from sstl_cli.importers.signals import Chunk, chunks
from sstl_cli.importers.sources import Group, Labels, groups


@dataclass(frozen=True)
class Import:
    """Runs as a stream, and the account of them, which is complete once the stream has ended."""

    runs: Iterator[Run]
    counts: Counts
    clocks: list[ClockReport]
    recordings: list[dict[str, object]] = field(default_factory=list)
    tendons: list[str] = field(default_factory=list)

    def document(self) -> dict[str, object]:
        """Return the account as plain values."""
        c = self.counts
        return {
            "recordings": self.recordings,
            "runs": c.runs,
            "samples_in": c.samples_in,
            "samples_out": c.samples_out,
            "set_aside": c.set_aside,
            "set_aside_pct": 100 * c.set_aside / max(c.samples_in, 1),
            "set_aside_by": dict(sorted(c.notes.set_aside.items())),
            "found": {
                "repeated_time": c.repeated,
                "backward_time": c.backward,
                "gaps": c.gaps,
                "dropouts": c.dropouts,
                "spikes": c.spikes,
                "filled": c.filled,
            },
            "step_s": c.step_s,
            "gap_s": c.gap_s,
            "clocks": [r.document() for r in self.clocks],
            "remarks": list(dict.fromkeys(c.remarks)),
        }


def run(
    files: list[Path],
    mapping: Mapping,
    *,
    wanted: str | None = None,
    manifest: dict[str, Labels] | None = None,
    advance: Callable[[float], None] = lambda _: None,
) -> Import:
    """Return the runs of the given files as a stream.

    Parameters
    ----------
    files : list of Path
        Recordings; each is a run or more, or they are merged as the mapping says.
    mapping : Mapping
        Channels, units, labels and policies.
    wanted : str, optional
        Format id, where it shall not be detected.
    manifest : dict, optional
        Labels by file name.
    advance : callable
        Told the bytes read since it was last called.

    Raises
    ------
    SstlError
        While the stream is read: bad input, or no run left in any file.
    """
    result = Import(iter(()), Counts(), [])
    object.__setattr__(result, "runs", _runs(result, files, mapping, wanted, manifest or {}, advance))
    return result


def provenance_extra(mapping: Mapping) -> dict[str, object]:
    """Return what the provenance of a log must say about its mapping."""
    extra: dict[str, object] = {"mapping": mapping.model_dump(by_alias=True, exclude_unset=True, mode="json")}
    output = mapping.columns.get("tension_out_n")
    if output is not None and output.as_ is not None:
        extra["not_a_tension"] = {"tension_out_n": output.unit or "unknown"}
    return extra


def _runs(
    result: Import,
    files: list[Path],
    mapping: Mapping,
    wanted: str | None,
    manifest: dict[str, Labels],
    advance: Callable[[float], None],
) -> Iterator[Run]:
    counts = result.counts
    policy = Policy(mapping.time, mapping.repair)
    used: set[str] = set()
    for group in groups(files, mapping, wanted, manifest):
        before_runs, before_samples = counts.runs, counts.samples_out
        for plan in group.plans:
            counts.remarks.extend(plan.notes)
            result.tendons.extend(str(v["tendon"]) for v in (plan.labels, plan.constants) if "tendon" in v)
        splitter = Splitter(group.plans[0].run_name, group.plans[0].constants, policy, counts, used, group.where)
        yield from splitter.runs(_appended(group, mapping, result, advance))
        result.recordings.append(
            {
                "file": ", ".join(dict.fromkeys(f.path.name for p in group.plans for f in p.files)),
                "format": group.plans[0].files[0].format.ID,
                "runs": counts.runs - before_runs,
                "samples": counts.samples_out - before_samples,
            }
        )
        if counts.runs == before_runs:
            counts.remarks.append(f"{group.where}: no run of at least {mapping.repair.min_samples} samples")
    if not counts.runs:
        why = "; ".join(f"{n} {reason}" for reason, n in counts.notes.set_aside.items()) or "no sample was read"
        raise SstlError(
            f"no run of at least {mapping.repair.min_samples} samples ({why})",
            where=str(files[0]),
            fix="check the file and the mapping",
            code="E345",
        )


def _appended(group: Group, mapping: Mapping, result: Import, advance: Callable[[float], None]) -> Iterable[Chunk]:
    """Yield the chunks of plans one after the other; ``shift`` lets a restarted clock go on."""
    last: float | None = None
    end: float | None = None
    for plan in group.plans:
        begin: float | None = None
        for chunk in chunks(
            plan,
            mapping.skip_samples,
            mapping.clocks.align,
            mapping.clocks.max_offset_s,
            result.counts.notes,
            result.clocks,
            advance,
        ):
            time = chunk.signals["time_s"]
            finite = time[np.isfinite(time)]
            if mapping.files.shift and last is not None and len(finite):
                if begin is None:
                    step = float(np.median(np.diff(finite))) if len(finite) > 1 else 0.0
                    begin = last + step - float(finite[0])
                chunk.signals["time_s"] = time + begin
                finite = finite + begin
            if len(finite):
                end = float(finite[-1])
            yield chunk
        last = end
