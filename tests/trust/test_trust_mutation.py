"""The check of the tests themselves: which tests a fault is shown to, what is compiled again for it, and what is published."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import mutation  # noqa: E402

BEFORE = """
Random samples:

| part | seed | faults possible | tried | killed | share killed (95 % interval) | of the others, no change of any answer |
|---|---|---|---|---|---|---|
| control | 7 | 1,913 | 120 | 100 | 83 % (76-89 %) | 5 |
| physics | 7 | 2,722 | 99 | 90 | 91 % (84-95 %) | 1 |
| together |  |  | 219 | 190 | 87 % (82-91 %) | 6 |

- sstl_cli/control/law.py:1:2: `a` -> `b` (reason)
- sstl_cli/physics/play.py:1:2: `a \\| b` -> `b`
"""


def test_a_fault_is_shown_to_the_tests_that_name_its_module_its_own_first_and_whole_diagnoses_never_but_its_own(tmp_path):
    texts = {
        "test_diagnosis_fit.py": "from sstl_cli.diagnosis.fit import fit",
        "test_diagnosis_fit_pieces.py": "from sstl_cli.diagnosis import fit",
        "test_diagnosis_fit_values.py": "from sstl_cli.diagnosis.fit import fit",
        "test_diagnosis_fitting.py": "from sstl_cli.diagnosis.fitting import x",
        "test_diagnosis_a.py": "from sstl_cli.diagnosis import noise, fit",
        "test_diagnosis_lines.py": "from sstl_cli.diagnosis import (\n    fit,\n    means,\n)\nx = (noise)",
        "test_diagnosis_b.py": "from sstl_cli.steps.diagnose import run\nfrom sstl_cli.diagnosis.fit import fit",
        "test_diagnosis_noise.py": "from sstl_cli.cli.app import app\nfrom sstl_cli.diagnosis.noise import x",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    files = sorted(tmp_path.iterdir())

    def names(module):
        return [f.stem.removeprefix("test_diagnosis_") for f in mutation._of_module(files, module)]

    # quick ones, which compare numbers, before its others
    assert names("fit") == ["fit_values", "fit", "fit_pieces", "a", "lines"]
    # on one line or on several
    assert names("means") == ["lines"]
    assert names("noise") == ["a", "noise"]
    assert names("") == ["fit_values", "a", "fit", "fit_pieces", "fitting", "lines"]


def test_every_module_of_the_diagnosis_has_tests_that_run_no_whole_program():
    files = sorted((ROOT / "tests" / "diagnosis").glob("test_*.py"))
    quick = {
        m.stem: [f for f in mutation._of_module(files, m.stem) if not mutation.WHOLE_PROGRAM.search(f.read_text())]
        for m in (ROOT / "sstl_cli" / "diagnosis").glob("*.py")
    }
    # one run is left out of whole searches
    assert {m for m, found in quick.items() if not found} <= {"__init__", "odd"}


def test_machine_code_is_thrown_away_where_a_compiled_function_or_a_constant_names_what_changed():
    users = mutation.users(ROOT / "sstl_cli")
    assert "sstl_cli/diagnosis/kalman.py" in users["sstl_cli/diagnosis/smoother.py"]
    assert "sstl_cli/diagnosis/simulator.py" not in users.get("sstl_cli/diagnosis/records.py", set())
    assert "sstl_cli/physics/rig/march.py" in users["sstl_cli/physics/rig/friction.py"]
    source = "from a import b, c\nfrom d import e\nA = b + 1\n@njit(cache=True)\ndef f(x):\n    return c(x)\ndef g(x):\n    return e(x)\n"
    assert {"b", "c"} <= mutation._frozen(ast.parse(source)) and "e" not in mutation._frozen(ast.parse(source))


def test_parts_that_were_not_run_keep_their_rows_and_survivors(monkeypatch):
    monkeypatch.setattr(mutation, "draw", lambda *_: (1234, []))
    found = {
        "physics": {
            "sstl_cli/physics/x.py:3:4: `1` -> `2`": [None],
            "sstl_cli/physics/x.py:4:4: `1` -> `2`": ["t"],
            "sstl_cli/physics/x.py:5:4: `1` -> `2`": [None, "t"],
        }
    }
    lines = mutation.page(found, 9, BEFORE).splitlines()
    rows = {line.split(" | ")[0].strip("| "): [c.strip() for c in line.strip("| ").split(" | ")] for line in lines if line.startswith("| ")}
    assert rows["control"] == ["control", "7", "1,913", "120", "100", "83 % (76-89 %)", "5"]
    assert rows["physics"][:5] == ["physics", "9", "1,234", "3", "1"]
    assert rows["together"][3:5] == ["123", "101"] and rows["together"][6] == "5"
    assert [line for line in lines if line.startswith("- ")] == [
        "- sstl_cli/control/law.py:1:2: `a` -> `b` (reason)",
        "- sstl_cli/physics/x.py:3:4: `1` -> `2`",
        "- sstl_cli/physics/x.py:5:4: `1` -> `2` (killed by a test added since)",
    ]
    assert mutation.page({}, 9, BEFORE).count("physics") == BEFORE.count("physics")


def test_the_published_table_is_one_that_the_tool_can_read():
    text = (ROOT / "docs" / "trust.md").read_text(encoding="utf-8").split("<!-- mutation begins -->")[1].split("<!-- mutation ends -->")[0]
    assert mutation.page({}, 1, text).strip() == text.strip() and all(f"| {p} |" in text for p in mutation.PARTS if p != "diagnosis")


@pytest.mark.parametrize("line", mutation.EQUAL.read_text(encoding="utf-8").splitlines()[1:])
def test_a_survivor_that_changes_nothing_has_its_reason(line):
    fault, reason = line.rsplit(" | ", 1)
    assert fault.startswith("sstl_cli/") and "` -> `" in fault and reason
