"""Headers that name a column twice, and cells between quotes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from program import inside

from sstl_cli.control.reference_file import read as read_reference
from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import Layout
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.importers.sources import read_manifest
from sstl_cli.importers.text_cells import cut
from sstl_cli.importers.text_layout import layout_of
from sstl_cli.steps import import_

ROWS = "".join(f"{0.01 * i:.2f},{1 + i},{2 + i},{3 + i},act\n" for i in range(40))
HEAD = "time_s,tension_in_n,tension_out_n,{},system\n"


def runs(path: Path, **columns: str) -> list:
    mapping = mapping_of({"columns": columns} if columns else {}, "m.toml")
    return list(import_.run([path], mapping).runs)


@pytest.mark.parametrize("twice", ["tension_in_n", "time_s", "tension_out_n", "system"])
def test_a_column_that_is_read_must_stand_once(twice: str, tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text(HEAD.format(twice) + ROWS)
    with pytest.raises(SstlError, match=f"E329.*{twice}.*more than once"):
        runs(tmp_path / "l.csv")


@pytest.mark.parametrize("command", ["check", "info"])
def test_commands_that_look_at_a_csv_say_so_too(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # wide enough for the sentence in a column of its own
    monkeypatch.setenv("COLUMNS", "400")
    (tmp_path / "l.csv").write_text(HEAD.format("tension_in_n") + ROWS)
    done = inside(command, tmp_path / "l.csv")
    assert done.returncode == 1 and "'tension_in_n' stands in the header more than once" in done.stdout + done.stderr


def test_an_optional_column_must_stand_once_too(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text("time_s,tension_in_n,tension_out_n,tension_ref_n,tension_ref_n\n" + ROWS.replace("act", "1"))
    with pytest.raises(SstlError, match="E329.*tension_ref_n"):
        list(import_.run([tmp_path / "l.csv"], mapping_of({"constants": {"system": "act"}}, "m.toml")).runs)


def test_a_mapping_may_say_which_is_meant_and_others_may_stand_twice(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text(HEAD.format("tension_in_n") + ROWS)
    with pytest.raises(SstlError, match="E329"):
        runs(tmp_path / "l.csv", tension_in_n="tension_in_n")
    [run] = runs(tmp_path / "l.csv", tension_in_n="tension_in_n.2")
    assert run.tension_in_n[0] == 3.0
    (tmp_path / "m.csv").write_text("time_s,tension_in_n,tension_out_n,note,note,system\n" + ROWS.replace(",act", ",7,act"))
    assert len(runs(tmp_path / "m.csv")[0]) == 40


def test_numbers_given_to_names_are_not_taken_already(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text("a,a,a.1\n" + "1,2,3\n" * 10)
    assert layout_of(tmp_path / "l.csv", Layout()).names == ("a.2", "a.3", "a.1")


def test_quoted_cells_hold_commas(tmp_path: Path) -> None:
    assert cut('"Force, in N",1,"say ""hi"""', ",") == ["Force, in N", "1", 'say "hi"']
    rows = "".join(f'{0.01 * i:.2f},{1 + i},{2 + i},"left, {i}",act\n' for i in range(40))
    (tmp_path / "l.csv").write_text('time_s,"Force, in N",tension_out_n,"note, free",system\n' + rows)
    [run] = runs(tmp_path / "l.csv", tension_in_n="Force, in N")
    assert np.array_equal(run.tension_in_n, 1.0 + np.arange(40))
    (tmp_path / "d.csv").write_text("time_s,tension_in_n,tension_out_n\n" + "".join(f'"0,{i:02d}","{i},5","{i},25"\n' for i in range(40)))
    [run] = list(import_.run([tmp_path / "d.csv"], mapping_of({"constants": {"system": "act"}}, "m.toml")).runs)
    assert run.tension_in_n[3] == 3.5 and run.tension_out_n[3] == 3.25 and run.time_s[3] == 0.03


@pytest.mark.parametrize("settings", ["", "Datei\t7\n", "Datei: 7\nMessrate: 50 Hz\n"])
@pytest.mark.parametrize("units", ["", "s\tN\tmN\t\n", "s\tN\tmN\n"])
def test_tabs_behind_the_last_name_name_no_column(settings: str, units: str, tmp_path: Path) -> None:
    """As catman writes them: E325 before."""
    rows = "".join(f"{0.01 * i:.2f}\t{1 + i}\t{2 + i}\n" for i in range(40))
    (tmp_path / "c.asc").write_text(f"HBM\n{settings}Zeit\tKraft prox\tKraft dist\t\t\n{units}{rows}")
    found = layout_of(tmp_path / "c.asc", Layout())
    assert found.names == ("Zeit", "Kraft prox", "Kraft dist") and found.units == (("s", "N", "mN") if units else ("", "", ""))
    # one name too many that says something is an error still
    (tmp_path / "c.asc").write_text(f"Zeit\tKraft prox\tKraft dist\tWeg\n{rows}")
    with pytest.raises(SstlError, match="E325"):
        layout_of(tmp_path / "c.asc", Layout())


def test_siblings_manifest_and_reference(tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text("file,config_id,config_id\na.csv,A,B\n")
    with pytest.raises(SstlError, match="E343.*'config_id' more than once"):
        read_manifest(tmp_path / "runs.csv")
    (tmp_path / "ref.csv").write_text("time_s,tension_ref_n,tension_ref_n\n" + "".join(f"{i},1,2\n" for i in range(9)))
    with pytest.raises(SstlError, match="E407.*tension_ref_n more than once"):
        read_reference(tmp_path / "ref.csv", 0.01)
