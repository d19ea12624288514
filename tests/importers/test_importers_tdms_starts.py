"""Waveforms of one TDMS file that were started at different times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter

from sstl_cli.importers.base import Layout, Notes
from sstl_cli.importers.tdms import channels, read

FIRST = np.datetime64("2024-05-03T14:05:06.5")


@pytest.mark.parametrize(
    ("starts", "offsets", "expected"),
    [
        ((FIRST, FIRST + np.timedelta64(2, "s")), (0.0, 0.0), (0.0, 2.0)),
        ((FIRST + np.timedelta64(250, "ms"), FIRST), (0.5, 0.0), (0.75, 0.0)),
        ((FIRST, FIRST), (0.0, 2.0), (0.0, 2.0)),
        # LabVIEW counts from 1904: a start that nobody set
        ((FIRST, np.datetime64("1904-01-01T00:00:00")), (0.0, 0.0), (0.0, 0.0)),
    ],
)
def test_each_clock_begins_with_its_own_channel(
    starts: tuple[np.datetime64, np.datetime64], offsets: tuple[float, float], expected: tuple[float, float], tmp_path: Path
) -> None:
    path = tmp_path / "act.tdms"
    timed = [{"wf_increment": 0.01, "wf_start_offset": o, "wf_start_time": s} for s, o in zip(starts, offsets, strict=True)]
    held = [ChannelObject("Log", n, np.arange(9.0), p) for n, p in zip(("F_in", "F_out"), timed, strict=True)]
    with TdmsWriter(str(path)) as writer:
        writer.write_segment(held)
    clocks = [c.time for c in channels(path, Layout()) if c.time]
    block = next(read(path, clocks, [], Layout(), Notes()))
    assert [float(np.asarray(block.columns[c])[0]) for c in clocks] == pytest.approx(expected)
    assert np.diff(np.asarray(block.columns[clocks[1]])) == pytest.approx(0.01)
