"""Two files of one test whose headers state when each began."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from sstl_cli.importers.guess import guess
from sstl_cli.importers.guess_stamps import between


def pair(folder: Path, heads: tuple[str, str], zeros: tuple[float, float] = (0.0, 0.0)) -> list[Path]:
    paths = [folder / "proximal_act_bend30.csv", folder / "distal_act_bend30.csv"]
    for path, head, zero in zip(paths, heads, zeros, strict=True):
        table = "".join(f"{zero + 0.02 * i:.3f},{2 + i % 50:.3f}\n" for i in range(400))
        path.write_text(f"{head}Time [s],Load [N]\n{table}")
    return paths


@pytest.mark.parametrize(
    ("heads", "offset"),
    [
        (("# Start: 2024-05-03T14:05:06.000\n", "# Start: 2024-05-03T14:05:08.500\n"), -2.5),
        (("Date: 5/3/2024\nTime: 2:05:06 PM\nGauge: M5-10\n", "Date: 5/3/2024\nTime: 2:05:08 PM\nGauge: M5-10\n"), -2.0),
        (("# recorded 14:05:06.5\n", "# recorded 14:05:05.0\n"), 1.5),
    ],
)
def test_starts_that_differ_are_asked_with_the_offset(heads: tuple[str, str], offset: float, tmp_path: Path) -> None:
    found = guess(pair(tmp_path, heads))
    assert tomllib.loads(found.toml)["columns"]["tension_out_n"]["time_offset"] == offset
    assert [q.target for q in found.questions] == ["tension_out_n"] and f"{abs(offset):g} s apart" in found.questions[0].text


@pytest.mark.parametrize(
    ("heads", "zeros"),
    [
        (("# Start: 14:05:06\n", "# Start: 14:05:06\n"), (0.0, 0.0)),
        # one zero for both: the clocks themselves tell it
        (("# Start: 14:05:06\n", "# Start: 14:05:08\n"), (6.4, 8.2)),
        (("# calibrated: 2024-05-03 14:05:06\n", "# calibrated: 2024-05-03 15:05:06\n"), (0.0, 0.0)),
    ],
)
def test_starts_that_tell_nothing_else_than_the_clocks_are_not_asked(
    heads: tuple[str, str], zeros: tuple[float, float], tmp_path: Path
) -> None:
    found = guess(pair(tmp_path, heads, zeros))
    assert "time_offset" not in found.toml and not found.questions


def test_times_over_midnight_are_those_of_one_night() -> None:
    assert (between("23:59:59", "00:00:01"), between("3. Mai 2024 14:05:06", "4. Mai 2024 14:05:06")) == (2.0, 86_400.0)
