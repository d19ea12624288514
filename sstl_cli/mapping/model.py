"""From pairs to a model: train every variant, one mapping for all tendons or one each, and describe the result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli import __version__
from sstl_cli.mapping import training
from sstl_cli.mapping.header import Header, Pair, VariantHeader
from sstl_cli.mapping.inference import Group, MappingModel, distance
from sstl_cli.mapping.pairs import Pairs
from sstl_cli.mapping.split import FIT, VALIDATION, Splits
from sstl_cli.mapping.variants import VARIANTS, Variant

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trained:
    """A model and the learning curves of its members; ``curves`` go with the tendon they belong to ('' for all)."""

    model: MappingModel
    curves: tuple[tuple[str, training.Curve], ...]


@dataclass(frozen=True)
class _Attempt:
    strategy: str
    groups: tuple[Group, ...]
    curves: tuple[tuple[str, training.Curve], ...]
    rmse: dict[str, Array]

    @property
    def score(self) -> float:
        return min(float(np.mean(r)) for r in self.rmse.values())


@dataclass(frozen=True)
class Origin:
    """What seeds and splits were drawn from, for the header of the model."""

    seed: int = 0
    split_seed: int = 0
    test_share: float = 0.25


def train(
    pairs: Pairs,
    splits: Splits,
    variants: tuple[Variant, ...] = VARIANTS,
    options: training.Options = training.Options(),
    strategy: str = "auto",
    origin: Origin = Origin(),
    advance: Callable[[float], None] | None = None,
) -> Trained:
    """Train all variants and seeds and return the model with the best variant of the validation part as default.

    Parameters
    ----------
    strategy : str
        With several tendons: ``one-hot`` (one mapping, indicator inputs), ``separate`` (one mapping each) or
        ``auto`` (both, kept is the one with the lower validation error). Without meaning for a single tendon.
    advance : callable, optional
        Told the share of the work done since it was told last; the shares sum to 1.
    """
    names = ["single"] if not pairs.tendons else [strategy] if strategy != "auto" else ["one-hot", "separate"]
    attempts = [_attempt(n, pairs, splits, variants, options, _share(advance, len(names))) for n in names]
    # the first is kept on a tie: one mapping is the simpler
    kept = min(attempts, key=lambda a: a.score)
    scores = {n: float(np.mean(r)) for n, r in kept.rmse.items()}
    training_rows = splits.mask(pairs.config_id, FIT + VALIDATION).any(axis=0)
    seen = pairs.take(np.flatnonzero(training_rows))
    inputs = _range(seen.sstl)
    header = Header(
        package_version=__version__,
        default=min(scores, key=lambda n: scores[n]),
        variants=tuple(
            VariantHeader(name=v.name, alpha=v.alpha, weight_inv=v.weight_inv, rmse_validation=scores[v.name]) for v in variants
        ),
        seed=origin.seed,
        seeds=splits.seeds,
        split_seed=origin.split_seed,
        per_seed_split=splits.per_seed,
        left_out=splits.left_out,
        test_share=origin.test_share,
        configs=splits.configs,
        roles=splits.roles,
        data_sha256=pairs.sha256(),
        pairs=len(pairs),
        tendons=pairs.tendons,
        strategy=kept.strategy,
        strategy_rmse={a.strategy: a.score for a in attempts},
        beta_act=_biases(seen.beta_act),
        beta_by_tendon={t: _biases(seen.beta_act[np.array(seen.tendon) == t]) for t in pairs.tendons},
        epochs=options.epochs,
        learning_rate=options.learning_rate,
        weight_decay=options.weight_decay,
        input_low=inputs.low,
        input_high=inputs.high,
        centre=inputs.centre,
        precision=inputs.precision,
        reach=inputs.reach,
    )
    return Trained(MappingModel(header, kept.groups), kept.curves)


def _attempt(
    strategy: str,
    pairs: Pairs,
    splits: Splits,
    variants: tuple[Variant, ...],
    options: training.Options,
    advance: Callable[[float], None] | None,
) -> _Attempt:
    if strategy == "separate":
        tendons = np.array(pairs.tendon)
        parts = [(t, pairs.take(np.flatnonzero(tendons == t))) for t in pairs.tendons]
        told = _share(advance, len(parts))
        done = [(t, training.fit(p.sstl, p.act, p.config_id, splits, variants, options, told), len(p)) for t, p in parts]
        total = sum(n for *_, n in done)
        rmse = {v.name: np.sqrt(sum(n * f.rmse_validation[v.name] ** 2 for _, f, n in done) / total) for v in variants}
        curves = tuple((t, c) for t, f, _ in done for c in f.curves)
        return _Attempt(strategy, tuple(f.group for _, f, _ in done), curves, rmse)
    x = pairs.sstl
    if strategy == "one-hot":
        x = np.hstack([x, [[float(t == n) for n in pairs.tendons] for t in pairs.tendon]])
    found = training.fit(x, pairs.act, pairs.config_id, splits, variants, options, advance)
    return _Attempt(strategy, (found.group,), tuple(("", c) for c in found.curves), found.rmse_validation)


@dataclass(frozen=True)
class _Range:
    """The box of the trained inputs, and their centre, inverse covariance and largest distance from it."""

    low: Pair
    high: Pair
    centre: Pair
    precision: tuple[Pair, Pair]
    reach: float


def _range(x: Array) -> _Range:
    """Return box, centre, inverse covariance and largest distance of the trained inputs."""
    centre: Array = x.mean(axis=0)
    # where inputs do not spread, the pseudo-inverse leaves that direction to the box
    precision = np.asarray(np.linalg.pinv(np.cov(x.T, bias=True), rcond=1e-12, hermitian=True), np.float64)
    reach = distance(x, centre, precision).max() * (1 + 1e-9)
    return _Range(_pair(x.min(axis=0)), _pair(x.max(axis=0)), _pair(centre), (_pair(precision[0]), _pair(precision[1])), float(reach))


def _pair(values: Array) -> Pair:
    return float(values[0]), float(values[1])


def _biases(beta: Array) -> tuple[float, float] | None:
    """Return mean biases in N over the runs that have them, None where none has."""
    known = [column[np.isfinite(column)] for column in beta.T]
    return (float(known[0].mean()), float(known[1].mean())) if all(len(k) for k in known) else None


def _share(advance: Callable[[float], None] | None, parts: int) -> Callable[[float], None] | None:
    return (lambda share: advance(share / parts)) if advance is not None else None
