"""Times written in words of other languages: read where they can only mean one, else refused with what to write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from header_table import X, Y
from proposals import proposed

from sstl_cli.importers.text_stamps import StampReader

# 14:05:06.12 on 3 May 2024, by UTC
MOMENT = 1_714_745_106.12


@pytest.mark.parametrize(
    "stamp",
    [
        "3. Mai 2024 14:05:06,12",
        "Fr., 3. Mai 2024 um 14:05:06,12 Uhr",
        "vendredi 3 mai 2024 à 14 h 05 min 06,12 s",
        "03-mag-2024 14:05:06.12",
        "3 de mayo de 2024 02:05:06.12 p. m.",
        "03.05.2024 2:05:06,12 p.\u00a0m.",
        "May 3, 2024 2:05:06.12PM",
        "Fri May  3 14:05:06.12 2024",
        "2024-May-03 14:05:06.12",
        "2024年5月3日 14时05分06.12秒",
        "2024年05月03日(金) 14時05分06秒12",
        "2024/5/3 下午 02:05:06.12",
        "2024/05/03 午後 2:05:06.12",
        "2024. 5. 3. 오후 2:05:06.12",
    ],
)
def test_one_moment_is_read_however_it_is_written(stamp: str) -> None:
    assert StampReader().seconds([stamp]) == pytest.approx([MOMENT], abs=1e-6)


@pytest.mark.parametrize("stamp", ["3 Foo 2024 14:05:06", "中午 02:05:06", "24-May-03 14:05:06", "am 2:05:06 pm", "14:05:06 a. m."])
def test_what_may_mean_another_time_or_none_is_no_stamp(stamp: str) -> None:
    with pytest.raises(ValueError, match=stamp.split()[0]):
        StampReader().seconds([stamp])


@pytest.mark.parametrize(
    ("encoding", "half"), [("gb18030", "下午"), ("cp932", "午後"), ("gb18030", ""), ("cp932", ""), ("cp1252", "février")]
)
def test_a_clock_in_an_older_encoding_is_read(encoding: str, half: str, tmp_path: Path) -> None:
    day = f"3 {half} 2024" if encoding == "cp1252" else f"2024/5/3 {half}" if half else "2024年5月3日"
    lines = (f"{day} 02:05:{6 + 0.01 * i:06.3f};{x:.3f};{y:.3f}\n" for i, (x, y) in enumerate(zip(X, Y, strict=True)))
    path = tmp_path / "act.csv"
    text = "Time;Fin (N);Fout (N)\n" + "".join(lines)
    columns, found = proposed(path, text, encoding)
    assert columns["time_s"] == {"column": "Time", "unit": "s"} and not found.questions


def test_times_in_a_form_that_is_not_known_are_shown_with_one_that_is(tmp_path: Path) -> None:
    lines = (f"day 3 at {i},{x:.3f},{y:.3f}\n" for i, (x, y) in enumerate(zip(X, Y, strict=True)))
    _, found = proposed(tmp_path / "act.csv", "Time,Fin (N),Fout (N)\n" + "".join(lines))
    assert "'Time' holds 'day 3 at 0'" in found.questions[0].text and "write 2024-05-03 14:05:06.120" in found.questions[0].text


def test_hours_of_a_half_go_on_over_noon() -> None:
    seconds = StampReader().seconds(["11:59:59.9 a. m.", "12:00:00.0 p. m.", "1:00:00 p. m."])
    assert np.diff(seconds) == pytest.approx([0.1, 3600.0])
