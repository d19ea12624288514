"""The quick look at runs of a few samples passes over nothing that the thorough one finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sstl_cli.identification import brief, samples

OPTIONAL = ("lead_mm", "position_in_mm", "tension_ref_n")
ODD = [0.0, 1.0, -1.0, 5.0, 1e-13, -1e-13, 1e15, 2e15, np.nan, np.inf, -np.inf]


@st.composite
def pieces(draw: st.DrawFn) -> samples.Piece:
    n = draw(st.integers(1, 15))
    odd = draw(st.sampled_from([[1.0, 2.5], ODD]))
    steps = draw(st.sampled_from([[0.01], [0.5], [0.01, 0.02], [1e-10], [0.0, 0.01, -0.01], [0.01, 50.0]]))
    time = np.cumsum([draw(st.sampled_from(steps)) for _ in range(n)])
    columns = {"time_s": time} if draw(st.integers(0, 9)) else {}
    columns |= {c: np.array([draw(st.sampled_from(odd)) for _ in range(n)]) for c in ("tension_in_n", "tension_out_n")}
    nulls = {c: draw(st.sampled_from([0, 0, 0, 1])) for c in columns}
    for name in draw(st.sets(st.sampled_from(OPTIONAL))):
        empty = draw(st.booleans())
        columns[name] = np.full(n, np.nan) if empty else np.array([draw(st.sampled_from(odd)) for _ in range(n)])
        nulls[name] = n if empty else 0
    labels = {"system": draw(st.sampled_from([["act"], ["sstl"], ["other"], ["act", "sstl"]]))}
    return samples.Piece(draw(st.sampled_from(["run", None])), columns, labels, nulls)


@given(pieces())
def test_the_quick_look_changes_no_finding(piece: samples.Piece) -> None:
    quick = samples.findings(piece, OPTIONAL)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(brief, "plain", lambda *_: False)
        assert samples.findings(piece, OPTIONAL) == quick


def test_the_quick_look_is_taken_where_all_is_well() -> None:
    columns = {"time_s": np.array([0.0, 0.1]), "tension_in_n": np.array([1.0, 2.0]), "tension_out_n": np.array([0.5, 1.0])}
    assert brief.plain(columns, {})
    for name, value in (("tension_in_n", np.nan), ("tension_out_n", 1e16), ("time_s", 0.1)):
        assert not brief.plain({**columns, name: np.array([value, columns[name][1]])}, {})
    assert not brief.plain(columns, {"time_s": 1}) and not brief.plain({**columns, "position_in_mm": np.zeros(2)}, {})
