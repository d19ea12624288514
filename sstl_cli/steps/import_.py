"""Recordings of any known format as runs of the log table, with everything that was repaired counted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from sstl_cli.core.aside import Aside
from sstl_cli.core.documents.logs import ClockPart, ImportDocument, Recording
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.runs import Run
from sstl_cli.core.sound import note, too_short, too_small
from sstl_cli.importers.chunk import Chunk
from sstl_cli.importers.clocks import ClockReport
from sstl_cli.importers.counts import Counts, Policy
from sstl_cli.importers.inline import inline_mapping, targets_of, with_policy
from sstl_cli.importers.mapping import TENSIONS, Mapping, read_mapping
from sstl_cli.importers.repair import Splitter
from sstl_cli.importers.signals import chunks
from sstl_cli.importers.sources import Bad, Group, Labels, groups
from sstl_cli.importers.turns import by_run
from sstl_cli.importers.window import windowed

# samples of one file that may wait in memory until it is known to be sound
HELD_SAMPLES = 2_000_000
# part of the samples that repeat a time with other readings from which on it is the clock that is coarse
COARSE = 0.1
ROWS_OF_THEIR_OWN = (
    'the tensions have rows of their own, with empty cells between: write dropouts = "interpolate" in [repair] of the mapping'
)


@dataclass(frozen=True)
class Import:
    """Runs as a stream, and the account of them, which is complete once the stream has ended."""

    runs: Iterator[Run]
    counts: Counts
    clocks: list[ClockReport]
    recordings: list[Recording] = field(default_factory=list)
    tendons: list[str] = field(default_factory=list)
    bad: list[Bad] = field(default_factory=list)

    @property
    def set_aside(self) -> bool:
        """Whether anything was."""
        return bool(self.counts.set_aside or self.counts.blanked or self.bad)

    @property
    def remarks(self) -> list[str]:
        """What else is worth saying, each once."""
        return list(dict.fromkeys(self.counts.remarks))

    def document(self, out: str, other: dict[str, str]) -> ImportDocument:
        """Return the account of runs written to ``out``; ``other`` are the units of columns that hold no tension."""
        c = self.counts
        told = ImportDocument(
            schema="sstl.import/1",
            out=out,
            recordings=self.recordings,
            runs=c.runs,
            samples_in=c.samples_in,
            samples_out=c.samples_out,
            set_aside=c.set_aside,
            set_aside_pct=c.set_aside_pct,
            set_aside_by=dict(sorted(c.notes.set_aside.items())),
            values_set_aside=dict(sorted(c.blanked.items())),
            found=c.found,
            step_s=c.step_s,
            gap_s=c.gap_s,
            clocks=[ClockPart(**r.document()) for r in self.clocks],
            files_set_aside=[{"file": b.path.name, "code": b.error.code, "message": b.error.what, "fix": b.error.fix} for b in self.bad],
            remarks=self.remarks,
        )
        return told.model_copy(update={"not_a_tension": other}) if other else told


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
    object.__setattr__(result, "runs", _judged(_runs(result, files, mapping, wanted, manifest or {}, advance)))
    return result


def _judged(pieces: Iterator[Run]) -> Iterator[Run]:
    """Yield pieces of runs, and note each run that no recorder can have given: it is written, and no command uses it."""
    last: Run | None = None
    samples, start, top = 0, 0.0, np.zeros(len(TENSIONS))
    for piece in chain(pieces, (None,)):
        if last is not None and (piece is None or piece.run_id != last.run_id):
            said = [too_small(name, np.array([t])) for name, t in zip(TENSIONS, top, strict=True)]
            said.append(too_short((float(last.time_s[-1]) - start) / max(samples - 1, 1)))
            note([Aside(last.run_id, 0, samples, f"{why} (it is written, and no command uses it)") for why in said if why])
            last = None
        if piece is None or not len(piece):
            continue
        if last is None:
            samples, start, top = 0, float(piece.time_s[0]), np.zeros(len(TENSIONS))
        samples += len(piece)
        top = np.maximum(top, [np.abs(getattr(piece, name)).max() for name in TENSIONS])
        last = piece
        yield piece


def mapping_of(file: Path | None, short: str | None = None, on_gap: str | None = None, merge: str | None = None) -> Mapping:
    """Return the mapping of a file, with what one in short and the policies say on top.

    Raises
    ------
    SstlError
        If the file asks what nobody answered, or a word is unknown.
    """
    chosen = read_mapping(file, targets_of(short or "")) if file is not None else Mapping()
    if short is not None:
        chosen = inline_mapping(short, chosen)
    return with_policy(chosen, on_gap=on_gap, merge=merge)


def manifest_of(given: Path | None, file: Path | None, mapping: Mapping) -> Path | None:
    """Return the table of labels: the one given, else that of the mapping, which lies beside its file."""
    if given is not None or not mapping.manifest:
        return given
    return file.parent / mapping.manifest if file is not None else Path(mapping.manifest)


def provenance_extra(mapping: Mapping) -> dict[str, object]:
    """Return what the provenance of a log must say about its mapping."""
    extra: dict[str, object] = {"mapping": mapping.model_dump(by_alias=True, exclude_unset=True, mode="json")}
    if other := no_tensions(mapping):
        extra["not_a_tension"] = other
    return extra


def no_tensions(mapping: Mapping) -> dict[str, str]:
    """Return the unit of each tension column that holds none, by name."""
    return {n: s.unit for n in TENSIONS if (s := mapping.columns.get(n)) is not None and s.as_ is not None}


def _runs(
    result: Import, files: list[Path], mapping: Mapping, wanted: str | None, manifest: dict[str, Labels], advance: Callable[[float], None]
) -> Iterator[Run]:
    counts = result.counts
    policy = Policy(mapping.time, mapping.repair)
    used: set[str] = set()
    for group in groups(files, mapping, wanted, manifest):
        if isinstance(group, Bad):
            _set_aside(result, files, group.path, group.error)
            continue
        before = counts.copy()
        names = set(used)
        for plan in group.plans:
            counts.remarks.extend(plan.notes)
            result.tendons.extend(str(v["tendon"]) for v in (plan.labels, plan.constants) if "tendon" in v)
        first = group.plans[0]
        splitter = Splitter(first.run_name, first.constants, policy, counts, used, group.where, first.units)
        pieces = splitter.runs(by_run(_appended(group, mapping, result, advance), mapping.time.gap_s, counts, group.where))
        try:
            held = list(_first_of(pieces)) if len(files) > 1 else []
        except SstlError as error:
            _set_aside(result, files, first.files[0].path, error)
            # nothing of a file that fails is counted or written
            counts.back_to(before)
            used &= names
            continue
        yield from held
        yield from pieces
        result.recordings.append(
            Recording(
                file=", ".join(dict.fromkeys(f.path.name for p in group.plans for f in p.files)),
                format=first.files[0].format.ID,
                runs=counts.runs - before.runs,
                samples=counts.samples_out - before.samples_out,
            )
        )
        if counts.runs == before.runs:
            counts.remarks.append(f"{group.where}: no run of at least {mapping.repair.min_samples} samples")
    if counts.notes.trimmed:
        counts.remarks.append(f"{counts.notes.trimmed} samples outside the window asked for were left out")
    if counts.differing > COARSE * counts.samples_in:
        why = "the stamps are coarser than the rows, or of packets as they arrived"
        counts.remarks.append(
            f"{counts.differing} samples of a repeated time held other readings: {why}; time_s = {{ rate_hz = ... }} keeps them"
        )
    if not counts.runs:
        if result.bad:
            raise result.bad[0].error
        why = "; ".join(f"{n} {reason}" for reason, n in counts.notes.set_aside.items()) or "no sample was read"
        raise SstlError(
            f"no run of at least {mapping.repair.min_samples} samples ({why})",
            where=str(files[0]),
            fix="check the file and the mapping" if counts.between < mapping.repair.min_samples else ROWS_OF_THEIR_OWN,
            code="E345",
        )


def _first_of(pieces: Iterator[Run]) -> Iterator[Run]:
    """Yield the pieces of one recording of a batch, as far as may stand in memory before any is written.

    A file that turns out to be damaged within them is set aside whole; damage behind them ends the import.
    """
    held = 0
    for piece in pieces:
        yield piece
        held += len(piece)
        if held >= HELD_SAMPLES:
            return


def _set_aside(result: Import, files: list[Path], path: Path, error: SstlError) -> None:
    if len(files) == 1 or isinstance(error, UsageError):
        raise error
    result.bad.append(Bad(path, error))


def _appended(group: Group, mapping: Mapping, result: Import, advance: Callable[[float], None]) -> Iterable[Chunk]:
    """Yield the chunks of plans one after the other; ``shift`` lets a restarted clock go on."""
    last: float | None = None
    end: float | None = None
    for plan in group.plans:
        begin: float | None = None
        read = chunks(
            plan, mapping.skip_samples, mapping.clocks.align, mapping.clocks.max_offset_s, result.counts.notes, result.clocks, advance
        )
        for chunk in windowed(read, mapping, result.counts.notes):
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
