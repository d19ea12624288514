"""How well the variants of a model predict configurations that they never saw (Table III)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping.inference import MappingModel
from sstl_cli.mapping.pairs import Pairs
from sstl_cli.mapping.split import HELD_OUT, Splits
from sstl_cli.mapping.variants import VARIANTS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Score:
    """One variant; columns are Gamma_p, Gamma_r and Total, all dimensionless.

    Attributes
    ----------
    rmse : array, shape (seeds, 3)
        RMSE of every seed; Total is the root of the mean of the two squared RMSEs.
    scatter : array, shape (2,)
        Standard deviation of the absolute errors over samples (the +- of Table III), pooled over seeds.
    ensemble : array, shape (3,)
        RMSE of the mean over seeds, on pairs that every seed holds out; NaN where there is none.
    """

    variant: str
    title: str
    rmse: Array
    scatter: Array
    ensemble: Array

    @property
    def mean(self) -> Array:
        mean: Array = self.rmse.mean(axis=0)
        return mean

    @property
    def spread(self) -> Array:
        """Standard deviation over seeds (n - 1), NaN for a single one."""
        return self.rmse.std(axis=0, ddof=1) if len(self.rmse) > 1 else np.full(3, np.nan)

    @property
    def told(self) -> Array:
        """RMSE of the mean over seeds; splits that differ by seed leave no pair to judge it on: then the mean of the seeds'."""
        return self.mean if np.isnan(self.ensemble[2]) else self.ensemble


@dataclass(frozen=True)
class Comparison:
    """Paired over seeds: Total of ``a`` minus ``b``; p values of the t and Wilcoxon tests, NaN where undefined.

    ``p_holm`` is the t test's after Holm's correction for the number of comparisons.
    """

    a: str
    b: str
    difference: float
    p_t: float
    p_wilcoxon: float
    p_holm: float = float("nan")


@dataclass(frozen=True)
class Evaluation:
    """Scores, comparisons, and per pair the prediction (mean over seeds) of every variant, shape (n, 2).

    ``held`` is of shape (seeds, n): which pairs each seed was judged on; ``outside`` of shape (n,): which
    inputs lie outside the trained range.
    """

    pairs: Pairs
    held: NDArray[np.bool_]
    outside: NDArray[np.bool_]
    scores: tuple[Score, ...]
    comparisons: tuple[Comparison, ...]
    predictions: dict[str, Array]

    def score(self, variant: str) -> Score:
        """Return the score of a variant by its name."""
        return next(s for s in self.scores if s.variant == variant)

    def outside_pct(self, seed: int | None = None) -> float:
        """Return the percentage of judged inputs outside the trained range, of one seed (by position) or of all."""
        judged = self.held[seed] if seed is not None else self.held.any(axis=0)
        return float(100.0 * self.outside[judged].mean())


def evaluate(model: MappingModel, pairs: Pairs, everything: bool = False) -> Evaluation:
    """Score every variant of a model.

    Parameters
    ----------
    everything : bool
        Judge on all pairs, those trained on included; otherwise on held-out and new configurations alone.

    Raises
    ------
    SstlError
        E506 if no held-out configuration is among the pairs, E505 if a tendon is unknown to the model.
    """
    header = model.header
    splits = Splits(header.configs, header.seeds, header.roles, header.per_seed_split, header.left_out)
    held = splits.mask(pairs.config_id, HELD_OUT)
    if everything:
        held = np.ones_like(held)
    if not held.any(axis=1).all():
        raise SstlError(
            f"none of the {len(pairs)} pairs is held out: the model was trained on them",
            code="E506",
            fix="give the whole table of the training, new configurations, or --all",
        )
    # pairs that no seed is judged on say nothing here
    shown = np.flatnonzero(held.any(axis=0))
    pairs, held = pairs.take(shown), held[:, shown]
    titles = {v.name: v.title for v in VARIANTS}
    scores, predictions = [], {}
    for name in header.names:
        members = _members(model, pairs, name)
        error = members - pairs.act
        rmse = np.sqrt(np.einsum("sn,snj->sj", held / held.sum(axis=1, keepdims=True), error**2))
        common = held.all(axis=0)
        mean = members.mean(axis=0)
        ensemble = np.sqrt(((mean - pairs.act)[common] ** 2).mean(axis=0)) if common.any() else np.full(2, np.nan)
        scatter = np.abs(error)[held].std(axis=0)
        scores.append(Score(name, titles[name], _with_total(rmse), scatter, _with_total(ensemble[None])[0]))
        predictions[name] = mean
    return Evaluation(pairs, held, model.outside_range(pairs.sstl), tuple(scores), compare(scores), predictions)


def compare(scores: list[Score]) -> tuple[Comparison, ...]:
    """Return the paired tests of every two variants over seeds."""
    found = []
    for a, b in combinations(scores, 2):
        d = a.rmse[:, 2] - b.rmse[:, 2]
        # differences without spread (two closed forms, one seed) leave nothing to test
        testable = len(d) > 1 and np.ptp(d) > 1e-12
        p_t = float(stats.ttest_1samp(d, 0.0).pvalue) if testable else float("nan")
        p_w = float(stats.wilcoxon(d).pvalue) if testable else float("nan")
        found.append(Comparison(a.variant, b.variant, float(d.mean()), p_t, p_w))
    holm = _holm(np.array([c.p_t for c in found]))
    return tuple(Comparison(c.a, c.b, c.difference, c.p_t, c.p_wilcoxon, float(p)) for c, p in zip(found, holm, strict=True))


def _members(model: MappingModel, pairs: Pairs, variant: str) -> Array:
    if not model.header.tendons:
        return model.members(pairs.sstl, variant=variant)
    done = np.empty((len(model.header.seeds), len(pairs), 2))
    tendons = np.array(pairs.tendon)
    for tendon in sorted(set(pairs.tendon)):
        rows = np.flatnonzero(tendons == tendon)
        done[:, rows] = model.members(pairs.sstl[rows], tendon or None, variant)
    return done


def _with_total(rmse: Array) -> Array:
    return np.column_stack([rmse, np.sqrt((rmse**2).mean(axis=1))])


def _holm(p: Array) -> Array:
    """Return p values that stay below alpha at most that often over all tests; NaN stays NaN."""
    done = np.full(len(p), np.nan)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known], kind="stable")]
    factors = len(known) - np.arange(len(known))
    done[order] = np.minimum(np.maximum.accumulate(p[order] * factors), 1.0) if len(known) else []
    return done
