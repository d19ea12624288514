"""Rows of the tables that a page shows, as far as it shows them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from sstl_cli.reporting.documents import number

_PREDICTED, _TRUE = ("pred", "predicted", "hat"), ("true", "target", "measured")


@dataclass(frozen=True)
class Epoch:
    """The losses of one variant and seed after one epoch; NaN where there is none."""

    variant: str
    epoch: int
    train_loss: float
    val_loss: float
    file: str = ""


@dataclass(frozen=True)
class Evaluated:
    """One variant and seed on configurations that were held out; the mean prediction over all seeds has no seed."""

    variant: str
    seed: int | None
    rmse_gamma_p: float
    rmse_gamma_r: float
    rmse_total: float
    outside_range_pct: float
    file: str = ""


Row = TypeVar("Row", Epoch, Evaluated)


@dataclass(frozen=True)
class Predicted:
    """One parameter of one configuration, true and predicted; ``group`` is the location, else the variant."""

    quantity: str
    group: str
    true: float
    predicted: float


def apart(rows: Sequence[Row]) -> list[Row]:
    """Return rows whose variants are named by their file where there are several: another model is no other seed.

    Examples
    --------
    >>> [row.variant for row in apart([Epoch("a", 0, 1.0, 1.0, "x.parquet"), Epoch("a", 0, 2.0, 2.0, "y.parquet")])]
    ['a (x.parquet)', 'a (y.parquet)']
    >>> [row.variant for row in apart([Epoch("a", 0, 1.0, 1.0, "x.parquet"), Epoch("a", 1, 2.0, 2.0, "x.parquet")])]
    ['a', 'a']
    """
    if len({row.file for row in rows}) < 2:
        return list(rows)
    return [replace(row, variant=f"{row.variant} ({row.file})") for row in rows]


def epochs(rows: Iterable[Mapping[str, object]], file: str = "") -> Iterator[Epoch]:
    """Yield the rows of a training history that have an epoch."""
    for row in rows:
        at = number(row.get("epoch"))
        if at >= 0:
            yield Epoch(str(row.get("variant", "–")), int(at), number(row.get("train_loss")), number(row.get("val_loss")), file)


def predictions(rows: Sequence[Mapping[str, object]]) -> Iterator[Predicted]:
    """Yield every quantity of which a row has both the true and the predicted value; of several variants each by itself.

    Their errors taken together are those of no mapping.
    """
    several = len({row.get("variant") for row in rows}) > 1
    for quantity, (truth, guess) in columns(list(rows[0]) if rows else []).items():
        for row in rows:
            x, y = number(row.get(truth)), number(row.get(guess))
            if x == x and y == y:
                yield Predicted(
                    f"{quantity} {row.get('variant')}" if several else quantity,
                    str(row.get("location") or row.get("variant") or "all"),
                    x,
                    y,
                )


def columns(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return quantity -> (true column, predicted column) by their names.

    Both ``gamma_p_true``/``gamma_p_pred`` and ``true_gamma_p``/``pred_gamma_p`` are understood; where there is
    no such true column, ``gamma_p`` itself is the truth of ``gamma_p_pred``.

    Examples
    --------
    >>> columns(["gamma_p", "gamma_p_hat", "true_gamma_r", "pred_gamma_r", "x_pred"])
    {'gamma_p': ('gamma_p', 'gamma_p_hat'), 'gamma_r': ('true_gamma_r', 'pred_gamma_r')}
    """
    found = {}
    for name in names:
        for word in _PREDICTED:
            for base, form in ((name.removesuffix("_" + word), "{0}_{1}"), (name.removeprefix(word + "_"), "{1}_{0}")):
                if base == name:
                    continue
                truth = next((t for t in [form.format(base, w) for w in _TRUE] if t in names), base if base in names else None)
                if truth is not None:
                    found[base] = (truth, name)
    return dict(sorted(found.items()))
