"""What drives a record, as a simulator takes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.neighbours import NEIGHBOUR
from sstl_cli.diagnosis.records import Record, starts_of
from sstl_cli.physics.effect import Drive, Mechanics
from sstl_cli.physics.transmission.model import drive_of, knots

Array = NDArray[np.float64]


def neighbour_of(r: Record) -> Array | None:
    """Return the tension (N, shape (n * factor,)) of the tendons recorded beside, None where that is not known."""
    beside = r.raw.extra.get(NEIGHBOUR)
    return None if beside is None else block_mean(beside, r.thin)[: len(r.u)]


def pieces(r: Record, mechanics: Mechanics) -> list[Drive]:
    """Return what drives a record, cut where a model of it begins anew; clock and path are those of the session where there is one."""
    drive = drive_of(r.system, r.location, r.dt_s, r.u, mechanics, r.rate)
    drive = replace(drive, time_s=drive.time_s + r.begun_s, path_n=drive.path_n + r.gone_n, slip=r.slip, neighbour_n=neighbour_of(r))
    if not r.again:
        return [drive]
    edges = [*(s.at for s in starts_of(r)), len(r.u)]
    return [_part(drive, slice(a, b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def _part(drive: Drive, part: slice) -> Drive:
    """Return a part of a drive, on the clock and the path of the whole."""
    cut = {
        f: getattr(drive, f)[part]
        for f in ("time_s", "tension_n", "rate_n_s", "path_n", "slip", "neighbour_n")
        if getattr(drive, f) is not None
    }
    return replace(drive, knots=knots(cut["tension_n"], drive.dt_s), **cut)
