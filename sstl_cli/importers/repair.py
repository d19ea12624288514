"""Chunks into runs: time made strictly increasing, faults counted and handled by a named policy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.packets import packets_of
from sstl_cli.core.runs import Run
from sstl_cli.core.sound import GAP_PERIODS, LARGEST, OPTIONAL, unsound
from sstl_cli.importers.chunk import Chunk, filled_rows, joined, rows_of
from sstl_cli.importers.counts import Counts, Policy
from sstl_cli.importers.mapping import LABELS, REQUIRED, TENSIONS
from sstl_cli.importers.plan import lead_of
from sstl_cli.importers.spikes import spikes
from sstl_cli.importers.systems import system_of

Array = NDArray[np.float64]
MAX_FILL_STEPS = 1_000
MAX_RUNS = 1_000_000
# runs up to this many samples come in one piece, longer ones in pieces of about this size
PIECE_ROWS = 262_144


class Splitter:
    """Turns the chunks of one recording into pieces of runs; a run may come in several pieces.

    Memory is bounded by a chunk: the last sample is held back, so that repeated time and gaps at the seams are seen.
    """

    def __init__(
        self,
        name: str,
        constants: dict[str, str | float],
        policy: Policy,
        counts: Counts,
        used: set[str],
        where: str,
        units: dict[str, str] | None = None,
    ) -> None:
        self.name, self.constants, self.policy, self.counts, self.used = name, constants, policy, counts, used
        self.where, self.units = where, units or {}
        self.last: dict[str, float] = {}
        self.held: Chunk | None = None
        self.run_id = ""
        self.lead: float | None = None
        self.key: tuple[str | None, ...] | None = None
        self.waiting: list[Chunk] = []
        self.waiting_rows = 0
        self.open = False
        self.zero: float | None = None
        self.gap_s = policy.time.gap_s
        self.step_s: float | None = None
        self.empty = 0

    def runs(self, chunks: Iterable[Chunk]) -> Iterator[Run]:
        """Yield pieces of runs; pieces of one run follow one another."""
        for chunk in chunks:
            chunk = self._without_end(chunk)
            self.counts.samples_in += len(chunk)
            yield from self._take(self._refreshed(self._clean(chunk)), last=False)
        if self.held is not None:
            held, self.held = self.held, None
            yield from self._take(held, last=True)
        yield from self._end()

    def _clean(self, chunk: Chunk) -> Chunk:
        """Handle values that no recorder can have given."""
        lost = np.zeros(len(chunk), bool)
        for name, values in chunk.signals.items():
            wrong = unsound(values) & ~np.isnan(values)
            if wrong.any():
                values = np.where(wrong, np.nan, values)
                chunk.signals[name] = values
                if name not in REQUIRED:
                    self.counts.blank(name, int(wrong.sum()))
            if name in REQUIRED:
                lost |= np.isnan(values)
            elif self.policy.repair.dropouts == "interpolate":
                chunk.signals[name] = _filled(chunk.signals["time_s"], values)
        n = int(lost.sum())
        if not n:
            return chunk
        self._lost(n, self.counts.samples_in - len(chunk) + int(np.argmax(lost)) + 1)
        no_time = np.isnan(chunk.signals["time_s"])
        if self.policy.repair.dropouts == "interpolate":
            for name in REQUIRED[1:]:
                chunk.signals[name] = _filled(chunk.signals["time_s"], chunk.signals[name])
            lost = no_time.copy()
            for name in REQUIRED[1:]:
                lost |= np.isnan(chunk.signals[name])
            self.counts.filled += n - int(lost.sum())
        elif len(chunk) - n < self.policy.repair.min_samples:
            filled = [_filled(chunk.signals["time_s"], chunk.signals[name]) for name in REQUIRED[1:]]
            self.counts.between += int(np.isfinite(np.sum(filled, axis=0) + chunk.signals["time_s"]).sum())
        self.counts.notes.aside("dropouts (no number)", int(lost.sum()))
        return rows_of(chunk, ~lost)

    def _without_end(self, chunk: Chunk) -> Chunk:
        """Return a chunk without empty rows at its end, as below a shorter run beside a longer one; where more follow, they are dropouts."""
        end = filled_rows(chunk)
        if end and self.empty:
            self.counts.samples_in += self.empty
            self._lost(self.empty, self.counts.samples_in - self.empty + 1)
            self.counts.notes.aside("dropouts (no number)", self.empty)
            self.empty = 0
        self.empty += len(chunk) - end
        return chunk if end == len(chunk) else rows_of(chunk, slice(0, end))

    def _lost(self, n: int, first: int) -> None:
        """Count dropouts, of which the first sample is given, and refuse them where that is wanted."""
        self.counts.dropouts += n
        if self.policy.repair.dropouts == "fail":
            raise SstlError(
                f"{n} dropouts (no number), the first at sample {first}",
                where=self.where,
                fix='use dropouts = "drop" or "interpolate" in [repair]',
                code="E350",
            )

    def _refreshed(self, chunk: Chunk) -> Chunk:
        """Set aside samples that a fast recorder repeated because a slow sensor had nothing new."""
        how = self.policy.repair.refreshed
        if how is None or not len(chunk):
            return chunk
        new = {}
        for name in TENSIONS:
            values = chunk.signals[name]
            new[name] = np.diff(values, prepend=self.last.get(name, np.nan)) != 0
            self.last[name] = float(values[-1])
        first, second = new.values()
        keep = first | second if how == "any" else first & second if how == "both" else new[how]
        self.counts.notes.aside("not refreshed by the sensor", int(len(keep) - keep.sum()))
        return rows_of(chunk, keep)

    def _take(self, chunk: Chunk, last: bool) -> Iterator[Run]:
        if self.held is not None:
            chunk = joined(self.held, chunk)
            self.held = None
        if not len(chunk):
            return
        changes = self._label_changes(chunk)
        chunk, changes = self._repeated(chunk, changes)
        chunk, changes = self._backward(chunk, changes)
        if not last:
            # everything at the last instant waits for what follows
            self.held = rows_of(chunk, slice(len(chunk) - 1, None))
            body = len(chunk) - 1
        else:
            body = len(chunk)
        time = chunk.signals["time_s"]
        step = np.diff(time)
        self._learn_gap(step[~changes[1:]])
        gaps = np.zeros(len(time), bool)
        if self.gap_s is not None:
            gaps[1:] = (step > self.gap_s) & ~changes[1:]
        chunk, starts, body = self._gaps(chunk, gaps, changes, body)
        cuts = [0, *np.flatnonzero(starts[1:body]) + 1, body] if body else [0]
        for a, b in pairwise(cuts):
            if starts[a]:
                yield from self._end()
            yield from self._add(rows_of(chunk, slice(a, b)))
        if not last and starts[body]:
            yield from self._end()

    def _label_changes(self, chunk: Chunk) -> NDArray[np.bool_]:
        """Return where a new run begins because run_id (or, without one, any label) changes."""
        names = ["run_id"] if "run_id" in chunk.labels else list(chunk.labels)
        changes = np.zeros(len(chunk), bool)
        for name in names:
            codes = chunk.labels[name].dictionary_encode().indices.fill_null(-1).to_numpy(zero_copy_only=False)
            changes[1:] |= np.diff(codes) != 0
        return changes

    def _repeated(self, chunk: Chunk, changes: NDArray[np.bool_]) -> tuple[Chunk, NDArray[np.bool_]]:
        time = chunk.signals["time_s"]
        same = np.zeros(len(chunk), bool)
        same[1:] = (time[1:] == time[:-1]) & ~changes[1:]
        n = int(same.sum())
        if not n:
            return chunk, changes
        if self.policy.time.repeated == "fail":
            at = float(time[int(np.argmax(same))])
            raise SstlError(f"time {at:g} s is repeated", where=self.where, fix='use repeated = "last" in [time]', code="E351")
        self.counts.repeated += n
        # where each row brings the news of one channel, the other holds its reading
        other = np.all([np.diff(chunk.signals[name], prepend=np.nan) != 0.0 for name in TENSIONS], axis=0)
        self.counts.differing += int(np.count_nonzero(same & other))
        self.counts.notes.aside(f"repeated time (kept the {self.policy.time.repeated})", n)
        if self.policy.time.repeated == "first":
            return rows_of(chunk, ~same), changes[~same]
        keep = np.concatenate((~same[1:], [True]))
        # a change of run marked on a dropped first row moves to the row that is kept
        groups = np.cumsum(~same) - 1
        moved = np.zeros(int(groups[-1]) + 1, bool)
        np.logical_or.at(moved, groups, changes)
        return rows_of(chunk, keep), moved

    def _backward(self, chunk: Chunk, changes: NDArray[np.bool_]) -> tuple[Chunk, NDArray[np.bool_]]:
        time = chunk.signals["time_s"]
        back = np.zeros(len(chunk), bool)
        back[1:] = (time[1:] < time[:-1]) & ~changes[1:]
        n = int(back.sum())
        if not n:
            return chunk, changes
        how = self.policy.time.backward
        if how == "fail":
            at = int(np.argmax(back))
            raise SstlError(
                f"time goes back from {time[at - 1]:g} s to {time[at]:g} s",
                where=self.where,
                fix='use backward = "split" or "drop" in [time]',
                code="E352",
            )
        self.counts.backward += n
        if how == "split":
            return chunk, changes | back
        keep = np.ones(len(chunk), bool)
        starts = [0, *np.flatnonzero(changes[1:]) + 1, len(time)]
        for a, b in pairwise(starts):
            top = np.maximum.accumulate(time[a:b])
            keep[a + 1 : b] = time[a + 1 : b] > top[:-1]
        self.counts.notes.aside("backward time", int(len(keep) - keep.sum()))
        return rows_of(chunk, keep), changes[keep]

    def _learn_gap(self, steps: Array) -> None:
        """Set what counts as a gap from the first samples: ten usual steps."""
        forward = steps[steps > 0]
        if self.step_s is None and len(forward) >= 3:
            self.step_s = float(np.median(forward))
            self.counts.step_s = self.counts.step_s or self.step_s
            if self.gap_s is None:
                self.gap_s = GAP_PERIODS * self.step_s
            self.counts.gap_s = self.counts.gap_s or self.gap_s

    def _gaps(self, chunk: Chunk, gaps: NDArray[np.bool_], changes: NDArray[np.bool_], body: int) -> tuple[Chunk, NDArray[np.bool_], int]:
        n = int(gaps.sum())
        if not n:
            return chunk, changes, body
        time = chunk.signals["time_s"]
        at = int(np.argmax(gaps))
        how = self.policy.time.on_gap
        if how == "fail":
            raise SstlError(
                f"{n} gaps, the first of {time[at] - time[at - 1]:.4g} s at {time[at - 1]:g} s",
                where=self.where,
                fix="use --on-gap split or fill, or raise gap_s",
                code="E353",
            )
        if self.policy.time.gap_s is None:
            self._refuse_packets(chunk, changes)
        self.counts.gaps += n
        if how == "split" or self.step_s is None:
            return chunk, changes | gaps, body
        rows = np.flatnonzero(gaps)
        missing = np.rint((time[rows] - time[rows - 1]) / self.step_s).astype(np.float64) - 1
        long = missing > MAX_FILL_STEPS
        if long.any():
            self.counts.remarks.append(f"{int(long.sum())} gaps longer than {MAX_FILL_STEPS} steps were split, not filled")
        starts = changes.copy()
        starts[rows[long]] = True
        fill = {int(r): int(m) for r, m in zip(rows[~long], missing[~long], strict=True)}
        self.counts.filled += sum(fill.values())
        where = np.concatenate([np.full(m, r) for r, m in fill.items()]) if fill else np.empty(0, np.int64)
        part = np.concatenate([np.arange(1, m + 1) / (m + 1) for m in fill.values()]) if fill else np.empty(0)
        source = np.insert(np.arange(len(time), dtype=np.float64), where.astype(np.int64), where - 1 + part)
        new_rows = np.ceil(source - 1e-12).astype(np.int64)
        signals = {k: np.interp(source, np.arange(len(v)), v) for k, v in chunk.signals.items()}
        original = source == np.floor(source)
        for k, v in chunk.signals.items():
            signals[k][original] = v
        labels = {k: v.take(pa.array(np.minimum(new_rows, len(time) - 1))) for k, v in chunk.labels.items()}
        spread = np.zeros(len(source), bool)
        spread[original] = starts
        # rows filled in front of the held-back sample belong to this body already
        return Chunk(signals, labels), spread, body + int((where <= body).sum())

    def _refuse_packets(self, chunk: Chunk, changes: NDArray[np.bool_]) -> None:
        """Refuse rows that were stamped when they arrived: each packet would be a run of its own, at a rate that nothing was recorded with."""
        time, tensions = chunk.signals["time_s"], [chunk.signals[name] for name in TENSIONS]
        for a, b in pairwise([0, *np.flatnonzero(changes[1:]) + 1, len(chunk)]):
            found = packets_of(time[a:b], tuple(v[a:b] for v in tensions))
            if found is not None:
                fix = f"{found.mend} (or, if the pauses are real, gap_s in [time])"
                raise SstlError(f"time comes in {found.said}", where=self.where, fix=fix, code="E358")

    def _add(self, piece: Chunk) -> Iterator[Run]:
        if not self.open and self.waiting_rows == 0:
            self.key = tuple(piece.labels[n][0].as_py() if n in piece.labels else None for n in LABELS)
            self.zero = float(piece.signals["time_s"][0]) if self.policy.time.start == "zero" else None
        for name in LABELS:
            if name in piece.labels and name not in ("run_id", "lead_mm") and len(piece.labels[name].unique()) > 1:
                raise SstlError(f"{name} changes within a run", where=self.where, fix="give the parts another run_id", code="E355")
        self.waiting.append(piece)
        self.waiting_rows += len(piece)
        if self.waiting_rows >= max(PIECE_ROWS, self.policy.repair.min_samples):
            yield from self._flush()

    def _flush(self) -> Iterator[Run]:
        """Yield what waits as one piece of the current run."""
        piece = joined(*self.waiting)
        self.waiting, self.waiting_rows = [], 0
        if not self.open:
            self._name_run()
            self.open = True
        run = self._run(self._spikes(piece))
        self.counts.samples_out += len(run)
        yield run

    def _end(self) -> Iterator[Run]:
        """Close the current run; what was too short to be one is set aside."""
        if self.waiting_rows and not self.open and self.waiting_rows < self.policy.repair.min_samples:
            self.counts.notes.aside(f"run shorter than {self.policy.repair.min_samples} samples", self.waiting_rows)
        elif self.waiting_rows:
            yield from self._flush()
        self.waiting, self.waiting_rows, self.open = [], 0, False

    def _name_run(self) -> None:
        """Give the run a name that no other run of the output has."""
        assert self.key is not None
        given = self.key[0] if self.key[0] is not None else self.constants.get("run_id")
        base = str(given) if given not in (None, "") else self.name
        self.run_id, n = base, 1
        while self.run_id in self.used:
            n += 1
            self.run_id = f"{base}-{n}"
            if n > MAX_RUNS:
                raise SstlError(f"splits into more than {MAX_RUNS} runs", where=self.where, fix="raise gap_s", code="E354")
        self.used.add(self.run_id)
        self.counts.runs += 1
        self.lead = self._lead(self.key[LABELS.index("lead_mm")])

    def _lead(self, given: str | None) -> float | None:
        """Return the lead of the screw (mm) of the run that begins; NaN says "not given", what no screw can have is counted."""
        value = given if given is not None else self.constants.get("lead_mm")
        lead = math.nan if value is None else lead_of(value, self.where)
        if abs(lead) <= LARGEST:
            return lead
        self.counts.blank("lead_mm", int(not math.isnan(lead)))
        return None

    def _spikes(self, piece: Chunk) -> Chunk:
        """Count spikes; handle them as told."""
        wild = np.zeros(len(piece), bool)
        for name in REQUIRED[1:]:
            values = piece.signals[name]
            here = spikes(values, self.policy.repair.spike_factor)
            if self.policy.repair.spikes == "interpolate" and here.any():
                good = ~here
                mended = values.copy()
                time = piece.signals["time_s"]
                mended[here] = np.interp(time[here], time[good], values[good])
                piece.signals[name] = mended
            wild |= here
        n = int(wild.sum())
        self.counts.spikes += n
        if n and self.policy.repair.spikes == "drop":
            self.counts.notes.aside("spikes", n)
            return rows_of(piece, ~wild)
        return piece

    def _run(self, piece: Chunk) -> Run:
        assert self.key is not None
        labels = {n: v if v is not None else self.constants.get(n) for n, v in zip(LABELS, self.key, strict=True)}
        text = {n: str(labels[n]) if labels[n] is not None else None for n in ("config_id", "location", "trajectory", "tendon")}
        signals = dict(piece.signals)
        if self.zero is not None:
            signals["time_s"] = signals["time_s"] - self.zero
        for name in OPTIONAL:
            if name in signals and np.isnan(signals[name]).all():
                del signals[name]
        unit_in, unit_out = (self.units.get(n, "N") for n in TENSIONS)
        return Run(
            run_id=self.run_id,
            system=system_of(labels["system"], f"{self.where}, run {self.run_id!r}"),
            lead_mm=self.lead,
            unit_in=unit_in,
            unit_out=unit_out,
            **text,  # type: ignore[arg-type]
            **signals,  # type: ignore[arg-type]
        )


def _filled(time: Array, values: Array) -> Array:
    """Return readings with those that are missing between two others set on the line through them."""
    no_time = np.isnan(time)
    good = np.isfinite(values) & ~no_time
    if good.sum() < 2:
        return values
    inside = ~good & ~no_time & (time > time[good][0]) & (time < time[good][-1])
    order = np.argsort(time[good], kind="stable")
    values = values.copy()
    values[inside] = np.interp(time[inside], time[good][order], values[good][order])
    return values
