"""What a model file says about itself: training data, split, ranges and biases."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from sstl_cli.core.config import Model
from sstl_cli.mapping.variants import BLOCKS, WIDTH

Pair = tuple[float, float]


class VariantHeader(Model):
    """One trained variant: shortcut weight (null for linear regression), lambda and validation RMSE (total)."""

    name: Literal["linear", "plain", "plain-inv", "skip", "skip-inv"]
    alpha: float | None
    weight_inv: float = Field(ge=0)
    rmse_validation: float | None


class Header(Model):
    """Metadata of a mapping model; slopes are dimensionless, biases in N.

    ``configs`` and ``roles`` say for every seed which configurations were fitted (f), used for early stopping (v)
    and held out (h). ``centre``, ``precision`` and ``reach`` bound the trained inputs by Mahalanobis distance.
    """

    schema_id: Literal["sstl.mapping"] = "sstl.mapping"
    schema_version: Literal[1] = 1
    package_version: str
    default: Literal["linear", "plain", "plain-inv", "skip", "skip-inv"]
    variants: tuple[VariantHeader, ...] = Field(min_length=1)
    seed: int
    seeds: tuple[int, ...] = Field(min_length=1)
    split_seed: int
    per_seed_split: bool
    left_out: str
    test_share: float
    configs: tuple[str, ...]
    roles: tuple[str, ...]
    data_sha256: str
    pairs: int
    tendons: tuple[str, ...]
    strategy: Literal["single", "one-hot", "separate"]
    strategy_rmse: dict[str, float]
    input_low: Pair
    input_high: Pair
    centre: Pair
    precision: tuple[Pair, Pair]
    reach: float = Field(ge=0)
    beta_act: Pair | None
    beta_by_tendon: dict[str, Pair | None]
    epochs: int
    learning_rate: float
    weight_decay: float

    @model_validator(mode="after")
    def _agree(self) -> Header:
        if self.default not in self.names:
            raise ValueError("default is not one of the variants")
        if len(set(self.names)) != len(self.names):
            raise ValueError("a variant stands twice")
        if len(self.roles) != len(self.seeds) or any(len(r) != len(self.configs) for r in self.roles):
            raise ValueError("roles do not fit seeds and configs")
        if self.strategy != "single" and len(self.tendons) < 2:
            raise ValueError("strategy needs several tendons")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(v.name for v in self.variants)

    @property
    def group_count(self) -> int:
        return len(self.tendons) if self.strategy == "separate" else 1

    @property
    def inputs(self) -> int:
        """Number of network inputs."""
        return 2 + (len(self.tendons) if self.strategy == "one-hot" else 0)

    def alpha(self, name: str) -> float | None:
        """Return the shortcut weight of a variant, None for linear regression."""
        return next(v.alpha for v in self.variants if v.name == name)

    def one_hot(self, tendon: str | None) -> tuple[float, ...]:
        """Return the indicator inputs of a tendon; empty unless one mapping serves several."""
        return tuple(float(t == tendon) for t in self.tendons) if self.strategy == "one-hot" else ()


def weight_shapes(alpha: float | None, seeds: int, inputs: int) -> dict[str, tuple[int, ...]]:
    """Return name and shape of every weight of a variant."""
    if alpha is None:
        return {"a": (seeds, 2, inputs), "c": (seeds, 2)}
    square, row = (seeds, BLOCKS, WIDTH, WIDTH), (seeds, BLOCKS, WIDTH)
    return {
        "e_w": (seeds, WIDTH, inputs),
        "e_b": (seeds, WIDTH),
        "w1": square,
        "b1": row,
        "w2": square,
        "b2": row,
        "h_w": (seeds, 2, WIDTH),
        "h_b": (seeds, 2),
    }
