"""Patterns of a mapping: Python's syntax, linear time."""

from __future__ import annotations

from pathlib import Path

import pytest
from spent import spent_s

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.mapping import Mapping, mapping_of
from sstl_cli.importers.pattern import compiled, search, starts
from sstl_cli.importers.sources import labels_of


@pytest.mark.parametrize(
    ("pattern", "text", "found"),
    [
        (r"bend_(?P<location>\w\w)_(?P<lead_mm>\d+)", "x_bend_NP_20.csv", {"location": "NP", "lead_mm": "20"}),
        (r"(a|b)-(?P<x>[(\](]+)\((c)", "b-(](c", {"x": "(]"}),
        (r"(?P<x>\d)?(?P<y>z)", "z", {"y": "z"}),
        (r"plain", "a plain name", {}),
        (r"^plain", "a plain name", None),
        (r"(?i)(?P<k>KDN)", "kdn", {"k": "kdn"}),
    ],
)
def test_groups_that_have_names(pattern: str, text: str, found: dict | None) -> None:
    assert search(pattern, [text]) == [found]


def test_start_of_each_text() -> None:
    assert starts(r"run(\d)/", ["run1/force", "x/run1/", "run2/"]) == ["run1/", None, "run2/"]


@pytest.mark.parametrize("bad", ["(a", "(?=x)", r"(a)\1", "a{100000}", "[a"])
def test_what_does_not_compile_is_one_line(bad: str) -> None:
    with pytest.raises(ValueError, match="does not compile"):
        compiled(bad)
    with pytest.raises(SstlError, match="file_name.*does not compile"):
        mapping_of({"file_name": bad}, "m.toml")


@pytest.mark.parametrize("pattern", ["(a+)+$", "(a|a)*b", "(a*)*c", "((a+)+)+$"])
def test_no_pattern_takes_long(pattern: str) -> None:
    name = Path("a" * 200 + "!.csv")
    started = spent_s()
    with pytest.raises(SstlError, match="does not fit"):
        labels_of(name, Mapping(file_name=f"^{pattern}$"), {})
    assert spent_s() - started < 1.0


def test_a_name_that_is_no_text() -> None:
    assert search("(?P<x>b.)", ["b\udcff"]) == [{"x": "b?"}]
