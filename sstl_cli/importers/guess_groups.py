"""Columns without readings that name the axes behind them, as a message is written flat (``force,x,y,z,torque,x,y,z``)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.importers.base import Channel

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
    for one in channels:
        axis = _AXIS.fullmatch(one.name)
        if axis is None:
            group = one.name if one.name in data and not np.isfinite(data[one.name]).any() else ""
        out.append(replace(one, label=f"{group} {axis[1].lower()}") if axis and group and not one.label else one)
    return out
