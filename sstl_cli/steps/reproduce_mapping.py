"""Table III: train the five variants on 150 simulated configurations, and set them against the limit of the data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from scipy import stats

from sstl_cli.core.rng import stream
from sstl_cli.mapping.inference import Group, forward
from sstl_cli.mapping.pairs import Pairs, pairs_of
from sstl_cli.mapping.split import FIT, HELD_OUT, VALIDATION, Splits, make_splits
from sstl_cli.mapping.training import Options, fit
from sstl_cli.mapping.variants import NAMES, VARIANTS, Variant
from sstl_cli.paper.generator import PLACES
from sstl_cli.paper.limit import Errors, bayes, bayes_error, errors
from sstl_cli.paper.settings import LOCATIONS
from sstl_cli.paper.statistics import range_entries
from sstl_cli.physics.scenario import load
from sstl_cli.steps.reproduce_slopes import identify

Array = NDArray[np.float64]
Key = tuple[str, str, str]
BEST = "skip-inv"
LEADS = 50


@dataclass(frozen=True)
class PairedTest:
    """Two variants on the same splits: mean difference of Total, and two p values.

    ``p_corrected`` is the paired t test with the variance raised by test/training size (Nadeau and Bengio
    2003), since the splits share configurations; ``p_wilcoxon`` the signed-rank test that ignores this.
    """

    first: str
    second: str
    difference: float
    p_corrected: float
    p_wilcoxon: float


@dataclass(frozen=True)
class Mapping:
    """Table III and what stands around it.

    ``per_seed`` has by variant the errors of every seed, shape (seeds, 3): pull, release, total; ``limit`` is the
    Bayes-optimal predictor's error on the generator and ``limit_here`` that on the held-out rows at hand;
    ``left_out`` has for each location the errors of every variant trained without it.
    """

    theta: pa.Table
    pairs: Pairs
    per_seed: dict[str, Array]
    entries: dict[Key, float]
    spread: dict[Key, float]
    tests: tuple[PairedTest, ...]
    limit: Errors
    limit_here: Errors
    left_out: dict[str, dict[str, Errors]]
    predict: Callable[[Array], Array]

    @property
    def best(self) -> str:
        """Name of the network variant with the lowest total error."""
        return min((n for n in NAMES if n != "linear"), key=lambda n: self.entries["III", n, "total"])


def run(
    seed: int,
    seeds: int,
    without: tuple[str, ...] = (),
    left_out_seeds: int = 3,
    advance: Callable[[float], None] | None = None,
) -> Mapping:
    """Return Table III for one simulated data set and ``seeds`` training seeds, each with its own held-out part.

    Parameters
    ----------
    without : tuple of str
        Configurations that the mapping handed on (``predict``) must not have seen.
    """
    theta, _ = identify(load("paper-150"), seed)
    pairs = pairs_of(theta)
    splits = make_splits(pairs.location_of(), range(seeds), seed, per_seed=True)
    group = _fit(pairs, splits, VARIANTS, advance)
    held = splits.mask(pairs.config_id, HELD_OUT)
    per_seed = {v.name: _errors(predictions(group, v, pairs.sstl), pairs.act, held) for v in VARIANTS}
    ideal = bayes(pairs.sstl, PLACES, LEADS)
    entries, spread = _entries(per_seed)
    entries.update(range_entries(theta))
    share = held[0].sum() / splits.mask(pairs.config_id, FIT + VALIDATION)[0].sum()
    tests = tuple(paired_test(per_seed, a, b, float(share)) for a, b in _contests())
    return Mapping(
        theta,
        pairs,
        per_seed,
        entries,
        spread,
        tests,
        bayes_error(PLACES, LEADS, stream(seed, "limit")),
        errors(ideal, pairs.act),
        {p: _left_out(pairs, p, seed, left_out_seeds) for p in LOCATIONS},
        _handed_on(pairs, without, seed),
    )


def predictions(group: Group, variant: Variant, sstl: Array) -> Array:
    """Return the predictions of every seed, shape (seeds, n, 2)."""
    return forward(sstl, group.scaling, group.variants[variant.name], variant.alpha)


def paired_test(per_seed: dict[str, Array], first: str, second: str, share: float) -> PairedTest:
    """Return whether two variants differ over the same seeds; ``share`` is test size over training size."""
    d = per_seed[first][:, 2] - per_seed[second][:, 2]
    n = len(d)
    if n < 2 or not d.std() > 0:
        return PairedTest(first, second, float(d.mean()), float("nan"), float("nan"))
    t = d.mean() / np.sqrt((1.0 / n + share) * d.var(ddof=1))
    return PairedTest(
        first, second, float(d.mean()), float(2.0 * stats.t.sf(abs(t), n - 1)), float(stats.wilcoxon(d).pvalue)
    )


def _contests() -> list[tuple[str, str]]:
    against_linear = [(n, "linear") for n in NAMES if n != "linear"]
    return [*against_linear, ("plain-inv", "plain"), ("skip-inv", "skip"), ("skip", "plain"), ("skip-inv", "plain-inv")]


def _fit(
    pairs: Pairs, splits: Splits, variants: tuple[Variant, ...], advance: Callable[[float], None] | None = None
) -> Group:
    return fit(pairs.sstl, pairs.act, pairs.config_id, splits, variants, Options(), advance).group


def _errors(predicted: Array, true: Array, held: NDArray[np.bool_]) -> Array:
    """Return pull, release and total RMSE of every seed on its held-out rows, shape (seeds, 3)."""
    found = [errors(p[h], true[h]) for p, h in zip(predicted, held, strict=True)]
    return np.array([[e.rmse_p, e.rmse_r, e.total] for e in found])


def _entries(per_seed: dict[str, Array]) -> tuple[dict[Key, float], dict[Key, float]]:
    """Return means and standard deviations over seeds; Total is the root of the mean of both squared RMSEs."""
    entries: dict[Key, float] = {}
    spread: dict[Key, float] = {}
    for name, values in per_seed.items():
        mean = values.mean(axis=0)
        sd = values.std(axis=0, ddof=1) if len(values) > 1 else np.zeros(3)
        total = Errors(float(mean[0]), float(mean[1])).total
        for i, (column, value) in enumerate(zip(("rmse_p", "rmse_r", "total"), (mean[0], mean[1], total), strict=True)):
            entries["III", name, column], spread["III", name, column] = float(value), float(sd[i])
    return entries, spread


def _left_out(pairs: Pairs, place: str, seed: int, seeds: int) -> dict[str, Errors]:
    """Return the errors at a location that training never saw: every variant, and the ideal map of the other two."""
    splits = make_splits(pairs.location_of(), range(seeds), seed, leave_out=place)
    group = _fit(pairs, splits, VARIANTS)
    away = np.array(pairs.location) == place
    found = {}
    for v in VARIANTS:
        each = [errors(p[away], pairs.act[away]) for p in predictions(group, v, pairs.sstl)]
        found[v.name] = Errors(float(np.mean([e.rmse_p for e in each])), float(np.mean([e.rmse_r for e in each])))
    others = [p for p in PLACES if p.name != place]
    found["ideal of the others"] = errors(bayes(pairs.sstl[away], others, LEADS), pairs.act[away])
    return found


def _handed_on(pairs: Pairs, without: tuple[str, ...], seed: int) -> Callable[[Array], Array]:
    kept = pairs.take([i for i, c in enumerate(pairs.config_id) if c not in without])
    best = tuple(v for v in VARIANTS if v.name == BEST)
    group = _fit(kept, make_splits(kept.location_of(), range(5), seed, per_seed=True), best)
    return lambda sstl: predictions(group, best[0], sstl).mean(axis=0)
