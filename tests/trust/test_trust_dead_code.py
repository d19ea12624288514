"""What `make lint` calls dead is what no line uses."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import dead_code


def test_the_check_sees_what_is_dead_and_what_is_not() -> None:
    tree = ast.parse(
        "A, B = 1, 2\nUNUSED = 3\ndef f():\n    '''UNUSED f g'''\n    return B\ndef g():\n    return f()\n@app.command\ndef hooked(): ...\n"
    )
    names = {n for n, _ in dead_code.defined(tree)}
    assert names == {"UNUSED", "f", "g"}
    uses = dead_code.used(tree)
    assert uses["f"] and not uses["g"] and not uses["UNUSED"]
