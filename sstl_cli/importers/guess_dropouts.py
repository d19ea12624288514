"""Rows without a reading of one tension, as where channels of several rates are put into one table: what an import makes of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.importers.guess_look import Look
from sstl_cli.importers.guess_stamps import GAP
from sstl_cli.importers.guess_time import MARK

# of the rows, how many hold both tensions where a few readings were lost
WHOLE = 0.9
# of the rarer tension's readings, how many stand beside one of the other where both were taken together
TOGETHER = 0.5


def with_dropouts(toml: str, look: Look) -> tuple[str, tuple[str, ...]]:
    """Return a proposal with what becomes of rows that lack a tension, and the reason; the proposal alone where hardly any does.

    Parameters
    ----------
    toml : str
        The proposal for one file.
    """
    held = [_read(look, [s.name for s in many]) for many in (look.roles.first, look.roles.second)]
    # channels on clocks of their own are put together by these
    if look.own or not all(len(v) for v in held) or len({len(v) for v in held}) > 1:
        return toml, ()
    both = int((held[0] & held[1]).sum())
    counts = [int(v.sum()) for v in held]
    rows = int((held[0] | held[1]).sum())
    if both >= WHOLE * rows or not all(counts):
        return toml, ()
    said = f"of {rows} rows {counts[0]} hold the input, {counts[1]} the output, {both} both"
    if both >= TOGETHER * min(counts):
        # readings that were taken together need none in between
        return f'{toml}\n[repair]\ndropouts = "drop"\n', (f'{said}: dropouts = "drop" keeps these, "interpolate" fills the others',)
    clock = look.data.get(look.time.channel or "", np.arange(len(held[0]), dtype=float))
    holes = [longest for v in held if (longest := _longest(clock[v])) > GAP]
    question = f"up to {max(holes):.0f} usual steps without a reading are bridged by a straight line: right?" if holes else ""
    line = 'dropouts = "interpolate"' + (MARK + question if question else "")
    return f"{toml}\n[repair]\n{line}\n", (
        f'{said}: rates of their own, dropouts = "interpolate" sets each on the line between its readings',
    )


def _read(look: Look, names: list[str]) -> NDArray[np.bool_]:
    """Return where all of some channels of a file have a reading, shape (n,); no element where one is missing or of another length."""
    values = [look.data[n] for n in names if n in look.data]
    if not values or len(values) < len(names) or len({len(v) for v in values}) > 1:
        return np.empty(0, np.bool_)
    return np.asarray(np.isfinite(np.sum(values, axis=0)))


def _longest(times: NDArray[np.float64]) -> float:
    """Return the longest of the steps between readings, in usual ones."""
    steps = np.diff(times[np.isfinite(times)])
    usual = float(np.median(steps)) if len(steps) else 0.0
    return float(steps.max()) / usual if usual > 0.0 else 0.0
