"""Headers of instruments that state names in lines of their own, names in other scripts or with blanks, and counters that begin anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sstl_cli.importers.guess import guess

N = 300
T = np.arange(N) * 0.01
X = 4.0 - 2.5 * np.cos(3.0 * T)
Y = 0.6 * X + 0.2 * np.sin(3.0 * T)


def lines(separator: str, *columns: np.ndarray, digits: int = 4) -> str:
    return "".join(separator.join(f"{v:.{digits}f}" for v in row) + "\n" for row in zip(*columns, strict=True))


def proposed(path: Path, text: str | bytes) -> tuple[str, dict[str, str]]:
    """Return why, and the lines of the mapping by what they give."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    found = guess([path])
    return " ".join(found.reasons), {x.split(" = ")[0]: x for x in found.toml.splitlines() if " = " in x}


@pytest.mark.parametrize(("name", "side"), [("distal", "out"), ("out", "out"), ("proximal", "in")])
def test_a_column_named_by_its_side_alone_is_that_side_and_both_are_asked(name: str, side: str, tmp_path: Path) -> None:
    """The tension beside it was called the output, as it stands beside the command of a motion."""
    _, found = proposed(tmp_path / "a.csv", f"t_ms,Stroke_Ref,Tension,{name}\n" + lines(",", 1000.0 * T, 5.0 * T, X, Y))
    mine, other = ("tension_out_n", "tension_in_n") if side == "out" else ("tension_in_n", "tension_out_n")
    assert f'column = "{name}"' in found[mine] and 'column = "Tension"' in found[other]
    assert all("(?)" in found[v] for v in (mine, other))
