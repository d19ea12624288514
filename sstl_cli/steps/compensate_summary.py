"""Summarise a compensation: means over configurations, the worst case, and what became of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sstl_cli.core.documents.control import CompensatedRun, MeanScore, ScoreRow
from sstl_cli.steps.compensate import Result

COMPLETE = ("proposed", "DI")


@dataclass(frozen=True)
class Gain:
    """RMSE in N of the best method that was run, and without compensation (None where that was not run)."""

    method: str
    after_n: float | None
    before_n: float | None

    @property
    def less_pct(self) -> float | None:
        """How much smaller the error is, in percent; None where there is nothing to compare with."""
        if self.before_n is None or self.after_n is None or self.method == "none" or self.before_n <= 0:
            return None
        return 100.0 * (1.0 - self.after_n / self.before_n)


def run_entry(result: Result) -> CompensatedRun:
    """Return what is told of one run beside its scores."""
    lines = result.case.lines(result.method) if result.method not in ("none", "recorded") else None
    mapped = None if result.case.mapped is None or result.method == "DI" else result.case.mapped.gamma_p
    return CompensatedRun(
        run_id=result.run_id,
        config_id=result.case.config_id,
        trajectory=result.trajectory,
        method=result.method,
        theta=None if lines is None else (lines.gamma_p, lines.beta_p, lines.gamma_r, lines.beta_r),
        slopes_from=None if lines is None else "mapping" if lines.gamma_p == mapped else "identified",
        outside_trained_range=result.case.outside,
        bound_cost_n=result.bound_cost_n,
        mape_bound_pct={w: s.mape_bound_pct for w, s in result.scores.items()},
    )


def steady(rows: Sequence[ScoreRow]) -> Sequence[ScoreRow]:
    """Return the scores of the window without the first cycle, all of them where there is none."""
    return [r for r in rows if r.window != "all"] or rows


def means(rows: Sequence[ScoreRow]) -> list[MeanScore]:
    """Return means over configurations in the steadiest window, by trajectory, location and method."""
    groups: dict[tuple[str | None, str | None, str], list[ScoreRow]] = {}
    for row in steady(rows):
        groups.setdefault((row.trajectory, row.location, row.method), []).append(row)
    return [
        MeanScore(
            trajectory=trajectory,
            location=location,
            method=method,
            n=len(members),
            rmse_n=_mean([r.rmse_n for r in members]),
            std_n=_mean([r.std_n for r in members]),
            mape_pct=_mean([r.mape_pct for r in members]),
            reduction_pct=_mean([r.reduction_pct for r in members]),
            window=members[0].window,
        )
        for (trajectory, location, method), members in groups.items()
    ]


def gain(summary: Sequence[MeanScore]) -> Gain:
    """Return what the compensation gained, over all references and places."""

    def rmse(method: str) -> float | None:
        return _mean([s.rmse_n for s in summary if s.method == method])

    method = next((m for m in (*COMPLETE, "no-bias") if rmse(m) is not None), summary[0].method)
    return Gain(method, rmse(method), rmse("none"))


def worst_rmse_n(rows: Sequence[ScoreRow]) -> float:
    """Return the largest RMSE (N) of the complete methods (of all compensating ones where neither was run)."""
    for group in (COMPLETE, ("no-bias",), ("none",)):
        values = [r.rmse_n for r in steady(rows) if r.method in group and r.rmse_n is not None]
        if values:
            return max(values)
    return float("nan")


def _mean(values: list[float | None]) -> float | None:
    known = [float(v) for v in values if v is not None]
    return sum(known) / len(known) if known else None
