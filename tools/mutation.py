"""Mutation check of identification, control, physics and diagnosis: whether any test notices a small fault.

``python tools/mutation.py --sample 40 --seed 1 [--parts physics] [--minutes 20] [--publish]`` draws that many faults a
part, puts each into a copy of the source, runs the part's tests and says which were killed. Results are kept in
build/mutation.jsonl; a fault that is in it is not tried again, but with ``--survivors``. An own tool, because compiled
functions keep their machine code on disk: after a fault in one module, that of every module that calls it must go,
which mutmut and cosmic-ray do not know.

The diagnosis takes its own module tests: for a fault in module X, the files whose source names X, its own (``test_diagnosis_X.py``, ``test_diagnosis_X_*.py``)
first, ``test_diagnosis_X_values.py`` before them. Left out are files that run the whole program, which are slow: they import ``sstl_cli.steps``, ``.api`` or ``.cli``.
A module's own file stays even then, as the last. ``--publish`` keeps the rows of parts of which the log knows nothing.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import math
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import NoReturn

from mutants import Mutant, mutants
from page_part import inside, put, table

ROOT = Path(__file__).resolve().parents[1]
PARTS = ("identification", "control", "physics", "diagnosis")
TESTS = {
    "identification": ("tests/identification", "tests/watch"),
    "control": ("tests/control",),
    "physics": ("tests/physics",),
    "diagnosis": ("tests/diagnosis",),
}
WHOLE_PROGRAM = re.compile(r"^from sstl_cli\.(steps|api|cli)\b", re.MULTILINE)
EQUAL = Path(__file__).with_name("mutation_equal.txt")
# files that compare numbers see most faults, and are quick
FIRST = ("_values.py", "_rules.py", "_golden.py", "_covariance.py", "_limits.py")
# the slow files last: a fault that a quick one sees needs no other
LAST = ("test_physics_refit.py", "test_control_cli.py", "test_identification_cli.py", "test_watch_follow.py", "test_watch_cli.py")
LIBRARIES = (
    "numpy",
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "numba",
    "pandas",
    "pyarrow.parquet",
    "pydantic",
    "pytest",
    "hypothesis",
    "typer",
    "rich",
    "joblib",
)
FLAGS = ["-x", "-q", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:xdist", "--hypothesis-seed=0", "--no-header", "--tb=no"]


class Copy:
    """A copy of the source and its tests in which one fault at a time stands."""

    def __init__(self, folder: Path) -> None:
        self.clean, self.tree = folder / "clean", folder / "tree"
        for name in ("sstl_cli", "tests", "tools", "docs", "data"):
            shutil.copytree(ROOT / name, self.tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "README.md", "constraints.txt", "Makefile", "CONTRIBUTING.md", "CHANGELOG.md"):
            shutil.copy2(ROOT / name, self.tree / name)
        self.users = users(self.tree / "sstl_cli")

    def baseline(self, part: str) -> float:
        """Run the tests of a part on the sound source, filling its compile cache; return the seconds of a second run."""
        for _ in range(2):
            started = time.monotonic()
            killer = self.test(self.files(part), 1200)
            if killer:
                raise SystemExit(f"{part}: the tests fail without any fault ({killer})")
        shutil.rmtree(self.clean, ignore_errors=True)
        shutil.copytree(self.tree / "sstl_cli", self.clean)
        return time.monotonic() - started

    def put(self, mutant: Mutant) -> None:
        """Put a fault in, and forget what was compiled from the module or from one that uses it."""
        path = self.tree / mutant.file
        path.write_text(mutant.apply(path.read_text(encoding="utf-8")), encoding="utf-8")
        for module in {mutant.file, *self.users.get(mutant.file, set())}:
            place = (self.tree / module).parent / "__pycache__"
            stem = Path(module).stem
            for kept in [*place.glob(f"{stem}.*.nb[ic]"), *place.glob(f"{stem}.*.pyc")]:
                kept.unlink()

    def restore(self) -> None:
        """Return to the sound source and what was compiled from it."""
        shutil.rmtree(self.tree / "sstl_cli")
        shutil.copytree(self.clean, self.tree / "sstl_cli")

    def files(self, part: str, module: str = "") -> list[Path]:
        """Return the test files of a part, quick ones first; of the diagnosis those that name a module, or all of its module tests."""
        found = sorted(f for p in TESTS[part] for f in (self.tree / p).glob("test_*.py"))
        if part == "diagnosis":
            return _of_module(found, Path(module).stem)
        return sorted(found, key=lambda f: (not f.name.endswith(FIRST), f.name in LAST and LAST.index(f.name) + 1))

    def test(self, files: list[Path], seconds: float) -> str:
        """Return the test that notices something, ``timeout``, or nothing."""
        if not files:
            return ""
        report = self.tree / "report.txt"
        report.unlink(missing_ok=True)
        child = os.fork()
        if child == 0:
            _run_tests(self.tree, [str(f) for f in files], report)
        end = time.monotonic() + seconds
        while True:
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                break
            if time.monotonic() > end:
                os.killpg(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return "timeout"
            time.sleep(0.02)
        if status == 0:
            return ""
        out = report.read_text(encoding="utf-8", errors="replace")
        named = [line.split()[1] for line in out.splitlines() if line.startswith(("FAILED ", "ERROR "))]
        return named[0].split("/")[-1] if named else f"pytest ended with status {status}"


def _of_module(files: list[Path], module: str) -> list[Path]:
    """Return the files whose source names a module of the diagnosis, its own first, of those quick ones; whole diagnoses only of its own, as the last."""
    named = re.compile(rf"sstl_cli\.diagnosis(\.{module}\b| import (.*|\([^)]*)\b{module}\b)")
    chosen = []
    for file in files:
        text, own = file.read_text(encoding="utf-8"), bool(re.fullmatch(rf"test_diagnosis_{module}(_\w+)?\.py", file.name))
        whole = bool(WHOLE_PROGRAM.search(text))
        if own if whole else own or not module or named.search(text):
            chosen.append((whole, not own, not file.name.endswith(FIRST), file))
    return [file for *_, file in sorted(chosen)]


def _run_tests(tree: Path, files: list[str], report: Path) -> NoReturn:
    """Run tests in this child process, which begins with every heavy library loaded, and end it."""
    status = 1
    try:
        os.setsid()
        # a background job ignores Ctrl-C, and what it starts would too
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.chdir(tree)
        out = os.open(report, os.O_WRONLY | os.O_CREAT)
        for stream in (1, 2):
            os.dup2(out, stream)
        os.environ.update(PYTHONPATH=str(tree), PYTHONDONTWRITEBYTECODE="1")
        os.environ.pop("NUMBA_CACHE_DIR", None)
        sys.dont_write_bytecode = True
        sys.path.insert(0, str(tree))
        import pytest

        status = int(pytest.main([*FLAGS, "-rfE", *files]))
        sys.stdout.flush()
    finally:
        os._exit(status)


def users(package: Path) -> dict[str, set[str]]:
    """Return, by file, the files whose machine code may depend on it: what their compiled functions and constants name, and on."""
    direct: dict[str, set[str]] = {}
    for path in package.rglob("*.py"):
        name, tree = str(path.relative_to(package.parent)), ast.parse(path.read_text(encoding="utf-8"))
        frozen = _frozen(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("sstl_cli"):
                named = [a.name for a in node.names if (a.asname or a.name) in frozen]
                for module in (m for n in named for m in (node.module, f"{node.module}.{n}")):
                    for file in (module.replace(".", "/") + ".py", module.replace(".", "/") + "/__init__.py"):
                        if (package.parent / file).is_file():
                            direct.setdefault(file, set()).add(name)
    closed: dict[str, set[str]] = {}
    for file in direct:
        seen: set[str] = set()
        todo = [file]
        while todo:
            for user in direct.get(todo.pop(), set()) - seen:
                seen.add(user)
                todo.append(user)
        closed[file] = seen
    return closed


def _frozen(tree: ast.Module) -> set[str]:
    """Return the names that compiled functions and constants of a module use: numba keeps what they were."""

    def compiled(node: ast.stmt) -> bool:
        inner = (n for n in ast.walk(node) if isinstance(n, ast.FunctionDef))
        return any("njit" in ast.unparse(d) for n in inner for d in n.decorator_list)

    kept = [n for n in tree.body if isinstance(n, (ast.Assign, ast.AnnAssign)) or compiled(n)]
    return {n.id for k in kept for n in ast.walk(k) if isinstance(n, ast.Name)}


def draw(part: str, sample: int, seed: int) -> tuple[int, list[Mutant]]:
    """Return how many faults there are in a part, and a sample of them."""
    found: list[Mutant] = []
    for path in sorted((ROOT / "sstl_cli" / part).rglob("*.py")):
        found += mutants(path, str(path.relative_to(ROOT)))
    return len(found), random.Random(f"{seed}/{part}").sample(found, min(sample, len(found)))


def main() -> int:
    """Run the check; return 1 if fewer than the wanted share were killed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--minutes", type=float, default=1e9, help="stop drawing after this time")
    parser.add_argument("--min-killed", type=float, default=0.0, help="gate: least share killed")
    parser.add_argument("--publish", action="store_true", help="write the tables into docs/trust.md")
    parser.add_argument("--survivors", action="store_true", help="try again what survived so far, after tests were added")
    parser.add_argument("--log", type=Path, default=ROOT / "build" / "mutation.jsonl", help="results so far")
    given = parser.parse_args()
    for name in LIBRARIES:
        importlib.import_module(name)
    end = time.monotonic() + 60 * given.minutes
    given.log.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        parts = given.parts.split(",")
        for k, part in enumerate(parts):
            total, sample = draw(part, 10**9 if given.survivors else given.sample, given.seed)
            known = results(given.log).get(part, {})
            again = {m for m, tries in known.items() if given.survivors and tries[-1] is None}
            sample = [m for m in sample if str(m) in again or (str(m) not in known and not given.survivors)]
            if not sample or time.monotonic() > end:
                continue
            whole = copy.baseline(part)
            share = time.monotonic() + (end - time.monotonic()) / (len(parts) - k)
            for mutant in sample:
                if time.monotonic() > share:
                    break
                copy.put(mutant)
                files = copy.files(part, mutant.file)
                killer = copy.test(files, 60 + 6 * whole * len(files) / len(copy.files(part)))
                copy.restore()
                line = json.dumps({"part": part, "seed": given.seed, "faults": total, "mutant": str(mutant), "killed_by": killer or None})
                print(line, flush=True)
                with open(given.log, "a", encoding="utf-8") as file:
                    file.write(line + "\n")
    found = results(given.log, given.seed)
    if given.publish:
        put("trust.md", "mutation", page(found, given.seed, inside("trust.md", "mutation")))
    killed = [r[-1] is not None for by_mutant in found.values() for r in by_mutant.values()]
    return 1 if killed and sum(killed) / len(killed) < given.min_killed else 0


def results(log: Path, seed: int | None = None) -> dict[str, dict[str, list[str | None]]]:
    """Return, by part and fault, what killed it in one try after another (None: nothing did); of one seed or of all."""
    found: dict[str, dict[str, list[str | None]]] = {}
    for line in log.read_text(encoding="utf-8").splitlines() if log.exists() else []:
        row = json.loads(line)
        if seed in (None, row.get("seed")):
            found.setdefault(row["part"], {}).setdefault(row["mutant"], []).append(row["killed_by"])
    return found


def interval(k: int, n: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share (J. Am. Stat. Assoc. 22 (1927) 209).

    Examples
    --------
    >>> [round(v, 3) for v in interval(9, 10)]
    [0.596, 0.982]
    """
    z = 1.96
    middle = (k + z * z / 2) / (n + z * z)
    half = z / (n + z * z) * math.sqrt(k * (n - k) / n + z * z / 4)
    return middle - half, middle + half


def equal() -> dict[str, str]:
    """Return why a survivor cannot change any answer, from lines ``file:line:column: `old` -> `new` | reason``."""
    lines = EQUAL.read_text(encoding="utf-8").splitlines() if EQUAL.exists() else []
    return dict(line.rsplit(" | ", 1) for line in lines if line and not line.startswith("#"))


def page(found: dict[str, dict[str, list[str | None]]], seed: int, before: str = "") -> str:
    """Return the table of shares killed at the first try, and what survived it; of parts that were not run as it was ``before``."""
    cells = ([c.strip() for c in line.strip("| ").split(" | ")] for line in before.splitlines() if line.startswith("|"))
    rows: dict[str, list[object]] = {c[0]: list(c) for c in cells if c[0] in PARTS and c[0] not in found}
    left = [line for line in before.splitlines() if line.startswith("- ") and line.split("/")[1] in rows]
    same = equal()
    for part, tries in found.items():
        alive = sorted(m for m, t in tries.items() if t[0] is None)
        why = {m: same.get(m) for m in alive}
        since = {m: "killed by a test added since" for m in alive if tries[m][-1] is not None}
        shown = [f"{m} ({why[m] or since[m]})" if why[m] or m in since else m for m in alive]
        left += ["- " + m.replace("|", "\\|") for m in shown]
        count = [len(tries), len(tries) - len(alive), sum(w is not None for w in why.values())]
        rows[part] = [part, seed, f"{draw(part, 0, seed)[0]:,}", *_shares(count)]
    ordered = [rows[part] for part in sorted(rows)]
    if ordered:
        ordered.append(["together", "", "", *_shares([sum(int(str(r[i])) for r in ordered) for i in (3, 4, 6)])])
    head = ["part", "seed", "faults possible", "tried", "killed", "share killed (95 % interval)", "of the others, no change of any answer"]
    lines = "\n".join(sorted(left)) or "none"
    return f"Random samples:\n\n{table(head, ordered)}\n\nSurvivors, with the reason where no answer can change, or what has become of them:\n\n{lines}"


def _shares(count: list[int]) -> list[object]:
    n, killed, equals = count
    low, high = interval(killed, n)
    return [n, killed, f"{100 * killed / n:.0f} % ({100 * low:.0f}-{100 * high:.0f} %)", equals]


if __name__ == "__main__":
    sys.exit(main())
