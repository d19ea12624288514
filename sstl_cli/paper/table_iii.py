"""Table III: train the five variants on 150 simulated configurations, and set them against the limit of the data.

The paper divides 75:25 and names no validation part. Here a quarter of each location's configurations is held out, no
configuration is in two parts, and a fifth of the rest (15 % of all) tells each network when to stop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.rng import stream
from sstl_cli.mapping.inference import Group, forward
from sstl_cli.mapping.pairs import Pairs, pairs_of
from sstl_cli.mapping.split import FIT, HELD_OUT, VALIDATION, Splits, make_splits
from sstl_cli.mapping.training import Options, fit
from sstl_cli.mapping.variants import NAMES, VARIANTS, Variant
from sstl_cli.paper.contests import CONTESTS, DIFFERENCE, MEAN, SAMPLES, SEEDS, WINS
from sstl_cli.paper.limit import Errors, bayes, bayes_error, errors
from sstl_cli.paper.settings import LOCATIONS
from sstl_cli.paper.statistics import range_entries
from sstl_cli.paper.table_i_ii import identify
from sstl_cli.physics.generator import PLACES
from sstl_cli.physics.scenario import load

Array = NDArray[np.float64]
Key = tuple[str, str, str]
BEST = "skip-inv"
LEADS = 50
#: training seeds of each data set
SEEDS_EACH = 5


@dataclass(frozen=True)
class Mapping:
    """Table III and what stands around it.

    ``per_seed`` has by variant the errors of every training seed, shape (seeds, 3): pull, release, total; ``samples``
    the standard deviation of the absolute errors over held-out samples, shape (2,), which is the paper's "+-";
    ``limit`` is the Bayes-optimal predictor's error on the generator and ``limit_here`` that on the rows at hand;
    ``left_out`` has for each location the errors of every variant trained without it.
    """

    theta: pa.Table
    pairs: Pairs
    per_seed: dict[str, Array]
    samples: dict[str, Array]
    entries: dict[Key, float]
    limit: Errors
    limit_here: Errors
    left_out: dict[str, dict[str, Errors]]
    predict: Callable[[Array], Array]

    @property
    def best(self) -> str:
        """Name of the network variant with the lowest total error."""
        return min((n for n in NAMES if n != "linear"), key=lambda n: self.entries["III", n, "total"])


@dataclass(frozen=True)
class _Judged:
    """Errors of the five variants on one data set, held-out part by held-out part."""

    per_seed: dict[str, Array]
    samples: dict[str, Array]


def run(
    seed: int,
    seeds: int = SEEDS_EACH,
    without: tuple[str, ...] = (),
    left_out_seeds: int = 3,
    advance: Callable[[float], None] | None = None,
) -> Mapping:
    """Return Table III for one simulated data set with one held-out part, and ``seeds`` training seeds.

    Parameters
    ----------
    without : tuple of str
        Configurations that the mapping handed on (``predict``) must not have seen.
    """
    theta, _ = identify(load("paper-150"), seed)
    pairs = pairs_of(theta)
    found = _judged(pairs, seed, seeds, advance)
    entries = means(found.per_seed)
    entries.update(range_entries(theta))
    ideal = bayes(pairs.sstl, PLACES, LEADS)
    return Mapping(
        theta,
        pairs,
        found.per_seed,
        found.samples,
        entries,
        bayes_error(PLACES, LEADS, stream(seed, "limit")),
        errors(ideal, pairs.act),
        {p: _left_out(pairs, p, seed, left_out_seeds) for p in LOCATIONS},
        handed_on(pairs, without, seed),
    )


def draw(seed: int, seeds: int = SEEDS_EACH) -> dict[str, dict[Key, float]]:
    """Return what one data set gives, by block: means over training seeds, their spread, that over samples, contests."""
    pairs = pairs_of(identify(load("paper-150"), seed)[0])
    found = _judged(pairs, seed, seeds, None)
    total = {name: float(values[:, 2].mean()) for name, values in found.per_seed.items()}
    gaps = {("III", f"{a} - {b}", "total"): total[a] - total[b] for a, b in CONTESTS}
    return {
        MEAN: means(found.per_seed),
        SEEDS: {
            ("III", name, column): float(values[:, i].std(ddof=1))
            for name, values in found.per_seed.items()
            for i, column in enumerate(COLUMNS)
        },
        SAMPLES: {
            ("III", name, column): float(values[i]) for name, values in found.samples.items() for i, column in enumerate(COLUMNS[:2])
        },
        DIFFERENCE: gaps,
        WINS: {key: float(gap < 0.0) for key, gap in gaps.items()},
    }


COLUMNS = ("rmse_p", "rmse_r", "total")


def means(per_seed: dict[str, Array]) -> dict[Key, float]:
    """Return Table III's entries: means over training seeds."""
    return {("III", name, column): float(values[:, i].mean()) for name, values in per_seed.items() for i, column in enumerate(COLUMNS)}


def require_apart(config_id: Sequence[str], splits: Splits) -> None:
    """Raise SstlError (E808) if a configuration is held out and trained on under the same seed."""
    names = np.array(config_id)
    both = splits.mask(config_id, HELD_OUT), splits.mask(config_id, FIT + VALIDATION)
    for held, trained in zip(*both, strict=True):
        leaked = sorted(set(names[held]) & set(names[trained]))
        if leaked or not held.any():
            what = f"{len(leaked)} configurations are trained on and judged on" if leaked else "nothing is held out"
            raise SstlError(what, where=", ".join(leaked[:3]), code="E808")


def _judged(pairs: Pairs, seed: int, seeds: int, advance: Callable[[float], None] | None) -> _Judged:
    splits = make_splits(pairs.location_of(), range(seeds), seed)
    require_apart(pairs.config_id, splits)
    group = _fit(pairs, splits, VARIANTS, advance)
    held = splits.mask(pairs.config_id, HELD_OUT)
    made = {v.name: predictions(group, v, pairs.sstl) for v in VARIANTS}
    return _Judged(
        {name: _errors(p, pairs.act, held) for name, p in made.items()},
        {name: np.abs(p - pairs.act)[held].std(axis=0) for name, p in made.items()},
    )


def predictions(group: Group, variant: Variant, sstl: Array) -> Array:
    """Return the predictions of every seed, shape (seeds, n, 2)."""
    return forward(sstl, group.scaling, group.variants[variant.name], variant.alpha)


def _fit(pairs: Pairs, splits: Splits, variants: tuple[Variant, ...], advance: Callable[[float], None] | None = None) -> Group:
    return fit(pairs.sstl, pairs.act, pairs.config_id, splits, variants, Options(), advance).group


def _errors(predicted: Array, true: Array, held: NDArray[np.bool_]) -> Array:
    """Return pull, release and total RMSE of every seed on its held-out rows, shape (seeds, 3)."""
    found = [errors(p[h], true[h]) for p, h in zip(predicted, held, strict=True)]
    return np.array([[e.rmse_p, e.rmse_r, e.total] for e in found])


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


def handed_on(pairs: Pairs, without: tuple[str, ...], seed: int) -> Callable[[Array], Array]:
    """Return one network of the paper's best variant, trained without the given configurations."""
    kept = pairs.take([i for i, c in enumerate(pairs.config_id) if c not in without])
    best = tuple(v for v in VARIANTS if v.name == BEST)
    splits = make_splits(kept.location_of(), (0,), seed)
    group = _fit(kept, splits, best)
    return lambda sstl: np.asarray(predictions(group, best[0], sstl)[0])
