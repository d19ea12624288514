"""How many numbers of the diagnosis somebody chose: counted over the syntax tree, and only ever fewer.

Counted is every number other than 0, 1, 2 and 1/2 in the package. What stands in ``constants.py`` was chosen by hand and is
counted by section: of those that decide what is said there are fewer than 25, and of all that are chosen many more. Apart
from them stand, each with its own count: guards (against division by zero, and of a matrix that has no inverse), indices and
shapes, mathematics, scales that the learned weights belong to, and numbers of compiled functions.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

import sstl_cli.diagnosis

PACKAGE = Path(sstl_cli.diagnosis.__file__).parent
CONSTANTS = "constants.py"
PLAIN = {0, 1, 2, 0.5}
# committed counts: a larger one is a number more that somebody chose, a smaller one belongs here
CHOSEN = {"said": 19, "read": 39, "believed": 59, "sought": 72, "shown": 19, "moved": 18}
APART = {"guards": 106, "mathematics": 64, "indices and shapes": 250, "compiled functions": 14, "scales of the learned weights": 10}
TINY, HUGE = 1e-6, 1e6
SHAPED = {"zeros", "empty", "full", "eye", "range", "round", "repeat", "diff", "pad", "sliding_window_view"}
# numba's cache of a function follows its own file only: a number elsewhere could change without it
COMPILED = {"kalman.py", "simulator.py", "slides.py", "smoother.py", "tries.py"}
MATHEMATICS = {
    # percent; of the normal: 95 % within 1.96, 2.5 and 97.5 %
    "shrink.py": {100.0: 4, 1.96: 1, 2.5: 1, 97.5: 1},
    "floor.py": {1.96: 1},
    "gap.py": {100.0: 5},
    "compared.py": {100.0: 1},
    "recorded.py": {100.0: 1},
    "channels.py": {100.0: 1},
    "reasons.py": {100.0: 10},
    "features.py": {0.975: 1},
    "by_run.py": {1.96: 2},
    "nameless.py": {100.0: 1},
    "stages.py": {100.0: 1},
    "sentence.py": {100.0: 6},
    "where.py": {100.0: 4, 0.25: 2, 0.75: 2},
    # rounding has a variance of 1/12 of the step squared, and an input counts by half of it
    "faults.py": {100.0: 3, 12.0: 1, 4.0: 1},
    # mean square of a number between 0 and 1, from an end
    "driven.py": {3.0: 1},
    # third differences have a variance of 1 + 9 + 9 + 1; means and quantiles of the normal below a share; quartiles
    "recorder.py": {12.0: 3, 20.0: 1, 0.95: 1, 0.717: 1, 0.3: 1, 75: 1, 25: 1, 6.0: 1},
    # moments of the normal, quartiles
    "residuals.py": {3: 3, 4: 1, 1.5: 1, 0.25: 1, 0.75: 1},
}
# phases, systems and halves, two by two
STRUCTURE = {"where.py": {4: 5, 3: 1}, "shrink.py": {4: 4}, "residuals.py": {4: 2, 8: 2, 3: 2}, "features.py": {4: 2}}
# what the numbers of a candidate are counted in: other units would need other weights
LEARNED = {"verdict.py"}


def numbers(tree):
    """Yield every number of a tree, with the nodes above it, the nearest last."""

    def down(node, above):
        is_number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
        if is_number and node.value not in PLAIN:
            yield node, above
        for child in ast.iter_child_nodes(node):
            yield from down(child, [*above, node])

    return down(tree, [])


def shaped(node, above):
    """Whether a whole number is an index, a shape or a count of elements."""
    if not isinstance(node.value, int):
        return False
    if any(isinstance(a, ast.Subscript) for a in above):
        return True
    calls = [a for a in above if isinstance(a, ast.Call)]
    named = {c.func.attr if isinstance(c.func, ast.Attribute) else getattr(c.func, "id", "") for c in calls[-1:]}
    divided = isinstance(above[-1], ast.BinOp) and isinstance(above[-1].op, (ast.Mod, ast.FloorDiv))
    return bool(named & SHAPED) or divided


def sorted_out(name, tree):
    """Return how many numbers of a module belong to each category, those that belong to none as ``left``."""
    found, left = Counter(), Counter()
    known = Counter(MATHEMATICS.get(name, {})), Counter(STRUCTURE.get(name, {}))
    for node, above in numbers(tree):
        value = node.value
        if abs(value) <= TINY or abs(value) >= HUGE:
            found["guards"] += 1
        elif known[0][value] > 0:
            known[0][value] -= 1
            found["mathematics"] += 1
        elif known[1][value] > 0:
            known[1][value] -= 1
            found["indices and shapes"] += 1
        elif shaped(node, above):
            found["indices and shapes"] += 1
        elif name in COMPILED:
            found["compiled functions"] += 1
        elif name in LEARNED:
            found["scales of the learned weights"] += 1
        else:
            left[f"{name}: {value!r}, line {node.lineno}"] += 1
    return found, left


def chosen(text):
    """Return how many numbers stand in each section of the module of constants."""
    heads = [(i, m[1]) for i, line in enumerate(text.splitlines(), 1) if (m := re.match(r"# === (\w+):", line))]
    found = Counter({name: 0 for _, name in heads})
    for node, _ in numbers(ast.parse(text)):
        found[[name for line, name in heads if line <= node.lineno][-1]] += 1
    return dict(found)


@pytest.fixture(scope="module")
def trees():
    return {p.name: ast.parse(p.read_text("utf-8")) for p in sorted(PACKAGE.glob("*.py"))}


def test_no_module_chooses_a_number_of_its_own(trees):
    left = [sorted_out(name, tree)[1] for name, tree in trees.items() if name != CONSTANTS]
    assert sum(left, Counter()) == Counter()


def test_the_numbers_apart_are_as_many_as_committed(trees):
    found = sum((sorted_out(name, tree)[0] for name, tree in trees.items() if name != CONSTANTS), Counter())
    assert dict(found) == APART


def test_the_chosen_numbers_are_as_many_as_committed():
    assert chosen((PACKAGE / CONSTANTS).read_text("utf-8")) == CHOSEN


def test_fewer_than_25_decide_what_is_said():
    assert CHOSEN["said"] < 25


def test_every_chosen_number_has_its_reason_above_it():
    lines = (PACKAGE / CONSTANTS).read_text("utf-8").splitlines()
    for node in ast.parse("\n".join(lines)).body:
        if isinstance(node, ast.Assign) and any(True for _ in numbers(node)):
            at = node.lineno - 2
            # a block of lines shares the reason above it
            while re.match(r"[A-Z_, ]+ = ", lines[at]):
                at -= 1
            assert lines[at].startswith("# ") and not lines[at].startswith("# ==="), lines[node.lineno - 1]


def test_docs_say_the_same_counts():
    text = (PACKAGE.parents[1] / "docs" / "diagnosis.md").read_text("utf-8")
    told = {m[1]: int(m[2]) for m in re.finditer(r"^\| `(\w+)` \| (\d+) \|", text, re.MULTILINE)}
    assert told == CHOSEN


@pytest.mark.parametrize(
    "line, category",
    [
        ("x = max(y, 1e-12)", "guards"),
        ("x = y[3]", "indices and shapes"),
        ("x = np.zeros((n, 4))", "indices and shapes"),
        ("x = k // 4", "indices and shapes"),
        ("x = 0.7 * y", "left"),
        ("if n < 20: pass", "left"),
        ("LEAST = 5", "left"),
        ("x = y[y > 0.7 * z]", "left"),
        ("x = 0.5 * y + 2", ""),
    ],
)
def test_a_new_number_is_noticed(line, category):
    found, left = sorted_out("new.py", ast.parse(line))
    assert (dict(found) or ({"left": 1} if left else {})) == ({category: 1} if category else {})
    assert sum(left.values()) == (category == "left")
