"""Judge a mapping on configurations it never saw, and relate the slopes of both systems (Tables I, II and III)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import pyarrow as pa

from sstl_cli.core.documents.mapping import ComparisonPart, CorrelationPart, JudgedPart, SummaryPart, TablesPart, VariantScore
from sstl_cli.core.errors import SstlError
from sstl_cli.core.tables import EVALUATION
from sstl_cli.mapping.evaluation import Evaluation, evaluate
from sstl_cli.mapping.header import Header
from sstl_cli.mapping.inference import MappingModel
from sstl_cli.mapping.pairs import Pairs, pairs_of
from sstl_cli.mapping.relations import Relations, relations
from sstl_cli.mapping.tables import PREDICTIONS


@dataclass(frozen=True)
class Related:
    """Tables I and II of the paired configurations, and what could not be paired."""

    relations: Relations
    pairs: Pairs


def run(model: MappingModel, theta: pa.Table, everything: bool = False, where: str = "") -> Evaluation:
    """Return the scores of every variant of a model on a Theta table.

    Raises
    ------
    SstlError
        E504 if nothing is paired, E505 and E506 where the model cannot be judged on it.
    """
    return evaluate(model, _pairs(theta, where), everything)


def run_tables(theta: pa.Table, where: str = "") -> Related:
    """Return the numbers of Tables I and II from a Theta table.

    Raises
    ------
    SstlError
        E504 if nothing is paired.
    """
    pairs = _pairs(theta, where)
    return Related(relations(pairs.sstl, pairs.act), pairs)


def evaluation_table(found: Evaluation, seeds: tuple[int, ...]) -> pa.Table:
    """Return the table ``sstl.evaluation``: a row a variant and seed, and one of the mean over seeds (seed null)."""
    rows = []
    for score in found.scores:
        lines: list[tuple[int | None, Any, float]] = [(seed, score.rmse[k], found.outside_pct(k)) for k, seed in enumerate(seeds)]
        if score.ensemble[2] == score.ensemble[2]:
            lines.append((None, score.ensemble, found.outside_pct()))
        for seed, rmse, outside in lines:
            values = dict(zip(("rmse_gamma_p", "rmse_gamma_r", "rmse_total"), rmse.tolist(), strict=True))
            rows.append({"variant": score.variant, "seed": seed, **values, "outside_range_pct": outside})
    return pa.Table.from_pylist(rows, schema=EVALUATION.arrow())


def predictions_table(found: Evaluation) -> pa.Table:
    """Return the table ``sstl.predictions``: true and predicted slopes of every judged pair and variant."""
    p = found.pairs
    pieces = [
        pa.Table.from_arrays(
            [
                pa.array(p.config_id),
                pa.array([v or None for v in p.location], pa.string()),
                pa.array([v or None for v in p.tendon], pa.string()),
                pa.repeat(pa.scalar(name), len(p)),
                p.act[:, 0],
                mean[:, 0],
                p.act[:, 1],
                mean[:, 1],
                found.outside,
            ],
            schema=PREDICTIONS.arrow(),
        )
        for name, mean in found.predictions.items()
    ]
    return pa.concat_tables(pieces)


def document(found: Evaluation, header: Header) -> JudgedPart:
    """Return how the variants of a model do."""
    names = ("gamma_p", "gamma_r", "total")
    gamma_p, gamma_r, total = found.score(header.default).told.tolist()
    return JudgedPart(
        default=header.default,
        pairs=len(found.pairs),
        seeds=list(header.seeds),
        per_seed_split=header.per_seed_split,
        left_out=header.left_out or None,
        rmse_gamma_p=gamma_p,
        rmse_gamma_r=gamma_r,
        rmse_total=total,
        outside_range_pct=found.outside_pct(),
        outside_range=[c for c, o in zip(found.pairs.config_id, found.outside, strict=True) if o],
        variants=[
            VariantScore(
                variant=s.variant,
                title=s.title,
                rmse_mean=dict(zip(names, s.mean.tolist(), strict=True)),
                rmse_sd_over_seeds=dict(zip(names, s.spread.tolist(), strict=True)),
                abs_error_sd_over_samples=dict(zip(names, s.scatter.tolist(), strict=False)),
                rmse_of_mean_over_seeds=dict(zip(names, s.ensemble.tolist(), strict=True)),
            )
            for s in found.scores
        ],
        comparisons=[ComparisonPart(**asdict(c)) for c in found.comparisons],
    )


def tables_document(found: Related) -> TablesPart:
    """Return Tables I and II."""
    r = found.relations
    return TablesPart(
        table_i={d: CorrelationPart(**asdict(c)) for d, c in r.correlation.items()},
        table_ii={s: {q: SummaryPart(**asdict(v)) for q, v in rows.items()} for s, rows in r.slopes.items()},
    )


def _pairs(theta: pa.Table, where: str) -> Pairs:
    pairs = pairs_of(theta)
    if not len(pairs):
        reasons = "; ".join(f"{k}: {v}" for k, v in list(pairs.aside.items())[:3])
        raise SstlError(
            "holds no configuration with both systems" + (f" ({reasons})" if reasons else ""),
            where=where,
            fix="give act and sstl runs with the same config_id",
            code="E504",
        )
    return pairs
