"""Share the tracking error of command streams out over the stages of the controller."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from sstl_cli.core.documents.control import StagesDocument, StageShares
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.stages import Stream, stage_shares


def streams(table: pa.Table) -> list[Stream]:
    """Return the command streams of a table, one per run and method; uncompensated ones have no stages."""
    frame = table.to_pandas()
    frame = frame[~frame["method"].isin(["none"])]
    out = []
    for (run_id, method), part in frame.groupby(["run_id", "method"], sort=True):
        columns = ("time_s", "tension_ref_n", "tension_cmd_n", "tension_in_n", "tension_out_n")
        arrays = [part[c].to_numpy(float) for c in columns]
        if np.isfinite(np.stack(arrays)).all():
            name = run_id if run_id.endswith(method) else f"{run_id} {method}"
            time, reference, command, t_in, t_out = arrays
            out.append(Stream(name, time, reference, command, t_in, t_out, part["phase"].to_numpy(str)))
    return out


def run(table: pa.Table) -> StagesDocument:
    """Return the stage shares of every command stream.

    Raises
    ------
    SstlError
        If no stream has both tensions, or none can be analysed.
    """
    rows, aside = [], {}
    for stream in streams(table):
        try:
            s = stage_shares(stream)
        except SstlError as error:
            aside[stream.run_id] = error.what
            continue
        rows.append(
            StageShares(
                run_id=s.run_id,
                rmse_n=s.rmse_n,
                simulated_rmse_n=s.simulated_rmse_n,
                share_pct=s.share_pct,
                believed=vars(s.believed),
                true=vars(s.true),
                loop_tau_s=s.loop_tau_s,
            )
        )
    if not rows:
        reason = next(iter(aside.values()), "no compensated stream with input and output tension")
        raise SstlError(f"no command stream can be analysed: {reason}", code="E933")
    return StagesDocument(schema="sstl.stages/1", streams=rows, set_aside=aside)
