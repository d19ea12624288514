"""Rows that were stamped on arrival, beside recorders that do pause."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.core.errors import SstlError
from sstl_cli.core.packets import packets_of
from sstl_cli.core.rng import stream
from sstl_cli.identification.samples import Piece, findings
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run


def movement(t: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two tensions (N) at some moments (s), with their noise."""
    rng = stream(seed, "packets")
    x = 12.0 + 8.0 * np.sin(0.7 * t) + 3.0 * np.sin(1.9 * t + seed)
    return x + 0.05 * rng.standard_normal(len(t)), 0.6 * x + 0.05 * rng.standard_normal(len(t))


def arrived(n: int, rows: int, rate_hz: float, step_s: float, jitter: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return when rows were measured, and the stamps that they got in packets of about so many."""
    rng = stream(1, "packet sizes")
    sizes = rows + rng.integers(-jitter, jitter + 1, n) if jitter else np.full(n, rows)
    packet = np.repeat(np.arange(n), sizes)[:n]
    begun = np.searchsorted(packet, packet)
    at = np.arange(n) / rate_hz
    return at, at[begun] + step_s * (np.arange(n) - begun)


@pytest.mark.parametrize(("rows", "rate", "step", "jitter"), [(20, 100.0, 1e-6, 0), (8, 400.0, 2e-5, 2), (64, 1000.0, 1e-4, 20)])
def test_rows_stamped_on_arrival_are_told_with_their_rate(rows: int, rate: float, step: float, jitter: int) -> None:
    at, stamps = arrived(6000, rows, rate, step, jitter)
    found = packets_of(stamps, movement(at, 3))
    assert found is not None
    assert found.rows == pytest.approx(rows, abs=1)
    assert found.rate_hz == pytest.approx(rate, rel=0.01)


@pytest.mark.parametrize(("rows", "rate", "pause"), [(20, 100.0, 2.0), (20, 1000.0, 0.2), (50, 500.0, 1.0), (5, 100.0, 0.6)])
def test_a_recorder_that_pauses_is_taken_at_its_word(rows: int, rate: float, pause: float) -> None:
    n = 100 * rows
    t = np.arange(n) / rate + pause * (np.arange(n) // rows)
    assert packets_of(t, movement(t, 4)) is None


def test_a_channel_that_stands_tells_nothing() -> None:
    _, stamps = arrived(4000, 20, 100.0, 1e-6)
    still = 5.0 + 0.05 * stream(2, "still").standard_normal(4000)
    assert packets_of(stamps, (still, np.full(4000, 3.0))) is None


def test_import_refuses_packets_and_says_the_rate(tmp_path: Path) -> None:
    at, stamps = arrived(4000, 20, 100.0, 1e-6)
    x, y = movement(at, 5)
    path = tmp_path / "log.csv"
    rows = [f"act,{t:.6f},{a:.4f},{b:.4f}\n" for t, a, b in zip(stamps, x, y, strict=True)]
    path.write_text("system,time_s,tension_in_n,tension_out_n\n" + "".join(rows))
    with pytest.raises(SstlError, match="packets of 20 rows") as failed:
        list(run([path], mapping_of({}, "test")).runs)
    assert failed.value.code == "E358"
    assert "rate_hz = 100 }" in str(failed.value.fix)
    # with a gap of one's own the stamps are taken as they stand
    assert len(list(run([path], mapping_of({"time": {"gap_s": 0.1}}, "test")).runs)) == 200


def test_check_says_packets_and_not_gaps() -> None:
    at, stamps = arrived(4000, 20, 100.0, 1e-6)
    x, y = movement(at, 6)
    found = {f.what: f.fix for f in findings(Piece("a", {"time_s": stamps, "tension_in_n": x, "tension_out_n": y}))}
    assert "gaps" not in found
    assert "rate_hz = 100 " in found["stamped in packets"]
