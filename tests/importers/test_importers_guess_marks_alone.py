"""Marks between thousands beside decimal ones that a file shows, and comments between its samples."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows
from proposals import proposed

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run


def german(values: np.ndarray, places: int) -> list[str]:
    """Return numbers as German spreadsheets write them."""
    return [f"{v:,.{places}f}".translate(str.maketrans(",.", ".,")) for v in values]


def table(time: list[str]) -> str:
    lines = zip(time, german(1000 * X, 1), german(1000 * Y, 1), strict=True)
    return "Zeit [ms];F_ein [mN];F_aus [mN]\n" + "".join(f"{';'.join(cells)}\n" for cells in lines)


def test_a_mark_between_thousands_is_one_where_the_file_shows_both(tmp_path: Path) -> None:
    path = tmp_path / "act_bend30.csv"
    _, found = proposed(path, table(german(1000 * T, 0)))
    assert not found.questions
    [log] = run([path], mapping_of(tomllib.loads(found.toml), "test")).runs
    assert np.allclose(log.time_s, T, atol=1e-3) and np.allclose(log.tension_in_n, X, atol=1e-4)


@pytest.mark.parametrize("time", [[f"{1 + t:.3f}" for t in T], [f"{t:.3f}" for t in T]])
def test_a_column_that_does_not_show_it_is_refused_in_its_own_words(time: list[str], tmp_path: Path) -> None:
    path = tmp_path / "act_bend30.csv"
    path.write_text(table(time))
    with pytest.raises(SstlError) as refused:
        guess([path])
    quoted = refused.value.what.split("'")[3]
    assert f";{quoted};" in path.read_text().replace("\n", ";")


def test_comments_between_runs_that_tell_another_bend_are_asked(tmp_path: Path) -> None:
    body = rows(T, X, Y)
    text = f"# Bend 30 deg\ntime_s,Fin_N,Fout_N\n{body}# Bend 60 deg\n{body}"
    _, found = proposed(tmp_path / "act.csv", text)
    [asked] = [q.text for q in found.questions if q.target == "config_id"]
    assert "'# Bend 30 deg' and '# Bend 60 deg'" in asked and "differ" in asked
    _, named = proposed(tmp_path / "act_bend30.csv", text)
    assert any("which tells the configuration" in q.text for q in named.questions)
    _, same = proposed(tmp_path / "act_bend30.csv", text.replace("60", "30"))
    assert not any("configuration" in q.text for q in same.questions)
