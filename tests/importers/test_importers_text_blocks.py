"""Tables of one header below each other in a text log: each a run, with the labels of its own lines, or refused where it is another table."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y, rows

from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.importers import text
from sstl_cli.importers.guess import Guess, guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import Import, run

HEAD = "t_s,Fin_N,Fout_N\n"
MAPPING = """
[text]
blocks = "runs"
block_lines = ['Bend: (?P<config_id>\\d+)']
[columns]
time_s = "t_s"
tension_in_n = { column = "Fin_N", unit = "N" }
tension_out_n = { column = "Fout_N", unit = "N" }
[constants]
system = "act"
"""


def block(k: int, start: float = 0.0, sep: str = ",", dec: str = ".") -> str:
    """Return the rows of block ``k``, which tells itself by its size."""
    return rows(T + start, (k + 1) * X, (k + 1) * Y, sep=sep, dec=dec)


def imported(path: Path, mapping: str) -> tuple[list[Run], Import]:
    """Return the runs of a file, and the account of them."""
    done = run([path], mapping_of(tomllib.loads(mapping), "m.toml"))
    return list(done.runs), done


def labels(path: Path, mapping: str) -> list[tuple[str, str, str | None, float]]:
    """Return run, system, bend and size of each run."""
    return [(r.run_id, r.system, r.config_id, round(float(r.tension_in_n.max() / X.max()), 3)) for r in imported(path, mapping)[0]]


def proposed(path: Path, content: str) -> tuple[Guess, dict[str, str]]:
    """Return a proposal, and its questions by their lines."""
    path.write_text(content)
    found = guess([path])
    return found, {q.target: q.text for q in found.questions}


@pytest.mark.parametrize("piece", [4 << 20, 2_500, 300])
@pytest.mark.parametrize(("end", "apart"), [("\n", 0.0), ("\r\n", 0.0), ("\n", float(T[-1] + T[1]))])
def test_blocks_are_runs_wherever_pieces_are_cut(
    piece: int, end: str, apart: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text, "BLOCK_BYTES", piece)
    content = "".join(f"# Run {k}\n\nBend: {30 * (k + 1)}\n{HEAD}{block(k, k * apart)}\n" for k in range(3))
    (tmp_path / "log.csv").write_bytes(content.replace("\n", end).encode())
    done = run([tmp_path / "log.csv"], mapping_of(tomllib.loads(MAPPING), "m.toml"))
    held: dict[tuple[str, str | None], list[np.ndarray]] = {}
    for one in done.runs:
        held.setdefault((one.run_id, one.config_id), []).append(one.tension_in_n)
    assert list(held) == [("log-1", "30"), ("log-2", "60"), ("log-3", "90")]
    for k, parts in enumerate(held.values()):
        np.testing.assert_allclose(np.concatenate(parts), (k + 1) * X, atol=1e-4)


def test_a_wrong_cell_of_a_later_block_is_named_with_its_line(tmp_path: Path) -> None:
    lines = "".join(f"Bend: {k}\n{HEAD}{block(k)}" for k in range(3)).splitlines()
    at = 2 * (len(T) + 2) + 50
    lines[at] = lines[at].replace(",", ",oops", 1)
    (tmp_path / "log.csv").write_text("\r\n".join(lines))
    with pytest.raises(SstlError, match=f"line {at + 1}: column 'Fin_N' holds 'oops"):
        labels(tmp_path / "log.csv", MAPPING)


def test_a_block_whose_lines_lack_a_label_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(f"Bend: 30\n{HEAD}{block(0)}Note: none\n{HEAD}{block(1)}")
    with pytest.raises(SstlError, match=rf"line {len(T) + 3}: block 2 has no line") as raised:
        labels(tmp_path / "log.csv", MAPPING)
    assert raised.value.code == "E341"


def test_one_name_for_all_blocks_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("".join(f"Bend: 30\n{HEAD}{block(k)}" for k in range(2)))
    with pytest.raises(SstlError, match="run_id is one for all blocks"):
        labels(tmp_path / "log.csv", MAPPING + 'run_id = "a"\n')


def test_a_header_that_is_only_repeated_is_left_out(tmp_path: Path) -> None:
    table = rows(T, X, Y).splitlines(keepends=True)
    path = tmp_path / "log.csv"
    found, asked = proposed(path, HEAD + "".join(table[:200]) + HEAD + "".join(table[200:]))
    assert "the clock goes on" in asked["blocks"]
    [one], _ = imported(path, found.toml.replace('blocks = "runs"', 'blocks = "append"'))
    assert len(one.time_s) == len(T)


@pytest.mark.parametrize("apart", [0.0, 100.0])
def test_a_clock_that_begins_anew_or_after_a_pause_needs_no_question(apart: float, tmp_path: Path) -> None:
    found, asked = proposed(tmp_path / "log.csv", "".join(HEAD + block(k, k * apart) for k in range(3)))
    assert set(asked) == {"system"}
    assert [x[0::3] for x in labels(tmp_path / "log.csv", found.toml)] == [("log-1", 1.0), ("log-2", 2.0), ("log-3", 3.0)]


MTS = "Data Acquisition: Timed\t\tTime:\t{}\tSec\n\nTime \tProximal Force \tDistal Force \nSec\tN\tN\n"
PRO = "{}\nTime\tForce In\tForce Out\nt\tFi\tFo\ns\tN\tN\n\n"
LVM = "Channels\t2\nSamples\t400\t400\n***End_of_Header***\t\nX_Value\tForce In (N)\tForce Out (N)\tComment\n"


@pytest.mark.parametrize(
    ("first", "heads", "sep"),
    [
        ("MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n", [MTS.format("52.010"), MTS.format("152.010")], "\t"),
        ("Vernier Format 2\nUntitled.cmbl 5/3/2024 14:05:06 .\n", [PRO.format("Run 1"), PRO.format("Latest")], "\t"),
        ("LabVIEW Measurement\nWriter_Version\t2\n***End_of_Header***\n", [LVM, LVM], "\t"),
        ("", ["# t_s Fin_N Fout_N\n"] * 2, " "),
        ("Probe 1\n", ["Zeit;Kraft_ein;Kraft_aus\ns;N;N\n"] * 2, ";"),
    ],
    ids=["MTS", "Logger Pro", "LabVIEW", "savetxt", "TestXpert"],
)  # fmt: skip
def test_blocks_as_loggers_write_them(first: str, heads: Sequence[str], sep: str, tmp_path: Path) -> None:
    content = first + "".join(head + block(k, 100.0 * k, sep) + "\n" for k, head in enumerate(heads))
    found, asked = proposed(tmp_path / "log.txt", content)
    assert set(asked) == {"system"}
    assert [x[3] for x in labels(tmp_path / "log.txt", found.toml)] == [1.0, 2.0]


@pytest.mark.parametrize(
    "titles",
    [
        ["# System: act\n# Bend: 30\n", "# System: sstl\n# Bend: 60\n"],
        ["act_bend30\n", "sstl_bend60\n"],
        ["Messung 1;act, bent by 30 deg\n", "Messung 2;sstl, bent by 60 deg\n"],
        ['"Specimen label","act_bend30"\n\n', '"Specimen label","sstl_bend60"\n\n'],
    ],
)
def test_lines_of_a_block_give_its_labels(titles: list[str], tmp_path: Path) -> None:
    found, asked = proposed(tmp_path / "log.csv", "# operator: kk\n" + "".join(t + HEAD + block(k) for k, t in enumerate(titles)))
    assert not asked
    assert labels(tmp_path / "log.csv", found.toml) == [("log-1", "act", "30", 1.0), ("log-2", "sstl", "60", 2.0)]


@pytest.mark.parametrize(
    ("titles", "what"),
    [
        (["straight\n", "curved\n"], "block_lines"),
        (["Passes: 1\n", "Passes: 2\n"], "block_lines"),
        (["Bend: 30\n", "Note: x\n", "Bend: 60\n"], "block_lines"),
        (["Units: N\n", "Units: lbf\n"], "blocks"),
        (["Gain: 1\n", "Gain: 10\n"], "blocks"),
        (["Sample rate: 100 Hz\n", "Sample rate: 200 Hz\n"], "blocks"),
        (["30\n", "45\n"], "block_lines"),
        (["NP_lead10\n", "CP_lead20\n"], "block_lines"),
    ],
)
def test_what_lines_of_blocks_leave_open_is_asked(titles: list[str], what: str, tmp_path: Path) -> None:
    _, asked = proposed(tmp_path / "log.csv", "".join(t + HEAD + block(k) for k, t in enumerate(titles)))
    assert what in asked


@pytest.mark.parametrize(
    ("titles", "bends"),
    [
        (["Run 1\n", "Latest\n"], [None, None]),
        (["Frequency: 0.2 Hz\n", "Frequency: 0.5 Hz\n"], [None, None]),
        (["1\n", "2\n"], [None, None]),
        (["Bend: -30\n", "Bend: 30\n"], ["-30", "30"]),
        (["Biegung: 22,5°\n", "Biegung: 45°\n"], ["22,5", "45"]),
        (["Bend: pi/2\n", "Bend: pi\n"], ["pi/2", "pi"]),
        (["Bend: 30\nOperator: kk\n\n", "Bend: 60\n"], ["30", "60"]),
    ],
)
def test_lines_of_blocks_that_leave_nothing_open_raise_no_question(titles: list[str], bends: list[str | None], tmp_path: Path) -> None:
    found, asked = proposed(tmp_path / "act.csv", "".join(t + HEAD + block(k) for k, t in enumerate(titles)))
    assert not asked
    assert [x[2] for x in labels(tmp_path / "act.csv", found.toml)] == bends


@pytest.mark.parametrize("below", ["s,lbf,lbf\n", ""])
def test_a_header_with_other_units_is_refused(below: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(f"t,Fin,Fout\ns,N,N\n{block(0)}t,Fin,Fout\n{below}{block(1)}")
    with pytest.raises(SstlError, match=f"line {len(T) + 4}: the names of the columns stand there again") as raised:
        guess([tmp_path / "log.csv"])
    assert raised.value.code == "E327" and "split the file there" in raised.value.fix


def test_a_header_of_other_names_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(HEAD + block(0) + HEAD.replace("Fout_N", "Fout_lbf") + block(1))
    with pytest.raises(SstlError, match="another header stands there"):
        guess([tmp_path / "log.csv"])


def test_what_stands_below_a_block_is_counted_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    found, _ = proposed(path, HEAD + block(0) + "1.60,3.2\n" + HEAD + block(1) + "Mean,9.1,7.2\n" + HEAD + block(2))
    _, done = imported(path, found.toml)
    assert done.counts.notes.set_aside == {
        "last line of a block cut off in the middle": 1,
        "rows of statistics below the samples of a block": 1,
    }
    path.write_text(HEAD + block(0) + "1.6,OVLD,OVLD\n" + HEAD + block(1))
    with pytest.raises(SstlError, match=f"line {len(T) + 2}: column 'Fin_N' holds 'OVLD'"):
        labels(path, found.toml)


def test_a_serial_monitor_that_was_opened_again_begins_a_block(tmp_path: Path) -> None:
    def lines(k: int) -> str:
        table = zip((k + 1) * X, (k + 1) * Y, strict=True)
        return "".join(f"10:2{k}:{i // 10:02d}.{i % 10}00 -> {100 * i},{x:.3f},{y:.3f}\n" for i, (x, y) in enumerate(table))

    found, asked = proposed(tmp_path / "log.txt", "".join(f"10:2{k}:00.000 -> t_ms,Fin_N,Fout_N\n{lines(k)}" for k in range(2)))
    assert set(asked) == {"system"}
    assert [x[3] for x in labels(tmp_path / "log.txt", found.toml)] == [1.0, 2.0]


def test_times_of_day_begin_anew_with_each_block(tmp_path: Path) -> None:
    lines = "".join(f"23:59:{i:02d}.000,{x:.3f},{y:.3f}\n" for i, (x, y) in enumerate(zip(X[:60], Y[:60], strict=True)))
    found, _ = proposed(tmp_path / "log.csv", 2 * ("Time,Fin_N,Fout_N\n" + lines))
    runs, _ = imported(tmp_path / "log.csv", found.toml)
    assert [float(r.time_s[0]) for r in runs] == [86340.0, 86340.0]
