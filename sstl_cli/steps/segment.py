"""Identify Theta of every run of a log, one run at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.core.tables import PARAMETERS
from sstl_cli.identification import Segmentation, SegmentOptions, segment_run


@dataclass(frozen=True)
class Segmented:
    """A run with its segmentation."""

    run: Run
    segmentation: Segmentation

    def row(self) -> dict[str, object]:
        """Return the row of the Theta table."""
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
            **({"tendon": run.tendon} if run.tendon is not None else {}),
        }


def run(runs: Iterable[Run], options: SegmentOptions) -> Iterator[Segmented]:
    """Yield every run with its segmentation, in the order given.

    Raises
    ------
    SstlError
        If two runs carry the same run_id.
    """
    seen: set[str] = set()
    for one in runs:
        if one.run_id in seen:
            raise SstlError(
                "comes twice", where=f"run {one.run_id!r}", fix="give every run its own run_id", code="E220"
            )
        seen.add(one.run_id)
        yield Segmented(one, segment_run(one, options))
