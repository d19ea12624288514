"""What text logs are written in: records in JSON, one a line, UTF-16 without a mark, minutes that begin anew, a gauge's lines above the names."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from header_table import T, X, Y
from proposals import proposed

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps.import_ import run


def test_records_of_one_shape_are_rows(tmp_path: Path) -> None:
    rows = [
        {"t_s": round(t, 3), "unit": "N", "F": {"in": round(x, 3), "out": round(y, 3)}, "ok": True} for t, x, y in zip(T, X, Y, strict=True)
    ]
    rows[7]["F"]["out"] = None  # type: ignore[index]
    columns, found = proposed(tmp_path / "act.jsonl", "".join(json.dumps(r) + "\n" for r in rows))
    assert [columns[c]["column"] for c in ("time_s", "tension_in_n", "tension_out_n")] == ["t_s", "F.in", "F.out"]
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([tmp_path / "act.jsonl"], read_mapping(tmp_path / "rig.toml")).runs
    kept = np.arange(len(T)) != 7
    np.testing.assert_allclose(one.tension_in_n[: kept.sum()], X[kept][: len(one.time_s)], atol=6e-4)


def test_records_whose_keys_differ_are_refused(tmp_path: Path) -> None:
    (tmp_path / "act.jsonl").write_text("".join(json.dumps({f"F{i % 3}": float(x)}) + "\n" for i, x in enumerate(X)))
    with pytest.raises(SstlError, match="keys are not the same"):
        guess([tmp_path / "act.jsonl"])


def test_a_line_of_another_shape_is_refused_with_its_number(tmp_path: Path) -> None:
    rows = [json.dumps({"t_s": round(t, 3), "F_in_N": x, "F_out_N": y}) for t, x, y in zip(T, X, Y, strict=True)]
    rows[len(rows) // 2] = '{"status": "ok"}'
    (tmp_path / "act.jsonl").write_text("\n".join(rows) + "\n")
    (tmp_path / "rig.toml").write_text(
        'format = "text"\n[columns]\ntime_s = "t_s"\ntension_in_n = "F_in_N"\ntension_out_n = "F_out_N"\n[constants]\nsystem = "act"\n'
    )
    with pytest.raises(SstlError, match=f"line {len(rows) // 2 + 1}"):
        list(run([tmp_path / "act.jsonl"], read_mapping(tmp_path / "rig.toml")).runs)


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf16_needs_no_mark(encoding: str, tmp_path: Path) -> None:
    table = "Time (s)\tInput force (N)\tOutput force (N)\n" + "".join(
        f"{t:.3f}\t{x:.3f}\t{y:.3f}\n" for t, x, y in zip(T, X, Y, strict=True)
    )
    (tmp_path / "act.txt").write_bytes(table.encode(encoding))
    found = guess([tmp_path / "act.txt"])
    assert not found.questions and '"Output force (N)"' in found.toml


def test_minutes_run_on_over_the_hour(tmp_path: Path) -> None:
    shown = [(3590 + k / 20) % 3600 for k in range(len(T))]
    text = "Zeit;Fin [N];Fout [N]\n" + "".join(
        f"{int(s // 60):02d}:{s % 60:05.2f};{x:.3f};{y:.3f}\n" for s, x, y in zip(shown, X, Y, strict=True)
    )
    columns, found = proposed(tmp_path / "act.csv", text)
    assert columns["time_s"] == {"column": "Zeit", "unit": "s"} and not {"time_s"} & {q.target for q in found.questions}
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([tmp_path / "act.csv"], read_mapping(tmp_path / "rig.toml")).runs
    np.testing.assert_allclose(np.diff(one.time_s), 0.05, atol=1e-6)


def test_a_narrow_line_above_the_names_is_no_header(tmp_path: Path) -> None:
    text = "FGV data,,\nModel,FGV-50XY,\nUnit,N,\nNo.,Time(s),Input force,Output force\n"
    text += "".join(f"{i},{t:.3f},{x:.3f},{y:.3f}\n" for i, (t, x, y) in enumerate(zip(T, X, Y, strict=True)))
    columns, _ = proposed(tmp_path / "act.csv", text)
    assert [columns[c]["column"] for c in ("time_s", "tension_in_n", "tension_out_n")] == ["Time(s)", "Input force", "Output force"]


WHOLE = [{"t": round(0.01 * k, 2), "fin": 2.25 + k, "fout": 1.5 + k} for k in range(60)]
COLUMNS = {name: [record[name] for record in WHOLE] for name in WHOLE[0]}


@pytest.mark.parametrize("indent", [None, 1])
@pytest.mark.parametrize(
    "document",
    [
        WHOLE,
        COLUMNS,
        {"data": WHOLE},
        {"meta": {"bend": 30}, "data": COLUMNS},
        {k: {str(i): v for i, v in enumerate(held)} for k, held in COLUMNS.items()},
    ],
)
def test_json_as_one_value_is_read_as_records(document: object, indent: int | None, tmp_path: Path) -> None:
    path = tmp_path / "act.json"
    path.write_text(json.dumps(document, indent=indent))
    found = guess([path])
    assert ("bend: 30" in found.toml) == ("meta" in document)  # type: ignore[operator]
    (tmp_path / "rig.toml").write_text(found.toml.replace("(?)", ""))
    [one] = run([path], read_mapping(tmp_path / "rig.toml")).runs
    assert list(one.tension_in_n) == [r["fin"] for r in WHOLE] and list(one.time_s) == [r["t"] for r in WHOLE]


@pytest.mark.parametrize("ext", ["json", "txt"])
@pytest.mark.parametrize("indent", [None, 1])
@pytest.mark.parametrize(
    "document",
    [
        [list(r.values()) for r in WHOLE],
        {str(k): r for k, r in enumerate(WHOLE)},
        {"t": COLUMNS["t"], "fin": COLUMNS["fin"][1:]},
        {"first": WHOLE, "second": WHOLE},
    ],
)
def test_json_of_another_form_is_refused_with_what_to_write(document: object, indent: int | None, ext: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{ext}"
    path.write_text(json.dumps(document, indent=indent))
    with pytest.raises(SstlError, match=r"E323.*holds JSON as (an array|one object).*one column for each name, or as one record a line"):
        guess([path])


def test_arrays_one_a_line_and_an_array_on_one_long_line_are_refused_likewise(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text("".join(json.dumps(list(r.values())) + "\n" for r in WHOLE))
    with pytest.raises(SstlError, match="an array a line.*one column for each name"):
        guess([path])
    path.write_text(json.dumps([list(r.values()) for r in WHOLE] * 1000))
    with pytest.raises(SstlError, match="E320.*one column for each name"):
        guess([path])


def test_a_record_without_a_key_is_told_as_one(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text("".join(json.dumps({k: v for k, v in r.items() if k != "fout" or i != 7}) + "\n" for i, r in enumerate(WHOLE)))
    with pytest.raises(SstlError, match="line 8.*other keys than those before.*null where nothing was read"):
        guess([path])


def test_what_begins_with_a_bracket_and_is_no_json_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("[Header]\n[Rig 1]\nTime (s),Fin (N),Fout (N)\n" + "".join(f"{r['t']},{r['fin']},{r['fout']}\n" for r in WHOLE))
    assert 'tension_in_n = { column = "Fin (N)", unit = "N" }' in guess([path]).toml
