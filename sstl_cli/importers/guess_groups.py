"""Groups of channels: columns without readings that name the axes behind them, as a message is written flat (``force,x,y,z``), and the struct of all."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.importers.base import Channel
from sstl_cli.importers.guess_words import SIDE_OF

# a header that holds a name several times is numbered
_AXIS = re.compile(r"([xyz])(?:\.\d+)?", re.IGNORECASE)


def with_groups(channels: Sequence[Channel], data: Mapping[str, NDArray[np.float64]]) -> list[Channel]:
    """Return the columns of a table; an axis behind a column that holds nothing is called after it.

    Examples
    --------
    >>> held = {"force": np.full(3, np.nan), "x.1": np.ones(3)}
    >>> [c.label for c in with_groups([Channel("force"), Channel("x.1")], held)]
    ['', 'force x']
    """
    group, out = "", []
    # Simulink calls what a model gives out, input and output alike
    roots = {c.name.partition(".")[0] for c in channels if "." in c.name} if all("." in c.name for c in channels) else set()
    if len(roots) == 1 and (root := roots.pop()).lower() in SIDE_OF:
        return [replace(c, label=c.label or c.name.removeprefix(f"{root}.")) for c in channels]
    for one in channels:
        axis = _AXIS.fullmatch(one.name)
        if axis is None:
            group = one.name if one.name in data and not np.isfinite(data[one.name]).any() else ""
        out.append(replace(one, label=f"{group} {axis[1].lower()}") if axis and group and not one.label else one)
    return out
