"""Identify Theta of every run of a log, one run at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import pyarrow as pa

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.core.tables import PARAMETERS, PHASES, TENDON, Column, theta_units
from sstl_cli.identification import PHASE_NAMES, Segmentation, SegmentOptions, gate, segment_run
from sstl_cli.identification.gate import Remark
from sstl_cli.steps.theta_rows import ThetaRows, row_of


@dataclass(frozen=True)
class Segmented:
    """A run with its segmentation."""

    run: Run
    segmentation: Segmentation

    def values(self) -> dict[str, str | float | None]:
        """Return the fields of the row of the Theta table."""
        run, found = self.run, self.segmentation
        return {
            "run_id": run.run_id,
            "config_id": run.config_id,
            "system": run.system,
            "location": run.location,
            "lead_mm": run.lead_mm,
            **{p: found.theta[p] for p in PARAMETERS},
            **{p + "_se": found.theta_se[p] for p in PARAMETERS},
            "inlier_p": found.inlier_p,
            "inlier_r": found.inlier_r,
            "rmse_p_n": found.rmse_p_n,
            "rmse_r_n": found.rmse_r_n,
            "loops": found.loops,
            "status": found.status,
            "tendon": run.tendon,
        }

    def row(self) -> ThetaRow:
        """Return the row of the Theta table."""
        return row_of(self.values())

    def phase_table(self) -> pa.Table:
        """Return the phase PB, PP, RB or RP of every sample."""
        n = len(self.run)
        phase = pa.DictionaryArray.from_arrays(pa.array(self.segmentation.phases), pa.array(PHASE_NAMES))
        arrays = [pa.repeat(pa.scalar(self.run.run_id), n), pa.array(self.run.time_s), phase.cast(pa.string())]
        return pa.Table.from_arrays(arrays, schema=PHASES.arrow())


@dataclass(frozen=True)
class Identified:
    """The rows of the Theta table, what the physics gate says of the runs, and the units of input and output."""

    rows: ThetaRows
    remarks: tuple[Remark, ...]
    unit_in: str
    unit_out: str

    @property
    def units(self) -> dict[str, str]:
        """The units of the columns, where they are not those of newtons."""
        return theta_units(self.unit_in, self.unit_out)

    @property
    def aside(self) -> list[tuple[str, str]]:
        """The runs whose rows are null in part or whole, each with the reason."""
        return [(run_id, status) for run_id, status in self.rows.statuses() if status != "ok"]


def identify(
    runs: Iterable[Run], options: SegmentOptions, physics: bool = True, each: Callable[[Segmented], None] = lambda _: None, where: str = ""
) -> Identified:
    """Return Theta of every run; runs that fail the physics gate are set aside, unless ``physics`` is off.

    Parameters
    ----------
    each : callable
        Told every run with its segmentation, as it comes: neither is kept.

    Raises
    ------
    SstlError
        If there is no run, two carry the same run_id, they are in different units, or all fail the gate.
    """
    rows, evidence = ThetaRows(), gate.Witnesses()
    unit_in = unit_out = "N"
    for found in run(runs, options):
        rows.add(found.values())
        unit_in, unit_out = found.run.unit_in, found.run.unit_out
        if physics:
            evidence.add(found.run)
        each(found)
    if not rows:
        raise SstlError("holds no run", where=where, fix="import a recording first", code="E221")
    remarks = gate.judge(evidence.log)
    return Identified(_set_aside(rows, remarks), remarks, unit_in, unit_out)


def run(runs: Iterable[Run], options: SegmentOptions) -> Iterator[Segmented]:
    """Yield every run with its segmentation, in the order given.

    Raises
    ------
    SstlError
        If two runs carry the same run_id, or runs are in different units.
    """
    seen: set[str] = set()
    units: dict[str, str] | None = None
    for one in runs:
        units = units or one.units
        if one.units != units:
            raise SstlError(
                f"has the output in {one.unit_out}, the runs before it in {units['tension_out_n']}",
                where=f"run {one.run_id!r}",
                fix="segment logs of one unit at a time",
                code="E222",
            )
        if one.run_id in seen:
            raise SstlError("comes twice", where=f"run {one.run_id!r}", fix="give every run its own run_id", code="E220")
        seen.add(one.run_id)
        yield Segmented(one, segment_run(one, options))


def _set_aside(rows: ThetaRows, remarks: Sequence[Remark]) -> ThetaRows:
    """Return the rows of the Theta table with those that fail the physics gate null and the reason in their status.

    Raises
    ------
    SstlError
        If no run is left.
    """
    failed: dict[str, Remark] = {}
    for remark in (r for r in reversed(remarks) if r.failed):
        failed.update(dict.fromkeys(remark.run_ids, remark))
    if not failed:
        return rows
    # a run that shows no slope anyway says itself why
    told = rows.seen()
    why = {name: remark for name, remark in failed.items() if name in told}
    if why and all(run_id in failed for run_id, _ in rows.statuses()):
        first = next(iter(why.values()))
        fix = f"in the mapping: {first.mend}; or --no-physics (in Python physics=False), if you know better"
        raise SstlError(f"cannot be right: {first.sentence}", fix=fix, code="E223")
    return rows.nulled({name: f"fails the physics gate ({said.rule}): {said.sentence}" for name, said in why.items()})


def extra_columns(rows: ThetaRows) -> list[Column]:
    """Return the columns that these rows of the Theta table have beyond its schema."""
    return [TENDON] if rows.name_tendons else []


def theta_table(rows: Sequence[ThetaRow]) -> pa.Table:
    """Return the Theta table of these rows."""
    return (rows if isinstance(rows, ThetaRows) else ThetaRows(rows)).table()
