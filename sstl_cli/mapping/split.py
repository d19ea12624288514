"""Divide configurations into fit, validation and held-out parts; no configuration is in two of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.rng import stream

FIT, VALIDATION, HELD_OUT = "f", "v", "h"
# of the training part; the rest is fitted
VALIDATION_SHARE = 0.2


@dataclass(frozen=True)
class Splits:
    """Roles of the configurations, one string of letters f, v, h a training seed.

    ``seeds`` and ``roles`` run together; letter i of a role belongs to ``configs[i]``. By default all seeds
    share the held-out part and differ in validation; with ``per_seed`` each holds out its own.
    """

    configs: tuple[str, ...]
    seeds: tuple[int, ...]
    roles: tuple[str, ...]
    per_seed: bool = False
    left_out: str = ""

    def mask(self, config_id: Sequence[str], parts: str) -> NDArray[np.bool_]:
        """Return, shape (seeds, n), whether each row's configuration has one of the roles; unknown: held out."""
        place = {c: i for i, c in enumerate(self.configs)}
        at = [place.get(c, -1) for c in config_id]
        return np.array([[(r[i] if i >= 0 else HELD_OUT) in parts for i in at] for r in self.roles], dtype=bool)


def make_splits(
    location_of: dict[str, str],
    seeds: Sequence[int],
    split_seed: int,
    test_share: float = 0.25,
    per_seed: bool = False,
    leave_out: str | None = None,
) -> Splits:
    """Return the splits of every training seed.

    Parameters
    ----------
    location_of : dict
        Location of every configuration; the shares hold within each location, as far as whole numbers allow.
    seeds : sequence of int
        Training seeds.
    split_seed : int
        Seed of the division into training and held-out configurations.
    test_share : float
        Share held out, 0.25 in the paper.
    per_seed : bool
        Hold out other configurations for every seed.
    leave_out : str, optional
        Location that is held out as a whole; then nothing else is.

    Raises
    ------
    SstlError
        E503 if the location is unknown or nothing remains to train on.
    """
    configs = tuple(sorted(location_of))
    places = np.array([location_of[c] for c in configs])
    if leave_out is not None and leave_out not in places:
        hint = nearest(leave_out, {str(p) for p in places if p})
        raise SstlError(f"no configuration at location '{leave_out}' ({hint})", where="--leave-out", code="E503")
    if leave_out is not None and (places != leave_out).sum() < 4:
        raise SstlError(
            "too few configurations at other locations to train on", where="--leave-out", fix="record at least 4 elsewhere", code="E503"
        )
    roles = []
    for seed in seeds:
        if leave_out is None:
            held = _draw(places, test_share, split_seed, "held-out", seed if per_seed else 0)
        else:
            held = places == leave_out
        rest = np.flatnonzero(~held)
        role = np.where(held, HELD_OUT, FIT)
        role[rest[_draw(places[rest], VALIDATION_SHARE, split_seed, "validation", seed)]] = VALIDATION
        roles.append("".join(role))
    return Splits(configs, tuple(seeds), tuple(roles), per_seed, leave_out or "")


def _draw(places: NDArray[np.str_], share: float, split_seed: int, *name: str | int) -> NDArray[np.bool_]:
    """Return which items are drawn: a share of each place by turns, at least one and not all."""
    rng = stream(split_seed, "mapping", *name)
    n = len(places)
    order = rng.permutation(n)
    # deal the places in shuffled order, then take evenly spaced items: every place gives its share
    order = order[np.argsort(places[order], kind="stable")]
    count = min(max(round(share * n), 1), n - 1)
    at = np.floor((np.arange(count) + rng.random()) * n / count).astype(int)
    drawn = np.zeros(n, dtype=bool)
    drawn[order[at]] = True
    return drawn
