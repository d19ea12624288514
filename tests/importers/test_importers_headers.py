"""The proposal on headers as loggers write them: each line is right or asks; none is silently wrong."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from header_table import HEADERS, Header, T, X, Y, rows
from header_table_misleading import MISLEADING
from header_table_more import MORE

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess import guess

TARGETS = ("time_s", "tension_in_n", "tension_out_n")


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Header], list[str]]:
    """Give ``right``, ``asked`` or ``wrong`` for clock, input and output of a header, each of which is asked alone and among all."""
    path = tmp_path_factory.mktemp("headers") / "log.csv"

    @cache
    def of(header: Header) -> list[str]:
        path.write_bytes(header.text.encode(header.encoding))
        found = guess([path])
        asked = {q.target for q in found.questions}
        columns = tomllib.loads(found.toml)["columns"]
        out = []
        for target, (channel, unit) in zip(TARGETS, (header.time, header.first, header.second), strict=True):
            if target in asked:
                out.append("asked")
                continue
            source = columns[target]
            right = channel is not None and unit is not None and source.get("column") == channel
            right = right and unit_of(source["unit"]) == unit_of(str(unit)) and "as" not in source
            out.append("right" if right else "wrong")
        return out

    return of


@pytest.mark.parametrize("header", (*HEADERS, *MORE, *MISLEADING), ids=lambda h: h.logger)
def test_right_or_asked(header: Header, verdicts: Callable[[Header], list[str]]) -> None:
    assert "wrong" not in verdicts(header)


def test_what_a_header_says_is_not_asked(verdicts: Callable[[Header], list[str]]) -> None:
    """Asking for everything would never be wrong: what the files do say is filled in."""
    assert len(HEADERS) == 25
    known = [c is not None and u is not None for h in HEADERS for c, u in (h.time, h.first, h.second)]
    every = [v for h in HEADERS for v in verdicts(h)]
    assert every.count("right") == sum(known) == 44


def test_what_more_headers_say_is_hardly_asked(verdicts: Callable[[Header], list[str]]) -> None:
    known = [c is not None and u is not None for h in MORE for c, u in (h.time, h.first, h.second)]
    every = [v for h in MORE for v in verdicts(h)]
    # a force with the tip's force beside it is asked for
    assert len(MORE) == 49 and every.count("right") == sum(known) - 1 == 95


def test_what_misleading_headers_do_say_is_not_asked(verdicts: Callable[[Header], list[str]]) -> None:
    known = [c is not None and u is not None for h in MISLEADING for c, u in (h.time, h.first, h.second)]
    every = [v for h in MISLEADING for v in verdicts(h)]
    assert every.count("right") == sum(known)


def test_a_deviation_is_no_position(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Time (s),Fin (N),Fout (N),Position deviation (mm)\n" + rows(T, X, Y, 0.001 * X))
    assert "position_in_mm" not in guess([path]).toml
