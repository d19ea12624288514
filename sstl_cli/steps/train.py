"""Train the mapping from the sensing loop's slopes to the actuation tendon's (Section IV-A)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import pyarrow as pa

from sstl_cli.mapping.inference import MappingModel
from sstl_cli.mapping.pairs import Pairs, pairs_of, require_enough
from sstl_cli.mapping.split import FIT, HELD_OUT, VALIDATION, make_splits
from sstl_cli.mapping.tables import HISTORY
from sstl_cli.mapping.variants import VARIANTS, Variant


@dataclass(frozen=True)
class Config:
    """Settings of one training run.

    ``seeds`` training seeds follow from ``seed``, which also divides the configurations; ``per_seed`` holds out
    other configurations for every seed; ``leave_out`` holds out a location instead of a share.
    """

    variants: tuple[Variant, ...] = VARIANTS
    seeds: int = 20
    seed: int = 0
    epochs: int | None = None
    test_share: float = 0.25
    per_seed: bool = False
    leave_out: str | None = None
    strategy: str = "auto"


@dataclass(frozen=True)
class Result:
    """The model, its learning curves (table ``sstl.history``), the pairs it came from and the parts they fell into."""

    model: MappingModel
    history: pa.Table
    pairs: Pairs
    counts: dict[str, int]
    epochs: dict[str, float]


def run(theta: pa.Table, config: Config = Config(), advance: Callable[[float], None] | None = None, where: str = "") -> Result:
    """Train every variant and seed on a Theta table.

    Raises
    ------
    SstlError
        E502 with too few pairs, E503 if a location to leave out is unknown.
    """
    # torch takes over a second to load: not before the tables are known to be sound
    from sstl_cli.mapping.model import Origin, train
    from sstl_cli.mapping.training import Options

    pairs = pairs_of(theta)
    require_enough(pairs, where)
    seeds = range(config.seed, config.seed + config.seeds)
    splits = make_splits(pairs.location_of(), seeds, config.seed, config.test_share, config.per_seed, config.leave_out)
    options = Options() if config.epochs is None else replace(Options(), epochs=config.epochs)
    origin = Origin(config.seed, config.seed, config.test_share)
    trained = train(pairs, splits, config.variants, options, config.strategy, origin, advance)
    parts = ((FIT, "fit"), (VALIDATION, "validation"), (HELD_OUT, "held_out"))
    rows = [
        {"variant": c.variant, "seed": c.seed, "tendon": tendon or None, "epoch": e, "train_loss": a, "val_loss": b}
        for tendon, c in trained.curves
        for e, a, b in zip(c.epoch.tolist(), c.train_loss.tolist(), c.val_loss.tolist(), strict=True)
    ]
    ends: dict[str, list[int]] = {}
    for _, curve in trained.curves:
        ends.setdefault(curve.variant, []).append(int(curve.epoch[curve.val_loss.argmin()]))
    return Result(
        trained.model,
        pa.Table.from_pylist(rows, schema=HISTORY.arrow()),
        pairs,
        {name: splits.roles[0].count(letter) for letter, name in parts},
        {n: sum(e) / len(e) for n, e in ends.items()},
    )
